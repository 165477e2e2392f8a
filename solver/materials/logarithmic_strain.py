"""Logarithmic (Hencky) strain H = 1/2 ln C of a 2 x 2 metric, without eigenvectors.

y = (E11, E22, 2 E12) is the Green strain. m = 1 + y1 + y2, d = y1 - y2, s = y3, rho = d^2 + s^2,
det C = m^2 - rho, v = rho/m^2; then H = (p + q d, p - q d, 2 q s) with p = 1/4 ln det C and
q = Phi(v)/(2 m), Phi = artanh(sqrt v)/sqrt v, which needs no distinct eigenvalues (theory_shell.md 6).
"""

from math import atanh, log, sqrt

from numba import njit

N_SERIES, N_SHORT = 17, 8  # v^17 at v = 0.1 and v^8 at v = 0.01 are below round-off


@njit(forceinline=True)
def phi(v):
    """Phi and its first derivative."""
    if v < 0.01:
        f0 = f1 = 0.0
        for k in range(N_SHORT, 0, -1):
            f0 = f0 * v + 1.0 / (2.0 * k + 1.0)
            f1 = f1 * v + k / (2.0 * k + 1.0)
        return f0 * v + 1.0, f1
    if v < 0.1:
        f0 = f1 = 0.0
        for k in range(N_SERIES, 0, -1):
            f0 = f0 * v + 1.0 / (2.0 * k + 1.0)
            f1 = f1 * v + k / (2.0 * k + 1.0)
        return f0 * v + 1.0, f1
    root = sqrt(v)
    f0 = atanh(root) / root
    return f0, (1.0 / (1.0 - v) - f0) / (2.0 * v)


@njit(forceinline=True)
def phi_second(v, f1):
    """Second derivative of Phi, whose first is f1."""
    if v < 0.1:
        f2 = 0.0
        for k in range(N_SHORT if v < 0.01 else N_SERIES, 1, -1):
            f2 = f2 * v + k * (k - 1) / (2.0 * k + 1.0)
        return f2
    return (1.0 / (1.0 - v) ** 2 - f1) / (2.0 * v) - f1 / v


@njit(forceinline=True)
def log_strain_gradient(y1, y2, y3, h, first):
    """Fills h (3,) with [H11, H22, 2 H12] and first (3, 3) with dH_k/dy_j."""
    m, d, s = 1.0 + y1 + y2, y1 - y2, y3
    rho = d * d + s * s
    det = m * m - rho
    f0, f1 = phi(rho / (m * m))
    p, q = 0.25 * log(det), f0 / (2.0 * m)
    h[0], h[1], h[2] = p + q * d, p - q * d, 2.0 * q * s
    # Derivatives with respect to (m, d, s), then y: m = 1 + y1 + y2, d = y1 - y2, s = y3.
    p_m, p_r = 0.5 * m / det, -0.25 / det
    q_m, q_r = -0.5 / det, f1 / (2.0 * m * m * m)
    pd, ps, qd, qs = 2.0 * d * p_r, 2.0 * s * p_r, 2.0 * d * q_r, 2.0 * s * q_r
    am, ad, a_s = p_m + q_m * d, pd + qd * d + q, ps + qs * d
    bm, bd, bs = p_m - q_m * d, pd - qd * d - q, ps - qs * d
    cm, cd, cs = 2.0 * q_m * s, 2.0 * qd * s, 2.0 * (qs * s + q)
    first[0, 0], first[0, 1], first[0, 2] = am + ad, am - ad, a_s
    first[1, 0], first[1, 1], first[1, 2] = bm + bd, bm - bd, bs
    first[2, 0], first[2, 1], first[2, 2] = cm + cd, cm - cd, cs


@njit(forceinline=True)
def log_strain_second(y1, y2, y3, t, second):
    """Fills second (3, 3) with t_k d2H_k/dy_i dy_j for a stress t (3,)."""
    m, d, s = 1.0 + y1 + y2, y1 - y2, y3
    rho = d * d + s * s
    det = m * m - rho
    _, f1 = phi(rho / (m * m))
    f2 = phi_second(rho / (m * m), f1)
    p_mm, p_mr, p_rr = 0.5 / det - m * m / det**2, 0.5 * m / det**2, -0.25 / det**2
    p_r, q_m, q_r = -0.25 / det, -0.5 / det, f1 / (2.0 * m**3)
    q_mm, q_mr, q_rr = m / det**2, -0.5 / det**2, f2 / (2.0 * m**5)
    qd, qs = 2.0 * d * q_r, 2.0 * s * q_r
    total, lever_d, lever_s = t[0] + t[1], t[0] - t[1], 2.0 * t[2]
    lever = lever_d * d + lever_s * s
    mm = total * p_mm + lever * q_mm
    md = total * 2.0 * d * p_mr + lever * 2.0 * d * q_mr + q_m * lever_d
    ms = total * 2.0 * s * p_mr + lever * 2.0 * s * q_mr + q_m * lever_s
    dd = total * (2.0 * p_r + 4.0 * d * d * p_rr) + lever * (2.0 * q_r + 4.0 * d * d * q_rr) + 2.0 * qd * lever_d
    ds = total * 4.0 * d * s * p_rr + lever * 4.0 * d * s * q_rr + qd * lever_s + qs * lever_d
    ss = total * (2.0 * p_r + 4.0 * s * s * p_rr) + lever * (2.0 * q_r + 4.0 * s * s * q_rr) + 2.0 * qs * lever_s
    second[0, 0] = mm + 2.0 * md + dd
    second[0, 1] = second[1, 0] = mm - dd
    second[1, 1] = mm - 2.0 * md + dd
    second[0, 2] = second[2, 0] = ms + ds
    second[1, 2] = second[2, 1] = ms - ds
    second[2, 2] = ss
