"""Quadratic yield loci, sigma_eq^2 = T^T P T."""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import POINT
from .dispatch import POINTS


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


@njit(**POINT)
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
