"""The closest point of a skin of facets: flat triangles with element or nodal normals, or Nagata patches.

Symbols are those of facet_geometry.py. An item is what is searched: a triangle, or an element that is one Nagata patch.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from cadlink.facet_geometry import (
    any_across,
    bends_at,
    blend,
    cross,
    dot,
    foot_on_patch,
    foot_on_triangle,
    minus,
    patch_shape,
    principal,
    row,
    scaled,
    side_point,
    surface_at,
)
from cadlink.facet_tree import DEPTH, LEAF, node_distance

ELEMENT, NODAL, NAGATA = 0, 1, 2
SHARP = 1e12  # 1/mm, stands for the curvature across a sharp edge
TOUCH = 1e-9  # mm: nearer than this m has no direction
CHUNK = 64  # points that share one stack
TIE = 1e-13  # of the size: facets as near as this are equally near, and the one that faces the point wins


class FacetSkin(NamedTuple):
    low: np.ndarray  # (n_nodes, 3) mm, the boxes of a FacetTree
    high: np.ndarray  # (n_nodes, 3) mm
    order: np.ndarray  # items leaf by leaf, -1 for none
    points: np.ndarray  # (n, 3) mm
    items: np.ndarray  # (k, 4) points of what is searched: triangles, or the elements of Nagata patches; -1 for none
    element: np.ndarray  # (k,) element of each item
    place: np.ndarray  # (k, 3) corners of its element that a triangle has
    normal: np.ndarray  # (k, 3) of a triangle; of an element where items are elements
    thin: np.ndarray  # (k,) bool: a triangle without an area, searched on its sides only
    side_normal: np.ndarray  # (k, 4, 3) pseudo-normals of the sides
    side_sharp: np.ndarray  # (k, 4) bool: a rim or a crease
    neighbour: np.ndarray  # (k, 4, 2) the item across each side and its side there, -1 for none
    point_normal: np.ndarray  # (n, 3) pseudo-normals of the points
    point_sharp: np.ndarray  # (n,) bool: a rim or a crease ends there
    patch: np.ndarray  # (m, 8, 3) coefficients of the elements
    field: np.ndarray  # (m, 8, 3) coefficients of the normals, interpolated or one for the element
    sides: np.ndarray  # (m,) 3 or 4
    bulge: np.ndarray  # (m,) mm, how far a patch may be from the flat triangles between its corners
    bend: np.ndarray  # (m,) 1/mm, about its largest curvature
    label: np.ndarray  # (m,) the element's number in the user's list


@njit
def flat_distance(skin, item, p):
    """Distance to the flat triangles between the corners of an element [mm]."""
    c = skin.items[item]
    x, best = row(skin.points, c[0]), np.inf
    for k in range(skin.sides[item] - 2):
        y, z = row(skin.points, c[k + 1]), row(skin.points, c[k + 2])
        _, v, w = foot_on_triangle(p, x, y, z, False)
        m = minus(p, blend(x, y, z, v, w))
        best = min(best, dot(m, m))
    return sqrt(best)


@njit
def nearest_facet(skin, kind, tie, p, seed, stack, bounds):
    """item, region, s, t, foot of the nearest facet; of equally near ones the one that faces the point most."""
    first_leaf = len(skin.low) // 2
    best, facing, item, region, s, t = np.inf, -1.0, -1, 0, 0.0, 0.0
    foot = p
    # The seed's facet comes first: it only tightens the search.
    stack[0], bounds[0], top = 0, 0.0, 1
    other = seed if 0 <= seed < len(skin.items) else -1
    k, stop = 0, 0
    while True:
        if other >= 0 and kind == NAGATA and flat_distance(skin, other, p) - skin.bulge[other] > best + tie:
            other = -1
        if other >= 0:
            c = skin.items[other]
            if kind == NAGATA:
                r1, s1, t1, h = foot_on_patch(p, skin.patch[other], skin.sides[other], skin.bend[other])
                q, _, _ = surface_at(skin.patch[other], s1, t1)
                m = minus(p, q)
            else:
                a, b, d = row(skin.points, c[0]), row(skin.points, c[1]), row(skin.points, c[2])
                r1, s1, t1 = foot_on_triangle(p, a, b, d, skin.thin[other])
                q = blend(a, b, d, s1, t1)
                m = minus(p, q)
                h = sqrt(dot(m, m))
                if r1 == 0:
                    # The height over the plane has no round-off from the foot.
                    n = row(skin.normal, other)
                    h = abs(dot(minus(p, a), n))
            if h <= best + tie:
                face = abs(dot(m, row(skin.normal, other)))
                if h < best - tie or face > facing:
                    best, facing, item, region, s, t, foot = min(best, h), face, other, r1, s1, t1, q
            other = -1
        if k < stop:
            other = skin.order[k]
            k += 1
            continue
        if top == 0:
            return item, region, s, t, foot
        top -= 1
        if bounds[top] > best + tie:
            continue
        node = stack[top]
        if node >= first_leaf:
            k = (node - first_leaf) * LEAF
            stop = k + LEAF
            continue
        child = 2 * node + 1
        left, right = node_distance(skin.low, skin.high, child, p), node_distance(skin.low, skin.high, child + 1, p)
        near, far, low, high = (child, child + 1, left, right) if left <= right else (child + 1, child, right, left)
        stack[top], bounds[top] = far, high
        stack[top + 1], bounds[top + 1] = near, low
        top += 2


@njit
def nodal_shape(skin, item, v, w, foot, normal):
    """Interpolated normal and how it turns: n, k1, k2, direction of k1."""
    element = skin.element[item]
    a, sides = skin.patch[element], skin.sides[element]
    place = skin.place[item]
    s0, t0 = side_point(place[0], sides, 0.0)
    s1, t1 = side_point(place[1], sides, 0.0)
    s2, t2 = side_point(place[2], sides, 0.0)
    s, t = s0 + v * (s1 - s0) + w * (s2 - s0), t0 + v * (t1 - t0) + w * (t2 - t0)
    if sides == 4:
        # The same point in the quadrilateral's own bilinear parameters.
        for _ in range(8):
            x, xs, xt = surface_at(a, s, t)
            m = minus(foot, x)
            e, f, g = dot(xs, xs), dot(xs, xt), dot(xt, xt)
            det = e * g - f * f
            if not det > 1e-12 * e * g:
                break
            gs, gt = dot(m, xs), dot(m, xt)
            ds, dt = (g * gs - f * gt) / det, (e * gt - f * gs) / det
            s, t = min(1.0, max(0.0, s + ds)), min(1.0, max(0.0, t + dt))
            if max(abs(ds), abs(dt)) < 1e-14:
                break
    _, xs, xt = surface_at(a, s, t)
    n, ns, nt = surface_at(skin.field[element], s, t)
    size = sqrt(dot(n, n))
    if size < 1e-6:
        return normal, 0.0, 0.0, any_across(normal)
    n = scaled(n, 1.0 / size)
    ns, nt = scaled(ns, 1.0 / size), scaled(nt, 1.0 / size)
    ns, nt = minus(ns, scaled(n, dot(n, ns))), minus(nt, scaled(n, dot(n, nt)))
    k1, k2, e = principal(n, xs, xt, dot(ns, xs), dot(nt, xs), dot(ns, xt), dot(nt, xt))
    return n, k1, k2, e


@njit
def facet_answer(skin, kind, item, region, s, t, p, foot):
    """Signed distance, normal, k1, k2, direction of k1 at the foot on the nearest facet."""
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    mine = row(skin.normal, item)
    tangent, bend = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if kind == NAGATA:
        n, k1, k2, e = patch_shape(skin.patch[item], s, t)
    elif kind == NODAL:
        n, k1, k2, e = nodal_shape(skin, item, s, t, foot, mine)
    else:
        n = row(skin.field[skin.element[item]], 0)
        k1, k2, e = 0.0, 0.0, any_across(n)
    # The side of the surface, and whether the foot is on a sharp edge.
    mean, sharp = n, False
    if region == 0:
        if kind != NAGATA:
            mean = mine
            h = abs(dot(minus(p, row(skin.points, skin.items[item, 0])), mine))
    elif region < 5:
        side = region - 1
        sharp = skin.side_sharp[item, side]
        mean = row(skin.side_normal[item], side)
        if kind == NAGATA:
            other, j = skin.neighbour[item, side, 0], skin.neighbour[item, side, 1]
            n_sides = skin.sides[item]
            s0, t0 = side_point(side, n_sides, 0.0)
            s1, t1 = side_point(side, n_sides, 1.0)
            r = ((s - s0) * (s1 - s0) + (t - t0) * (t1 - t0)) / ((s1 - s0) ** 2 + (t1 - t0) ** 2)
            _, xs, xt = surface_at(skin.patch[item], s, t)
            xss, xst, xtt = bends_at(skin.patch[item], s, t)
            a, b = s1 - s0, t1 - t0
            tangent = (a * xs[0] + b * xt[0], a * xs[1] + b * xt[1], a * xs[2] + b * xt[2])
            bend = (
                a * a * xss[0] + 2.0 * a * b * xst[0] + b * b * xtt[0],
                a * a * xss[1] + 2.0 * a * b * xst[1] + b * b * xtt[1],
                a * a * xss[2] + 2.0 * a * b * xst[2] + b * b * xtt[2],
            )
            mean = n
            if other >= 0:
                s2, t2 = side_point(j, skin.sides[other], 1.0 - r)
                n2, _, _, _ = patch_shape(skin.patch[other], s2, t2)
                mean = (n[0] + n2[0], n[1] + n2[1], n[2] + n2[2])
        else:
            c = skin.items[item]
            tangent = minus(row(skin.points, c[(side + 1) % 3]), row(skin.points, c[side]))
    else:
        corner = skin.items[item, region - 5]
        sharp = skin.point_sharp[corner]
        mean = row(skin.point_normal, corner)
    sign = 1.0 if dot(m, mean) >= 0.0 else -1.0
    d = sign * h
    # Where the surface goes on smoothly the gradient is the normal of a Nagata patch; element and nodal normals are
    # what their names say.
    if not (sharp or kind == NAGATA):
        return d, n, k1, k2, e
    if region > 0 and h > TOUCH:
        n = scaled(m, sign / h)
    elif region > 0:
        size = sqrt(dot(mean, mean))
        n = scaled(mean, 1.0 / size) if size > 0.0 else n
    if not sharp:
        e = minus(e, scaled(n, dot(e, n)))
        size = sqrt(dot(e, e))
        return d, n, k1, k2, (scaled(e, 1.0 / size) if size > 0.0 else any_across(n))
    if region >= 5:
        return d, n, sign * SHARP, sign * SHARP, any_across(n)
    across = cross(tangent, n)
    size = sqrt(dot(across, across))
    across = scaled(across, 1.0 / size) if size > 0.0 else any_across(n)
    along = cross(n, across)
    speed = dot(tangent, tangent)
    k = -dot(bend, n) / speed if speed > 0.0 else 0.0
    if sign > 0.0:
        return d, n, SHARP, k, across
    return d, n, k, -SHARP, along


@njit(parallel=True, cache=True)
def project_on_facets(skin, kind, tie, points, seed, distance, point, normal, curvature, direction, face, new_seed):
    """Fill the fields of a Projection. Points are independent: the same bits at any thread count."""
    n = len(points)
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        stack, bounds = np.zeros(DEPTH, np.int64), np.zeros(DEPTH)
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            p = (points[i, 0], points[i, 1], points[i, 2])
            item, region, s, t, foot = nearest_facet(skin, kind, tie, p, int(seed[i, 0]), stack, bounds)
            d, nrm, k1, k2, e = facet_answer(skin, kind, item, region, s, t, p, foot)
            distance[i], face[i] = d, skin.label[skin.element[item]]
            for c in range(3):
                point[i, c], normal[i, c], direction[i, c] = foot[c], nrm[c], e[c]
            curvature[i, 0], curvature[i, 1] = k1, k2
            new_seed[i, 0], new_seed[i, 1], new_seed[i, 2] = item, s, t
