"""Points, derivatives and shape of rational Bezier arcs and patches, and closest points on arcs.

    s, t    parameters of one patch (or arc), in [0, 1]
    r       S(s, t) - p, from the point to the curve [mm]
    work    scratch (WORK), one for each thread

Bernstein polynomials serve any degree and place; power.py is quicker where it serves.
"""

from math import atan, atanh, sqrt, tan, tanh

import numpy as np
from numba import njit

from cadlink.kernels import POINT

WORK = (8, 32)
MAX_ITERATIONS = 60
STEP = 1e-10  # mm: a step this small ends Newton; the next error is its square times the curvature
SURE = 1e-4  # mm: below it a step is not tested against the distance, which stalls at round-off


# One rational Bezier patch. Those of one face form a grid, v fastest.
#   degree   p, q;  ctrl  number of its first control point (w x, w y, w z, w), then i (q + 1) + j
#   ramp     how the face's u and v follow s and t;  uv  u0, u1, v0, v1
#   natural  whether s = 0, s = 1, t = 0, t = 1 end the whole surface
#   centre  mm, rational  whether weights differ, steady  whether the power basis serves (power.py)
PATCH = np.dtype(
    [
        ("degree", "i8", 2),
        ("ctrl", "i8"),
        ("ramp", "i8", 2),
        ("uv", "f8", 4),
        ("natural", "i8", 4),
        ("face", "i8"),
        ("centre", "f8", 3),
        ("rational", "i8"),
        ("steady", "i8"),
    ]
)


@njit(**POINT)
def arc_point(ctrl, first, degree, s, out):
    """Homogeneous point, first and second derivative of an arc: rows 0, 1, 2 of out.

    Sum of binomial s^i (1-s)^(n-i) b_i by Horner in (1 - s), differentiated alongside.
    """
    r = 1.0 - s
    for c in range(4):
        out[0, c], out[1, c], out[2, c] = 0.0, 0.0, 0.0
    power, power1, power2, binomial = 1.0, 0.0, 0.0, 1.0
    for i in range(degree + 1):
        for c in range(4):
            b = ctrl[first + i, c] * binomial
            out[2, c] = out[2, c] * r - 2.0 * out[1, c] + b * (i * (i - 1.0) * power2)
            out[1, c] = out[1, c] * r - out[0, c] + b * (i * power1)
            out[0, c] = out[0, c] * r + b * power
        power2, power1, power = power1, power, power * s
        binomial *= (degree - i) / (i + 1.0)


@njit(**POINT)
def bernstein_rows(n, s, work, row):
    """Bernstein polynomials of degree n and their two derivatives in work[row .. row + 2]."""
    r = 1.0 - s
    b, b1, b2 = work[row], work[row + 1], work[row + 2]
    b[0] = 1.0
    for k in range(1, n + 1):
        if k == n:
            for i in range(k):
                b1[i] = b[i]
        if k == n - 1:
            for i in range(k):
                b2[i] = b[i]
        left = 0.0
        for i in range(k):
            old = b[i]
            b[i] = r * old + left
            left = s * old
        b[k] = left
    # Derivatives by differences of the lower degrees, from the end so that they fit in place.
    b1[n] = 0.0
    for i in range(n, -1, -1):
        here = b1[i] if i < n else 0.0
        before = b1[i - 1] if i > 0 else 0.0
        b1[i] = n * (before - here)
    for i in range(n, -1, -1):
        here = b2[i] if i < n - 1 else 0.0
        before = b2[i - 1] if 0 < i < n else 0.0
        older = b2[i - 2] if i > 1 else 0.0
        b2[i] = n * (n - 1.0) * (older - 2.0 * before + here)


