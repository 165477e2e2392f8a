"""The closest point of a skin of facets: flat triangles with element or nodal normals, or Nagata patches.

    p, q    point and its foot [mm];  m = p - q
    region  where the foot lies: 0 inside the facet, 1 .. 4 on side 0 .. 3, 5 .. 8 at corner 0 .. 3
    s, t    parameters of a facet: corners at (0, 0), (1, 0), (0, 1) or (0, 0), (1, 0), (1, 1), (0, 1)
    a       coefficients of a facet: x = a0 + a1 s + a2 t + a3 s^2 + a4 s t + a5 t^2 + a6 s^2 t + a7 s t^2
    n       unit normal out of the material;  k, e  curvatures and principal direction

Distances are exact to round-off on flat triangles (Ericson, Real-Time Collision Detection, 5.1.5) and converged to
1e-12 mm on Nagata patches: cubic equations on their sides, Newton inside.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit, prange

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


@njit(forceinline=True)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(forceinline=True)
def minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(forceinline=True)
def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(forceinline=True)
def scaled(a, x):
    return a[0] * x, a[1] * x, a[2] * x


@njit(forceinline=True)
def row(array, i):
    return array[i, 0], array[i, 1], array[i, 2]


@njit(forceinline=True)
def blend(a, b, c, v, w):
    """a + v (b - a) + w (c - a)."""
    u = 1.0 - v - w
    return u * a[0] + v * b[0] + w * c[0], u * a[1] + v * b[1] + w * c[1], u * a[2] + v * b[2] + w * c[2]


@njit(forceinline=True)
def on_segment(p, a, b):
    """Parameter of the foot on a segment, in [0, 1]."""
    d = minus(b, a)
    h = dot(d, d)
    return min(1.0, max(0.0, dot(minus(p, a), d) / h)) if h > 0.0 else 0.0


@njit
def foot_on_triangle(p, a, b, c, thin):
    """region, v, w: foot a + v (b - a) + w (c - a) of a point on a triangle."""
    if not thin:
        ab, ac, ap = minus(b, a), minus(c, a), minus(p, a)
        d1, d2 = dot(ab, ap), dot(ac, ap)
        if d1 <= 0.0 and d2 <= 0.0:
            return 5, 0.0, 0.0
        bp = minus(p, b)
        d3, d4 = dot(ab, bp), dot(ac, bp)
        if d3 >= 0.0 and d4 <= d3:
            return 6, 1.0, 0.0
        vc = d1 * d4 - d3 * d2
        if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
            return 1, d1 / (d1 - d3), 0.0
        cp = minus(p, c)
        d5, d6 = dot(ab, cp), dot(ac, cp)
        if d6 >= 0.0 and d5 <= d6:
            return 7, 0.0, 1.0
        vb = d5 * d2 - d1 * d6
        if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
            return 3, 0.0, d2 / (d2 - d6)
        va = d3 * d6 - d5 * d4
        if va <= 0.0 and d4 >= d3 and d5 >= d6:
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            return 2, 1.0 - w, w
        # Inside: the foot by the normal equations, scaled to the triangle.
        return 0, vb / (va + vb + vc), vc / (va + vb + vc)
    best, region, v, w = np.inf, 5, 0.0, 0.0
    for side in range(3):
        x, y = (a, b) if side == 0 else ((b, c) if side == 1 else (c, a))
        s = on_segment(p, x, y)
        m = minus(p, blend(x, y, x, s, 0.0))
        h = dot(m, m)
        if h < best:
            best = h
            region = 1 + side if 0.0 < s < 1.0 else 5 + (side + (1 if s >= 1.0 else 0)) % 3
            v = s if side == 0 else (1.0 - s if side == 1 else 0.0)
            w = 0.0 if side == 0 else (s if side == 1 else 1.0 - s)
    return region, v, w


@njit
def surface_at(a, s, t):
    """x, x_s, x_t of a facet."""
    x = (0.0, 0.0, 0.0)
    xs, xt = x, x
    f = (1.0, s, t, s * s, s * t, t * t, s * s * t, s * t * t)
    fs = (0.0, 1.0, 0.0, 2.0 * s, t, 0.0, 2.0 * s * t, t * t)
    ft = (0.0, 0.0, 1.0, 0.0, s, 2.0 * t, s * s, 2.0 * s * t)
    for i in range(8):
        b = row(a, i)
        x = (x[0] + f[i] * b[0], x[1] + f[i] * b[1], x[2] + f[i] * b[2])
        xs = (xs[0] + fs[i] * b[0], xs[1] + fs[i] * b[1], xs[2] + fs[i] * b[2])
        xt = (xt[0] + ft[i] * b[0], xt[1] + ft[i] * b[1], xt[2] + ft[i] * b[2])
    return x, xs, xt


@njit(forceinline=True)
def bends_at(a, s, t):
    """x_ss, x_st, x_tt of a facet."""
    b, c, d, e, f = row(a, 3), row(a, 4), row(a, 5), row(a, 6), row(a, 7)
    return (
        (2.0 * (b[0] + t * e[0]), 2.0 * (b[1] + t * e[1]), 2.0 * (b[2] + t * e[2])),
        (
            c[0] + 2.0 * (s * e[0] + t * f[0]),
            c[1] + 2.0 * (s * e[1] + t * f[1]),
            c[2] + 2.0 * (s * e[2] + t * f[2]),
        ),
        (2.0 * (d[0] + s * f[0]), 2.0 * (d[1] + s * f[1]), 2.0 * (d[2] + s * f[2])),
    )


@njit(forceinline=True)
def side_point(side, sides, r):
    """(s, t) at r along a side, in the direction the corners are listed."""
    if side == 0:
        return r, 0.0
    if sides == 3:
        return (1.0 - r, r) if side == 1 else (0.0, 1.0 - r)
    return (1.0, r) if side == 1 else ((1.0 - r, 1.0) if side == 2 else (0.0, 1.0 - r))


@njit
def foot_on_parabola(p, x0, x1, xm):
    """Parameter of the nearest point of the parabola through x0, xm (at 1/2) and x1, in [0, 1], and distance squared.

    Half the derivative of the squared distance is a cubic; its roots where it rises are the minima.
    """
    # x = x0 + r b + r^2 c
    cx = (2.0 * (x0[0] + x1[0]) - 4.0 * xm[0], 2.0 * (x0[1] + x1[1]) - 4.0 * xm[1], 2.0 * (x0[2] + x1[2]) - 4.0 * xm[2])
    bx = (x1[0] - x0[0] - cx[0], x1[1] - x0[1] - cx[1], x1[2] - x0[2] - cx[2])
    q = minus(x0, p)
    g0, g1, g2, g3 = dot(q, bx), dot(bx, bx) + 2.0 * dot(q, cx), 3.0 * dot(bx, cx), 2.0 * dot(cx, cx)
    # The cubic is monotone between 0, its turning points and 1.
    t1, t2 = 0.0, 0.0
    disc = g2 * g2 - 3.0 * g3 * g1
    if disc > 0.0:
        h = -(g2 + sqrt(disc)) if g2 >= 0.0 else -(g2 - sqrt(disc))
        r1 = h / (3.0 * g3) if g3 > 0.0 else -1.0
        r2 = g1 / h if h != 0.0 else -1.0
        t1, t2 = min(1.0, max(0.0, min(r1, r2))), min(1.0, max(0.0, max(r1, r2)))
    best, found = np.inf, 0.0
    lo, g_lo = 0.0, g0
    for k in range(3):
        hi = t1 if k == 0 else (t2 if k == 1 else 1.0)
        g_hi = g0 + hi * (g1 + hi * (g2 + hi * g3))
        r = -1.0
        if k == 0 and g_lo >= 0.0:
            r = 0.0
        elif g_lo < 0.0 <= g_hi and hi > lo:
            left, right = lo, hi
            r = left + (right - left) * g_lo / (g_lo - g_hi)
            for _ in range(60):
                g = g0 + r * (g1 + r * (g2 + r * g3))
                if g < 0.0:
                    left = r
                else:
                    right = r
                slope = g1 + r * (2.0 * g2 + r * 3.0 * g3)
                new = r - g / slope if slope > 0.0 else 0.5 * (left + right)
                if not left <= new <= right:
                    new = 0.5 * (left + right)
                step = abs(new - r)
                r = new
                if step <= 1e-16 or g == 0.0:
                    break
        elif k == 2 and g_hi < 0.0:
            r = 1.0
        if r >= 0.0:
            y = (q[0] + r * (bx[0] + r * cx[0]), q[1] + r * (bx[1] + r * cx[1]), q[2] + r * (bx[2] + r * cx[2]))
            h = dot(y, y)
            if h < best:
                best, found = h, r
        lo, g_lo = hi, g_hi
    return found, best


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
def foot_on_patch(p, a, sides, bend):
    """region, s, t of the foot on a Nagata patch, and its distance."""
    best, region, s, t = np.inf, 0, 0.0, 0.0
    for side in range(sides):
        s0, t0 = side_point(side, sides, 0.0)
        s1, t1 = side_point(side, sides, 1.0)
        sm, tm = side_point(side, sides, 0.5)
        x0, _, _ = surface_at(a, s0, t0)
        x1, _, _ = surface_at(a, s1, t1)
        xm, _, _ = surface_at(a, sm, tm)
        r, h = foot_on_parabola(p, x0, x1, xm)
        if h < best:
            best = h
            s, t = side_point(side, sides, r)
            region = 1 + side if 0.0 < r < 1.0 else 5 + (side + (1 if r >= 1.0 else 0)) % sides
    # Inside: Newton from the middle, and from towards each corner where the patch may bend round the point; a foot
    # outside is answered by a side.
    single = sqrt(best) * bend < 0.3
    for start in range(sides + 1):
        if start == 0:
            u, v = (1.0 / 3.0, 1.0 / 3.0) if sides == 3 else (0.5, 0.5)
        else:
            c, d = side_point(start - 1, sides, 0.0)
            u, v = (0.6 * c + 0.4 / 3.0, 0.6 * d + 0.4 / 3.0) if sides == 3 else (0.6 * c + 0.2, 0.6 * d + 0.2)
        converged = False
        for _ in range(30):
            x, xs, xt = surface_at(a, u, v)
            xss, xst, xtt = bends_at(a, u, v)
            m = minus(x, p)
            gs, gt = dot(m, xs), dot(m, xt)
            hss, hst, htt = dot(xs, xs) + dot(m, xss), dot(xs, xt) + dot(m, xst), dot(xt, xt) + dot(m, xtt)
            det = hss * htt - hst * hst
            if not (hss > 0.0 and det > 1e-6 * hss * htt):
                hss, hst, htt = dot(xs, xs), dot(xs, xt), dot(xt, xt)
                det = hss * htt - hst * hst
            if not det > 0.0:
                break
            du, dv = (hst * gt - htt * gs) / det, (hst * gs - hss * gt) / det
            longest = max(abs(du), abs(dv))
            if longest > 0.5:
                du, dv = du * 0.5 / longest, dv * 0.5 / longest
            u, v = u + du, v + dv
            if u < -0.3 or v < -0.3 or u > 1.3 or v > 1.3:
                break
            if longest <= 1e-14:
                converged = True
                break
            converged = longest <= 1e-9
        within = u >= 0.0 and v >= 0.0 and (u + v <= 1.0 if sides == 3 else (u <= 1.0 and v <= 1.0))
        if converged and within:
            x, _, _ = surface_at(a, u, v)
            m = minus(x, p)
            h = dot(m, m)
            if h < best:
                best, region, s, t = h, 0, u, v
        if single and (converged or start > 0):
            break
    return region, s, t, sqrt(best)


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


@njit(forceinline=True)
def any_across(n):
    """A unit vector across n."""
    e = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    return scaled(e, 1.0 / sqrt(dot(e, e)))


@njit
def principal(n, xs, xt, bss, bst, bts, btt):
    """k1 >= k2 and the direction of k1 from tangents and the form b (b_ij = n_j . x_i), its symmetric part."""
    t1 = minus(xs, scaled(n, dot(xs, n)))
    length = sqrt(dot(t1, t1))
    if length == 0.0:
        return 0.0, 0.0, any_across(n)
    t1 = scaled(t1, 1.0 / length)
    t2 = cross(n, t1)
    f, g = dot(xt, t1), dot(xt, t2)
    if abs(g) <= 1e-12 * abs(length):
        return 0.0, 0.0, t1
    # s, t to lengths along t1, t2: (1/length, 0) and (-f/(length g), 1/g).
    i, j, k = 1.0 / length, -f / (length * g), 1.0 / g
    w11 = i * i * bss
    w12 = i * (j * bss + k * bst)
    w21 = i * (j * bss + k * bts)
    w22 = j * j * bss + j * k * (bst + bts) + k * k * btt
    w12 = 0.5 * (w12 + w21)
    mean, half = 0.5 * (w11 + w22), 0.5 * (w11 - w22)
    spread = sqrt(half * half + w12 * w12)
    if spread == 0.0:
        return mean, mean, t1
    # Eigenvector of mean + spread.
    x, y = (half + spread, w12) if half >= 0.0 else (w12, spread - half)
    size = sqrt(x * x + y * y)
    x, y = x / size, y / size
    e = (x * t1[0] + y * t2[0], x * t1[1] + y * t2[1], x * t1[2] + y * t2[2])
    return mean + spread, mean - spread, e


@njit
def patch_shape(a, s, t):
    """Outward normal, k1, k2, direction of k1 of a Nagata patch."""
    _, xs, xt = surface_at(a, s, t)
    n = cross(xs, xt)
    size = sqrt(dot(n, n))
    if size == 0.0:
        return n, 0.0, 0.0, any_across((0.0, 0.0, 1.0))
    n = scaled(n, 1.0 / size)
    xss, xst, xtt = bends_at(a, s, t)
    b12 = -dot(xst, n)
    k1, k2, e = principal(n, xs, xt, -dot(xss, n), b12, b12, -dot(xtt, n))
    return n, k1, k2, e


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
