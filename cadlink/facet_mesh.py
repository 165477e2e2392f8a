"""Triangles and quadrilaterals as one skin: welded, turned the same way round, with the normals of its parts.

corners   (m, 4) point numbers of each element, -1 in the last column of a triangle
wedge     one element at one of its corners
edge      two points that an element joins, with all the elements that do
rim       an edge that only one element has; a mesh without rims is closed
pseudo-normal  of an edge the sum of its facets' unit normals, of a point their sum weighted by the angle of each
          facet there: its side of a foot is the side of the surface (Baerentzen & Aanaes 2005)
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cadlink.errors import CadError

WELD = 1e-9  # of the size of the mesh: points nearer than this are one
THIN = 1e-12  # twice the area of a facet over its longest side squared: below it has no normal of its own


class Edges(NamedTuple):
    """Edges of elements or triangles.

    side_edge   (m, k) edge of each side (from corner i to the next), -1 where there is none
    count       (e,) how many elements share it
    owner       (e, 2) two of them, the second -1 at a rim
    slot        (e, 2) which of their sides it is
    opposite    (e,) True where those two run along it in opposite directions, as neighbours on one side do
    ends        (e, 2) points
    """

    side_edge: np.ndarray
    count: np.ndarray
    owner: np.ndarray
    slot: np.ndarray
    opposite: np.ndarray
    ends: np.ndarray


def check_mesh(points, cells):
    """points (n, 3) float and corners (m, 4) int. Raises CadError, one line, for anything else."""
    points = np.ascontiguousarray(np.asarray(points, float))
    if points.ndim != 2 or points.shape[1] != 3:
        raise CadError(f"facets: points of shape {points.shape}, expected (n, 3)")
    groups = cells if isinstance(cells, (list, tuple)) and len(cells) and np.ndim(cells[0]) == 2 else [cells]
    corners = []
    for group in groups:
        found = np.asarray(group)
        if found.ndim != 2 or found.shape[1] not in (3, 4) or not np.issubdtype(found.dtype, np.integer):
            raise CadError(
                f"facets: cells of shape {found.shape} and type {found.dtype}, expected integers (m, 3) or (m, 4)"
            )
        padded = np.full((len(found), 4), -1)
        padded[:, : found.shape[1]] = found
        if len(found) and (found.min() < 0 or found.max() >= len(points)):
            raise CadError(f"facets: cells name points {found.min()} to {found.max()}, expected 0 to {len(points) - 1}")
        corners.append(padded)
    corners = np.vstack(corners)
    if not len(corners):
        raise CadError("facets: no cell, expected triangles or quadrilaterals")
    if not np.isfinite(points[corners[corners >= 0]]).all():
        raise CadError("facets: points that are nan or inf, expected finite coordinates in mm")
    return points, corners


def weld(points, corners):
    """Coincident points made one, collapsed elements dropped, quadrilaterals with a collapsed side made triangles.

    returns : points (n, 3), corners (m, 4), kept (m,) the number of each element before, column (m, 4) which of its
        corners each one is, -1 for none
    """
    from scipy.spatial import cKDTree  # only here

    used = np.unique(corners[corners >= 0])
    at = points[used]
    size = float(np.ptp(at, axis=0).max())
    pairs = cKDTree(at).query_pairs(WELD * size, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(used), len(used)))
    n, group = connected_components(graph, directed=False)
    first = np.full(n, len(used))
    np.minimum.at(first, group, np.arange(len(used)))
    order = np.argsort(first)  # points keep their order
    rank = np.empty(n, int)
    rank[order] = np.arange(n)
    new = np.full(len(points) + 1, -1)
    new[used] = rank[group]
    corners = new[corners]  # corner -1 reads the last entry, -1
    points = at[first[order]]

    # Repeated neighbours leave; what remains of a quadrilateral is a triangle.
    triangle = corners[:, 3] < 0
    following = np.where(triangle[:, None], corners[:, [1, 2, 0, 3]], corners[:, [1, 2, 3, 0]])
    same = (corners == following) & (corners >= 0)
    n_same = same.sum(axis=1)
    folded = ~triangle & ((corners[:, 0] == corners[:, 2]) | (corners[:, 1] == corners[:, 3]))
    shrunk = ~triangle & (n_same == 1) & ~folded
    column = np.where(corners < 0, -1, np.arange(4))
    for k in np.flatnonzero(shrunk):
        corners[k] = [*corners[k][~same[k]], -1]
        column[k] = [*np.flatnonzero(~same[k]), -1]
    kept = np.flatnonzero((n_same == 0) & ~folded | shrunk)
    if not len(kept):
        raise CadError("facets: every cell is collapsed, expected triangles or quadrilaterals with an area")
    return points, corners[kept], kept, column[kept]


def edges_of(corners):
    """Edges of elements; corners (m, 3) or (m, 4), -1 in the last column of a triangle."""
    m, width = corners.shape
    triangle = corners[:, -1] < 0
    end = np.roll(corners, -1, axis=1)
    end[triangle, width - 2] = corners[triangle, 0]
    slots = np.broadcast_to(np.arange(width), (m, width))
    real = corners >= 0
    a, b, slot = corners[real], end[real], slots[real]
    owner = np.broadcast_to(np.arange(m)[:, None], (m, width))[real]
    pair = np.column_stack([np.minimum(a, b), np.maximum(a, b)])
    ends, inverse, count = np.unique(pair, axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.ravel()
    side_edge = np.full((m, width), -1)
    side_edge[real] = inverse
    order = np.argsort(inverse, kind="stable")
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    first = order[start]
    second = order[np.minimum(start + 1, len(order) - 1)]
    two = count > 1
    owners = np.column_stack([owner[first], np.where(two, owner[second], -1)])
    slots = np.column_stack([slot[first], np.where(two, slot[second], -1)])
    return Edges(side_edge, count, owners, slots, a[first] == b[second], ends)


def turned_alike(points, corners, edges):
    """Corners turned so that neighbours agree, and closed pieces have their normals outwards.

    An open piece keeps the sense most of its area has; a closed one inside another (a cavity) points into itself.
    returns : corners (m, 4), turned (m,) bool
    raises : CadError for a one-sided surface (a Moebius strip)
    """
    m = len(corners)
    inner = np.flatnonzero(edges.count == 2)
    f, g = edges.owner[inner].T
    agree = edges.opposite[inner]
    # Two copies of each element, as it is and turned; neighbours are joined in the senses that agree.
    row = np.concatenate([f, f + m])
    column = np.concatenate([np.where(agree, g, g + m), np.where(agree, g + m, g)])
    graph = coo_array((np.ones(len(row)), (row, column)), shape=(2 * m, 2 * m))
    n, label = connected_components(graph, directed=False)
    if (label[:m] == label[m:]).any():
        at = points[corners[np.flatnonzero(label[:m] == label[m:])[0], 0]]
        raise CadError(f"facets: one-sided surface near {at.round(6).tolist()}, expected one with two sides")
    area = np.linalg.norm(area_vectors(points, corners), axis=1)
    as_given = np.bincount(label[:m], area, n)
    turned = as_given[label[:m]] < as_given[label[m:]]
    tie = as_given[label[:m]] == as_given[label[m:]]
    turned |= tie & (label[:m] > label[m:])
    corners = reversed_where(corners, turned)

    # Closed pieces: outwards by their volume, inwards where they are cavities.
    _, piece = connected_components(coo_array((np.ones(len(f)), (f, g)), shape=(m, m)), directed=False)
    closed = np.ones(piece.max() + 1, bool)
    for edge_owner in edges.owner[edges.count == 1, 0]:
        closed[piece[edge_owner]] = False
    odd = edges.count > 2
    closed[piece[edges.owner[odd].ravel()]] = False
    volume = np.bincount(piece, np.einsum("ij,ij->i", points[corners[:, 0]], area_vectors(points, corners)) / 3.0)
    flip = closed & (volume < 0.0)
    shells = np.flatnonzero(closed)
    if len(shells) > 1:
        for inside in shells:
            at = points[corners[np.flatnonzero(piece == inside)[0], 0]]
            depth = sum(encloses(points, corners[piece == other], at) for other in shells if other != inside)
            flip[inside] ^= depth % 2 == 1
    outward = flip[piece]
    return reversed_where(corners, outward), turned ^ outward


def encloses(points, corners, at):
    """Whether a point lies inside a closed piece, by its winding number (van Oosterom & Strackee 1983)."""
    a, b, c = (points[t] - at for t in split(points, corners)[0].T)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
    angle = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    return abs(angle.sum()) > 2.0 * np.pi


def reversed_where(corners, mask):
    """Corners in the opposite order where the mask says so; the first stays the first."""
    corners = corners.copy()
    triangle = mask & (corners[:, 3] < 0)
    quad = mask & (corners[:, 3] >= 0)
    corners[triangle] = corners[triangle][:, [0, 2, 1, 3]]
    corners[quad] = corners[quad][:, [0, 3, 2, 1]]
    return corners


def area_vectors(points, corners):
    """(m, 3) normal of each element times its area; of a warped quadrilateral half the product of its diagonals."""
    last = np.where(corners[:, 3] < 0, corners[:, 2], corners[:, 3])
    a, b, c, d = (points[k] for k in (corners[:, 0], corners[:, 1], corners[:, 2], last))
    return 0.5 * np.cross(c - a, d - b)


def split(points, corners):
    """Triangles of the elements: a quadrilateral along its inner or, where both are, its shorter diagonal.

    returns : triangles (t, 3) points, element (t,), place (t, 3) corner of the element each point is
    """
    triangle = np.flatnonzero(corners[:, 3] < 0)
    quad = np.flatnonzero(corners[:, 3] >= 0)
    a, b, c, d = (points[corners[quad, k]] for k in range(4))

    def folds(p, q, r, s):
        """How far the two triangles beside the diagonal from p to r face apart."""
        return np.einsum("ij,ij->i", np.cross(q - p, r - p), np.cross(r - p, s - p)) <= 0.0

    first_folds, second_folds = folds(a, b, c, d), folds(b, c, d, a)
    shorter = np.linalg.norm(c - a, axis=1) <= np.linalg.norm(d - b, axis=1)
    first = np.where(first_folds == second_folds, shorter, ~first_folds)
    one, other = quad[first], quad[~first]
    element = np.concatenate([triangle, one, one, other, other])
    ways = [(0, 1, 2), (0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)]
    counts = [len(triangle), len(one), len(one), len(other), len(other)]
    place = np.repeat(np.array(ways), counts, axis=0)
    order = np.argsort(element, kind="stable")
    element, place = element[order], place[order]
    return corners[element[:, None], place], element, place


def unit(v):
    """Vectors (.., 3) at length 1; zero vectors stay."""
    size = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(size > 0.0, size, 1.0)


def triangle_normals(points, triangles, edges):
    """(t, 3) unit normals; triangles without an area take the mean of their neighbours'. thin (t,) bool."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    v = np.cross(b - a, c - a)
    longest = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
    thin = np.linalg.norm(v, axis=1) <= THIN * longest
    if thin.all():
        raise CadError("facets: no cell has an area, expected triangles or quadrilaterals with one")
    normal = np.where(thin[:, None], 0.0, unit(v))
    two = edges.count >= 2
    for _ in range(8):
        lost = thin & ~normal.any(axis=1)
        if not lost.any():
            break
        total = np.zeros_like(normal)
        f, g = edges.owner[two].T
        np.add.at(total, f, normal[g])
        np.add.at(total, g, normal[f])
        normal[lost] = unit(total)[lost]
    return normal, thin


