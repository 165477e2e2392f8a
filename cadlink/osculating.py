"""The foot on a curved patch from the osculating cubic at an earlier foot: no evaluation of the patch.

    q, n     earlier foot and unit normal;  e, f = n x e  principal directions;  k_e, k_f curvatures
    C        cubic form of the surface there, C_eee, C_eef, C_eff, C_fff: the derivative of the curvature [1/mm^2]
    x, y, z  p - q along e, f, n [mm]
    s        how far the foot has moved along e and f [mm]
    c, c'    bounds of the first and second derivative of the curvature on the leaf, [1/mm^2, 1/mm^3]

The surface is  z = -(k_e x^2 + k_f y^2) / 2 - C(x, y) / 6.  With  s_e = x / (1 + k_e z),  s_f = y / (1 + k_f z),

    d = z + (k_e x s_e + k_f y s_f) / 2 + C(s, s, s) / 6
    s_i -= z C(s, s, i) / 2 / (1 + k_i z)
    foot = q + s_e e + s_f f - (k_e s_e^2 + k_f s_f^2) / 2 n,     normal = n + sum (k_i s_i + C(s, s, i) / 2) i

What is left out is of fourth order in the distance and of third order in the foot, with g the smaller 1 + k_i d,

    s^4 (c' (1 + |k d|) / 24 + d^2 c^2 / (8 g))      and      s^3 (|d| c' / 6 + d^2 c^2 / (2 g) + k^2 / 2) / g.

Curvatures follow to first order while they are well apart. The second derivatives at a foot that itself came from a
Taylor step of length h miss c h, which adds c h s^2 / 2 to the distance and |d| c h s / g to the foot. The shift up to
which all of it stays within TRACKED is `calm`.
"""

from math import sqrt

from numba import njit

from cadlink.kernels import POINT
from cadlink.nurbs import cross, dot
from cadlink.power import third_derivatives

TRACKED = (1e-12, 5e-8)  # mm: errors in distance and foot that a model may leave
APART = 10.0  # times what turns the principal directions
LIFT = 0.1  # mm: how much the distance may change while a model serves
# Columns of what is remembered: radius, face, foot, normal, direction of k_e, k_e, k_f, the derivatives of the
# patch's parameters along e and f (s_e, s_f, t_e, t_f), C, and the distance.
CALM, LABEL, FOOT, NORMAL, DIRECTION, BEND, PER, CUBIC, HEIGHT, REMEMBERED = 0, 1, 2, 5, 8, 11, 13, 17, 21, 22


