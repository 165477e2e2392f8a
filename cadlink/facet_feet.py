"""What facets propose to feet.py: the nearest point of each one within reach; and how tight their hollows are.

p       the point;  q its nearest point on a facet;  h = |p - q|;  m = (p - q) / h
towards direction from the known foot to p; proposals along it are not worth a test
"""

from math import sqrt

import numpy as np
from numba import njit, prange

from cadlink.facet_closest import CHUNK, NAGATA, flat_distance
from cadlink.facet_geometry import blend, dot, foot_on_patch, foot_on_triangle, minus, row, surface_at
from cadlink.facet_mesh import edges_of, split, triangle_normals
from cadlink.facet_tree import DEPTH, LEAF, node_distance
from cadlink.feet import ALIKE
from cadlink.skin_feet import ROOM, propose_foot


@njit
def foot_on_facet(skin, kind, item, p, side):
    """Whether the nearest point of a facet may be a foot, and that point.

    A point on the side or at a corner of a flat facet is one only if m is as near to the mean normal there as the
    facet's own; all facets that meet there are asked, and one of them is far enough off.
    """
    if kind == NAGATA:
        _, s, t, _ = foot_on_patch(p, skin.patch[item], skin.sides[item], skin.bend[item])
        q, _, _ = surface_at(skin.patch[item], s, t)
        return True, q
    c = skin.items[item]
    x, y, z = row(skin.points, c[0]), row(skin.points, c[1]), row(skin.points, c[2])
    region, v, w = foot_on_triangle(p, x, y, z, skin.thin[item])
    q = blend(x, y, z, v, w)
    if region == 0:
        return True, q
    m = minus(p, q)
    mean = row(skin.side_normal[item], region - 1) if region < 5 else row(skin.point_normal, c[region - 5])
    return side * dot(m, mean) >= (dot(row(skin.normal, item), mean) - 1e-9) * sqrt(dot(m, m)), q


@njit(parallel=True, cache=True)
def propose_on_facets(skin, kind, points, towards, side, reach, found, distances, counts):
    """Fill the proposals of each point: found (n, ROOM, 3), distances (n, ROOM), counts (n,). side (n,) : +1 outside"""
    n, first_leaf = len(points), len(skin.low) // 2
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        stack = np.zeros(DEPTH, np.int64)
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            p = (points[i, 0], points[i, 1], points[i, 2])
            known = (towards[i, 0], towards[i, 1], towards[i, 2])
            count, top = 0, 1
            stack[0] = 0
            while top > 0:
                top -= 1
                node = stack[top]
                if node_distance(skin.low, skin.high, node, p) > reach[i]:
                    continue
                if node < first_leaf:
                    stack[top], stack[top + 1] = 2 * node + 1, 2 * node + 2
                    top += 2
                    continue
                for k in range((node - first_leaf) * LEAF, (node - first_leaf + 1) * LEAF):
                    item = skin.order[k]
                    if item < 0 or (kind == NAGATA and flat_distance(skin, item, p) - skin.bulge[item] > reach[i]):
                        continue
                    possible, q = foot_on_facet(skin, kind, item, p, side[i])
                    if possible:
                        count = propose_foot(p, q, known, reach[i], found[i], distances[i], count)
            counts[i] = count


def propose(skin, kind, side, points, towards, reach):
    """Owner (c,) and foot (c, 3) of what facets propose. side : (n,) +1 for points outside the material, else -1"""
    n = len(points)
    found, distances, counts = np.empty((n, ROOM, 3)), np.empty((n, ROOM)), np.zeros(n, np.int64)
    if n:
        propose_on_facets(skin, kind, points, towards, side, reach, found, distances, counts)
    taken = np.arange(ROOM) < counts[:, None]
    return np.repeat(np.arange(n), counts), found[taken]


def tightest(points, corners, side):
    """Smallest radius [mm] facets are hollow with on one side (+1 outside the material), inf for none.

    0 where neighbours turn by more than ALIKE; a smaller turn stands for the radius of a circle that turns so much over
    the facet's width.
    """
    triangles, _, _ = split(points, corners)
    edges = edges_of(triangles)
    normal, _ = triangle_normals(points, triangles, edges)
    two = edges.count == 2
    f, g = edges.owner[two].T
    a, b = points[edges.ends[two]].transpose(1, 0, 2)
    middle = points[triangles].mean(axis=1)
    # Hollow where the neighbour's middle lies in front of the facet.
    ahead = side * np.einsum("ec,ec->e", middle[g] - a, normal[f])
    turn = np.arccos(np.clip(np.einsum("ec,ec->e", normal[f], normal[g]), -1.0, 1.0))
    hollow = (ahead > 0.0) & (turn > 1e-6)
    if not hollow.any():
        return np.inf
    if turn[hollow].max() > ALIKE:
        return 0.0
    along = np.linalg.norm(b - a, axis=1)
    width = [np.linalg.norm(np.cross(middle[k] - a, b - a), axis=1) * 3.0 / along for k in (f, g)]
    return float((np.minimum(*width)[hollow] / turn[hollow]).min())
