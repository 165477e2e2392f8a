"""Hardening curves: yield stress against equivalent plastic strain, and their table.

Any callable that maps an array of strains to stresses [MPa] is a hardening curve; the classes here are
the usual ones. The solver sees only the table: cubic Hermite pieces over knots spaced as fourth powers, dense
where the curve is steep. With 1024 knots a Swift curve with e0 of 1e-4 is met to 1e-9 of its value.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numba import njit

from ..errors import SceneError

N_KNOTS = 1024
LARGEST_STRAIN = 4.0  # the table's end; beyond it the curve goes on straight


def _positive(kind, **values):
    for name, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise SceneError(f"{kind} hardening {name}: found {value!r}, expected a number above 0")


@dataclass(frozen=True)
class Swift:
    """K (e0 + e)^n [MPa]."""

    K: float
    e0: float
    n: float

    def __post_init__(self):
        _positive("Swift", K=self.K, e0=self.e0)
        if not 0.0 <= self.n < 1.0:
            raise SceneError(f"Swift hardening n: found {self.n!r}, expected 0 up to 1")

    def __call__(self, strain):
        return self.K * (self.e0 + strain) ** self.n


@dataclass(frozen=True)
class Ludwik:
    """s0 + K e^n [MPa]."""

    s0: float
    K: float
    n: float

    def __post_init__(self):
        _positive("Ludwik", s0=self.s0, n=self.n)

    def __call__(self, strain):
        return self.s0 + self.K * np.asarray(strain) ** self.n


@dataclass(frozen=True)
class Voce:
    """s0 + Q (1 - exp(-b e)) [MPa]."""

    s0: float
    Q: float
    b: float

    def __post_init__(self):
        _positive("Voce", s0=self.s0, b=self.b)

    def __call__(self, strain):
        return self.s0 - self.Q * np.expm1(-self.b * np.asarray(strain))


@dataclass(frozen=True)
class HockettSherby:
    """s_sat - (s_sat - s0) exp(-a e^p) [MPa]."""

    s0: float
    s_sat: float
    a: float
    p: float

    def __post_init__(self):
        _positive("Hockett-Sherby", s0=self.s0, s_sat=self.s_sat, a=self.a, p=self.p)

    def __call__(self, strain):
        return self.s_sat - (self.s_sat - self.s0) * np.exp(-self.a * np.asarray(strain) ** self.p)


@dataclass(frozen=True)
class Table:
    """Straight lines through measured points, level after the last.

    strain, stress : sequences of equal length; strain starts at 0 and rises, stress in MPa
    """

    strain: Sequence[float]
    stress: Sequence[float]

    def __post_init__(self):
        strain, stress = np.asarray(self.strain, float), np.asarray(self.stress, float)
        if strain.ndim != 1 or strain.shape != stress.shape or len(strain) < 2:
            raise SceneError("hardening table: expected two lists of equal length, at least two points")
        if strain[0] != 0.0 or not (np.diff(strain) > 0.0).all():
            raise SceneError("hardening table: expected plastic strains that start at 0 and rise")
        if not (stress > 0.0).all():
            raise SceneError(f"hardening table: found stress {stress.min()}, expected values above 0 MPa")

    def __call__(self, strain):
        return np.interp(strain, self.strain, self.stress)


@dataclass(frozen=True)
class Sum:
    """Weighted sum of curves, for example Sum(((0.5, Swift(...)), (0.5, Voce(...))))."""

    parts: Sequence[tuple[float, Callable]]

    def __call__(self, strain):
        return sum(weight * curve(strain) for weight, curve in self.parts)


def tabulate(curve):
    """Knots of a hardening curve: (N_KNOTS, 2), value [MPa] and derivative with respect to y, at the strains
    y^4 for evenly spaced y up to LARGEST_STRAIN^(1/4).

    Raises SceneError where the curve is not a finite stress above 0.
    """
    y = np.linspace(0.0, LARGEST_STRAIN**0.25, N_KNOTS)
    value = np.asarray(curve(y**4), dtype=float) * np.ones(N_KNOTS)
    wrong = ~(np.isfinite(value) & (value > 0.0))
    if wrong.any():
        k = np.argmax(wrong)
        found = f"found {value[k]:g} MPa at plastic strain {y[k] ** 4:.3g}"
        raise SceneError(f"hardening curve: {found}, expected a finite stress above 0")
    # No overshoot between knots where the curve has a corner (Fritsch and Carlson 1980).
    limit = np.full(N_KNOTS, np.inf)
    secant = 3.0 * np.abs(np.diff(value) / np.diff(y))
    limit[:-1] = secant
    limit[1:] = np.minimum(limit[1:], secant)
    return np.ascontiguousarray(np.column_stack([value, np.clip(_slopes(curve, y), -limit, limit)]))


def _slopes(curve, y):
    """Derivative with respect to y at the knots, by fourth-order differences; 0 at strain 0."""
    step = 1e-3 * (y[1] - y[0])

    def at(offset):
        return np.asarray(curve((y[1:] + offset) ** 4), dtype=float) * np.ones(len(y) - 1)

    slope = (at(-2 * step) - 8 * at(-step) + 8 * at(step) - at(2 * step)) / (12 * step)
    return np.concatenate([[0.0], slope])


@njit(forceinline=True)
def yield_stress(strain, table):
    """Yield stress [MPa] and its slope with respect to the strain, from the table of `tabulate`."""
    n = table.shape[0]
    end = sqrt(sqrt(LARGEST_STRAIN))
    width = end / (n - 1)
    if strain >= LARGEST_STRAIN:
        slope = table[n - 1, 1] / (4.0 * end**3)
        return table[n - 1, 0] + slope * (strain - LARGEST_STRAIN), slope
    y = sqrt(sqrt(max(strain, 0.0)))
    i = min(int(y / width), n - 2)
    s = y / width - i
    y0, y1 = table[i, 0], table[i + 1, 0]
    d0, d1 = table[i, 1] * width, table[i + 1, 1] * width
    c2 = 3.0 * (y1 - y0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (y1 - y0)
    value = y0 + s * (d0 + s * (c2 + s * c3))
    slope = (d0 + s * (2.0 * c2 + s * 3.0 * c3)) / width
    # dy/dstrain is unbounded at 0: in the first interval its value half-way stands in.
    return value, slope / (4.0 * max(y, 0.5 * width) ** 3)
