"""Yoshida-Uemori two-surface hardening (IJP 18 (2002) 661-686) for any locus.

Symbols: p equivalent plastic strain; m = (T - alpha)/Y, phi(m) = 1; alpha = theta + beta; a = B + R - Y.

    yield surface    phi(T - alpha) = Y, of constant size
    bounding surface of size B + R around beta, d beta = k (b m - beta) dp
    theta            d theta = C (a m - sqrt(a/phi(theta)) theta) dp
    R                dR = k (R_sat - R) dp, only while beta moves the surface of stagnation phi(beta - q) = r
    stagnation       dr = h d phi(beta - q), dq = (1 - h) d phi(beta - q) along beta - q

(k is the paper's m.) Over an increment m stays at its end value: beta follows in closed form, theta = K theta_old + J m
by a two-stage L-stable Runge-Kutta method (SDIRK2) in `N_STEPS` sub-steps, each stage of which is a quadratic equation
for sqrt(phi(theta)). Every derivative is that of these formulas. Sub-steps of the increments that theta turns round in
count most: with six of them, strains of 0.004 after a reversal are met to 0.6 MPa (four: 1.7, eight: 0.25).
"""

from dataclasses import dataclass, fields
from math import exp, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import INNER, POINT
from .dispatch import POINTS, locus
from .isotropic import begin_nothing

N_STEPS = 6
GAMMA = 1.0 - sqrt(0.5)
# Columns of the history.
THETA, BETA, Q, RADIUS, R = 0, 3, 6, 9, 10


@dataclass(frozen=True)
class YoshidaUemori:
    """Y, B, R_sat, b [MPa]; C, m rates of the two backstresses; h share of the stagnation surface that grows."""

    Y: float
    B: float
    C: float
    R_sat: float
    m: float
    b: float
    h: float

    n_history = 11

    def __post_init__(self):
        for item in fields(self):
            value = getattr(self, item.name)
            lowest = "above 0" if item.name in ("Y", "B", "C") else "of 0 or more"
            if not np.isfinite(value) or value < 0.0 or (lowest == "above 0" and value == 0.0):
                raise SceneError(f"Yoshida-Uemori {item.name}: found {value!r}, expected a number {lowest}")
        if self.B <= self.Y:
            raise SceneError(f"Yoshida-Uemori B: found {self.B!r}, expected MPa above Y = {self.Y!r}")
        if self.h > 1.0:
            raise SceneError(f"Yoshida-Uemori h: found {self.h!r}, expected 0 up to 1")

    @property
    def initial_yield_stress(self):
        """MPa."""
        return float(self.Y)

    def data(self):
        """Numbers for the kernels."""
        return YoshidaUemoriData(*(float(getattr(self, item.name)) for item in fields(self)))


class YoshidaUemoriData(NamedTuple):
    Y: float
    B: float
    C: float
    R_sat: float
    m: float
    b: float
    h: float


@njit(**POINT)
def yu_backstress(data, past, alpha):
    for i in range(3):
        alpha[i] = past[THETA + i] + past[BETA + i]


@njit(**POINT)
def grow_bound(data, shape, past, dg, m, work, beta, beta_g, r_m):
    """Bounding surface after dg: fills beta, its derivative beta_g and r_m = dR/dm, all (3,).

    Returns R, dR/ddg, d beta/dm (a multiple of 1) and the distance phi(beta - q).
    """
    left = exp(-data.m * dg)
    added = data.b * (1.0 - left)
    away, gradient, leaving = work[0, 1], work[0, 0], work[0, 2]
    for i in range(3):
        away[i] = past[BETA + i] - past[Q + i]
    before = min(locus(shape, away, leaving, work[1]), past[RADIUS])
    for i in range(3):
        beta[i] = past[BETA + i] * left + added * m[i]
        beta_g[i] = data.m * (data.b * m[i] - past[BETA + i]) * left
        away[i] = beta[i] - past[Q + i]
        r_m[i] = 0.0
    distance = locus(shape, away, gradient, work[1])
    if distance <= past[RADIUS]:
        return past[R], 0.0, added, distance
    # The share of the increment in which beta was outside. The distance is convex along it: a parabola with the
    # right ends and the right slope at the start, so that the share is continuous in every direction.
    if before == 0.0:
        for i in range(3):
            leaving[i] = gradient[i]
    slope = slope_g = distance_g = 0.0
    for i in range(3):
        slope += leaving[i] * (beta[i] - past[BETA + i])
        slope_g += leaving[i] * beta_g[i]
        distance_g += gradient[i] * beta_g[i]
    bend, inside = max(distance - before - slope, 0.0), past[RADIUS] - before
    width = sqrt(slope * slope + 4.0 * bend * inside)
    exit = 0.0
    if slope > 0.0:
        exit = 2.0 * inside / (slope + width)
    elif bend > 0.0:
        exit = (width - slope) / (2.0 * bend)
    exit = min(exit, 1.0)
    exit_slope, exit_distance = 0.0, 0.0
    if width > 1e-30 * data.b:
        exit_slope, exit_distance = exit * (exit - 1.0) / width, -exit * exit / width
    rest = (data.R_sat - past[R]) * exp(-data.m * (1.0 - exit) * dg)
    for i in range(3):
        r_m[i] = -rest * data.m * dg * added * (exit_slope * leaving[i] + exit_distance * gradient[i])
    r_g = rest * data.m * (1.0 - exit - dg * (exit_slope * slope_g + exit_distance * distance_g))
    return data.R_sat - rest, r_g, added, distance


