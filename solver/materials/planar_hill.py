"""Planar isotropic Hill plasticity in logarithmic strain space, plane stress (theory.md 1 and 4).

Symbols: H logarithmic strain [11, 22, 2*12]; T its work-conjugate stress [11, 22, 12]; Hp plastic part;
ep equivalent plastic strain; r normal anisotropy. With A = T1 + T2, B = T1 - T2, C = T3 the locus is
diagonal: sigma_eq^2 = pa A^2/2 + pb B^2/2 + 2 pb C^2, pa = 1/(1+r), pb = (1+2r)/(1+r), and so is plane-stress
elasticity: A = ca (H1 + H2), B = cb (H1 - H2), C = cb H3/2, ca = E/(1-nu), cb = E/(1+nu).
Backward Euler then is one scalar equation for dg, the increment of ep (theory_shell.md 7).
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numba import njit, prange

from ..errors import SceneError
from .hardening import yield_stress
from .logarithmic_strain import log_strain, log_strain_derivatives


@dataclass(frozen=True)
class PlanarHill:
    """sigma_eq^2 = s11^2 + s22^2 - 2r/(1+r) s11 s22 + 2(1+2r)/(1+r) s12^2.

    r : normal anisotropy, the mean of the r-values (r0 + 2 r45 + r90)/4; 1 is von Mises
    """

    r: float

    def __post_init__(self):
        if not (np.isfinite(self.r) and self.r > -0.5):
            raise SceneError(f"Hill r: found {self.r!r}, expected a number above -0.5")


@dataclass(frozen=True)
class VonMises(PlanarHill):
    """PlanarHill with r = 1."""

    r: float = 1.0


@njit(forceinline=True)
def plastic_increment(a, b, c, ep, ca, cb, pa, pb, table):
    """Increment dg of the equivalent plastic strain for a trial stress (a, b, c); 0 where elastic.

    Newton on sigma_eq(dg) = sigma_y(ep + dg), kept inside a bracket, so that it ends from any finite
    trial state: sigma_eq falls with dg, and sigma_y stays above 0.
    """
    qa, qb = 0.5 * pa * a * a, 0.5 * pb * b * b + 2.0 * pb * c * c
    trial = sqrt(qa + qb)
    sy, slope = yield_stress(ep, table)
    if trial <= sy * (1.0 + 1e-12):
        return 0.0
    low, high = 0.0, 2.0 * trial / min(ca * pa, cb * pb)
    dg = min((trial - sy) / (max(ca * pa, cb * pb) + max(slope, 0.0)), high)
    for _ in range(200):
        sy, slope = yield_stress(ep + dg, table)
        mu = dg / sy
        ka, kb = 1.0 / (1.0 + ca * pa * mu), 1.0 / (1.0 + cb * pb * mu)
        s = sqrt(qa * ka * ka + qb * kb * kb)
        f = s - sy
        if f > 0.0:
            low = dg
        else:
            high = dg
        if abs(f) <= 1e-13 * sy:
            break
        ds = -(qa * ka**3 * ca * pa + qb * kb**3 * cb * pb) * (1.0 - mu * slope) / (sy * s)
        step = dg - f / (ds - slope)
        if not low < step < high:
            step = 0.5 * (low + high)
        if step == dg:
            break
        dg = step
    return dg


@njit(forceinline=True)
def stress_and_tangent(h, hp, ep, young, nu, r, table, stress, tangent):
    """Return map of one point. Fills stress T (3,) and tangent dT/dH (3, 3); returns dg and sigma_y.

    h : (3,) strain; hp : (3,) plastic strain at the start of the increment
    """
    ca, cb = young / (1.0 - nu), young / (1.0 + nu)
    pa, pb = 1.0 / (1.0 + r), (1.0 + 2.0 * r) / (1.0 + r)
    e1, e2, e3 = h[0] - hp[0], h[1] - hp[1], h[2] - hp[2]
    a, b, c = ca * (e1 + e2), cb * (e1 - e2), 0.5 * cb * e3
    dg = plastic_increment(a, b, c, ep, ca, cb, pa, pb, table)
    sy, slope = yield_stress(ep + dg, table)
    mu = dg / sy
    ka, kb = 1.0 / (1.0 + ca * pa * mu), 1.0 / (1.0 + cb * pb * mu)
    a, b, c = ka * a, kb * b, kb * c
    stress[0], stress[1], stress[2] = 0.5 * (a + b), 0.5 * (a - b), c
    # Xi = (De^-1 + mu P)^-1 in the diagonal basis, then in components.
    xa, xb = 0.5 * ca * ka, 0.5 * cb * kb
    tangent[0, 0] = tangent[1, 1] = xa + xb
    tangent[0, 1] = tangent[1, 0] = xa - xb
    tangent[2, 2] = xb
    tangent[0, 2] = tangent[1, 2] = tangent[2, 0] = tangent[2, 1] = 0.0
    if dg > 0.0:
        n1, n2, n3 = 0.5 * (pa * a + pb * b) / sy, 0.5 * (pa * a - pb * b) / sy, 2.0 * pb * c / sy
        m1 = (xa + xb) * n1 + (xa - xb) * n2
        m2 = (xa - xb) * n1 + (xa + xb) * n2
        m3 = xb * n3
        scale = 1.0 / (n1 * m1 + n2 * m2 + n3 * m3 + slope / (1.0 - mu * slope))
        tangent[0, 0] -= scale * m1 * m1
        tangent[0, 1] -= scale * m1 * m2
        tangent[0, 2] -= scale * m1 * m3
        tangent[1, 0] -= scale * m2 * m1
        tangent[1, 1] -= scale * m2 * m2
        tangent[1, 2] -= scale * m2 * m3
        tangent[2, 0] -= scale * m3 * m1
        tangent[2, 1] -= scale * m3 * m2
        tangent[2, 2] -= scale * m3 * m3
    return dg, sy


@njit(parallel=True, cache=True)
def update(metric, hp_old, ep_old, young, nu, r, table, s, ds_dc, strain, hp, ep, stress, thickness_strain):
    """Stress of every point from its metric.

    metric : (m, 3) C11 C22 C12; hp_old : (m, 3); ep_old : (m,)
    fills s (m, 3) second Piola-Kirchhoff [MPa]; ds_dc (m, 3, 3) its derivative with respect to the
    Green strain [E11, E22, 2 E12], left out where ds_dc is empty; strain H (m, 3); hp (m, 3); ep (m,);
    stress T (m, 3), conjugate to H; thickness_strain (m,) H33
    """
    for p in prange(metric.shape[0]):
        h = strain[p]
        first, second = np.empty((3, 3)), np.empty((3, 3))
        t = np.empty(3)
        c = np.empty((3, 3))
        y1, y2, y3 = 0.5 * (metric[p, 0] - 1.0), 0.5 * (metric[p, 1] - 1.0), metric[p, 2]
        log_strain(y1, y2, y3, h)
        dg, sy = stress_and_tangent(h, hp_old[p], ep_old[p], young, nu, r, table, t, c)
        log_strain_derivatives(y1, y2, y3, t, first, second)
        for i in range(3):
            s[p, i] = first[0, i] * t[0] + first[1, i] * t[1] + first[2, i] * t[2]
            if ds_dc.shape[0] == 0:
                continue
            for j in range(3):
                total = second[i, j]
                for k in range(3):
                    total += first[k, i] * (c[k, 0] * first[0, j] + c[k, 1] * first[1, j] + c[k, 2] * first[2, j])
                ds_dc[p, i, j] = total
        mu = dg / sy
        pr = r / (1.0 + r)
        hp[p, 0] = hp_old[p, 0] + mu * (t[0] - pr * t[1])
        hp[p, 1] = hp_old[p, 1] + mu * (t[1] - pr * t[0])
        hp[p, 2] = hp_old[p, 2] + mu * 2.0 * (1.0 + 2.0 * r) / (1.0 + r) * t[2]
        ep[p] = ep_old[p] + dg
        stress[p, 0], stress[p, 1], stress[p, 2] = t[0], t[1], t[2]
        thickness_strain[p] = -nu / young * (t[0] + t[1]) - hp[p, 0] - hp[p, 1]
