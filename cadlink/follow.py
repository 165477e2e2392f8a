"""Closest points of those of many moving points that may have come near: for loops that ask often.

    p       a point in the frame of the surface
    place   where it was when it was last looked at
    reach   of a point: it is looked at where its distance may be smaller
    room    of a seed: how far the point may move before another item can be nearest (its column REACH)

The distance changes by no more than a point moves (it is 1-Lipschitz): one known at a place bounds it from below at any
other. Where its seed tells that a foot stays on the same closed form, it takes no more than the formula. Apart from
project_points, since handing it a whole skin costs 5 us, as much as 200 such feet.
"""

import numpy as np
from numba import njit, prange

from cadlink.closest import CHUNK, ITEM, PLACE, REACH, STAMP, A
from cadlink.kernels import POINT
from cadlink.lipschitz import stays_far
from cadlink.nurbs import WORK
from cadlink.records import PLANE
from cadlink.skin import ON_FACE
from cadlink.track import track_face

FEW = 2000  # points that one thread looks at sooner than several begin
SOON = 0.7  # of its room that a point has moved when others are searched for: then it is, too


@njit(forceinline=True, **POINT)
def follow_rows(
    items, faces, rims, rasters, pieces, ctrl, stamp, points, shift, reach, start, stop, place,
    distance, normal, curvature, direction, face, seed, work, near, left, soon,
):  # fmt: skip
    """Points start to stop of `follow_forms`, into near, left and soon from start on: how many are in each."""
    n_near = n_left = n_soon = 0
    for i in range(start, stop):
        p = (points[i, 0] - shift[0], points[i, 1] - shift[1], points[i, 2] - shift[2])
        if stays_far(p, place, i, distance[i] - reach[i]):
            continue
        place[i, 0], place[i, 1], place[i, 2] = p
        near[start + n_near] = i
        n_near += 1
        item, a, room = int(seed[i, ITEM]), seed[i, A], seed[i, REACH]
        x, y, z = p[0] - seed[i, PLACE], p[1] - seed[i, PLACE + 1], p[2] - seed[i, PLACE + 2]
        moved = x * x + y * y + z * z
        label = -1
        if seed[i, STAMP] == stamp and moved < room * room and items[item].kind == ON_FACE:
            ref = items[item].ref
            sure = a > 0.0 and moved < a * a
            d, _, m, k1, k2, e, label = track_face(faces[ref], rims[ref], rasters, pieces, ctrl, p, sure, work)
        if label < 0:
            left[start + n_left] = i
            n_left += 1
            continue
        distance[i] = d
        if faces[ref].form != PLANE:
            # Of a plane they are what they were.
            face[i], curvature[i, 0], curvature[i, 1] = label, k1, k2
            normal[i, 0], normal[i, 1], normal[i, 2] = m
            direction[i, 0], direction[i, 1], direction[i, 2] = e
        if moved > SOON * SOON * room * room:
            soon[start + n_soon] = i
            n_soon += 1
    return n_near, n_left, n_soon


@njit(forceinline=True, **POINT)
def search_soon(soon, start, n_soon, seed, left, n_left):
    """Add points that will soon leave their room to those to be searched for; returns how many these are."""
    for k in range(start, start + n_soon):
        seed[soon[k], REACH] = 0.0
        left[n_left] = soon[k]
        n_left += 1
    return n_left


@njit(cache=True)
def follow_few(
    items, faces, rims, rasters, pieces, ctrl, stamp, points, shift, reach, place,
    distance, normal, curvature, direction, face, seed, near, left, soon,
):  # fmt: skip
    """`follow_forms` on one thread."""
    n_near, n_left, n_soon = follow_rows(
        items, faces, rims, rasters, pieces, ctrl, stamp, points, shift, reach, 0, len(reach), place,
        distance, normal, curvature, direction, face, seed, np.empty(WORK), near, left, soon,
    )  # fmt: skip
    return n_near, search_soon(soon, 0, n_soon, seed, left, n_left) if n_left else 0


@njit(parallel=True, cache=True)
def follow_forms(
    items, faces, rims, rasters, pieces, ctrl, stamp, points, shift, reach, place,
    distance, normal, curvature, direction, face, seed, near, left, soon, counts,
):  # fmt: skip
    """Fills near (n,) with the points that may lie nearer than their reach, place (n, 3) with where these are, and
    their rows of a Projection, feet excepted, where they stay on the same closed form.

    points (m, 3) of which the first n are looked at, shift (3,): how far the surface has been carried; reach (n,)
    left (n,) : filled with those of them that are to be searched for; soon (n,) and counts (chunks, 3) scratch
    returns : how many are near, and left. What is not a number is near nothing.

    If any are left, those that will soon leave their room are among them, for one call searches many.
    """
    n, n_chunks = len(reach), (len(reach) + CHUNK - 1) // CHUNK
    for chunk in prange(n_chunks):
        start, stop = chunk * CHUNK, min(n, (chunk + 1) * CHUNK)
        counts[chunk, 0], counts[chunk, 1], counts[chunk, 2] = follow_rows(
            items, faces, rims, rasters, pieces, ctrl, stamp, points, shift, reach, start, stop, place,
            distance, normal, curvature, direction, face, seed, np.empty(WORK), near, left, soon,
        )  # fmt: skip
    n_near = n_left = 0
    for chunk in range(n_chunks):
        for k in range(chunk * CHUNK, chunk * CHUNK + counts[chunk, 0]):
            near[n_near] = near[k]
            n_near += 1
        for k in range(chunk * CHUNK, chunk * CHUNK + counts[chunk, 1]):
            left[n_left] = left[k]
            n_left += 1
    if n_left:
        for chunk in range(n_chunks):
            n_left = search_soon(soon, chunk * CHUNK, counts[chunk, 2], seed, left, n_left)
    return n_near, n_left
