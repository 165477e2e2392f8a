"""Yield locus Yld2000-2d (Barlat, Brem, Yoon et al., IJP 19 (2003) 1297-1319), plane stress.

    |X1' - X2'|^a + |2 X2" + X1"|^a + |2 X1" + X2"|^a = 2 sigma_eq^a

with X' = L' T, X" = L" T and X1, X2 their principal values. The eight alphas enter L', L" (the paper's Eq. 20-22). With
the half differences and shears (d', s'), (d", s"), the mean M" and their radii R' and R", the three terms are (2 R')^a,
|3 M" - R"|^a, |3 M" + R"|^a: smooth functions of five linear forms of T, which needs no principal directions.
The exponent a is 6 for steel (bcc) and 8 for aluminium (fcc). Convex for any alphas.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import POINT
from .dispatch import POINTS


@dataclass(frozen=True)
class Yld2000:
    """Eight alphas and the exponent; `Yld2000.fit` finds them from tests.

    alphas : (8,), all 1 for the isotropic locus (von Mises for a = 2 or 4)
    a : exponent, 2 or more
    """

    alphas: tuple
    a: float = 8.0

    def __post_init__(self):
        alphas = np.asarray(self.alphas, dtype=float)
        if alphas.shape != (8,) or not np.isfinite(alphas).all():
            raise SceneError(f"Yld2000 alphas: found {self.alphas!r}, expected 8 numbers")
        if not (np.isfinite(self.a) and self.a >= 2.0):
            raise SceneError(f"Yld2000 a: found {self.a!r}, expected a number of 2 or more, such as 6 or 8")
        object.__setattr__(self, "alphas", tuple(float(alpha) for alpha in alphas))

    @classmethod
    def fit(cls, s0, s45, s90, sb, r0, r45, r90, rb, a=8.0):
        """Alphas that meet uniaxial yield stresses and r-values at 0, 45 and 90 degrees, the equibiaxial yield stress
        sb and its ratio of strains rb = de22/de11. Stresses are relative to the hardening curve's.

        Raises SceneError where no such locus is found.
        """
        from .yld2000_fit import fit_alphas

        return cls(fit_alphas((s0, s45, s90, sb), (r0, r45, r90, rb), a), a)

    @property
    def forms(self):
        """The five linear forms d', s', M", d", s" of [11, 22, 12], (5, 3)."""
        return linear_forms(np.asarray(self.alphas))

    def data(self):
        """Numbers for the kernels."""
        return Yld2000Data(np.ascontiguousarray(self.forms), float(self.a))


def linear_forms(alphas):
    """d', s', M", d", s" of [11, 22, 12] for eight alphas, (5, 3)."""
    a1, a2, a3, a4, a5, a6, a7, a8 = alphas
    one = np.array([[2 * a1, -a1, 0.0], [-a2, 2 * a2, 0.0], [0.0, 0.0, 3 * a7]]) / 3.0
    two = np.array([
        [8 * a5 - 2 * a3 - 2 * a6 + 2 * a4, 4 * a6 - 4 * a4 - 4 * a5 + a3, 0.0],
        [4 * a3 - 4 * a5 - 4 * a4 + a6, 8 * a4 - 2 * a6 - 2 * a3 + 2 * a5, 0.0],
        [0.0, 0.0, 9 * a8],
    ]) / 9.0  # fmt: skip
    return np.array([
        0.5 * (one[0] - one[1]), one[2], 0.5 * (two[0] + two[1]), 0.5 * (two[0] - two[1]), two[2],
    ])  # fmt: skip


class Yld2000Data(NamedTuple):
    """forms : (5, 3); a : exponent"""

    forms: np.ndarray
    a: float


