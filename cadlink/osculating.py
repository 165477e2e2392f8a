"""The foot on a curved patch from the osculating paraboloid at an earlier foot: no evaluation of the patch.

    q, n     earlier foot and unit normal;  e, f = n x e  principal directions;  k_e, k_f curvatures
    x, y, z  p - q along e, f, n [mm]
    s_e, s_f how far the foot has moved along e and f [mm]
    c        bound of the derivative of the curvature along the surface [1/mm^2], one for each leaf

With  z = -(k_e x^2 + k_f y^2) / 2  for the surface, to second order of the shift and at any height z,

    s_e = x / (1 + k_e z),   s_f = y / (1 + k_f z)
    d = z + (k_e x s_e + k_f y s_f) / 2
    foot = q + s_e e + s_f f - (k_e s_e^2 + k_f s_f^2) / 2 n,     normal = n + k_e s_e e + k_f s_f f

What is left out is the third order of the surface, c s^3 / 6 of the distance; the normal misses c s^2 / 2, which moves
the foot by |d| c s^2 / 2 / (1 + k d). Curvatures and their direction are those of the earlier foot: they miss c s. The
fourth order, k^3 s^4 (1 + k d) / 8, is that of a circle. A shift at which none of these passes TRACKED is `calm`.

A foot that itself came from a Taylor step of length h has curvatures that miss c h. The error then is
c s^2 (s / 6 + h / 2), which stays within c calm^3 / 6 for s <= calm - h; so does that of the foot.
"""

from math import sqrt

from numba import njit

from cadlink.kernels import POINT
from cadlink.nurbs import cross, dot

TRACKED = (5e-12, 5e-8)  # mm: errors in distance and foot that a model may leave
REACH = 2.0  # mm: distance from the skin at which they are promised for the fourth order
# Columns of what is remembered: radius, face, foot, normal, direction of k_e, k_e, k_f, and the derivatives
# of the patch's parameters along e and f: s_e, s_f, t_e, t_f.
CALM, LABEL, FOOT, NORMAL, DIRECTION, BEND, PER, REMEMBERED = 0, 1, 2, 5, 8, 11, 13, 17


@njit(**POINT)
def calm_radius(c, bend, size):
    """Radius [mm] within which distances are as good as promised.

    c : bound of the derivative of the curvature; bend : of the curvature; size : of the leaf, which bounds it too
    """
    third = (6.0 * TRACKED[0] / max(c, 1e-300)) ** (1.0 / 3.0)
    fourth = (8.0 * TRACKED[0] / max(bend * bend * bend * (1.0 + bend * REACH), 1e-300)) ** 0.25
    return min(0.25 * size, min(third, fourth))


@njit(forceinline=True, **POINT)
def recall(seed, i, first, p):
    """Whether the model serves a point; d, foot, normal, direction of k_e, and the shifts of the patch's parameters.

    seed, i, first : what is remembered stands in the row from this column on
    """
    n = (seed[i, first + NORMAL], seed[i, first + NORMAL + 1], seed[i, first + NORMAL + 2])
    e = (seed[i, first + DIRECTION], seed[i, first + DIRECTION + 1], seed[i, first + DIRECTION + 2])
    q = (seed[i, first + FOOT], seed[i, first + FOOT + 1], seed[i, first + FOOT + 2])
    k_e, k_f, calm = seed[i, first + BEND], seed[i, first + BEND + 1], seed[i, first + CALM]
    f = cross(n, e)
    r = (p[0] - q[0], p[1] - q[1], p[2] - q[2])
    x, y, z = dot(r, e), dot(r, f), dot(r, n)
    s_e, s_f = x / (1.0 + k_e * z), y / (1.0 + k_f * z)
    t_e, t_f = k_e * s_e, k_f * s_f
    d = z + 0.5 * (x * t_e + y * t_f)
    drop = 0.5 * (s_e * t_e + s_f * t_f)
    foot = (
        q[0] + s_e * e[0] + s_f * f[0] - drop * n[0],
        q[1] + s_e * e[1] + s_f * f[1] - drop * n[1],
        q[2] + s_e * e[2] + s_f * f[2] - drop * n[2],
    )
    # Both of length 1, and at a right angle, to second order.
    up, along = 1.0 - 0.5 * (t_e * t_e + t_f * t_f), 1.0 - 0.5 * t_e * t_e
    m = (
        up * n[0] + t_e * e[0] + t_f * f[0],
        up * n[1] + t_e * e[1] + t_f * f[1],
        up * n[2] + t_e * e[2] + t_f * f[2],
    )
    t = (
        along * e[0] - t_e * n[0] - 0.5 * t_e * t_f * f[0],
        along * e[1] - t_e * n[1] - 0.5 * t_e * t_f * f[1],
        along * e[2] - t_e * n[2] - 0.5 * t_e * t_f * f[2],
    )
    ds = seed[i, first + PER] * s_e + seed[i, first + PER + 1] * s_f
    dt = seed[i, first + PER + 2] * s_e + seed[i, first + PER + 3] * s_f
    return s_e * s_e + s_f * s_f < calm * calm, d, foot, m, t, ds, dt


@njit(forceinline=True, **POINT)
def remember(seed, i, first, leaf, s, t, step, reach, label, D, out):
    """Fill the row from the answer at a foot on a leaf (track.py) and the derivatives there.

    step : length of the Taylor step that led there [mm]; reach : how far the point may go
    """
    d, k_e, k_f = out[0], out[10], out[11]
    n, e = (out[4], out[5], out[6]), (out[7], out[8], out[9])
    f = cross(n, e)
    d_s, d_t = (D[1, 0], D[1, 1], D[1, 2]), (D[2, 0], D[2, 1], D[2, 2])
    # The inverse of (S_s, S_t) in the frame e, f.
    a, b, c, g = dot(d_s, e), dot(d_t, e), dot(d_s, f), dot(d_t, f)
    per = 1.0 / (a * g - b * c)
    s_e, s_f, t_e, t_f = g * per, -b * per, -c * per, a * per
    # The foot stays where no boundary passes, ..
    inner = leaf.inner
    calm = leaf.calm
    room_s, room_t = min(s - inner[0], inner[1] - s), min(t - inner[2], inner[3] - t)
    size_s, size_t = s_e * s_e + s_f * s_f, t_e * t_e + t_f * t_f
    calm = min(calm, min(room_s / sqrt(size_s), room_t / sqrt(size_t)))
    # .. and as near to the true one as promised wherever the point may be.
    least = 1.0 + min(d * k_e, d * k_f) - reach * max(k_e, -k_f)
    foot = 2.0 * TRACKED[1] * least / (leaf.twist * (abs(d) + reach))
    calm = (min(calm, sqrt(foot)) if foot > 0.0 else 0.0) - step
    seed[i, first + CALM], seed[i, first + LABEL] = max(0.0, calm), label
    for k in range(3):
        seed[i, first + FOOT + k], seed[i, first + NORMAL + k] = out[1 + k], n[k]
        seed[i, first + DIRECTION + k] = e[k]
    seed[i, first + BEND], seed[i, first + BEND + 1] = k_e, k_f
    seed[i, first + PER], seed[i, first + PER + 1] = s_e, s_f
    seed[i, first + PER + 2], seed[i, first + PER + 3] = t_e, t_f
