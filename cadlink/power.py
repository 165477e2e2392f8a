"""Bezier patches in a centred power basis, and Newton steps on them that end in a Taylor series.

    s, t     parameters of the patch, in [0, 1];  a = s - 1/2, b = t - 1/2
    c_ij     S w = sum c_ij a^i b^j, four components each, lengths from the patch's centre [mm]
    r        S(s, t) - p
    D        derivatives of S: rows S, S_s, S_t, S_ss, S_st, S_tt of (6, 3)

Horner in b, then in a, with both derivatives alongside, costs half of the Bernstein rows of
nurbs.py. About the centre the powers of 1/2 keep round-off as small as there, for the degrees CAD
uses; patches of which that is not so are marked and left to nurbs.py.

A Newton step that is short (Leaf.tiny) needs no second evaluation: the Taylor series through second
order has the new foot, its distance and its normal (leaves.py measures how short that is).
"""

from math import comb, sqrt

import numpy as np
from numba import njit

from cadlink.kernels import POINT
from cadlink.nurbs import dot, over

ROUND_OFF = 1e-12  # mm: largest sum of round-off, nearly never reached, of a patch that serves
FOUND, HELD, DOUBTFUL = 1, 0, -1
STEPS = 12
CONVERGED = 0.0003  # of Leaf.tiny: no error of the series is left in the distance, 3e-8 of the curvature


def power_basis(degree):
    """(n + 1, n + 1): powers of a from Bernstein coefficients."""
    n = degree
    matrix = np.zeros((n + 1, n + 1))
    for k in range(n + 1):
        # Binomial(n, k) (1/2 + a)^k (1/2 - a)^(n - k)
        up, down = np.array([0.5, 1.0]), np.array([0.5, -1.0])
        product = np.array([float(comb(n, k))])
        for factor in [up] * k + [down] * (n - k):
            product = np.convolve(product, factor)
        matrix[:, k] = product
    return matrix


def to_power(patches, ctrl):
    """Coefficients (n, 4), numbered like the control points; sets centre, rational and steady."""
    power = np.zeros_like(ctrl)
    degree = patches["degree"]
    for p, q in np.unique(degree, axis=0):
        ids = np.flatnonzero((degree[:, 0] == p) & (degree[:, 1] == q))
        take = patches["ctrl"][ids][:, None] + np.arange((p + 1) * (q + 1))
        net = ctrl[take]
        weight = net[..., 3:]
        centre = (net[..., :3] / weight).mean(axis=1)
        net[..., :3] -= weight * centre[:, None]
        rational = np.ptp(weight[..., 0], axis=1) > 0.0
        # A common weight divides out.
        net /= weight[:, :1]
        left, right = power_basis(p), power_basis(q)
        c = np.einsum("ik,jl,nklx->nijx", left, right, net.reshape(-1, p + 1, q + 1, 4), optimize=True)
        halves = 0.5 ** np.add.outer(np.arange(p + 1), np.arange(q + 1))
        error = 2.2e-16 * 2.0 * (np.abs(c[..., :3]).max(axis=3) * halves).sum(axis=(1, 2))
        power[take] = c.reshape(len(ids), -1, 4)
        patches["centre"][ids], patches["rational"][ids] = centre, rational
        # What its place in space costs anyway is no reason against it.
        place = 4.4e-16 * np.abs(centre).max(axis=1)
        patches["steady"][ids] = error < ROUND_OFF + place
    return power


