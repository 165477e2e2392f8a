"""The foot of a point on one patch with care: downhill from any start, to a minimum on the square.

    s, t    parameters of the patch, in [0, 1]
    r       S(s, t) - p, from the point to the surface [mm]
    g       gradient of |r|^2 / 2 in (s, t);  H its Hessian

Newton with the exact Hessian where it is positive definite, Gauss-Newton elsewhere, steps halved
until the distance falls (Piegl & Tiller, The NURBS Book, 6.1, with an active set for the sides of
the square).
"""

from math import sqrt

import numpy as np
from numba import njit

from cadlink.kernels import POINT
from cadlink.nurbs import MAX_ITERATIONS, STEP, SURE, clamped, dot, minus, patch_point
from cadlink.power import derivatives

POLE = 1e-18  # square of the ratio of the two speeds at a pole
AROUND, HALVINGS = 16, 20  # curves tried there, and halvings towards the best


@njit(**POINT)
def patch_derivatives(patch, ctrl, power, s, t, work):
    """S, S_s, S_t, S_ss, S_st, S_tt of a rational patch: by its power basis where that serves."""
    if not patch.steady:
        return patch_point(patch, ctrl, s, t, work)
    x, d_s, d_t, d_ss, d_st, d_tt = derivatives(patch, power, s, t)
    centre = patch.centre
    return (x[0] + centre[0], x[1] + centre[1], x[2] + centre[2]), d_s, d_t, d_ss, d_st, d_tt


@njit(**POINT)
def newton_step(g1, g2, a11, a12, a22, h11, h12, h22, held1, held2):
    """Step in (s, t) against the gradient; held parameters stay.

    a: metric S_i . S_j (Gauss-Newton), h: exact Hessian, used where it is positive definite.
    """
    if held1 and held2:
        return 0.0, 0.0
    if held1:
        m = h22 if h22 > 1e-3 * a22 else a22
        return 0.0, (-g2 / m if m > 0.0 else 0.0)
    if held2:
        m = h11 if h11 > 1e-3 * a11 else a11
        return (-g1 / m if m > 0.0 else 0.0), 0.0
    det = h11 * h22 - h12 * h12
    if h11 > 0.0 and det > 1e-6 * a11 * a22:
        return (h12 * g2 - h22 * g1) / det, (h12 * g1 - h11 * g2) / det
    # Gauss-Newton, a little damped so that a pole (S_s = 0) does no harm.
    m11, m22 = a11 * 1.000001 + 1e-14 * a22, a22 * 1.000001 + 1e-14 * a11
    det = m11 * m22 - a12 * a12
    if det <= 0.0:
        return 0.0, 0.0
    return (a12 * g2 - m22 * g1) / det, (a12 * g1 - m11 * g2) / det


@njit(**POINT)
def slope_out(patch, ctrl, power, r, s, t, collapsed, work):
    """How the distance changes along the curve that leaves a pole at (s, t), < 0 downhill.

    r : from the point to the pole; collapsed : 0 where S_s vanishes there, 1 where S_t does
    """
    _, d_s, d_t, _, _, _ = patch_derivatives(patch, ctrl, power, s, t, work)
    d, end = (d_t, t) if collapsed == 0 else (d_s, s)
    size = sqrt(dot(d, d))
    return (-1.0 if end > 0.5 else 1.0) * dot(r, d) / size if size > 0.0 else 0.0


@njit(**POINT)
def way_out(patch, ctrl, power, r, s, t, collapsed, work):
    """The curve that leads down most steeply from a side that is one point (a pole).

    returns : s, t of that curve at the pole, and whether it leads down at all
    """
    least, best = np.inf, 0.5
    for k in range(AROUND):
        x = (k + 0.5) / AROUND
        slope = slope_out(
            patch, ctrl, power, r, x if collapsed == 0 else s, t if collapsed == 0 else x, collapsed, work
        )
        if slope < least:
            least, best = slope, x
    # Closer and closer to it: the sector that leads down may be narrow.
    width = 1.0 / AROUND
    for _ in range(HALVINGS):
        width *= 0.5
        for side in range(2):
            x = clamped(best + (width if side == 0 else -width))
            slope = slope_out(
                patch, ctrl, power, r, x if collapsed == 0 else s, t if collapsed == 0 else x, collapsed, work
            )
            if slope < least:
                least, best = slope, x
                break
    return (best if collapsed == 0 else s), (t if collapsed == 0 else best), least < 0.0


