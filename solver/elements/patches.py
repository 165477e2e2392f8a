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

# A triangle's own part in its metric; the rest is the mean over its sides of what two triangles have in common. Bending
# in the plane strains a linear triangle by e0 + d, e0 right at its middle and d of opposite sign next door: the energy
# holds OWN^2 d.d in place of the variance v of the exact strain. In a lattice of right-angled triangles, over all
# linear stresses in equilibrium, OWN^2 d.d = v for OWN = 0.37 to 0.40 by least squares and 0.58 to 0.62 on the mean
# (Poisson's ratio 0 to 0.3).
OWN = 0.5
SHARED = (1.0 - OWN) / 3.0  # of what two triangles have in common, per side


class Patches(NamedTuple):
    """m triangles, n nodes, k edge slopes.

    slots (m, 9): row of the unknown in each slot, -1 where there is none
    beyond (m, 3, 3): where the apex across side i lies, unfolded, as a weighted sum of the triangle's nodes; minus the
        weight of node i is its altitude relative to the triangle's own
    lever (m, 3): altitude on side i, by its edge slope's sign and per mesh size, 0 where it has none
    image (m, 3): row in planes of the plane that side i is mirrored at, -1 without
    planes (p, 4): unit normal, and place along it [mm]
    n_slopes: k
    """

    slots: np.ndarray
    beyond: np.ndarray
    lever: np.ndarray
    image: np.ndarray
    planes: np.ndarray
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
    cells, axes, m, n = membranes.cells, membranes.axes, len(membranes.cells), len(points)
    tri_across, node_across = neighbours(cells)
    inside = tri_across >= 0
    mirror, level = mirrors(points, cells, ~inside, axes, planes, clamped)
    reflected = np.any(mirror != 0.0, axis=2)
    apex = np.where(inside, cells[tri_across, node_across], np.where(reflected, cells, -1))
    seen = np.where(apex < 0, cells, apex)
    # Side by side.
    wants_slope, beyond = ~inside & ~reflected, np.zeros((m, 3, 3))
    altitude = 1.0 / np.linalg.norm(membranes.gradients, axis=2)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        side = points[cells[:, k]] - points[cells[:, j]]
        length = np.linalg.norm(side, axis=1)
        own_along = np.einsum("mc,mc->m", points[cells[:, i]] - points[cells[:, j]], side) / length
        # The apex across: how far along the side, and away from it.
        far = points[seen[:, i]]
        behind = np.einsum("mc,mc->m", mirror[:, i], far) - level[:, i]
        away = far - 2.0 * behind[:, None] * mirror[:, i] - points[cells[:, j]]
        along = np.einsum("mc,mc->m", away, side) / length
        h = np.linalg.norm(away - (along / length)[:, None] * side, axis=1)
        # Unfolded about the side, as a weighted sum of the triangle's nodes.
        ratio = h / altitude[:, i]
        beyond[:, i, i] = -ratio
        beyond[:, i, k] = (along + ratio * own_along) / length
        beyond[:, i, j] = 1.0 + ratio - beyond[:, i, k]
        # Where the four-node slope misses some constant curvature.
        s_own, s_far = own_along - 0.5 * length, along - 0.5 * length
        miss = 0.5 * np.stack([
            0.5 * (h - altitude[:, i]),
            (s_own + s_far) / np.sqrt(2.0),
            (length**2 / 8 - s_own**2 / 2) / altitude[:, i] + (s_far**2 / 2 - length**2 / 8) / h,
        ])  # fmt: skip
        wants_slope[:, i] |= inside[:, i] & (np.linalg.norm(miss, axis=0) > INEXACT * length)
    # A side inside may look inexact from one triangle by round-off and exact from the other.
    tri, i = np.nonzero(inside & wants_slope)
    wants_slope[tri_across[tri, i], node_across[tri, i]] = True
    # Number the slopes; the triangle of lower number counts a slope positive.
    slope, sign, n_slopes = number_slopes(tri_across, node_across, wants_slope)
    lever = sign * wants_slope * altitude / size
    slots = np.concatenate([cells, apex, np.where(wants_slope, n + slope, -1)], axis=1)
    planes, image = np.concatenate([mirror, level[:, :, None]], axis=2)[reflected], np.full((m, 3), -1)
    planes, image[reflected] = distinct(planes)
    slots = np.ascontiguousarray(slots, dtype=np.int64)
    return Patches(slots, beyond, lever, image.astype(np.int32), planes, n_slopes)


def distinct(planes):
    """Different rows of planes (k, 4), and which of them each is (k,)."""
    rows, which = np.unique(planes, axis=0, return_inverse=True)
    return np.ascontiguousarray(rows), which.ravel()


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