@njit(**POINT)
def patch_point(patch, ctrl, s, t, work):
    """S, S_s, S_t, S_ss, S_st, S_tt of a rational patch, three components each.

    Quotient rule on homogeneous derivatives: S_s = (A_s - w_s S) / w and so on (The NURBS Book 4.4).
    """
    p, q, k = patch.degree[0], patch.degree[1], patch.ctrl
    bernstein_rows(p, s, work, 0)
    bernstein_rows(q, t, work, 3)
    x = x_s = x_t = x_ss = x_st = x_tt = 0.0
    y = y_s = y_t = y_ss = y_st = y_tt = 0.0
    z = z_s = z_t = z_ss = z_st = z_tt = 0.0
    w = w_s = w_t = w_ss = w_st = w_tt = 0.0
    for i in range(p + 1):
        a0 = a1 = a2 = b0 = b1 = b2 = c0 = c1 = c2 = d0 = d1 = d2 = 0.0
        for j in range(q + 1):
            t0, t1, t2 = work[3, j], work[4, j], work[5, j]
            a, b, c, d = ctrl[k, 0], ctrl[k, 1], ctrl[k, 2], ctrl[k, 3]
            a0, a1, a2 = a0 + t0 * a, a1 + t1 * a, a2 + t2 * a
            b0, b1, b2 = b0 + t0 * b, b1 + t1 * b, b2 + t2 * b
            c0, c1, c2 = c0 + t0 * c, c1 + t1 * c, c2 + t2 * c
            d0, d1, d2 = d0 + t0 * d, d1 + t1 * d, d2 + t2 * d
            k += 1
        s0, s1, s2 = work[0, i], work[1, i], work[2, i]
        x, x_s, x_ss = x + s0 * a0, x_s + s1 * a0, x_ss + s2 * a0
        x_t, x_st, x_tt = x_t + s0 * a1, x_st + s1 * a1, x_tt + s0 * a2
        y, y_s, y_ss = y + s0 * b0, y_s + s1 * b0, y_ss + s2 * b0
        y_t, y_st, y_tt = y_t + s0 * b1, y_st + s1 * b1, y_tt + s0 * b2
        z, z_s, z_ss = z + s0 * c0, z_s + s1 * c0, z_ss + s2 * c0
        z_t, z_st, z_tt = z_t + s0 * c1, z_st + s1 * c1, z_tt + s0 * c2
        w, w_s, w_ss = w + s0 * d0, w_s + s1 * d0, w_ss + s2 * d0
        w_t, w_st, w_tt = w_t + s0 * d1, w_st + s1 * d1, w_tt + s0 * d2
    f = 1.0 / w
    w_s, w_t, w_ss, w_st, w_tt = w_s * f, w_t * f, w_ss * f, w_st * f, w_tt * f
    x, x_s, x_t, x_ss, x_st, x_tt = over(x, x_s, x_t, x_ss, x_st, x_tt, f, w_s, w_t, w_ss, w_st, w_tt)
    y, y_s, y_t, y_ss, y_st, y_tt = over(y, y_s, y_t, y_ss, y_st, y_tt, f, w_s, w_t, w_ss, w_st, w_tt)
    z, z_s, z_t, z_ss, z_st, z_tt = over(z, z_s, z_t, z_ss, z_st, z_tt, f, w_s, w_t, w_ss, w_st, w_tt)
    return (
        (x, y, z),
        (x_s, y_s, z_s),
        (x_t, y_t, z_t),
        (x_ss, y_ss, z_ss),
        (x_st, y_st, z_st),
        (x_tt, y_tt, z_tt),
    )


@njit(forceinline=True, **POINT)
def over(a, a_s, a_t, a_ss, a_st, a_tt, f, w_s, w_t, w_ss, w_st, w_tt):
    """a / w and its derivatives by the quotient rule; f = 1 / w, and w_s .. are those of w, divided by w."""
    a = a * f
    a_s, a_t = a_s * f - w_s * a, a_t * f - w_t * a
    a_ss = a_ss * f - 2.0 * w_s * a_s - w_ss * a
    a_st = a_st * f - w_s * a_t - w_t * a_s - w_st * a
    a_tt = a_tt * f - 2.0 * w_t * a_t - w_tt * a
    return a, a_s, a_t, a_ss, a_st, a_tt


@njit(forceinline=True, **POINT)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(forceinline=True, **POINT)
def cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@njit(forceinline=True, **POINT)
def minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(forceinline=True, **POINT)
def clamped(x):
    return min(1.0, max(0.0, x))


@njit(**POINT)
def shape_on_patch(patch, ctrl, s, t, sense, work):
    """Outward normal, curvatures k1 >= k2 (> 0 convex) and the direction of k1.

    Eigenvalues of the shape operator from the two fundamental forms (do Carmo 3.3). At a pole the
    parametrisation is singular: the values just beside it stand in.
    """
    n, size = (0.0, 0.0, 0.0), 0.0
    for _ in range(2):
        _, d_s, d_t, d_ss, d_st, d_tt = patch_point(patch, ctrl, s, t, work)
        n = cross(d_s, d_t)
        size = sqrt(dot(n, n))
        if size > 1e-9 * (dot(d_s, d_s) + dot(d_t, d_t)):
            break
        s, t = min(1.0 - 1e-5, max(1e-5, s)), min(1.0 - 1e-5, max(1e-5, t))
    if size == 0.0:
        return (0.0, 0.0, sense), 0.0, 0.0, (1.0, 0.0, 0.0)
    return shape_of(d_s, d_t, d_ss, d_st, d_tt, sense)