@njit(forceinline=True, **POINT)
def derivatives(patch, power, s, t):
    """S - centre and its derivatives D of a patch."""
    p, q = patch.degree[0], patch.degree[1]
    k = patch.ctrl + (p + 1) * (q + 1)
    a, b = s - 0.5, t - 0.5
    x = x_s = x_t = x_ss = x_st = x_tt = 0.0
    y = y_s = y_t = y_ss = y_st = y_tt = 0.0
    z = z_s = z_t = z_ss = z_st = z_tt = 0.0
    w = w_s = w_t = w_ss = w_st = w_tt = 0.0
    for _ in range(p + 1):
        x0 = x1 = x2 = y0 = y1 = y2 = z0 = z1 = z2 = w0 = w1 = w2 = 0.0
        for _ in range(q + 1):
            k -= 1
            x2, x1, x0 = x2 * b + x1, x1 * b + x0, x0 * b + power[k, 0]
            y2, y1, y0 = y2 * b + y1, y1 * b + y0, y0 * b + power[k, 1]
            z2, z1, z0 = z2 * b + z1, z1 * b + z0, z0 * b + power[k, 2]
            w2, w1, w0 = w2 * b + w1, w1 * b + w0, w0 * b + power[k, 3]
        x_ss, x_s, x = x_ss * a + x_s, x_s * a + x, x * a + x0
        y_ss, y_s, y = y_ss * a + y_s, y_s * a + y, y * a + y0
        z_ss, z_s, z = z_ss * a + z_s, z_s * a + z, z * a + z0
        w_ss, w_s, w = w_ss * a + w_s, w_s * a + w, w * a + w0
        x_st, x_t, x_tt = x_st * a + x_t, x_t * a + x1, x_tt * a + x2
        y_st, y_t, y_tt = y_st * a + y_t, y_t * a + y1, y_tt * a + y2
        z_st, z_t, z_tt = z_st * a + z_t, z_t * a + z1, z_tt * a + z2
        w_st, w_t, w_tt = w_st * a + w_t, w_t * a + w1, w_tt * a + w2
    x_ss, x_tt, y_ss, y_tt, z_ss, z_tt = 2.0 * x_ss, 2.0 * x_tt, 2.0 * y_ss, 2.0 * y_tt, 2.0 * z_ss, 2.0 * z_tt
    if patch.rational:
        f = 1.0 / w
        w_s, w_t, w_ss, w_st, w_tt = w_s * f, w_t * f, 2.0 * w_ss * f, w_st * f, 2.0 * w_tt * f
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


@njit(**POINT)
def third_derivatives(patch, power, s, t, n, foot, n_ss, n_st, n_tt):
    """n . S_sss, n . S_sst, n . S_stt, n . S_ttt at a foot with normal n, where n . S_ss .. are known.

    The numerator of n . (S - foot) alone is differentiated; its value and first derivatives vanish there.
    """
    p, q = patch.degree[0], patch.degree[1]
    k = patch.ctrl + (p + 1) * (q + 1)
    a, b = s - 0.5, t - 0.5
    level = n[0] * (foot[0] - patch.centre[0]) + n[1] * (foot[1] - patch.centre[1]) + n[2] * (foot[2] - patch.centre[2])
    z = z_s = z_ss = z_sss = z_t = z_st = z_sst = z_tt = z_stt = z_ttt = w = w_s = w_t = 0.0
    for _ in range(p + 1):
        z0 = z1 = z2 = z3 = w0 = w1 = 0.0
        for _ in range(q + 1):
            k -= 1
            c = n[0] * power[k, 0] + n[1] * power[k, 1] + n[2] * power[k, 2] - level * power[k, 3]
            z3, z2, z1, z0 = z3 * b + z2, z2 * b + z1, z1 * b + z0, z0 * b + c
            w1, w0 = w1 * b + w0, w0 * b + power[k, 3]
        z_sss, z_ss, z_s, z = z_sss * a + z_ss, z_ss * a + z_s, z_s * a + z, z * a + z0
        z_sst, z_st, z_t = z_sst * a + z_st, z_st * a + z_t, z_t * a + z1
        z_stt, z_tt, z_ttt = z_stt * a + z_tt, z_tt * a + z2, z_ttt * a + z3
        w_s, w, w_t = w_s * a + w, w * a + w0, w_t * a + w1
    per = 1.0 / w
    return (
        per * (6.0 * z_sss - 3.0 * w_s * n_ss),
        per * (2.0 * z_sst - 2.0 * w_s * n_st - w_t * n_ss),
        per * (2.0 * z_stt - 2.0 * w_t * n_st - w_s * n_tt),
        per * (6.0 * z_ttt - 3.0 * w_t * n_tt),
    )


@njit(forceinline=True, **POINT)
def moved(a, a_s, a_t, ds, dt):
    return a[0] + a_s[0] * ds + a_t[0] * dt, a[1] + a_s[1] * ds + a_t[1] * dt, a[2] + a_s[2] * ds + a_t[2] * dt


