"""The shell triangle's surroundings: who lies across each side, and the constant operators on that patch
(theory_shell.md 2 and 10).

Side i lies opposite to node i. Slots of a triangle: 0-2 its nodes, 3-5 the apices across its sides, 6-8 the edge slopes
of its sides. A side on a plane of symmetry, or clamped, sees the mirror image of the triangle's own node; a free side
sees nothing.

An edge slope is a correction of the surface's slope across a side [rad], an unknown of its own on free sides and on
those interior sides whose four nodes do not give the slope exactly. It is kept as slope times mesh size [mm], so that
all unknowns are lengths and their forces Newtons.
"""

from typing import NamedTuple

import numpy as np

from ..errors import SceneError

INEXACT = 0.02  # error of the four-node slope, relative to the side, above which it gets an unknown


class Patches(NamedTuple):
    """m triangles, n nodes, k edge slopes.

    slots (m, 9): row of the unknown in each slot, -1 where there is none
    change (m, 3, 4): of the gradient across side i, from the triangle's nodes and the apex [1/mm]: both triangles of a
        side have the same gradient along it, so that the mid-side gradient is G^i_aI = L_I,a + nu_a q^i_I
    side (m, 3, 2): outward normal of side i; turn (m, 3, 3): curvature [11, 22, 2*12] from its slope [1/mm]
    edge (m, 3, 3): curvature [11, 22, 2*12] from the slope of side i [1/mm^2 for slopes in mm]
    mirror (m, 3, 3), level (m, 3): unit normal and place of the plane that side i is mirrored at, 0 without
    n_slopes: k
    """

    slots: np.ndarray
    change: np.ndarray
    side: np.ndarray
    turn: np.ndarray
    edge: np.ndarray
    mirror: np.ndarray
    level: np.ndarray
    n_slopes: int


