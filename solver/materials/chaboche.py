"""Armstrong-Frederick and Chaboche kinematic hardening, with any isotropic part.

The backstress is a sum of terms, each with d alpha_i = C_i m dp - gamma_i alpha_i dp, m = (T - alpha)/phi(T - alpha):
in tension the law of Armstrong and Frederick (1966) and Chaboche (IJP 2 (1986) 149-188), for von Mises the usual
2/3 C dHp, and for every locus a backstress that saturates in the locus's own shape. Over an increment m stays at its
end value, and the terms follow in closed form, alpha_i exp(-gamma_i dp) + C_i/gamma_i (1 - exp(-gamma_i dp)) m,
exact for proportional loading whatever the increment. gamma = 0 is Prager's linear law.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp, expm1
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import POINT
from .dispatch import POINTS
from .hardening import tabulate, yield_stress
from .isotropic import begin_nothing


@dataclass(frozen=True)
class Chaboche:
    """Several backstresses around a yield surface that grows by a curve.

    size : radius of the yield surface: MPa, or a hardening curve for mixed hardening
    terms : (C [MPa], gamma) of each backstress
    """

    size: float | Callable
    terms: Sequence[tuple[float, float]]

    def __post_init__(self):
        if not callable(self.size) and not (np.isfinite(self.size) and self.size > 0.0):
            raise SceneError(f"Chaboche size: found {self.size!r}, expected MPa above 0 or a hardening curve")
        terms = np.asarray(self.terms, dtype=float)
        if terms.ndim != 2 or terms.shape[1] != 2 or not len(terms):
            raise SceneError(f"Chaboche terms: found {self.terms!r}, expected pairs (C, gamma)")
        if not (np.isfinite(terms).all() and (terms >= 0.0).all()):
            raise SceneError(f"Chaboche terms: found {self.terms!r}, expected C in MPa and gamma of 0 or more")

    @property
    def n_history(self):
        """Three components for each term."""
        return 3 * len(self.terms)

    @property
    def initial_yield_stress(self):
        """MPa."""
        return float(np.ravel(self.size(np.zeros(1)))[0]) if callable(self.size) else float(self.size)

    def data(self):
        """Numbers for the kernels. Raises SceneError where the curve is not one."""
        size = self.size
        curve = size if callable(size) else lambda strain: np.full(np.shape(strain), float(size))
        return ChabocheData(tabulate(curve), np.ascontiguousarray(self.terms, dtype=float))


def ArmstrongFrederick(size, C, gamma):
    """Chaboche with one backstress. size : MPa or a hardening curve; C : MPa"""
    return Chaboche(size, ((C, gamma),))


class ChabocheData(NamedTuple):
    """table : of the size; terms : (k, 2)"""

    table: np.ndarray
    terms: np.ndarray


@njit(**POINT)
def chaboche_backstress(data, past, alpha):
    alpha[:] = 0.0
    for t in range(data.terms.shape[0]):
        for i in range(3):
            alpha[i] += past[3 * t + i]


@njit(**POINT)
def relax(c, gamma, dg):
    """What is left of a backstress, and what the increment adds along m [MPa]."""
    if gamma * dg < 1e-12:
        return 1.0, c * dg
    return exp(-gamma * dg), -c * expm1(-gamma * dg) / gamma


@njit(**POINT)
def harden_chaboche(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work):
    alpha[:] = 0.0
    alpha_g[:] = 0.0
    alpha_m[:] = 0.0
    for t in range(data.terms.shape[0]):
        c, gamma = data.terms[t, 0], data.terms[t, 1]
        left, added = relax(c, gamma, dg)
        for i in range(3):
            alpha[i] += past[3 * t + i] * left + added * m[i]
            alpha_g[i] += (c * m[i] - gamma * past[3 * t + i]) * left
            alpha_m[i, i] += added
    return yield_stress(ep + dg, data.table)


@njit(**POINT)
def remember_chaboche(data, shape, ep, past, begun, dg, m, n, h, now, work):
    for t in range(data.terms.shape[0]):
        left, added = relax(data.terms[t, 0], data.terms[t, 1], dg)
        for i in range(3):
            now[3 * t + i] = past[3 * t + i] * left + added * m[i]


POINTS["backstress", ChabocheData] = chaboche_backstress
POINTS["begin", ChabocheData] = begin_nothing
POINTS["harden", ChabocheData] = harden_chaboche
POINTS["remember", ChabocheData] = remember_chaboche