@njit(forceinline=True, **POINT)
def shape_of(d_s, d_t, d_ss, d_st, d_tt, sense):
    """The same from the derivatives of a surface that is regular there.

    With m = S_s x S_t and tangents e along S_s, f = n x e the second form b is, in that frame,

        k_ee = b_ss / E,   k_ef = (b_st - F/E b_ss) / (n . m),   k_ff = (F^2/E b_ss - 2 F b_st + E b_tt) / |m|^2
    """
    m = cross(d_s, d_t)
    E, F, G = dot(d_s, d_s), dot(d_s, d_t), dot(d_t, d_t)
    per = 1.0 / sqrt(dot(m, m))
    size = sense * per
    n = (size * m[0], size * m[1], size * m[2])
    b_ss, b_st, b_tt = -dot(d_ss, n), -dot(d_st, n), -dot(d_tt, n)
    # The longer of the two goes first; that turns m round.
    if E < G:
        d_s, E, b_ss, b_tt, size = d_t, G, b_tt, b_ss, -size
    per_e = 1.0 / sqrt(E)
    e = (per_e * d_s[0], per_e * d_s[1], per_e * d_s[2])
    f = cross(n, e)
    skew = F * per_e * per_e
    k_ee = b_ss * per_e * per_e
    k_ef = size * (b_st - skew * b_ss)
    k_ff = per * per * (F * (skew * b_ss - 2.0 * b_st) + E * b_tt)
    mean, half = 0.5 * (k_ee + k_ff), 0.5 * (k_ee - k_ff)
    root = sqrt(half * half + k_ef * k_ef)
    # Direction of k1: the eigenvector, taken from the row that does not cancel.
    if half >= 0.0:
        c, d = half + root, k_ef
    else:
        c, d = k_ef, root - half
    length = sqrt(c * c + d * d)
    if length > 0.0:
        length = 1.0 / length
        c, d = c * length, d * length
    else:
        c, d = 1.0, 0.0
    direction = (c * e[0] + d * f[0], c * e[1] + d * f[1], c * e[2] + d * f[2])
    return n, mean + root, mean - root, direction


@njit(**POINT)
def arc_foot(ctrl, first, degree, point, s, work):
    """Minimum of the distance to one arc, downhill from s.

    returns : s, foot, tangent C', C'', distance^2
    """
    f, step = np.inf, 0.0
    foot = d_s = d_ss = (0.0, 0.0, 0.0)
    for _ in range(MAX_ITERATIONS):
        new = clamped(s + step)
        foot1, e_s, e_ss = arc_derivatives(ctrl, first, degree, new, work)
        r = minus(foot1, point)
        f1 = dot(r, r)
        speed = sqrt(dot(e_s, e_s))
        length = abs(new - s) * speed
        if not (f1 < f or length < SURE):
            step *= 0.4
            continue
        s, f, foot, d_s, d_ss = new, f1, foot1, e_s, e_ss
        g, a = dot(r, d_s), dot(d_s, d_s)
        h = a + dot(r, d_ss)
        held = (s <= 0.0 and g > 0.0) or (s >= 1.0 and g < 0.0)
        if held or a == 0.0:
            break
        step = -g / (h if h > 1e-3 * a else a)
        if abs(clamped(s + step) - s) * speed < 1e-13 or 0.0 < length < STEP:
            break
    return s, foot, d_s, d_ss, f


@njit(forceinline=True, **POINT)
def arc_derivatives(ctrl, first, degree, s, work):
    """C, C', C'' of a rational arc."""
    arc_point(ctrl, first, degree, s, work)
    w, w1, w2 = work[0, 3], work[1, 3], work[2, 3]
    x, y, z = work[0, 0] / w, work[0, 1] / w, work[0, 2] / w
    x1, y1, z1 = (work[1, 0] - w1 * x) / w, (work[1, 1] - w1 * y) / w, (work[1, 2] - w1 * z) / w
    x2 = (work[2, 0] - 2.0 * w1 * x1 - w2 * x) / w
    y2 = (work[2, 1] - 2.0 * w1 * y1 - w2 * y) / w
    z2 = (work[2, 2] - 2.0 * w1 * z1 - w2 * z) / w
    return (x, y, z), (x1, y1, z1), (x2, y2, z2)


@njit(**POINT)
def from_ramp(s, t0, t1, ramp):
    """Parameter of the CAD curve at arc parameter s (bezier.py has the formulas)."""
    if ramp == 0:
        return t0 + s * (t1 - t0)
    middle, half = 0.5 * (t0 + t1), 0.25 * (t1 - t0)
    if ramp == 1:
        return middle + 2.0 * atan((2.0 * s - 1.0) * tan(half))
    return middle + 2.0 * atanh((2.0 * s - 1.0) * tanh(half))


@njit(**POINT)
def to_ramp(t, t0, t1, ramp):
    """Arc parameter s at a parameter of the CAD curve."""
    if ramp == 0:
        return (t - t0) / (t1 - t0)
    middle, half = 0.5 * (t0 + t1), 0.25 * (t1 - t0)
    if ramp == 1:
        return 0.5 * (1.0 + tan(0.5 * (t - middle)) / tan(half))
    return 0.5 * (1.0 + tanh(0.5 * (t - middle)) / tanh(half))
