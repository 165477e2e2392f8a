"""Logarithmic (Hencky) strain H = 1/2 ln C of a 2 x 2 metric, without eigenvectors.

y = (E11, E22, 2 E12) is the Green strain. a = y1 + y2, m = 1 + a, d = y1 - y2, s = y3, rho = d^2 + s^2,
grown = det C - 1 = a (2 + a) - rho, v = rho/m^2; then H = (p + q d, p - q d, 2 q s) with p = 1/4 ln det C and
q = Phi(v)/(2 m), Phi = artanh(sqrt v)/sqrt v, which needs no distinct eigenvalues (theory_shell.md 6). The logarithm is
a value of Phi too: ln(1 + grown) = 2 u Phi(u^2), u = grown/(2 + grown).

Phi = 1 + v (1/3 + v/5 + ...) is a polynomial where its argument is below `NEAR`, in every function but `phi_closed`:
the series in the brackets interpolated at the Chebyshev points of 0..NEAR. It has its pole at v = 1, so that 11 terms
do what takes 17 of the series.
"""

from math import atanh, sqrt

import numpy as np
from numba import njit

from ..kernels import FUSED_POINT

NEAR, N_TERMS = 0.1, 11  # the last term is below round-off


def bracket(t):
    """(Phi - 1)/v at v = NEAR (1 + t)/2, summed to round-off."""
    v = 0.5 * NEAR * (1.0 + t)
    return sum(v**k / (2.0 * k + 3.0) for k in range(18, -1, -1))


TERMS = tuple(
    float(c) for c in np.polynomial.chebyshev.cheb2poly(np.polynomial.chebyshev.chebinterpolate(bracket, N_TERMS - 1))
)


@njit(**FUSED_POINT)
def invariants(c11, c22, c12):
    """m, d, s, grown of a metric."""
    y1, y2 = 0.5 * (c11 - 1.0), 0.5 * (c22 - 1.0)
    a, d, s = y1 + y2, y1 - y2, c12
    return 1.0 + a, d, s, a * (2.0 + a) - (d * d + s * s)


@njit(**FUSED_POINT)
def phi_series(v):
    """Phi and its first derivative."""
    t, b0, b1 = v * (2.0 / NEAR) - 1.0, 0.0, 0.0
    for k in range(N_TERMS - 1, -1, -1):
        b1 = b1 * t + b0
        b0 = b0 * t + TERMS[k]
    return 1.0 + v * b0, b0 + v * (2.0 / NEAR) * b1


@njit(**FUSED_POINT)
def phi_series_second(v):
    """Second derivative of Phi."""
    t, b0, b1, b2 = v * (2.0 / NEAR) - 1.0, 0.0, 0.0, 0.0
    for k in range(N_TERMS - 1, -1, -1):
        b2 = b2 * t + b1
        b1 = b1 * t + b0
        b0 = b0 * t + TERMS[k]
    return 2.0 * (2.0 / NEAR) * (b1 + v * (2.0 / NEAR) * b2)


@njit(**FUSED_POINT)
def phi_closed(v):
    """Phi and its first two derivatives, from `NEAR` on."""
    root, steep = sqrt(v), 1.0 / (1.0 - v)
    f0 = atanh(root) / root
    f1 = 0.5 * (steep - f0) / v
    return f0, f1, (0.5 * (steep * steep - f1) - f1) / v


@njit(**FUSED_POINT)
def log_strain(half, d, s, log_det, f0):
    """[H11, H22, 2 H12]. half : 1/(2 m)"""
    p, q = 0.25 * log_det, f0 * half
    return p + q * d, p - q * d, 2.0 * q * s


@njit(**FUSED_POINT)
def first_derivatives(m, half, over, f0, f1):
    """q; derivatives p_m, p_r, q_m, q_r of p and q with respect to m and rho. half : 1/(2 m); over : 1/det C"""
    return f0 * half, 0.5 * m * over, -0.25 * over, -0.5 * over, 4.0 * f1 * half * half * half


@njit(**FUSED_POINT)
def conjugate(m, half, d, s, over, f0, f1, t1, t2, t3):
    """t_k dH_k/dy_j of a stress t."""
    q, p_m, p_r, q_m, q_r = first_derivatives(m, half, over, f0, f1)
    # m = 1 + y1 + y2, d = y1 - y2, s = y3
    total, lever_d, lever_s = t1 + t2, t1 - t2, 2.0 * t3
    lever = lever_d * d + lever_s * s
    by_m, by_r = total * p_m + lever * q_m, 2.0 * (total * p_r + lever * q_r)
    by_d = by_r * d + q * lever_d
    return by_m + by_d, by_m - by_d, by_r * s + q * lever_s


@njit(**FUSED_POINT)
def log_strain_gradient(m, half, d, s, over, f0, f1):
    """dH_k/dy_j, row by row."""
    q, p_m, p_r, q_m, q_r = first_derivatives(m, half, over, f0, f1)
    pd, ps, qd, qs = 2.0 * d * p_r, 2.0 * s * p_r, 2.0 * d * q_r, 2.0 * s * q_r
    am, ad = p_m + q_m * d, pd + qd * d + q
    bm, bd = p_m - q_m * d, pd - qd * d - q
    cm, cd = 2.0 * q_m * s, 2.0 * qd * s
    return am + ad, am - ad, ps + qs * d, bm + bd, bm - bd, ps - qs * d, cm + cd, cm - cd, 2.0 * (qs * s + q)


@njit(**FUSED_POINT)
def log_strain_second(m, half, d, s, over, f1, f2, t1, t2, t3):
    """t_k d2H_k/dy_i dy_j for a stress t: 11, 22, 33, 12, 13, 23."""
    cube = 4.0 * half * half * half
    p_r, q_m, q_r = -0.25 * over, -0.5 * over, f1 * cube
    p_mm, p_mr, p_rr = over * (0.5 - m * m * over), 0.5 * m * over * over, -0.25 * over * over
    q_mm, q_mr, q_rr = m * over * over, -0.5 * over * over, 4.0 * f2 * cube * half * half
    qd, qs = 2.0 * d * q_r, 2.0 * s * q_r
    total, lever_d, lever_s = t1 + t2, t1 - t2, 2.0 * t3
    lever = lever_d * d + lever_s * s
    mr, rr, r = 2.0 * (total * p_mr + lever * q_mr), 4.0 * (total * p_rr + lever * q_rr), total * p_r + lever * q_r
    mm = total * p_mm + lever * q_mm
    md, ms = mr * d + q_m * lever_d, mr * s + q_m * lever_s
    dd = 2.0 * r + rr * d * d + 2.0 * qd * lever_d
    ds = rr * d * s + qd * lever_s + qs * lever_d
    ss = 2.0 * r + rr * s * s + 2.0 * qs * lever_s
    return mm + 2.0 * md + dd, mm - 2.0 * md + dd, ss, mm - dd, ms + ds, ms - ds
