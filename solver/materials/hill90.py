"""Yield locus of Hill 1990 (JMPS 38 (1990) 405-417), plane stress, in components along the axes of orthotropy.

With A = T11 + T22, B = T11 - T22, C = 2 T12, rho^2 = B^2 + C^2 and Q = (A^2 + rho^2)/2 = T11^2 + T22^2 + 2 T12^2:

    f = |A|^m + k rho^m + Q^(m/2 - 1) (b B^2 - 2 a A B) = (2 s_b)^m sigma_eq^m

In tension at the angle theta, f = s^m (1 + k - 2 a cos 2 theta + b cos^2 2 theta), and at 45 degrees the r-value is
(k - 1)/2. So s_b, s0, s45, s90 and r45 give m, k, a and b in closed form:

    k = 1 + 2 r45,  (2 s_b/s45)^m = 2 (1 + r45),  (2 s_b/s0)^m = 1 + k - 2 a + b,  (2 s_b/s90)^m = 1 + k + 2 a + b

The form is convex only for moderate a and b: `yield_locus.convexity` checks.
"""

from dataclasses import dataclass
from math import log, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import POINT
from .dispatch import POINTS


@dataclass(frozen=True)
class Hill90:
    """From yield stresses, relative to the hardening curve's, and one r-value.

    s0, s45, s90 : uniaxial, along, at 45 degrees to and across the rolling direction; sb : equibiaxial
    r45 : r-value at 45 degrees
    """

    s0: float
    s45: float
    s90: float
    sb: float
    r45: float

    def __post_init__(self):
        for name in ("s0", "s45", "s90", "sb"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise SceneError(f"Hill90 {name}: found {value!r}, expected a stress ratio above 0")
        if not (np.isfinite(self.r45) and self.r45 > -0.5):
            raise SceneError(f"Hill90 r45: found {self.r45!r}, expected a number above -0.5")
        if 2.0 * self.sb <= self.s45 or not self.exponent > 1.0:
            found = f"found sb/s45 = {self.sb / self.s45:.4g} with r45 = {self.r45:g}"
            raise SceneError(f"Hill90: {found}, expected values whose exponent log(2 + 2 r45)/log(2 sb/s45) is above 1")

    @property
    def exponent(self):
        """m."""
        return log(2.0 * (1.0 + self.r45)) / log(2.0 * self.sb / self.s45)

    def data(self):
        """Numbers for the kernels."""
        m, k = self.exponent, 1.0 + 2.0 * self.r45
        along, across = (2.0 * self.sb / self.s0) ** m, (2.0 * self.sb / self.s90) ** m
        return Hill90Data(m, k, 0.25 * (across - along), 0.5 * (along + across) - 1.0 - k, 2.0 * self.sb)


class Hill90Data(NamedTuple):
    m: float
    k: float
    a: float
    b: float
    size: float


@njit(**POINT)
def hill90_locus(data, x, n, h):
    """Point function of the general return map (`dispatch.locus`)."""
    m, k, a, b = data.m, data.k, data.a, data.b
    sa, sb, sc = x[0] + x[1], x[0] - x[1], 2.0 * x[2]
    scale = sqrt(0.5 * (sa * sa + sb * sb + sc * sc))
    if not scale > 0.0:
        n[:] = 0.0
        h[:] = 0.0
        return scale
    sa, sb, sc = sa / scale, sb / scale, sc / scale  # Q = 1
    # Where m < 2 the curvature is unbounded along two rays: the floor keeps it finite.
    ra, rr = max(abs(sa), 1e-8), max(sqrt(sb * sb + sc * sc), 1e-8)
    pa, pr = ra ** (m - 2.0), k * rr ** (m - 2.0)
    w, w_a, w_b = b * sb * sb - 2.0 * a * sa * sb, -2.0 * a * sb, 2.0 * (b * sb - a * sa)
    e = 0.5 * m - 1.0  # Q^e: dQ = (A, B, C), and Q = 1
    total = pa * sa * sa + pr * (sb * sb + sc * sc) + w
    g = (m * pa * sa + e * w * sa + w_a, m * pr * sb + e * w * sb + w_b, m * pr * sc + e * w * sc)
    q = e * (e - 1.0) * w
    t = m * (m - 2.0) * pr / (rr * rr)
    h_aa = m * (m - 1.0) * pa + e * w + q * sa * sa + 2.0 * e * w_a * sa
    h_ab = q * sa * sb + e * (w_a * sb + w_b * sa) - 2.0 * a
    h_ac = q * sa * sc + e * w_a * sc
    h_bb = m * pr + t * sb * sb + e * w + q * sb * sb + 2.0 * e * w_b * sb + 2.0 * b
    h_bc = t * sb * sc + q * sb * sc + e * w_b * sc
    h_cc = m * pr + t * sc * sc + e * w + q * sc * sc
    phi = total ** (1.0 / m)
    outer, curved = phi / (m * total) / data.size, (1.0 / m - 1.0) / total
    h_aa, h_ab, h_ac = h_aa + curved * g[0] * g[0], h_ab + curved * g[0] * g[1], h_ac + curved * g[0] * g[2]
    h_bb, h_bc, h_cc = h_bb + curved * g[1] * g[1], h_bc + curved * g[1] * g[2], h_cc + curved * g[2] * g[2]
    n[0], n[1], n[2] = outer * (g[0] + g[1]), outer * (g[0] - g[1]), 2.0 * outer * g[2]
    outer /= scale
    h[0, 0], h[1, 1] = outer * (h_aa + 2.0 * h_ab + h_bb), outer * (h_aa - 2.0 * h_ab + h_bb)
    h[0, 1] = h[1, 0] = outer * (h_aa - h_bb)
    h[0, 2] = h[2, 0] = 2.0 * outer * (h_ac + h_bc)
    h[1, 2] = h[2, 1] = 2.0 * outer * (h_ac - h_bc)
    h[2, 2] = 4.0 * outer * h_cc
    return phi * scale / data.size


POINTS["locus", Hill90Data] = hill90_locus
