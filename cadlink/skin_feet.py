"""What a trimmed skin proposes to feet.py: stationary points on its items within reach; and how tight its hollows are.

p       the point;  q a foot;  h = |p - q|
towards direction from the known foot to p; proposals along it are not worth a test
"""

from math import cos, sin, sqrt

import numpy as np
from numba import njit, prange

from cadlink.answer import INNER, edge_at, faces_at_edge
from cadlink.boxtree import box_distance
from cadlink.closest import CHUNK
from cadlink.feet import ALIKE
from cadlink.items import CELLS, STARTS, leaf_holds, start_in_leaf, try_item
from cadlink.leaf_bounds import UNIQUE, bend_by_height, cell_beside, leaf_beside
from cadlink.nurbs import WORK, arc_derivatives, dot, minus
from cadlink.patch_foot import patch_foot
from cadlink.radii import radii_of_skin
from cadlink.skin import ON_ARC, ON_LEAF, ON_LINE, ON_VERTEX

ROOM = 32  # proposals of a point; the nearest ones are kept
DEPTH = 256  # of the walk down the tree
NOWHERE = 1e-6  # of the reach: a point as near as this to a foot is on the skin, and has no direction
PROBE = 1e-3  # of an edge's length: how far from its middle the skin is asked which way it turns there
ALIKE_COSINE = cos(ALIKE)


@njit(forceinline=True)
def propose_foot(p, q, towards, reach, found, distances, count):
    """Enter a foot among the nearest ROOM ones; returns how many there are."""
    m = minus(p, q)
    h = sqrt(dot(m, m))
    if not NOWHERE * reach < h <= reach or dot(m, towards) > ALIKE_COSINE * h:
        return count
    k = count
    if count == len(distances):
        k = 0
        for other in range(1, count):
            if distances[other] > distances[k]:
                k = other
        if distances[k] <= h:
            return count
    else:
        count += 1
    distances[k] = h
    for c in range(3):
        found[k, c] = q[c]
    return count


@njit(**INNER)
def propose_on_item(skin, item, p, towards, reach, found, distances, count, work):
    """Enter the feet on one item; returns how many there are."""
    if skin.items[item].kind != ON_LEAF:
        h, _, _, q = try_item(skin, item, p, np.inf, -1.0, -1.0, work)
        return propose_foot(p, q, towards, reach, found, distances, count) if h < np.inf else count
    leaf = skin.leaves[skin.items[item].ref]
    patch = skin.patches[leaf.patch]
    bound, beside, x, y, z = leaf_beside(leaf, p)
    if bound > reach or beside > reach * leaf.cone:
        return count
    alone = (bound + 2.0 * leaf.half[2]) * bend_by_height(leaf, z) < UNIQUE
    for cell in range(-1, 0 if alone else STARTS):
        if cell >= 0 and cell_beside(leaf, cell % CELLS, x, y) > reach * leaf.cone:
            continue
        s, t = start_in_leaf(leaf, cell, x, y)
        s, t, q, f, free, _ = patch_foot(patch, skin.ctrl, skin.power, p, s, t, work)
        if free and f <= reach * reach:
            if leaf_holds(leaf, patch, skin.faces[patch.face], skin.pieces, skin.ctrl, s, t, work):
                count = propose_foot(p, q, towards, reach, found, distances, count)
    return count


@njit(parallel=True, cache=True)
def propose_on_skin(skin, points, towards, reach, found, distances, counts):
    """Fill the proposals of each point: found (n, ROOM, 3), distances (n, ROOM), counts (n,)."""
    n = len(points)
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        work, stack = np.zeros(WORK), np.zeros(DEPTH, np.int64)
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            p = (points[i, 0], points[i, 1], points[i, 2])
            known = (towards[i, 0], towards[i, 1], towards[i, 2])
            count, top = 0, 0
            for root in skin.roots:
                if root >= 0:
                    stack[top] = root
                    top += 1
            while top > 0:
                top -= 1
                node = skin.nodes[stack[top]]
                if box_distance(node, p) > reach[i]:
                    continue
                if node.child >= 0:
                    stack[top], stack[top + 1] = node.child, node.child + 1
                    top += 2
                    continue
                for k in range(node.start, node.stop):
                    item = skin.order[k]
                    if box_distance(skin.items[item], p) <= reach[i]:
                        count = propose_on_item(skin, item, p, known, reach[i], found[i], distances[i], count, work)
            counts[i] = count


