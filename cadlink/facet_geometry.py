"""One facet: the closest point on a flat triangle or a Nagata patch, and the shape of a patch there.

    p, q    point and its foot [mm];  m = p - q
    region  where the foot lies: 0 inside the facet, 1 .. 4 on side 0 .. 3, 5 .. 8 at corner 0 .. 3
    s, t    parameters of a facet: corners at (0, 0), (1, 0), (0, 1) or (0, 0), (1, 0), (1, 1), (0, 1)
    a       coefficients of a facet: x = a0 + a1 s + a2 t + a3 s^2 + a4 s t + a5 t^2 + a6 s^2 t + a7 s t^2
    n       unit normal out of the material;  k, e  curvatures and principal direction

Distances are exact to round-off on flat triangles (Ericson, Real-Time Collision Detection, 5.1.5) and converged to
1e-12 mm on Nagata patches: cubic equations on their sides, Newton inside.
"""

from math import sqrt

import numpy as np
from numba import njit


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