@njit(**INNER)
def follow_bound(data, shape, past, dg, r, r_g, r_m, m, k_m, j_m, work):
    """theta = K theta_old + J m after dg, while R goes straight from its old value to r(dg, m).

    Returns K, J and their derivatives with respect to dg; fills those with respect to m, k_m and j_m (3,).
    """
    w, gradient, old = work[4, 0], work[4, 1], work[4, 2]
    wk_m, wj_m, before_k_m, before_j_m = work[2, 0], work[2, 1], work[2, 2], work[3, 0]
    for i in range(3):
        old[i], k_m[i], j_m[i] = past[THETA + i], 0.0, 0.0
    k, k_g, j, j_g = 1.0, 0.0, 0.0, 0.0
    before_k, before_k_g, before_j, before_j_g = k, k_g, j, j_g
    g_g = GAMMA * data.C / N_STEPS
    g = g_g * dg
    ahead = (1.0 - GAMMA) / GAMMA
    for stage in range(2 * N_STEPS):
        second = stage % 2 == 1
        share = (stage // 2 + (1.0 if second else GAMMA)) / N_STEPS
        a = data.B - data.Y + past[R] + share * (r - past[R])
        a_g, root_a = share * r_g, sqrt(a)
        if second:  # from the sub-step's start, with the first stage's slope
            wk, wk_g = before_k + ahead * (k - before_k), before_k_g + ahead * (k_g - before_k_g)
            wj, wj_g = before_j + ahead * (j - before_j), before_j_g + ahead * (j_g - before_j_g)
            for i in range(3):
                wk_m[i] = before_k_m[i] + ahead * (k_m[i] - before_k_m[i])
                wj_m[i] = before_j_m[i] + ahead * (j_m[i] - before_j_m[i])
        else:
            before_k, before_k_g, before_j, before_j_g = k, k_g, j, j_g
            wk, wk_g, wj, wj_g = k, k_g, j, j_g
            for i in range(3):
                before_k_m[i] = wk_m[i] = k_m[i]
                before_j_m[i] = wj_m[i] = j_m[i]
        wj += g * a
        wj_g += g_g * a + g * a_g
        for i in range(3):
            wj_m[i] += g * share * r_m[i]
            w[i] = wk * old[i] + wj * m[i]
        # theta (1 + g sqrt(a/phi(theta))) = w: y = sqrt(phi(theta)) solves y^2 + g sqrt(a) y = phi(w).
        size = locus(shape, w, gradient, work[1])
        if size <= 1e-14 * a:
            k = k_g = j = j_g = 0.0
            for i in range(3):
                k_m[i] = j_m[i] = 0.0
            continue
        along_old = gradient[0] * old[0] + gradient[1] * old[1] + gradient[2] * old[2]
        along_m = gradient[0] * m[0] + gradient[1] * m[1] + gradient[2] * m[2]
        s = sqrt(g * g * a + 4.0 * size)
        y = 2.0 * size / (s + g * root_a)
        kept = y * y / size
        y_g, y_a = 0.5 * (g * a / s - root_a), 0.25 * (g * g / s - g / root_a)
        kept_size = 2.0 * y / (s * size) - kept / size
        kept_g, kept_a = 2.0 * y * y_g / size, 2.0 * y * y_a / size
        slope = kept_size * (along_old * wk_g + along_m * wj_g) + kept_g * g_g + kept_a * a_g
        k, k_g = kept * wk, kept * wk_g + wk * slope
        j, j_g = kept * wj, kept * wj_g + wj * slope
        for i in range(3):
            slope = kept_size * (along_old * wk_m[i] + along_m * wj_m[i] + wj * gradient[i])
            slope += kept_a * share * r_m[i]
            k_m[i] = kept * wk_m[i] + wk * slope
            j_m[i] = kept * wj_m[i] + wj * slope
    return k, j, k_g, j_g


@njit(**POINT)
def harden_yu(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work):
    beta, beta_g, r_m, k_m, j_m = work[6, 0], work[6, 1], work[6, 2], work[5, 0], work[5, 1]
    r, r_g, spread, _ = grow_bound(data, shape, past, dg, m, work, beta, beta_g, r_m)
    kept, added, kept_g, added_g = follow_bound(data, shape, past, dg, r, r_g, r_m, m, k_m, j_m, work)
    for i in range(3):
        alpha[i] = kept * past[THETA + i] + added * m[i] + beta[i]
        alpha_g[i] = kept_g * past[THETA + i] + added_g * m[i] + beta_g[i]
        for j in range(3):
            alpha_m[i, j] = k_m[j] * past[THETA + i] + j_m[j] * m[i]
        alpha_m[i, i] += added + spread
    return data.Y, 0.0


@njit(**POINT)
def remember_yu(data, shape, ep, past, begun, dg, m, n, h, now, work):
    beta, beta_g, r_m, k_m, j_m = work[6, 0], work[6, 1], work[6, 2], work[5, 0], work[5, 1]
    r, _, _, distance = grow_bound(data, shape, past, dg, m, work, beta, beta_g, r_m)
    moved = max(distance - past[RADIUS], 0.0)
    for i in range(3):
        now[BETA + i] = beta[i]
        shift = (1.0 - data.h) * moved / distance * (beta[i] - past[Q + i]) if moved > 0.0 else 0.0
        now[Q + i] = past[Q + i] + shift
    now[RADIUS] = past[RADIUS] + data.h * moved
    now[R] = r
    kept, added, _, _ = follow_bound(data, shape, past, dg, r, 0.0, r_m, m, k_m, j_m, work)
    for i in range(3):
        now[THETA + i] = kept * past[THETA + i] + added * m[i]


POINTS["backstress", YoshidaUemoriData] = yu_backstress
POINTS["begin", YoshidaUemoriData] = begin_nothing
POINTS["harden", YoshidaUemoriData] = harden_yu
POINTS["remember", YoshidaUemoriData] = remember_yu