@njit(**POINT)
def yld2000_locus(data, x, n, h):
    """Point function of the general return map (`dispatch.locus`)."""
    f, a = data.forms, data.a
    d1 = f[0, 0] * x[0] + f[0, 1] * x[1]
    s1 = f[1, 2] * x[2]
    mean = f[2, 0] * x[0] + f[2, 1] * x[1]
    d2 = f[3, 0] * x[0] + f[3, 1] * x[1]
    s2 = f[4, 2] * x[2]
    r1, r2 = sqrt(d1 * d1 + s1 * s1), sqrt(d2 * d2 + s2 * s2)
    scale = max(2.0 * r1, 3.0 * abs(mean) + r2)
    if not scale > 0.0:
        n[:] = 0.0
        h[:] = 0.0
        return scale
    # In units of the largest term.
    d1, s1, mean, d2, s2, r1, r2 = d1 / scale, s1 / scale, mean / scale, d2 / scale, s2 / scale, r1 / scale, r2 / scale
    u, v, w = 2.0 * r1, abs(3.0 * mean - r2), abs(3.0 * mean + r2)
    pu, pv, pw = u ** (a - 2.0), v ** (a - 2.0), w ** (a - 2.0)
    total = pu * u * u + pv * v * v + pw * w * w
    # Derivatives of the sum f(r1, mean, r2): by r1 over r1, and so on.
    k1 = 4.0 * a * pu
    k1_r = 4.0 * (a - 2.0) * k1 / (u * u) if u > 0.0 else 0.0  # (dk1/dr1)/r1
    low, high = a * pv * (3.0 * mean - r2), a * pw * (3.0 * mean + r2)
    low2, high2 = a * (a - 1.0) * pv, a * (a - 1.0) * pw
    f_m, f_mm = 3.0 * (low + high), 9.0 * (low2 + high2)
    f_rr = low2 + high2
    if r2 > 1e-5 * abs(mean) and r2 > 0.0:
        k2 = (high - low) / r2
        k2_r = (f_rr - k2) / (r2 * r2)
        f_mr = 3.0 * (high2 - low2) / r2
    else:  # the limit r2 -> 0
        k2 = f_rr
        third = (a - 2.0) * (a - 3.0) / 3.0 / (9.0 * mean * mean) if mean != 0.0 else 0.0
        k2_r = f_rr * third
        f_mr = f_rr * (a - 2.0) / mean if mean != 0.0 else 0.0
    phi = (0.5 * total) ** (1.0 / a)
    # phi = (total/2)^(1/a): first and second derivatives in units of 1 and 1/scale.
    outer = phi / (a * total)
    curved = (1.0 / a - 1.0) / total
    g0, g1, g2, g3, g4 = k1 * d1, k1 * s1, f_m, k2 * d2, k2 * s2
    t0 = g0 * f[0, 0] + g2 * f[2, 0] + g3 * f[3, 0]
    t1 = g0 * f[0, 1] + g2 * f[2, 1] + g3 * f[3, 1]
    t2 = g1 * f[1, 2] + g4 * f[4, 2]
    n[0], n[1], n[2] = outer * t0, outer * t1, outer * t2
    h00, h01, h11 = k1 + k1_r * d1 * d1, k1_r * d1 * s1, k1 + k1_r * s1 * s1
    h33, h34, h44 = k2 + k2_r * d2 * d2, k2_r * d2 * s2, k2 + k2_r * s2 * s2
    h23, h24 = f_mr * d2, f_mr * s2
    for i in range(2):
        for j in range(i, 2):
            second = h00 * f[0, i] * f[0, j] + f_mm * f[2, i] * f[2, j] + h33 * f[3, i] * f[3, j]
            second += h23 * (f[2, i] * f[3, j] + f[3, i] * f[2, j])
            h[i, j] = h[j, i] = second
        h[i, 2] = h[2, i] = f[1, 2] * h01 * f[0, i] + f[4, 2] * (h24 * f[2, i] + h34 * f[3, i])
    h[2, 2] = h11 * f[1, 2] * f[1, 2] + h44 * f[4, 2] * f[4, 2]
    g = (t0, t1, t2)
    for i in range(3):
        for j in range(3):
            h[i, j] = outer * (h[i, j] + curved * g[i] * g[j]) / scale
    return phi * scale


POINTS["locus", Yld2000Data] = yld2000_locus