def propose(skin, points, towards, reach):
    """Owner (c,) and foot (c, 3) of what a skin proposes; the arguments of feet.py."""
    n = len(points)
    found, distances, counts = np.empty((n, ROOM, 3)), np.empty((n, ROOM)), np.zeros(n, np.int64)
    if n:
        propose_on_skin(skin, points, towards, reach, found, distances, counts)
    taken = np.arange(ROOM) < counts[:, None]
    return np.repeat(np.arange(n), counts), found[taken]


# --- how tight the corners are ---------------------------------------------------------------------------------------


@njit(cache=True)
def middles_of_curves(skin, place, mean, length, turn):
    """Fill, of each curve, its middle (k, 3), mean normal (k, 3), length [mm] and the sine between its faces (k,)."""
    work = np.zeros(WORK)
    for item in skin.items:
        if item.kind < ON_LINE or item.kind >= ON_VERTEX:
            continue
        curve = skin.curves[item.ref]
        f = curve.frame
        if item.kind == ON_LINE:
            a = 0.5
            x = (f[0, 0] + 0.5 * f[1, 0], f[0, 1] + 0.5 * f[1, 1], f[0, 2] + 0.5 * f[1, 2])
            size = sqrt(f[1, 0] ** 2 + f[1, 1] ** 2 + f[1, 2] ** 2)
        elif item.kind == ON_ARC:
            a = 0.5
            x, d1, _ = arc_derivatives(skin.ctrl, curve.ctrl, curve.degree, a, work)
            size = sqrt(dot(d1, d1))
        else:
            a = 0.5 * (curve.span[0] + curve.span[1])
            c, s = cos(a), sin(a)
            x = (
                f[0, 0] + c * f[1, 0] + s * f[2, 0],
                f[0, 1] + c * f[1, 1] + s * f[2, 1],
                f[0, 2] + c * f[1, 2] + s * f[2, 2],
            )
            size = sqrt(f[1, 0] ** 2 + f[1, 1] ** 2 + f[1, 2] ** 2) * min(1.0, curve.span[1] - curve.span[0])
        tau, _, _ = edge_at(item.kind, curve, skin.ctrl, a, work)
        n, sine = faces_at_edge(skin, skin.edges[curve.edge], tau, work)
        length[item.ref], turn[item.ref] = size, sine
        for c in range(3):
            place[item.ref, c], mean[item.ref, c] = x[c], n[c]


def tightest(surface, side):
    """Smallest radius [mm] the skin is hollow with on one side: +1 outside the material, -1 inside.

    0 where an edge turns by more than ALIKE: the middle of the two normals leads from it to nearer points of its faces
    """
    skin = surface.skin
    size = float(np.ptp(np.vstack([skin.items["low"], skin.items["high"]]), axis=0).max())
    k = len(skin.curves)
    place, mean, length, turn = np.empty((k, 3)), np.empty((k, 3)), np.empty(k), np.empty(k)
    middles_of_curves(skin, place, mean, length, turn)
    sharp = np.flatnonzero(turn > np.sin(ALIKE))
    step = np.maximum(PROBE * length[sharp], 100.0 * skin.edges["slack"][skin.curves["edge"][sharp]])
    hit = surface.project(place[sharp] + side * step[:, None] * mean[sharp])
    if (side * hit.distance < np.cos(0.5 * ALIKE) * step).any():
        return 0.0
    return radii_of_skin(skin, size)[0 if side > 0.0 else 1]
