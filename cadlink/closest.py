"""The closest point of a trimmed skin: the quick search, and the careful one where that is in doubt.

    p       the point
    best    smallest distance so far, plus the slack of an edge or vertex
    a, b    parameters of a foot: u, v of a face, s, t of a patch, tau, angle or s of an edge

A closest point on a trimmed skin is a foot inside a face, a foot on an edge, or a vertex. The
careful search walks the trees over all items in order of nearness; each is measured exactly; the
smallest distance wins. The quick one (quick.py) decides all but about one point in a thousand.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from cadlink.answer import answer
from cadlink.boxtree import box_distance
from cadlink.items import try_item
from cadlink.kernels import INNER, POINT
from cadlink.nurbs import WORK
from cadlink.osculating import CALM, LABEL, REMEMBERED, recall, remember
from cadlink.power import CONVERGED
from cadlink.quick import AGAIN, PENDING, SKIN, WAITING, quick_search, room_inside, surely_in
from cadlink.skin import ON_FACE, ON_LEAF
from cadlink.track import ANSWER, answer_on_patch, form_of, settle, track_edge, track_face, track_leaf, write

# Columns of a seed: item, its parameters (of a closed form first the room_inside), the point searched for, reach,
# number of the surface; on a skin with curved patches then a foot and its osculating paraboloid.
ITEM, A, B, PLACE, REACH, STAMP, COLUMNS = 0, 1, 2, 3, 6, 7, 8
WITH_MODEL = COLUMNS + REMEMBERED
CHUNK = 64  # points at least that share one scratch space
CHUNKS = 64  # scratch spaces at most, but for the last: one costs as much as 50 tracked points


class Hints(NamedTuple):
    """What a search found at the middle of each cell of a grid from `low`: where one without a seed begins, and ends if
    the point lies in its reach."""

    low: np.ndarray
    per_mm: np.ndarray
    seed: np.ndarray  # (nx, ny, nz, 4) item, a, b, reach


@njit(**INNER)
def nearest(skin, p, hint, hint_a, hint_b, stack, bounds, work):
    """The item with the closest point: item, two parameters, foot.

    hint : item and parameters found last time, item < 0 for none; it only tightens the search
    """
    best, item, a, b, foot = np.inf, -1, 0.0, 0.0, p
    # The hint comes first, then the trees from their roots.
    other, a1, b1 = hint, hint_a, hint_b
    top, k, stop = 0, 0, 0
    for root in skin.roots:
        if root >= 0:
            stack[top], bounds[top] = root, 0.0
            top += 1
    if not 0 <= hint < len(skin.items):
        other = -1
    while True:
        if other >= 0:
            value, a1, b1, foot1 = try_item(skin, other, p, best, a1, b1, work)
            if value < best:
                best, item, a, b, foot = value, other, a1, b1, foot1
            other = -1
        if k < stop:
            # Items of a leaf of the tree.
            if box_distance(skin.items[skin.order[k]], p) < best:
                other, a1, b1 = skin.order[k], -1.0, -1.0
            k += 1
            continue
        if top == 0:
            return item, a, b, foot
        top -= 1
        if bounds[top] >= best:
            continue
        node = skin.nodes[stack[top]]
        child = node.child
        if child < 0:
            k, stop = node.start, node.stop
            continue
        left, right = box_distance(skin.nodes[child], p), box_distance(skin.nodes[child + 1], p)
        # The nearer child goes on top of the stack.
        if left <= right:
            stack[top], bounds[top] = child + 1, right
            stack[top + 1], bounds[top + 1] = child, left
        else:
            stack[top], bounds[top] = child, left
            stack[top + 1], bounds[top + 1] = child + 1, right
        top += 2


@njit(**INNER)
def careful_search(skin, p, hint, hint_a, hint_b, entries, bounds, work, out):
    """Fill out with the answer at the nearest item of all: item, two parameters, face."""
    item, a, b, foot = nearest(skin, p, hint, hint_a, hint_b, entries, bounds, work)
    d, q, n, k1, k2, e, label = answer(skin, item, a, b, p, foot, work)
    write(out, d, q, n, k1, k2, e)
    return item, a, b, label


@njit(forceinline=True, **POINT)
def hint_at(p, low, per_mm, grid):
    """Item, a, b, reach and middle of the cell of a point, or of the nearest cell."""
    i = min(grid.shape[0] - 1, max(0, int((p[0] - low[0]) * per_mm[0])))
    j = min(grid.shape[1] - 1, max(0, int((p[1] - low[1]) * per_mm[1])))
    k = min(grid.shape[2] - 1, max(0, int((p[2] - low[2]) * per_mm[2])))
    at = (low[0] + (i + 0.5) / per_mm[0], low[1] + (j + 0.5) / per_mm[1], low[2] + (k + 0.5) / per_mm[2])
    return int(grid[i, j, k, 0]), grid[i, j, k, 1], grid[i, j, k, 2], grid[i, j, k, 3], at


@njit(forceinline=True, **POINT)
def put(i, d, q, m, k1, k2, e, label, distance, point, normal, curvature, direction, face):
    """Fill the fields of a Projection for one point."""
    distance[i], face[i], curvature[i, 0], curvature[i, 1] = d, label, k1, k2
    for c in range(3):
        point[i, c], normal[i, c], direction[i, c] = q[c], m[c], e[c]


@njit(forceinline=True, **POINT)
def taken(out):
    """What `write` (track.py) has put there: distance, foot, normal, curvatures, direction."""
    return out[0], (out[1], out[2], out[3]), (out[4], out[5], out[6]), out[10], out[11], (out[7], out[8], out[9])


@njit(forceinline=True, **POINT)
def put_seed(new_seed, i, item, a, b, at, reach, stamp):
    new_seed[i, ITEM], new_seed[i, A], new_seed[i, B], new_seed[i, REACH] = item, a, b, reach
    new_seed[i, PLACE], new_seed[i, PLACE + 1], new_seed[i, PLACE + 2] = at
    new_seed[i, STAMP] = stamp


@njit(forceinline=True, **POINT)
def put_model(new_seed, i, leaves, patches, power, ref, a, b, step, label, found, out):
    """Remember the foot on leaf `ref`, where no boundary is near; ref < 0 for a foot that is not on a leaf."""
    if ref >= 0 and surely_in(leaves[ref], a, b):
        leaf = leaves[ref]
        remember(new_seed, i, COLUMNS, leaf, patches[leaf.patch], power, a, b, step, label, found, out)
    else:
        for c in range(COLUMNS, WITH_MODEL):
            new_seed[i, c] = 0.0


@njit(**INNER)
def track_chunk(
    skin, hints, stamp, rows, start, stop, scratch, left, points, seed,
    distance, point, normal, curvature, direction, face, new_seed,
):  # fmt: skip
    """Answer those of points[rows[start:stop]] that are in reach of their last search: its item is looked at alone.

    left : filled with the others, whose new seeds then have the hint to search from; returns their number
    """
    work, found, out = scratch
    items, faces, rims, leaves, patches = skin.items, skin.faces, skin.rims, skin.leaves, skin.patches
    rasters, pieces, ctrl, power = skin.rasters, skin.pieces, skin.ctrl, skin.power
    low, per_mm, grid = hints.low, hints.per_mm, hints.seed
    tracked, modelled = found[0], seed.shape[1] == WITH_MODEL
    n_left = 0
    for row in range(start, stop):
        i = rows[row]
        p = (points[i, 0], points[i, 1], points[i, 2])
        own = seed[i, STAMP] == stamp
        if own:
            item, a, b, reach = int(seed[i, ITEM]), seed[i, A], seed[i, B], seed[i, REACH]
            at, room = (seed[i, PLACE], seed[i, PLACE + 1], seed[i, PLACE + 2]), reach
        else:
            item, a, b, reach, at = hint_at(p, low, per_mm, grid)
            # So much of it must be left as a search looks for.
            room = max(0.0, reach - SKIN)
        x, y, z = p[0] - at[0], p[1] - at[1], p[2] - at[2]
        moved = x * x + y * y + z * z
        if moved < room * room:
            if own and modelled and seed[i, COLUMNS + CALM] > 0.0:
                served, d, q, m, k1, k2, e, ds, dt = recall(seed, i, COLUMNS, p)
                if served:
                    label = int(seed[i, COLUMNS + LABEL])
                    put(i, d, q, m, k1, k2, e, label, distance, point, normal, curvature, direction, face)
                    for c in range(WITH_MODEL):
                        new_seed[i, c] = seed[i, c]
                    continue
                # Else its shift is where Newton starts.
                a, b = min(1.0, max(0.0, a + ds)), min(1.0, max(0.0, b + dt))
            kind, ref, label, fresh, step = items[item].kind, items[item].ref, -1, -1, 0.0
            if kind == ON_FACE:
                sure = a > 0.0 and moved < a * a
                d, q, m, k1, k2, e, label = track_face(faces[ref], rims[ref], rasters, pieces, ctrl, p, sure, work)
            else:
                if kind == ON_LEAF:
                    leaf = leaves[ref]
                    patch = patches[leaf.patch]
                    face1, rim, fresh = faces[patch.face], rims[patch.face], ref
                    tiny = 1.0 if own else CONVERGED
                    a, b, label, step = track_leaf(
                        leaf, patch, face1, rim, rasters, pieces, ctrl, power, p, a, b, tiny, tracked, work, out
                    )
                else:
                    a, b, label = track_edge(skin, item, a, b, p, work, out)
                d, q, m, k1, k2, e = taken(out)
            if label >= 0:
                put(i, d, q, m, k1, k2, e, label, distance, point, normal, curvature, direction, face)
                put_seed(new_seed, i, item, a, b, at, reach, stamp)
                if modelled:
                    put_model(new_seed, i, leaves, patches, power, fresh, a, b, step, label, tracked, out)
                continue
        if not own:
            a, b = -1.0, -1.0
        new_seed[i, ITEM], new_seed[i, A], new_seed[i, B] = item, a, b
        left[n_left] = i
        n_left += 1
    return n_left


@njit(**INNER)
def search_chunk(
    skin, stamp, left, n_left, scratch, points,
    distance, point, normal, curvature, direction, face, new_seed,
):  # fmt: skip
    """Answer the first n_left of the points in `left` by a search from the hints in their new seeds."""
    entries, bounds, pending, work, found, out = scratch
    items, faces, rims, leaves, patches = skin.items, skin.faces, skin.rims, skin.leaves, skin.patches
    rasters, pieces, ctrl, power = skin.rasters, skin.pieces, skin.ctrl, skin.power
    nodes, order, root = skin.nodes, skin.order, skin.roots[0]
    modelled = new_seed.shape[1] == WITH_MODEL
    for k in range(n_left):
        i = left[k]
        p = (points[i, 0], points[i, 1], points[i, 2])
        hint, hint_a, hint_b = int(new_seed[i, ITEM]), new_seed[i, A], new_seed[i, B]
        item, a, b, row, reach, fresh = -1, 0.0, 0.0, 0, AGAIN, -1
        for attempt in range(2):
            if reach == AGAIN:
                item, a, b, row, reach = quick_search(
                    skin, items, nodes, order, root, faces, rims, leaves, patches, rasters, pieces, ctrl, power,
                    p, hint, hint_a, hint_b, attempt == 0, entries, bounds, pending, found, work,
                )  # fmt: skip
        kind, ref = items[item].kind, items[item].ref
        if reach >= 0.0 and kind == ON_FACE:
            label = faces[ref].label
            _, d, q, m, k1, k2, e = form_of(faces[ref], rims[ref], p)
            a = room_inside(faces[ref], rims[ref], rasters, pieces, p)
        else:
            if reach < 0.0:
                reach = 0.0
                if hint < 0:
                    hint, hint_a, hint_b = item, a, b
                item, a, b, label = careful_search(skin, p, hint, hint_a, hint_b, entries, bounds, work, out)
            elif kind == ON_LEAF and answer_on_patch(p, found[row], leaves[ref].sense, out):
                label, fresh = faces[patches[leaves[ref].patch].face].label, ref
            else:
                label = settle(skin, item, a, b, p, found[row], work, out)
            d, q, m, k1, k2, e = taken(out)
        put(i, d, q, m, k1, k2, e, label, distance, point, normal, curvature, direction, face)
        put_seed(new_seed, i, item, a, b, p, reach, stamp)
        if modelled:
            put_model(new_seed, i, leaves, patches, power, fresh, a, b, 0.0, label, found[row], out)


@njit(parallel=True, cache=True)
def project_points(
    skin, hints, stamp, rows, points, seed, distance, point, normal, curvature, direction, face, new_seed
):
    """Fill these rows of the fields of a Projection. Points are independent: the same bits at any thread count.

    hints : the grid of hints
    stamp : number of the surface; seeds that carry another are not its own
    rows : (k,) of points (n, 3) to be looked at, each once
    seed, new_seed : (n, columns), may be the same array
    """
    n = len(rows)
    size = max(CHUNK, n // CHUNKS)
    for chunk in prange((n + size - 1) // size):
        start, stop = chunk * size, min(n, (chunk + 1) * size)
        scratch = np.zeros(WORK), np.zeros((2, 6, 3)), np.zeros(ANSWER)
        left = np.zeros(size, np.int64)
        n_left = track_chunk(
            skin, hints, stamp, rows, start, stop, scratch, left, points, seed,
            distance, point, normal, curvature, direction, face, new_seed,
        )  # fmt: skip
        if n_left:
            waiting = np.zeros(WAITING, np.int64), np.zeros(WAITING), np.zeros((PENDING, 4))
            search_chunk(
                skin, stamp, left, n_left, (*waiting, *scratch), points,
                distance, point, normal, curvature, direction, face, new_seed,
            )  # fmt: skip