def corner_angles(points, corners):
    """(m, k) angle of each element at its corners [rad], 0 where there is none."""
    m, width = corners.shape
    triangle = corners[:, -1] < 0
    ahead, behind = np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)
    ahead[triangle, width - 2] = corners[triangle, 0]
    behind[triangle, 0] = corners[triangle, width - 2]
    u, v = points[ahead] - points[corners], points[behind] - points[corners]
    angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=-1), (u * v).sum(axis=-1))
    return np.where(corners >= 0, angle, 0.0)


def point_normals(n_points, triangles, normal, angle):
    """(n, 3) angle-weighted pseudo-normals of the points, unit length."""
    total = np.zeros((n_points, 3))
    np.add.at(total, triangles.ravel(), (angle[..., None] * normal[:, None, :]).reshape(-1, 3))
    return unit(total)


def edge_normals(edges, normal):
    """(e, 3) pseudo-normals of edges: the sum of the unit normals of all facets that share them."""
    total = np.zeros((len(edges.count), 3))
    real = edges.side_edge >= 0
    owner = np.broadcast_to(np.arange(len(normal))[:, None], real.shape)[real]
    np.add.at(total, edges.side_edge[real], normal[owner])
    return unit(total)


def corner_normals(points, corners, edges, normal, crease, weighted):
    """(m, 4, 3) normals of the elements at their corners: the mean of the element normals round a point.

    Seed Eq. 14, e_node = 1/N sum e_elem, over the N elements at the point, or those of them that are joined through
    edges where neighbours meet at less than `crease` rad (None: all). Not brought to unit length.
    weighted : weigh by the angle at the point instead of alike
    returns : normals, sharp (e,) whether each edge is a crease or not shared by just two
    """
    m = len(corners)
    real = corners >= 0
    sharp = edges.count != 2
    f, g = edges.owner.T
    if crease is not None:
        turn = np.arctan2(
            np.linalg.norm(np.cross(normal[f], normal[g]), axis=1), np.einsum("ij,ij->i", normal[f], normal[g])
        )
        sharp |= turn > crease
    if crease is None:
        group = np.where(real, corners, len(points))
    else:
        inner = np.flatnonzero(~sharp)
        number = np.arange(4 * m).reshape(m, 4)
        n_sides = np.where(corners[:, 3] < 0, 3, 4)
        f, g = edges.owner[inner].T
        i, j = edges.slot[inner].T
        # Sides run in opposite directions: the start of one is the end of the other.
        row = np.concatenate([number[f, i], number[f, (i + 1) % n_sides[f]]])
        column = np.concatenate([number[g, (j + 1) % n_sides[g]], number[g, j]])
        graph = coo_array((np.ones(len(row)), (row, column)), shape=(4 * m, 4 * m))
        group = connected_components(graph, directed=False)[1].reshape(m, 4)
    weight = corner_angles(points, corners) if weighted else real.astype(float)
    n_groups = int(group.max()) + 1
    total, count = np.zeros((n_groups, 3)), np.zeros(n_groups)
    np.add.at(total, group.ravel(), (weight[..., None] * normal[:, None, :]).reshape(-1, 3))
    np.add.at(count, group.ravel(), weight.ravel())
    mean = total / np.where(count > 0.0, count, 1.0)[:, None]
    return np.where(real[..., None], mean[group], 0.0), sharp