def neighbours(cells):
    """Triangle and local node across each side, (m, 3) each, -1 where there is none.

    Raises SceneError where more than two triangles share a side or two of them face opposite ways.
    """
    m = len(cells)
    start, end = cells[:, [1, 2, 0]].ravel(), cells[:, [2, 0, 1]].ravel()
    key = np.minimum(start, end) * (cells.max() + 1) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    if (same[1:] & same[:-1]).any():
        side = order[np.flatnonzero(same[1:] & same[:-1])[0]]
        raise SceneError(f"blank mesh: three triangles share the side of nodes {start[side]} and {end[side]}")
    first, second = order[:-1][same], order[1:][same]
    turned = start[first] == start[second]
    if turned.any():
        a, b = first[turned][0] // 3, second[turned][0] // 3
        raise SceneError(f"blank mesh: triangles {a} and {b} face opposite ways, expected one side up everywhere")
    across = np.full(3 * m, -1)
    across[first], across[second] = second, first
    return np.where(across < 0, -1, across // 3).reshape(m, 3), np.where(across < 0, -1, across % 3).reshape(m, 3)


def mirrors(points, cells, outside, axes, planes, clamped):
    """Planes that sides are mirrored at: normal (m, 3, 3) and level (m, 3), 0 where there is none.

    outside : (m, 3) bool, sides with nothing across; planes : {axis index: nodes on that plane of symmetry};
    clamped : nodes of clamped edges
    """
    m = len(cells)
    normal, level = np.zeros((m, 3, 3)), np.zeros((m, 3))
    for nodes, axis in [(clamped, None), *((nodes, axis) for axis, nodes in planes.items())]:
        on = np.zeros(len(points), dtype=bool)
        on[nodes] = True
        for i in range(3):
            j, k = cells[:, (i + 1) % 3], cells[:, (i + 2) % 3]
            tri = np.flatnonzero(outside[:, i] & on[j] & on[k])
            if axis is None:
                along = points[k[tri]] - points[j[tri]]
                across = np.cross(along, axes[tri, 2])
                normal[tri, i] = across / np.linalg.norm(across, axis=1)[:, None]
            else:
                normal[tri, i] = np.eye(3)[axis]
            level[tri, i] = np.einsum("mc,mc->m", normal[tri, i], points[j[tri]])
    return normal, level


def build_patches(points, membranes, size, planes, clamped):
    """Patches of a mesh.

    membranes : the triangles' own operators; size : mesh size [mm]; planes : {axis index: nodes}, planes of symmetry;
    clamped : nodes of clamped edges. Raises SceneError where the triangles do not form one orientable surface.
    """
    cells, axes, linear, area = membranes.cells, membranes.axes, membranes.gradients, membranes.area
    m, n = len(cells), len(points)
    tri_across, node_across = neighbours(cells)
    inside = tri_across >= 0
    mirror, level = mirrors(points, cells, ~inside, axes, planes, clamped)
    reflected = np.any(mirror != 0.0, axis=2)
    apex = np.where(inside, cells[tri_across, node_across], np.where(reflected, cells, -1))
    seen = np.where(apex < 0, cells, apex)
    # Operators, side by side.
    gradient, edge = np.zeros((m, 3, 2, 6)), np.zeros((m, 3, 3))
    plane = np.einsum("mac,mic->mia", axes[:, :2], points[cells] - points[cells][:, :1])
    wants_slope, normal = ~inside & ~reflected, np.empty((m, 3, 2))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        own = np.zeros((m, 2, 6))
        own[:, :, :3] = linear.transpose(0, 2, 1)
        side = plane[:, k] - plane[:, j]
        length = np.linalg.norm(side, axis=1)
        t = side / length[:, None]
        nu = np.stack([t[:, 1], -t[:, 0]], axis=1)
        normal[:, i] = nu
        altitude = 2.0 * area / length
        edge[:, :, i] = -2.0 / altitude[:, None] * np.stack([nu[:, 0] ** 2, nu[:, 1] ** 2, 2 * nu[:, 0] * nu[:, 1]], 1)
        # The apex across, unfolded about the side into the triangle's plane.
        far = points[seen[:, i]]
        behind = np.einsum("mc,mc->m", mirror[:, i], far) - level[:, i]
        far = far - 2.0 * behind[:, None] * mirror[:, i]
        t3 = (points[cells[:, k]] - points[cells[:, j]]) / length[:, None]
        away = far - points[cells[:, j]]
        s = np.einsum("mc,mc->m", away, t3)
        h = np.linalg.norm(away - s[:, None] * t3, axis=1)
        q = plane[:, j] + s[:, None] * t + h[:, None] * nu
        other = triangle_gradients(plane[:, k], plane[:, j], q)
        both = own.copy()
        weight = (altitude / (altitude + h))[:, None]
        both *= weight[:, :, None]
        for slot, place in ((0, k), (1, j), (2, 3 + i)):
            both[:, :, place] += (1.0 - weight) * other[:, slot]
        closed = inside[:, i] | reflected[:, i]
        gradient[:, i] = np.where(closed[:, None, None], both, own)
        # Where the four-node slope misses some constant curvature.
        s_own, s_far = np.einsum("ma,ma->m", plane[:, i] - plane[:, j], t) - 0.5 * length, s - 0.5 * length
        miss = 0.5 * np.stack([
            0.5 * (h - altitude),
            (s_own + s_far) / np.sqrt(2.0),
            (length**2 / 8 - s_own**2 / 2) / altitude + (s_far**2 / 2 - length**2 / 8) / h,
        ])  # fmt: skip
        wants_slope[:, i] |= inside[:, i] & (np.linalg.norm(miss, axis=0) > INEXACT * length)
    # A side inside may look inexact from one triangle by round-off and exact from the other.
    tri, i = np.nonzero(inside & wants_slope)
    wants_slope[tri_across[tri, i], node_across[tri, i]] = True
    # Number the slopes; the triangle of lower number counts a slope positive.
    slope, sign, n_slopes = number_slopes(tri_across, node_across, wants_slope)
    turn = edge.copy()
    edge *= (sign * wants_slope)[:, None, :] / size
    change = np.einsum("mia,miak->mik", normal, gradient - own[:, None])
    change = np.concatenate([change[:, :, :3], np.einsum("mii->mi", change[:, :, 3:])[:, :, None]], axis=2)
    slots = np.concatenate([cells, apex, np.where(wants_slope, n + slope, -1)], axis=1)
    slots = np.ascontiguousarray(slots, dtype=np.int64)
    return Patches(slots, np.ascontiguousarray(change), normal, turn, edge, mirror, level, n_slopes)


def number_slopes(tri_across, node_across, wanted):
    """Number (m, 3) and sign (m, 3) of each side's slope, and how many there are."""
    m = len(wanted)
    here = np.arange(3 * m).reshape(m, 3)
    there = np.where(tri_across >= 0, 3 * tri_across + node_across, here)
    owner = np.minimum(here, there)
    kept, number = np.unique(owner[wanted], return_inverse=True)
    slope = np.zeros((m, 3), dtype=np.int64)
    slope[wanted] = number.ravel()
    return slope, np.where(owner == here, 1.0, -1.0), len(kept)


def triangle_gradients(a, b, c):
    """Gradients of the linear shape functions of triangles (a, b, c), each (m, 2). Returns (m, 3, 2)."""
    double_area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    sides = np.stack([c - b, a - c, b - a], axis=1)
    return np.stack([-sides[:, :, 1], sides[:, :, 0]], axis=2) / double_area[:, None, None]
