"""Return map of any locus with any hardening law: closest-point Newton in plane stress.

Symbols: H logarithmic strain [11, 22, 2*12]; T stress conjugate to it; Hp plastic strain; ep equivalent plastic strain;
alpha backstress; x = T - alpha; phi the locus, n its gradient, h its second derivative; m = x/phi(x); dg increment of
ep.
Backward Euler asks for x and dg with

    r = De^-1 (x + alpha(dg, m)) - e + dg n(x) = 0,  e = H - Hp_old,      phi(x) = size(dg).

Newton with a line search on |r|^2 + ((phi - size)/E)^2 starts where the ray of the trial state meets the locus.
Where it stalls, the trial state is approached from that meeting point in steps, each solution the guess of the next;
the step's old state stays the same, so the answer is that of one increment.
"""

from math import isnan, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..kernels import INNER, POINT
from ..lanes import put, vector
from .block import E33, EP, HP, H, T, take_stiffness
from .dispatch import backstress, begin, harden, locus, remember
from .modulus import young_at
from .rate import rate_factor

TOLERANCE = 1e-12  # of the yield strain; of the trial strain 1e-14


class Scratch(NamedTuple):
    """Arrays of one point at work."""

    x: np.ndarray  # (3,) T - alpha
    guess: np.ndarray  # (3,) x under trial
    step: np.ndarray  # (3,) Newton's
    e: np.ndarray  # (3,) trial elastic strain
    start: np.ndarray  # (3,) e whose stress lies on the locus
    aim: np.ndarray  # (3,) e on the way between them
    n: np.ndarray  # (3,)
    h: np.ndarray  # (3, 3)
    hm: np.ndarray  # (3, 3) h at m
    m: np.ndarray  # (3,)
    r: np.ndarray  # (3,)
    b: np.ndarray  # (3,) dr/ddg
    jacobian: np.ndarray  # (3, 3) dr/dx
    inverse: np.ndarray  # (3, 3)
    alpha: np.ndarray  # (3,)
    alpha_g: np.ndarray  # (3,)
    alpha_m: np.ndarray  # (3, 3)
    work: np.ndarray  # (8, 3, 3) of the hardening law
    stiffness: np.ndarray  # (3, 3) dT/dH


@njit(**POINT)
def new_scratch():
    """Scratch of one thread."""
    v, a = np.zeros((11, 3)), np.zeros((6, 3, 3))
    return Scratch(
        v[0], v[1], v[2], v[3], v[4], v[5], v[6], a[0], a[1], v[7], v[8], v[9], a[2], a[3], v[10],
        np.zeros(3), a[4], np.zeros((8, 3, 3)), a[5],
    )  # fmt: skip