@njit(**POINT)
def patch_foot(patch, ctrl, power, point, s, t, work):
    """Minimum of the distance to one patch, downhill from (s, t).

    returns : s, t, foot, distance^2; whether it may be an interior foot: False where the distance
        still falls across a side that ends the whole surface; and the pull across any side [mm]
    """
    f, ds, dt, size1, size2, stuck = np.inf, 0.0, 0.0, 0.0, 0.0, False
    foot = r = d_s = d_t = (0.0, 0.0, 0.0)
    for _ in range(MAX_ITERATIONS):
        s1, t1 = clamped(s + ds), clamped(t + dt)
        length = abs(s1 - s) * size1 + abs(t1 - t) * size2
        foot1, e_s, e_t, e_ss, e_st, e_tt = patch_derivatives(patch, ctrl, power, s1, t1, work)
        r1 = minus(foot1, point)
        f1 = dot(r1, r1)
        if not (f1 < f or length < SURE):
            ds, dt = 0.4 * ds, 0.4 * dt
            continue
        s, t, foot, r, f, d_s, d_t = s1, t1, foot1, r1, f1, e_s, e_t
        if 0.0 < length < STEP:
            break
        g1, g2 = dot(r, d_s), dot(r, d_t)
        a11, a12, a22 = dot(d_s, d_s), dot(d_s, d_t), dot(d_t, d_t)
        h11, h12, h22 = a11 + dot(r, e_ss), a12 + dot(r, e_st), a22 + dot(r, e_tt)
        held1 = (s <= 0.0 and g1 > 0.0) or (s >= 1.0 and g1 < 0.0)
        held2 = (t <= 0.0 and g2 > 0.0) or (t >= 1.0 and g2 < 0.0)
        # At a pole one parameter has no meaning; where the other is held, another curve may lead on from there.
        pole = 0 if a11 <= POLE * a22 else (1 if a22 <= POLE * a11 else -1)
        if pole >= 0:
            held1, held2 = held1 or pole == 0, held2 or pole == 1
            if held1 and held2 and not stuck:
                stuck = True
                s, t, down = way_out(patch, ctrl, power, r, s, t, pole, work)
                if down:
                    ds, dt, f = 0.0, 0.0, np.inf
                    continue
        ds, dt = newton_step(g1, g2, a11, a12, a22, h11, h12, h22, held1, held2)
        size1, size2 = sqrt(a11), sqrt(a22)
        if abs(clamped(s + ds) - s) * size1 + abs(clamped(t + dt) - t) * size2 < 1e-13:
            break
    # How hard each side of the square holds the foot back, as a length along the surface.
    g1, g2 = dot(r, d_s), dot(r, d_t)
    size1, size2 = max(sqrt(dot(d_s, d_s)), 1e-300), max(sqrt(dot(d_t, d_t)), 1e-300)
    slack = 1e-8 * sqrt(f) + 1e-11
    pull, free = 0.0, True
    for side in range(4):
        if side == 0:
            held = g1 / size1 if s <= 0.0 else 0.0
        elif side == 1:
            held = -g1 / size1 if s >= 1.0 else 0.0
        elif side == 2:
            held = g2 / size2 if t <= 0.0 else 0.0
        else:
            held = -g2 / size2 if t >= 1.0 else 0.0
        pull = max(pull, held)
        # A side of the whole surface that does so belongs to an edge, not to the face.
        if held > slack and patch.natural[side]:
            free = False
    return s, t, foot, f, free, pull