@njit(**POINT)
def foot_in_box(patch, power, p, s, t, s0, s1, t0, t1, tiny_s, tiny_t, first_tiny, out):
    """Foot of a point on a patch between s0 .. s1 and t0 .. t1, by Newton from (s, t).

    tiny_s, tiny_t : steps that the Taylor series may end, times first_tiny for the first step
    returns : FOUND, with s, t and the derivatives there in out; HELD where the nearest point of
        the box is on its side; DOUBTFUL where that cannot be told; then s, t, the distance there, and
        how far [mm] the foot seems to be beyond the side; of a foot FOUND, the length of the last step [mm]
    """
    centre = patch.centre
    px, py, pz = p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]
    tiny = first_tiny
    for _ in range(STEPS):
        x, d_s, d_t, d_ss, d_st, d_tt = derivatives(patch, power, s, t)
        r = (x[0] - px, x[1] - py, x[2] - pz)
        g1, g2 = dot(r, d_s), dot(r, d_t)
        a11, a22 = dot(d_s, d_s), dot(d_t, d_t)
        h11, h12, h22 = a11 + dot(r, d_ss), dot(d_s, d_t) + dot(r, d_st), a22 + dot(r, d_tt)
        det = h11 * h22 - h12 * h12
        for c in range(3):
            out[0, c] = centre[c] + x[c]
        if not (h11 > 0.0 and det > 1e-4 * a11 * a22):
            return DOUBTFUL, s, t, 0.0, 0.0
        ds, dt = (h12 * g2 - h22 * g1) / det, (h12 * g1 - h11 * g2) / det
        if abs(ds) <= tiny * tiny_s and abs(dt) <= tiny * tiny_t:
            # The Taylor series at the foot.
            s_new, t_new = s + ds, t + dt
            beyond = max(max(s0 - s_new, s_new - s1), max(t0 - t_new, t_new - t1))
            if beyond > 1e-9:
                size = max(sqrt(a11), sqrt(a22)) * beyond
                h = sqrt(dot(r, r))
                return (HELD if size > 3e-4 * h + 1e-7 else DOUBTFUL), s, t, h, size
            e_s, e_t = moved(d_s, d_ss, d_st, ds, dt), moved(d_t, d_st, d_tt, ds, dt)
            f_s = (0.5 * (d_s[0] + e_s[0]), 0.5 * (d_s[1] + e_s[1]), 0.5 * (d_s[2] + e_s[2]))
            f_t = (0.5 * (d_t[0] + e_t[0]), 0.5 * (d_t[1] + e_t[1]), 0.5 * (d_t[2] + e_t[2]))
            foot = moved(x, f_s, f_t, ds, dt)
            for c in range(3):
                out[0, c] = centre[c] + foot[c]
                out[1, c], out[2, c] = e_s[c], e_t[c]
                out[3, c], out[4, c], out[5, c] = d_ss[c], d_st[c], d_tt[c]
            away = (foot[0] - px, foot[1] - py, foot[2] - pz)
            length = sqrt(2.0 * (a11 * ds * ds + a22 * dt * dt))
            return FOUND, s_new, t_new, sqrt(dot(away, away)), length
        # On a side that holds the foot back the other parameter moves alone.
        hold_s, hold_t = (
            (s <= s0 and ds < 0.0) or (s >= s1 and ds > 0.0),
            (t <= t0 and dt < 0.0) or (t >= t1 and dt > 0.0),
        )
        if hold_s or hold_t:
            pull = max(abs(ds) * sqrt(a11) if hold_s else 0.0, abs(dt) * sqrt(a22) if hold_t else 0.0)
            h = sqrt(dot(r, r))
            far = 3e-4 * h + 1e-7
            if hold_s and hold_t:
                return (HELD if pull > far else DOUBTFUL), s, t, h, pull
            width = 0.02 * ((s1 - s0) * sqrt(a11) if hold_s else (t1 - t0) * sqrt(a22))
            # A way along the side turns the pull; it must be longer than that to tell.
            along = abs(dt) * sqrt(a22) if hold_s else abs(ds) * sqrt(a11)
            if pull > max(far, width, along):
                return HELD, s, t, h, pull
            if hold_s:
                ds, dt = 0.0, -g2 / h22
            else:
                ds, dt = -g1 / h11, 0.0
            if abs(ds) <= tiny_s and abs(dt) <= tiny_t:
                return (HELD if pull > far else DOUBTFUL), s, t, h, pull
        s, t = min(s1, max(s0, s + ds)), min(t1, max(t0, t + dt))
        tiny = CONVERGED
    return DOUBTFUL, s, t, 0.0, 0.0