@njit(forceinline=True, **POINT)
def recall(seed, i, first, p):
    """Whether the model serves a point; d, foot, normal, k_e, k_f, direction, and the shifts of the parameters.

    seed, i, first : what is remembered stands in the row from this column on
    """
    n = (seed[i, first + NORMAL], seed[i, first + NORMAL + 1], seed[i, first + NORMAL + 2])
    e = (seed[i, first + DIRECTION], seed[i, first + DIRECTION + 1], seed[i, first + DIRECTION + 2])
    q = (seed[i, first + FOOT], seed[i, first + FOOT + 1], seed[i, first + FOOT + 2])
    k_e, k_f, calm = seed[i, first + BEND], seed[i, first + BEND + 1], seed[i, first + CALM]
    c_eee, c_eef = seed[i, first + CUBIC], seed[i, first + CUBIC + 1]
    c_eff, c_fff = seed[i, first + CUBIC + 2], seed[i, first + CUBIC + 3]
    f = cross(n, e)
    r = (p[0] - q[0], p[1] - q[1], p[2] - q[2])
    x, y, z = dot(r, e), dot(r, f), dot(r, n)
    per_e, per_f = 1.0 / (1.0 + k_e * z), 1.0 / (1.0 + k_f * z)
    s_e, s_f = x * per_e, y * per_f
    served = s_e * s_e + s_f * s_f < calm * calm and abs(z - seed[i, first + HEIGHT]) < LIFT
    # The curvature's change along s, then the distance, then the shift to second order.
    c_ee, c_ef, c_ff = c_eee * s_e + c_eef * s_f, c_eef * s_e + c_eff * s_f, c_eff * s_e + c_fff * s_f
    half_e, half_f = 0.5 * (c_ee * s_e + c_ef * s_f), 0.5 * (c_ef * s_e + c_ff * s_f)
    d = z + 0.5 * (k_e * x * s_e + k_f * y * s_f) + (half_e * s_e + half_f * s_f) / 3.0
    s_e, s_f = s_e - z * half_e * per_e, s_f - z * half_f * per_f
    t_e, t_f = k_e * s_e + half_e, k_f * s_f + half_f
    drop = 0.5 * (k_e * s_e * s_e + k_f * s_f * s_f)
    foot = (
        q[0] + s_e * e[0] + s_f * f[0] - drop * n[0],
        q[1] + s_e * e[1] + s_f * f[1] - drop * n[1],
        q[2] + s_e * e[2] + s_f * f[2] - drop * n[2],
    )
    ds = seed[i, first + PER] * s_e + seed[i, first + PER + 1] * s_f
    dt = seed[i, first + PER + 2] * s_e + seed[i, first + PER + 3] * s_f
    # Principal directions turn in the tangent plane.
    turn = 0.0
    if k_e - k_f > APART * abs(c_ef):
        turn = c_ef / (k_e - k_f)
        k_e, k_f = k_e + c_ee, k_f + c_ff
    # Both of length 1, and at a right angle, to second order; beside an umbilic the turn is large, so to sixth in it.
    square = turn * turn
    length = 1.0 - square * (0.5 - 0.375 * square)
    up, along = 1.0 - 0.5 * (t_e * t_e + t_f * t_f), length - 0.5 * t_e * t_e
    side, down = turn * length - 0.5 * t_e * t_f, length * (t_e + turn * t_f)
    m = (
        up * n[0] + t_e * e[0] + t_f * f[0],
        up * n[1] + t_e * e[1] + t_f * f[1],
        up * n[2] + t_e * e[2] + t_f * f[2],
    )
    t = (
        along * e[0] - down * n[0] + side * f[0],
        along * e[1] - down * n[1] + side * f[1],
        along * e[2] - down * n[2] + side * f[2],
    )
    return served, d, foot, m, max(k_e, k_f), min(k_e, k_f), t, ds, dt