@njit(**POINT, _nrt=False)
def invert(a, inverse):
    """Inverse of a 3 x 3 matrix."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1]
    c01 = a[1, 2] * a[2, 0] - a[1, 0] * a[2, 2]
    c02 = a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0]
    d = 1.0 / (a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02)
    inverse[0, 0], inverse[1, 0], inverse[2, 0] = c00 * d, c01 * d, c02 * d
    inverse[0, 1] = (a[0, 2] * a[2, 1] - a[0, 1] * a[2, 2]) * d
    inverse[1, 1] = (a[0, 0] * a[2, 2] - a[0, 2] * a[2, 0]) * d
    inverse[2, 1] = (a[0, 1] * a[2, 0] - a[0, 0] * a[2, 1]) * d
    inverse[0, 2] = (a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]) * d
    inverse[1, 2] = (a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2]) * d
    inverse[2, 2] = (a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]) * d


@njit(**POINT, _nrt=False)
def linearise(k, dg, phi, young, young_slope, nu):
    """Fills jacobian = dr/dx, its inverse and b = dr/ddg."""
    # dm/dx = (1 - m n^T)/phi
    k.jacobian[:] = 0.0
    for i in range(3):
        am = k.alpha_m[i, 0] * k.m[0] + k.alpha_m[i, 1] * k.m[1] + k.alpha_m[i, 2] * k.m[2]
        for j in range(3):
            k.jacobian[i, j] = (k.alpha_m[i, j] - am * k.n[j]) / phi
        k.jacobian[i, i] += 1.0
    for j in range(3):
        a0, a1, a2 = k.jacobian[0, j], k.jacobian[1, j], k.jacobian[2, j]
        k.jacobian[0, j] = (a0 - nu * a1) / young + dg * k.h[0, j]
        k.jacobian[1, j] = (a1 - nu * a0) / young + dg * k.h[1, j]
        k.jacobian[2, j] = 2.0 * (1.0 + nu) * a2 / young + dg * k.h[2, j]
    # d(De^-1 T)/ddg = De^-1 (d alpha/ddg - E'/E T)
    loss = young_slope / young
    g0 = k.alpha_g[0] - loss * (k.x[0] + k.alpha[0])
    g1 = k.alpha_g[1] - loss * (k.x[1] + k.alpha[1])
    g2 = k.alpha_g[2] - loss * (k.x[2] + k.alpha[2])
    k.b[0] = (g0 - nu * g1) / young + k.n[0]
    k.b[1] = (g1 - nu * g0) / young + k.n[1]
    k.b[2] = 2.0 * (1.0 + nu) * g2 / young + k.n[2]
    invert(k.jacobian, k.inverse)


# Without counting references to arrays, all of which outlive the call: that took 1.5 us of 2.6 us per Yld2000 point.
@njit(**INNER, _nrt=False)
def newton(shape, hardening, rate, elastic, e, ep, past, begun, dg, k):
    """Solve for x (in k.x) and dg from a guess. Returns whether it converged, dg and the slope of the size.

    On success k holds everything at the solution, linearised.
    """
    base, trial, length, dstep = dg, dg, 0.0, 0.0
    for i in range(3):
        k.step[i] = 0.0
    best, nu = np.inf, elastic.nu
    length_e = sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2)
    for _ in range(80):
        for i in range(3):
            k.guess[i] = k.x[i] + length * k.step[i]
        trial = base + length * dstep
        young, young_slope = young_at(elastic, ep + trial)
        phi = locus(shape, k.guess, k.n, k.h)
        merit, f, size, slope = np.inf, 0.0, 0.0, 0.0
        if phi > 0.0:
            for i in range(3):
                k.m[i] = k.guess[i] / phi
                for j in range(3):
                    k.hm[i, j] = k.h[i, j] * phi
            size, slope = harden(
                hardening, shape, ep, past, begun, trial, k.m, k.n, k.hm, k.alpha, k.alpha_g, k.alpha_m, k.work
            )
            factor, factor_slope = rate_factor(trial, rate)
            slope = slope * factor + size * factor_slope
            size *= factor
            t0, t1, t2 = k.guess[0] + k.alpha[0], k.guess[1] + k.alpha[1], k.guess[2] + k.alpha[2]
            k.r[0] = (t0 - nu * t1) / young - e[0] + trial * k.n[0]
            k.r[1] = (t1 - nu * t0) / young - e[1] + trial * k.n[1]
            k.r[2] = 2.0 * (1.0 + nu) * t2 / young - e[2] + trial * k.n[2]
            f = phi - size
            merit = k.r[0] ** 2 + k.r[1] ** 2 + k.r[2] ** 2 + (f / elastic.young) ** 2
        limit = TOLERANCE * size / elastic.young + 1e-14 * length_e
        done = merit <= limit * limit
        if not done and not merit <= (1.0 - 2e-4 * length) * best:
            # Less of the step: the minimum of a parabola through what is known.
            shorter = length * length * best / (merit + (2.0 * length - 1.0) * best) if merit < np.inf else 0.0
            length = min(max(0.1 * length, shorter), 0.5 * length)
            if length < 1e-8:
                return False, base, slope
            continue
        for i in range(3):
            k.x[i] = k.guess[i]
        base, best = trial, merit
        linearise(k, base, phi, young, young_slope, nu)
        if done:
            return True, base, slope
        q0 = k.inverse[0, 0] * k.r[0] + k.inverse[0, 1] * k.r[1] + k.inverse[0, 2] * k.r[2]
        q1 = k.inverse[1, 0] * k.r[0] + k.inverse[1, 1] * k.r[1] + k.inverse[1, 2] * k.r[2]
        q2 = k.inverse[2, 0] * k.r[0] + k.inverse[2, 1] * k.r[1] + k.inverse[2, 2] * k.r[2]
        w0 = k.inverse[0, 0] * k.b[0] + k.inverse[0, 1] * k.b[1] + k.inverse[0, 2] * k.b[2]
        w1 = k.inverse[1, 0] * k.b[0] + k.inverse[1, 1] * k.b[1] + k.inverse[1, 2] * k.b[2]
        w2 = k.inverse[2, 0] * k.b[0] + k.inverse[2, 1] * k.b[1] + k.inverse[2, 2] * k.b[2]
        below = k.n[0] * w0 + k.n[1] * w1 + k.n[2] * w2 + slope
        dstep = (f - k.n[0] * q0 - k.n[1] * q1 - k.n[2] * q2) / below
        k.step[0], k.step[1], k.step[2] = -q0 - w0 * dstep, -q1 - w1 * dstep, -q2 - w2 * dstep
        length = 1.0
        if base + dstep < 0.0:  # flow never goes backwards
            length = max(-0.9 * base / dstep, 1e-6)
    return False, base, 0.0


@njit(**POINT, _nrt=False)
def return_point(shape, hardening, rate, elastic, ep, past, k):
    """Stress of one point whose trial strain is k.e. Returns dg (0: elastic, NaN: no solution), size slope.

    On plastic return k.x, k.alpha and the linearisation hold the solution.
    """
    nu = elastic.nu
    young, _ = young_at(elastic, ep)
    c = young / (1.0 - nu * nu)
    backstress(hardening, past, k.alpha)
    k.x[0] = c * (k.e[0] + nu * k.e[1]) - k.alpha[0]
    k.x[1] = c * (k.e[1] + nu * k.e[0]) - k.alpha[1]
    k.x[2] = 0.5 * young / (1.0 + nu) * k.e[2] - k.alpha[2]
    phi = locus(shape, k.x, k.n, k.h)
    for i in range(3):
        k.m[i] = k.x[i] / phi if phi > 0.0 else 0.0
        for j in range(3):
            k.hm[i, j] = k.h[i, j] * phi
    begun = begin(hardening, shape, past, k.m, k.n, k.hm)
    size, slope = harden(hardening, shape, ep, past, begun, 0.0, k.m, k.n, k.hm, k.guess, k.alpha_g, k.alpha_m, k.work)
    if phi <= size * (1.0 + 1e-12):
        return 0.0, slope, begun
    # Where the ray of the trial state meets the locus, and the flow that takes the stress there.
    k.b[0] = c * (k.n[0] + nu * k.n[1])
    k.b[1] = c * (k.n[1] + nu * k.n[0])
    k.b[2] = 0.5 * young / (1.0 + nu) * k.n[2]
    below = slope
    for i in range(3):
        below += k.n[i] * (k.b[i] + k.alpha_g[i])
    dg = (phi - size) / below
    for i in range(3):
        k.x[i] *= size / phi
    t0, t1, t2 = k.x[0] + k.alpha[0], k.x[1] + k.alpha[1], k.x[2] + k.alpha[2]
    k.start[0], k.start[1] = (t0 - nu * t1) / young, (t1 - nu * t0) / young
    k.start[2] = 2.0 * (1.0 + nu) * t2 / young
    x0, x1, x2 = k.x[0], k.x[1], k.x[2]
    good, found, slope = newton(shape, hardening, rate, elastic, k.e, ep, past, begun, dg, k)
    if good:
        return found, slope, begun
    # Approach the trial state in steps.
    k.x[0], k.x[1], k.x[2] = x0, x1, x2
    dg, tau, width = 0.0, 0.0, 0.125
    while True:
        ahead = min(tau + width, 1.0)
        x0, x1, x2 = k.x[0], k.x[1], k.x[2]
        for i in range(3):
            k.aim[i] = k.start[i] + ahead * (k.e[i] - k.start[i])
        good, found, slope = newton(shape, hardening, rate, elastic, k.aim, ep, past, begun, dg, k)
        if good:
            dg, tau = found, ahead
            if tau >= 1.0:
                return dg, slope, begun
            width *= 2.0
        else:
            k.x[0], k.x[1], k.x[2] = x0, x1, x2
            width *= 0.25
            if width < 1e-9:
                return np.nan, slope, begun


@njit(**POINT, _nrt=False)
def stiffness_of(k, dg, slope, young, young_slope, nu):
    """Fills k.stiffness = dT/dH at the solution."""
    c = young / (1.0 - nu * nu)
    shear = 0.5 * young / (1.0 + nu)
    k.stiffness[:] = 0.0
    if dg > 0.0:
        g0 = k.n[0] * k.inverse[0, 0] + k.n[1] * k.inverse[1, 0] + k.n[2] * k.inverse[2, 0]
        g1 = k.n[0] * k.inverse[0, 1] + k.n[1] * k.inverse[1, 1] + k.n[2] * k.inverse[2, 1]
        g2 = k.n[0] * k.inverse[0, 2] + k.n[1] * k.inverse[1, 2] + k.n[2] * k.inverse[2, 2]
        below = g0 * k.b[0] + g1 * k.b[1] + g2 * k.b[2] + slope
        k.r[0], k.r[1], k.r[2] = g0 / below, g1 / below, g2 / below  # ddg/dH
        for i in range(3):
            w = k.inverse[i, 0] * k.b[0] + k.inverse[i, 1] * k.b[1] + k.inverse[i, 2] * k.b[2]
            for j in range(3):
                k.jacobian[i, j] = k.inverse[i, j] - w * k.r[j]  # dx/dH
        for i in range(3):
            for j in range(3):
                total = k.n[i] * k.r[j]
                for l in range(3):
                    total += dg * k.h[i, l] * k.jacobian[l, j]
                k.stiffness[i, j] = -total
    for i in range(3):
        k.stiffness[i, i] += 1.0
    for j in range(3):
        a0, a1 = k.stiffness[0, j], k.stiffness[1, j]
        k.stiffness[0, j], k.stiffness[1, j] = c * (a0 + nu * a1), c * (a1 + nu * a0)
        k.stiffness[2, j] *= shear
    if dg > 0.0 and young_slope != 0.0:
        loss = young_slope / young
        for i in range(3):
            for j in range(3):
                k.stiffness[i, j] += loss * (k.x[i] + k.alpha[i]) * k.r[j]


@njit(**INNER, error_model="numpy")
def respond_general(shape, hardening, rate, elastic, n, w, past, now, stiffened):
    """See `update.respond`. A point whose return map finds no solution gets NaN."""
    k, nu = new_scratch(), elastic.nu
    for p in range(n):
        (h1, h2, h3), (hp1, hp2, hp3), ep = vector(w, H, p), vector(w, HP, p), w[EP + p]
        k.e[0], k.e[1], k.e[2] = h1 - hp1, h2 - hp2, h3 - hp3
        dg, slope, begun = return_point(shape, hardening, rate, elastic, ep, past[p], k)
        young, young_slope = young_at(elastic, ep + dg)
        if dg == 0.0:
            for i in range(past.shape[1]):
                now[p, i] = past[p, i]
            c = young / (1.0 - nu * nu)
            t1, t2, t3 = c * (k.e[0] + nu * k.e[1]), c * (k.e[1] + nu * k.e[0]), 0.5 * young / (1.0 + nu) * k.e[2]
        else:
            remember(hardening, shape, ep, past[p], begun, dg, k.m, k.n, k.hm, now[p], k.work)
            hp1, hp2, hp3 = hp1 + dg * k.n[0], hp2 + dg * k.n[1], hp3 + dg * k.n[2]
            t1, t2, t3 = k.x[0] + k.alpha[0], k.x[1] + k.alpha[1], k.x[2] + k.alpha[2]
            if isnan(dg):
                t1 = t2 = t3 = np.nan
        put(w, T, p, (t1, t2, t3))
        put(w, HP, p, (hp1, hp2, hp3))
        w[EP + p], w[E33 + p] = ep + dg, -nu / young * (t1 + t2) - hp1 - hp2
        if stiffened:
            stiffness_of(k, dg, slope, young, young_slope, nu)
            take_stiffness(w, p, k.stiffness)
