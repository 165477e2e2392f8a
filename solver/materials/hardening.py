"""Hardening curves: yield stress against equivalent plastic strain, and their table.

Any callable that maps an array of strains to stresses [MPa] is a hardening curve; the classes here are
the usual ones. The solver sees only the table: cubic Hermite pieces over knots spaced as squares, dense
where the curve is steep. With 1024 knots a Swift curve is met to 1e-10 of its value.
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
    """Knots of a hardening curve: (N_KNOTS, 2), value [MPa] and derivative with respect to the root of
    the strain at strains LARGEST_STRAIN (i / (N_KNOTS - 1))^2.

    Raises SceneError where the curve is not a finite stress above 0.
    """
    root = np.linspace(0.0, sqrt(LARGEST_STRAIN), N_KNOTS)
    value = np.asarray(curve(root**2), dtype=float) * np.ones(N_KNOTS)
    if not (np.isfinite(value).all() and (value > 0.0).all()):
        worst = root[np.argmin(np.where(np.isfinite(value), value, -np.inf))] ** 2
        raise SceneError(f"hardening curve at plastic strain {worst:.3g}: expected a finite stress above 0 MPa")
    slope = _slopes(curve, root)
    # No overshoot between knots where the curve has a corner (Fritsch and Carlson 1980).
    secant = np.diff(value) / np.diff(root)
    limit = np.full(N_KNOTS, np.inf)
    limit[:-1] = 3.0 * np.abs(secant)
    limit[1:] = np.minimum(limit[1:], 3.0 * np.abs(secant))
    return np.ascontiguousarray(np.column_stack([value, np.clip(slope, -limit, limit)]))


def _slopes(curve, root):
    """Derivative with respect to the root at the knots, fourth-order differences inside each interval."""
    step = 1e-3 * (root[1] - root[0])
    inside = np.maximum(root, 2.0 * step)

    def at(offset):
        return np.asarray(curve((inside + offset) ** 2), dtype=float)

    slope = (at(-2 * step) - 8 * at(-step) + 8 * at(step) - at(2 * step)) / (12 * step)
    # At strain 0 the derivative with respect to the root is that of a one-sided difference.
    start = [np.asarray(curve(np.asarray((k * step) ** 2)), dtype=float) for k in range(5)]
    slope[0] = (-25 * start[0] + 48 * start[1] - 36 * start[2] + 16 * start[3] - 3 * start[4]) / (12 * step)
    return slope


@njit(forceinline=True)
def yield_stress(strain, table):
    """Yield stress [MPa] and its slope with respect to the strain, from the table of `tabulate`."""
    n = table.shape[0]
    width = sqrt(LARGEST_STRAIN) / (n - 1)
    if strain >= LARGEST_STRAIN:
        slope = table[n - 1, 1] / (2.0 * sqrt(LARGEST_STRAIN))
        return table[n - 1, 0] + slope * (strain - LARGEST_STRAIN), slope
    # Near strain 0 the root's derivative is unbounded: one hundredth of the first interval stands in.
    root = sqrt(max(strain, 0.0))
    i = min(int(root / width), n - 2)
    s = root / width - i
    y0, y1 = table[i, 0], table[i + 1, 0]
    d0, d1 = table[i, 1] * width, table[i + 1, 1] * width
    c2 = 3.0 * (y1 - y0) - 2.0 * d0 - d1
    c3 = d0 + d1 - 2.0 * (y1 - y0)
    value = y0 + s * (d0 + s * (c2 + s * c3))
    slope = (d0 + s * (2.0 * c2 + s * 3.0 * c3)) / width
    return value, slope / (2.0 * max(root, 0.01 * width))
