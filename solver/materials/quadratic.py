"""Quadratic yield loci, sigma_eq^2 = T^T P T, with isotropic hardening: one scalar equation per point.

Symbols: H logarithmic strain [11, 22, 2*12]; T its work-conjugate stress [11, 22, 12]; Hp plastic part; ep equivalent
plastic strain; De plane-stress elasticity. P and De^-1 are diagonalised together, once per material:
V^T De^-1 V = 1, V^T P V = diag(l). In coordinates x, T = V x, the trial state is x = V^T (H - Hp), backward Euler gives
x_i/(1 + mu l_i) with mu = dg/s_y(ep + dg), sigma_eq^2 = sum l_i x_i^2, and what remains is one equation for dg
(theory_shell.md 7). The shear 12 is a mode of its own.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from ..errors import SceneError
from .dispatch import POINTS
from .hardening import yield_stress
from .logarithmic_strain import log_strain_gradient, log_strain_second
from .rate import rate_factor


class Quadratic:
    """What every quadratic locus shares; `matrix` is its own."""

    def data(self):
        """Numbers for the general return map."""
        return QuadraticData(np.ascontiguousarray(self.matrix))


@dataclass(frozen=True)
class PlanarHill(Quadratic):
    """sigma_eq^2 = s11^2 + s22^2 - 2r/(1+r) s11 s22 + 2(1+2r)/(1+r) s12^2.

    r : normal anisotropy, the mean of the r-values (r0 + 2 r45 + r90)/4; 1 is von Mises
    """

    r: float

    def __post_init__(self):
        if not (np.isfinite(self.r) and self.r > -0.5):
            raise SceneError(f"Hill r: found {self.r!r}, expected a number above -0.5")

    @property
    def matrix(self):
        """P (3, 3)."""
        coupling = self.r / (1.0 + self.r)
        shear = 2.0 * (1.0 + 2.0 * self.r) / (1.0 + self.r)
        return np.array([[1.0, -coupling, 0.0], [-coupling, 1.0, 0.0], [0.0, 0.0, shear]])


@dataclass(frozen=True)
class VonMises(PlanarHill):
    """PlanarHill with r = 1."""

    r: float = 1.0


@dataclass(frozen=True)
class Hill48(Quadratic):
    """Hill 1948 from the r-values along, at 45 degrees to and across the rolling direction; sigma_eq is the uniaxial
    stress along the rolling direction (theory.md 4)."""

    r0: float
    r45: float
    r90: float

    def __post_init__(self):
        for name, value in (("r0", self.r0), ("r90", self.r90)):
            if not (np.isfinite(value) and value > 0.0):
                raise SceneError(f"Hill48 {name}: found {value!r}, expected a number above 0")
        if not (np.isfinite(self.r45) and self.r45 > -0.5):
            raise SceneError(f"Hill48 r45: found {self.r45!r}, expected a number above -0.5")

    @property
    def matrix(self):
        """P (3, 3)."""
        r0, r45, r90 = self.r0, self.r45, self.r90
        coupling = r0 / (1.0 + r0)
        across = r0 * (1.0 + r90) / (r90 * (1.0 + r0))
        shear = (r0 + r90) * (1.0 + 2.0 * r45) / (r90 * (1.0 + r0))
        return np.array([[1.0, -coupling, 0.0], [-coupling, across, 0.0], [0.0, 0.0, shear]])


class QuadraticData(NamedTuple):
    """matrix : P (3, 3)"""

    matrix: np.ndarray


@njit(forceinline=True)
def quadratic_locus(data, x, n, h):
    """Point function of the general return map (`dispatch.locus`)."""
    p = data.matrix
    n[0] = p[0, 0] * x[0] + p[0, 1] * x[1]
    n[1] = p[1, 0] * x[0] + p[1, 1] * x[1]
    n[2] = p[2, 2] * x[2]
    phi = sqrt(max(n[0] * x[0] + n[1] * x[1] + n[2] * x[2], 0.0))
    if phi == 0.0:
        n[:] = 0.0
        h[:] = 0.0
        return 0.0
    for i in range(3):
        n[i] /= phi
    for i in range(3):
        for j in range(3):
            h[i, j] = (p[i, j] - n[i] * n[j]) / phi
    return phi


POINTS["locus", QuadraticData] = quadratic_locus


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


@njit(forceinline=True)
def plastic_increment(q1, q2, q3, ep, k, table, rate):
    """Increment dg of the equivalent plastic strain, 0 where elastic; with the yield stress and its slope there.

    q : l_i x_i^2 of the trial state, so that sigma_eq^2 is their sum. Newton on sigma_eq(dg) = s_y(ep + dg), kept
    inside a bracket, so that it ends from any finite trial state: sigma_eq falls with dg, and s_y stays above 0.
    """
    trial = sqrt(q1 + q2 + q3)
    static, slope = yield_stress(ep, table)
    if trial <= static * (1.0 + 1e-12):
        return 0.0, static, slope
    largest = max(k.l1, k.l2, k.l3)
    # The mode that relaxes slowest bounds dg; a mode without stress does not count.
    smallest = largest
    if 0.0 < k.l1 < smallest:
        smallest = k.l1
    if 0.0 < k.l2 < smallest:
        smallest = k.l2
    if 0.0 < k.l3 < smallest:
        smallest = k.l3
    low, high = 0.0, 2.0 * trial / smallest
    dg = min((trial - static) / (largest + max(slope, 0.0)), high)
    sy = static
    for _ in range(200):
        sy, slope = yield_stress(ep + dg, table)
        factor, factor_slope = rate_factor(dg, rate)
        slope = slope * factor + sy * factor_slope
        sy *= factor
        mu = dg / sy
        k1, k2, k3 = 1.0 / (1.0 + k.l1 * mu), 1.0 / (1.0 + k.l2 * mu), 1.0 / (1.0 + k.l3 * mu)
        w1, w2, w3 = q1 * k1 * k1, q2 * k2 * k2, q3 * k3 * k3
        s = sqrt(w1 + w2 + w3)
        f = s - sy
        if f > 0.0:
            low = dg
        else:
            high = dg
        if abs(f) <= 1e-13 * sy:
            break
        ds = -(w1 * k1 * k.l1 + w2 * k2 * k.l2 + w3 * k3 * k.l3) * (1.0 - mu * slope) / (sy * s)
        step = dg - f / (ds - slope)
        if not low < step < high:
            step = 0.5 * (low + high)
        elif abs(f) <= 1e-8 * sy:  # converges quadratically: the next would find nothing left
            sy += slope * (step - dg)
            dg = step
            break
        if step == dg:
            break
        dg = step
    return dg, sy, slope


@njit(parallel=True, cache=True)
def update_quadratic(metric, hp_old, ep_old, k, table, rate, s, ds_dc, strain, hp, ep, stress, thickness_strain):
    """Stress of every point from its metric.

    metric : (p, 3) C11 C22 C12; hp_old : (p, 3); ep_old : (p,); k : Modes
    fills s (p, 3) second Piola-Kirchhoff [MPa]; ds_dc (p, 3, 3) its derivative with respect to the Green strain
    [E11, E22, 2 E12], left out where ds_dc is empty; strain H (p, 3); hp (p, 3); ep (p,); stress T (p, 3),
    conjugate to H; thickness_strain (p,) H33
    """
    wanted = ds_dc.shape[0] > 0
    chunk = 64
    for block in prange((metric.shape[0] + chunk - 1) // chunk):
        first, second, c = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        h, t = np.empty(3), np.empty(3)
        for p in range(block * chunk, min((block + 1) * chunk, metric.shape[0])):
            y1, y2, y3 = 0.5 * (metric[p, 0] - 1.0), 0.5 * (metric[p, 1] - 1.0), metric[p, 2]
            log_strain_gradient(y1, y2, y3, h, first)
            strain[p, 0], strain[p, 1], strain[p, 2] = h[0], h[1], h[2]
            # Return map, in modes.
            e1, e2, e3 = h[0] - hp_old[p, 0], h[1] - hp_old[p, 1], h[2] - hp_old[p, 2]
            x1, x2, x3 = k.v11 * e1 + k.v21 * e2, k.v12 * e1 + k.v22 * e2, k.v33 * e3
            dg, sy, slope = plastic_increment(k.l1 * x1 * x1, k.l2 * x2 * x2, k.l3 * x3 * x3, ep_old[p], k, table, rate)
            mu = dg / sy
            k1, k2, k3 = 1.0 / (1.0 + k.l1 * mu), 1.0 / (1.0 + k.l2 * mu), 1.0 / (1.0 + k.l3 * mu)
            x1, x2, x3 = k1 * x1, k2 * x2, k3 * x3
            t1, t2, t3 = k.v11 * x1 + k.v12 * x2, k.v21 * x1 + k.v22 * x2, k.v33 * x3
            stress[p, 0], stress[p, 1], stress[p, 2] = t1, t2, t3
            hp[p, 0] = hp_old[p, 0] + mu * (k.p11 * t1 + k.p12 * t2)
            hp[p, 1] = hp_old[p, 1] + mu * (k.p12 * t1 + k.p22 * t2)
            hp[p, 2] = hp_old[p, 2] + mu * k.p33 * t3
            ep[p] = ep_old[p] + dg
            thickness_strain[p] = -k.nu / k.young * (t1 + t2) - hp[p, 0] - hp[p, 1]
            for i in range(3):
                s[p, i] = first[0, i] * t1 + first[1, i] * t2 + first[2, i] * t3
            if not wanted:
                continue
            # dT/dH: Xi = (De^-1 + mu P)^-1 less the flow.
            c[0, 0] = k.v11 * k1 * k.v11 + k.v12 * k2 * k.v12
            c[0, 1] = c[1, 0] = k.v11 * k1 * k.v21 + k.v12 * k2 * k.v22
            c[1, 1] = k.v21 * k1 * k.v21 + k.v22 * k2 * k.v22
            c[2, 2] = k.v33 * k3 * k.v33
            c[0, 2] = c[1, 2] = c[2, 0] = c[2, 1] = 0.0
            if dg > 0.0:
                n1, n2, n3 = k.l1 * x1 / sy, k.l2 * x2 / sy, k.l3 * x3 / sy
                m1, m2, m3 = k1 * n1, k2 * n2, k3 * n3
                scale = 1.0 / (n1 * m1 + n2 * m2 + n3 * m3 + slope / (1.0 - mu * slope))
                m1, m2, m3 = k.v11 * m1 + k.v12 * m2, k.v21 * m1 + k.v22 * m2, k.v33 * m3
                c[0, 0] -= scale * m1 * m1
                c[0, 1] -= scale * m1 * m2
                c[1, 1] -= scale * m2 * m2
                c[0, 2] -= scale * m1 * m3
                c[1, 2] -= scale * m2 * m3
                c[2, 2] -= scale * m3 * m3
                c[1, 0], c[2, 0], c[2, 1] = c[0, 1], c[0, 2], c[1, 2]
            t[0], t[1], t[2] = t1, t2, t3
            log_strain_second(y1, y2, y3, t, second)
            for i in range(3):
                a1 = c[0, 0] * first[0, i] + c[0, 1] * first[1, i] + c[0, 2] * first[2, i]
                a2 = c[1, 0] * first[0, i] + c[1, 1] * first[1, i] + c[1, 2] * first[2, i]
                a3 = c[2, 0] * first[0, i] + c[2, 1] * first[1, i] + c[2, 2] * first[2, i]
                for j in range(3):
                    ds_dc[p, j, i] = second[j, i] + first[0, j] * a1 + first[1, j] * a2 + first[2, j] * a3
