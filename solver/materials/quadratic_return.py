"""Return map of quadratic loci with isotropic hardening: one scalar equation per point, a block of points at a time.

Symbols: H logarithmic strain [11, 22, 2*12]; T its work-conjugate stress [11, 22, 12]; Hp plastic part; ep equivalent
plastic strain; De plane-stress elasticity. P and De^-1 are diagonalised together, once per material:
V^T De^-1 V = 1, V^T P V = diag(l). In coordinates x, T = V x, the trial state is x = V^T (H - Hp), backward Euler gives
x_i k_i, k_i = 1/(1 + mu l_i) with mu = dg/s_y(ep + dg). With q_i = l_i x_i^2 of the trial state,
sigma_eq^2 = sum q_i k_i^2, so that one equation for dg remains, sigma_eq(dg) = s_y(ep + dg) (theory_shell.md 7). The
shear 12 is a mode of its own.

Newton works on G = s_y/sigma_eq - 1 = 0: for one l alone and linear hardening that is linear in dg. Its step is bent by
the curvature that different l give (Chebyshev's method), so that a guess off by f is next off by some f^3: with
A, B, C = sum q k^2 (k l)^0, 1, 2 and v = s_y - dg s_y', G' sigma^3 s_y = B v + A s_y s_y' and, but for s_y'',
G'' sigma^5 s_y^3 = 3 v^2 (B^2 - A C). All points of a block take each sweep together, those that are done without
moving, so that no point sees its neighbours; the few that take more than `N_SWEEPS`, and every point of a material with
a rate, are solved one by one inside a bracket.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..kernels import FUSED, FUSED_POINT, INNER
from ..lanes import BLOCK, put, vector
from .block import C11, C12, C13, C21, C22, C23, C31, C32, C33, E33, EP, HP, OWN, SHARED, H, T
from .hardening import N_KNOTS, piece, place_of, yield_stress
from .rate import rate_factor

# Fields of a block beside the shared ones: trial state, its q, what is sought, the curve at a guess.
X, Q = BLOCK * SHARED, BLOCK * (SHARED + 3)
DG, SY, SLOPE, MU, OPEN, Y, PLACE, ROW, A0, A1, A2, A3 = (BLOCK * i for i in range(SHARED + 6, SHARED + OWN))
N_SWEEPS = 8
YIELDS, NEARLY, EXACT = 1e-12, 5e-6, 1e-13  # of the yield stress; from NEARLY the next step of a sweep is the last
BEND = 0.5  # of a step, at most, by the curvature: far from the solution it tells little


class Modes(NamedTuple):
    """Common eigenvectors of P and De^-1 and what a point needs beside them."""

    v11: float
    v12: float
    v21: float
    v22: float
    v33: float
    l1: float
    l2: float
    l3: float
    p11: float
    p12: float
    p22: float
    p33: float
    young: float
    nu: float


def modes_of(matrix, young, nu):
    """Modes of a material. matrix : P (3, 3)"""
    c = young / (1.0 - nu**2)
    root = np.linalg.cholesky(c * np.array([[1.0, nu], [nu, 1.0]]))
    shear = 0.5 * young / (1.0 + nu)
    values, vectors = np.linalg.eigh(root.T @ matrix[:2, :2] @ root)
    v = root @ vectors
    values = np.maximum(values, 0.0)
    numbers = (*v.ravel(), np.sqrt(shear), *values, matrix[2, 2] * shear)
    numbers += (matrix[0, 0], matrix[0, 1], matrix[1, 1], matrix[2, 2], young, nu)
    return Modes(*(float(number) for number in numbers))


@njit(**FUSED_POINT)
def relaxed(dg, sy, k):
    """k_i = 1/(1 + l_i dg/s_y) of the three modes, all times the fourth number and over s_y: one quotient for three."""
    d1, d2, d3 = sy + k.l1 * dg, sy + k.l2 * dg, sy + k.l3 * dg
    d23 = d2 * d3
    return d23, d1 * d3, d1 * d2, d1 * d23


@njit(**FUSED_POINT)
def excess(q1, q2, q3, dg, sy, rise, run, k):
    """sigma_eq - s_y after dg more of equivalent plastic strain, and the step from there. The slope of s_y is
    rise/run."""
    k1, k2, k3, all_three = relaxed(dg, sy, k)
    over = sy / all_three
    k1, k2, k3 = k1 * over, k2 * over, k3 * over
    w1, w2, w3 = q1 * k1 * k1, q2 * k2 * k2, q3 * k3 * k3
    a, (k1, k2, k3) = w1 + w2 + w3, (k1 * k.l1, k2 * k.l2, k3 * k.l3)
    f, b, c = sqrt(a) - sy, w1 * k1 + w2 * k2 + w3 * k3, w1 * k1 * k1 + w2 * k2 * k2 + w3 * k3 * k3
    v, sa = sy * run - dg * rise, sy * a
    below = b * v + rise * sa
    over = 1.0 / (sy * below)
    to_slope = over * sy
    bend = 1.5 * (v * to_slope) * (v * to_slope) * (a * c - b * b) * f * (over * below)
    return f, f * sa * run * to_slope * (1.0 + max(min(bend, BEND), -BEND))


@njit(**FUSED, error_model="numpy")
def sweep_block(w, n, k, table):
    """Fills DG, SY and SLOPE of the points of a block whose equation Newton solves. Returns how many it does not,
    which OPEN marks."""
    left = n
    for _ in range(N_SWEEPS):
        # The curve's pieces; late sweeps stay on those they have.
        moved = 0
        for p in range(n):
            y, place = place_of(w[EP + p] + w[DG + p])
            row = float(int(place)) if place < N_KNOTS - 1.0 else N_KNOTS - 1.0
            moved += 1 if row != w[ROW + p] else 0
            w[Y + p], w[PLACE + p], w[ROW + p] = y, place - row, row
        if moved > 0:
            for p in range(n):
                i = int(w[ROW + p])
                w[A0 + p], w[A1 + p], w[A2 + p], w[A3 + p] = table[i, 0], table[i, 1], table[i, 2], table[i, 3]
        left = 0
        for p in range(n):
            dg, open_ = w[DG + p], w[OPEN + p]
            sy, rise, run = piece(w[Y + p], w[PLACE + p], w[A0 + p], w[A1 + p], w[A2 + p], w[A3 + p])
            q1, q2, q3 = vector(w, Q, p)
            f, step = excess(q1, q2, q3, dg, sy, rise, run, k)
            elastic = (dg == 0.0) & (f <= YIELDS * sy)
            step = 0.0 if elastic else step
            moves = open_ > 0.0
            slope = rise / run
            w[DG + p] = dg + step if moves else dg
            w[SY + p] = sy + slope * step if moves else w[SY + p]
            w[SLOPE + p] = slope if moves else w[SLOPE + p]
            # Where flow begins the curve in y tells no slope: the first step is short by what hardening takes.
            near = (abs(f) <= NEARLY * sy) & (w[Y + p] > 0.0)
            open_ = 0.0 if elastic | near else open_
            w[OPEN + p] = open_
            left += 1 if open_ > 0.0 else 0
        if left == 0:
            break
    return left


@njit(**INNER, error_model="numpy")
def plastic_increment(q1, q2, q3, ep, k, table, rate):
    """Increment dg of the equivalent plastic strain, 0 where elastic; with the yield stress and its slope there.

    Newton inside a bracket, so that it ends from any finite trial state: sigma_eq falls with dg, and s_y stays above 0.
    """
    trial = sqrt(q1 + q2 + q3)
    sy, slope = yield_stress(ep, table)
    if trial <= sy * (1.0 + YIELDS):
        return 0.0, sy, slope
    if not trial < np.inf:
        return np.nan, sy, slope
    # The mode that relaxes slowest bounds dg; a mode without stress does not count.
    smallest = max(k.l1, k.l2, k.l3)
    for l in (k.l1, k.l2, k.l3):
        if 0.0 < l < smallest:
            smallest = l
    low, dg, high = 0.0, 0.0, 2.0 * trial / smallest
    for _ in range(200):
        sy, slope = yield_stress(ep + dg, table)
        factor, factor_slope = rate_factor(dg, rate)
        slope = slope * factor + sy * factor_slope
        sy *= factor
        f, step = excess(q1, q2, q3, dg, sy, slope, 1.0, k)
        if f > 0.0:
            low = dg
        else:
            high = dg
        if abs(f) <= EXACT * sy:
            break
        ahead = dg + step
        if not low < ahead < high:
            ahead = 0.5 * (low + high)
        if ahead == dg:
            break
        dg = ahead
    return dg, sy, slope


@njit(**FUSED, error_model="numpy")
def begin_block(w, n, k):
    """Fills the trial state of a block."""
    for p in range(n):
        (h1, h2, h3), (hp1, hp2, hp3) = vector(w, H, p), vector(w, HP, p)
        e1, e2, e3 = h1 - hp1, h2 - hp2, h3 - hp3
        x1, x2, x3 = k.v11 * e1 + k.v21 * e2, k.v12 * e1 + k.v22 * e2, k.v33 * e3
        put(w, X, p, (x1, x2, x3))
        put(w, Q, p, (k.l1 * x1 * x1, k.l2 * x2 * x2, k.l3 * x3 * x3))
        w[DG + p], w[OPEN + p], w[ROW + p] = 0.0, 1.0, -1.0


@njit(**FUSED, error_model="numpy")
def end_block(w, n, k):
    """Fills T, HP, EP and E33 of a block, from the solution of its equations."""
    for p in range(n):
        sy, dg, (x1, x2, x3) = w[SY + p], w[DG + p], vector(w, X, p)
        k1, k2, k3, all_three = relaxed(dg, sy, k)
        over = 1.0 / (sy * all_three)
        mu, over = dg * all_three * over, sy * sy * over
        x1, x2, x3 = x1 * (k1 * over), x2 * (k2 * over), x3 * (k3 * over)
        put(w, X, p, (x1, x2, x3))
        w[MU + p] = mu
        put(w, T, p, (k.v11 * x1 + k.v12 * x2, k.v21 * x1 + k.v22 * x2, k.v33 * x3))
        w[EP + p] += dg
    for p in range(n):
        mu, (t1, t2, t3), (hp1, hp2, hp3) = w[MU + p], vector(w, T, p), vector(w, HP, p)
        hp1, hp2 = hp1 + mu * (k.p11 * t1 + k.p12 * t2), hp2 + mu * (k.p12 * t1 + k.p22 * t2)
        put(w, HP, p, (hp1, hp2, hp3 + mu * k.p33 * t3))
        w[E33 + p] = -k.nu / k.young * (t1 + t2) - hp1 - hp2


@njit(**FUSED, error_model="numpy")
def stiffen_block(w, n, k):
    """Fills C of a block: Xi = (De^-1 + mu P)^-1 less the flow."""
    for p in range(n):
        sy, slope, mu = w[SY + p], w[SLOPE + p], w[MU + p]
        k1, k2, k3 = 1.0 / (1.0 + mu * k.l1), 1.0 / (1.0 + mu * k.l2), 1.0 / (1.0 + mu * k.l3)
        x1, x2, x3 = vector(w, X, p)
        n1, n2, n3 = k.l1 * x1 / sy, k.l2 * x2 / sy, k.l3 * x3 / sy
        m1, m2, m3 = k1 * n1, k2 * n2, k3 * n3
        flow = 1.0 / (n1 * m1 + n2 * m2 + n3 * m3 + slope / (1.0 - mu * slope))
        flow = flow if w[DG + p] > 0.0 else 0.0
        m1, m2, m3 = k.v11 * m1 + k.v12 * m2, k.v21 * m1 + k.v22 * m2, k.v33 * m3
        w[C11 + p] = k.v11 * k1 * k.v11 + k.v12 * k2 * k.v12 - flow * m1 * m1
        w[C22 + p] = k.v21 * k1 * k.v21 + k.v22 * k2 * k.v22 - flow * m2 * m2
        w[C33 + p] = k.v33 * k3 * k.v33 - flow * m3 * m3
        w[C12 + p] = w[C21 + p] = k.v11 * k1 * k.v21 + k.v12 * k2 * k.v22 - flow * m1 * m2
        w[C13 + p] = w[C31 + p] = -flow * m1 * m3
        w[C23 + p] = w[C32 + p] = -flow * m2 * m3


@njit(**FUSED, error_model="numpy")
def respond_quadratic(k, curve, rate, elastic, n, w, past, now, stiffened):
    """See `update.respond`. The law has no history of its own."""
    begin_block(w, n, k)
    if rate.inverse_dt > 0.0 or sweep_block(w, n, k, curve.table) > 0:
        for p in range(n):
            if w[OPEN + p] > 0.0:
                q1, q2, q3 = vector(w, Q, p)
                w[DG + p], w[SY + p], w[SLOPE + p] = plastic_increment(q1, q2, q3, w[EP + p], k, curve.table, rate)
    end_block(w, n, k)
    if stiffened:
        if rate.inverse_dt == 0.0:
            # The last step ended beyond where the slope was taken.
            for p in range(n):
                _, w[SLOPE + p] = yield_stress(w[EP + p], curve.table)
        stiffen_block(w, n, k)