@njit(**POINT)
def remember(seed, i, first, leaf, patch, power, s, t, step, label, D, out):
    """Fill the row from the answer at a foot on a leaf (track.py) and the derivatives there.

    step : length of the Taylor step that led there [mm]
    """
    q, d, k_e, k_f = (out[1], out[2], out[3]), out[0], out[10], out[11]
    n, e = (out[4], out[5], out[6]), (out[7], out[8], out[9])
    f = cross(n, e)
    d_s, d_t = (D[1, 0], D[1, 1], D[1, 2]), (D[2, 0], D[2, 1], D[2, 2])
    d_ss, d_st, d_tt = (D[3, 0], D[3, 1], D[3, 2]), (D[4, 0], D[4, 1], D[4, 2]), (D[5, 0], D[5, 1], D[5, 2])
    # The inverse of (S_s, S_t) in the frame e, f.
    a, b, c, g = dot(d_s, e), dot(d_t, e), dot(d_s, f), dot(d_t, f)
    per = 1.0 / (a * g - b * c)
    s_e, s_f, t_e, t_f = g * per, -b * per, -c * per, a * per
    # With parameters that run along e and f the tangential parts of S_ee, S_ef, S_ff and the normal ones of S_eee ..
    z_sss, z_sst, z_stt, z_ttt = third_derivatives(patch, power, s, t, n, q, dot(d_ss, n), dot(d_st, n), dot(d_tt, n))
    ss_e, st_e, tt_e = dot(d_ss, e), dot(d_st, e), dot(d_tt, e)
    ss_f, st_f, tt_f = dot(d_ss, f), dot(d_st, f), dot(d_tt, f)
    ee_e, ee_f = second(s_e, t_e, s_e, t_e, ss_e, st_e, tt_e), second(s_e, t_e, s_e, t_e, ss_f, st_f, tt_f)
    ef_e, ef_f = second(s_e, t_e, s_f, t_f, ss_e, st_e, tt_e), second(s_e, t_e, s_f, t_f, ss_f, st_f, tt_f)
    ff_e, ff_f = second(s_f, t_f, s_f, t_f, ss_e, st_e, tt_e), second(s_f, t_f, s_f, t_f, ss_f, st_f, tt_f)
    along_e = (z_sss * s_e + z_sst * t_e, z_sst * s_e + z_stt * t_e, z_stt * s_e + z_ttt * t_e)
    along_f = (z_sss * s_f + z_sst * t_f, z_sst * s_f + z_stt * t_f, z_stt * s_f + z_ttt * t_f)
    c_eee = -second(s_e, t_e, s_e, t_e, along_e[0], along_e[1], along_e[2]) - 3.0 * k_e * ee_e
    c_eef = -second(s_e, t_e, s_e, t_e, along_f[0], along_f[1], along_f[2]) - 2.0 * k_e * ef_e - k_f * ee_f
    c_eff = -second(s_f, t_f, s_f, t_f, along_e[0], along_e[1], along_e[2]) - k_e * ff_e - 2.0 * k_f * ef_f
    c_fff = -second(s_f, t_f, s_f, t_f, along_f[0], along_f[1], along_f[2]) - 3.0 * k_f * ff_f
    calm = calm_radius(leaf, s, t, s_e * s_e + s_f * s_f, t_e * t_e + t_f * t_f, d, k_e, k_f, step)
    seed[i, first + CALM], seed[i, first + LABEL] = calm, label
    for k in range(3):
        seed[i, first + FOOT + k], seed[i, first + NORMAL + k], seed[i, first + DIRECTION + k] = q[k], n[k], e[k]
    seed[i, first + BEND], seed[i, first + BEND + 1] = k_e, k_f
    seed[i, first + PER], seed[i, first + PER + 1] = s_e, s_f
    seed[i, first + PER + 2], seed[i, first + PER + 3] = t_e, t_f
    seed[i, first + CUBIC], seed[i, first + CUBIC + 1] = c_eee, c_eef
    seed[i, first + CUBIC + 2], seed[i, first + CUBIC + 3] = c_eff, c_fff
    seed[i, first + HEIGHT] = d


@njit(forceinline=True, **POINT)
def second(s1, t1, s2, t2, ss, st, tt):
    """The bilinear form of two directions."""
    return s1 * s2 * ss + (s1 * t2 + s2 * t1) * st + t1 * t2 * tt


@njit(forceinline=True, **POINT)
def calm_radius(leaf, s, t, size_s, size_t, d, k_e, k_f, step):
    """Shift of the foot [mm] that the model can follow while the distance changes by at most LIFT.

    size_s, size_t : squares of the derivatives of s and t along the surface [1/mm^2]
    """
    # The foot stays where no boundary passes.
    inner = leaf.inner
    room_s, room_t = min(s - inner[0], inner[1] - s), min(t - inner[2], inner[3] - t)
    calm = min(leaf.calm, min(room_s / sqrt(size_s), room_t / sqrt(size_t)))
    far, bend = abs(d) + LIFT, max(k_e, -k_f)
    g = 1.0 + min(d * k_e, d * k_f) - LIFT * bend
    if not (g > 0.0 and calm > 0.0):
        return 0.0
    per, c, more = 1.0 / g, leaf.twist[0], leaf.twist[1]
    # Half of what is allowed for the fourth order, half for what the second misses.
    skew = far * far * c * c * per
    calm = min(calm, sqrt(sqrt(0.5 * TRACKED[0] / max(more * (1.0 + far * bend) / 24.0 + skew / 8.0, 1e-300))))
    if step > 0.0:
        wrong = max(c * step, 1e-300)
        calm = min(calm, min(sqrt(TRACKED[0] / wrong), 0.5 * TRACKED[1] / (far * wrong * per)))
    foot = calm * calm * calm * (far * more / 6.0 + 0.5 * (skew + bend * bend)) * per
    return calm * min(1.0, sqrt(0.5 * TRACKED[1] / max(foot, 1e-300)))
