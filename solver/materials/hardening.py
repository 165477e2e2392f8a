"""Hardening curves: yield stress against equivalent plastic strain, and their table.

Any callable that maps an array of strains to stresses [MPa] is a hardening curve; the classes here are
the usual ones. The solver sees only the table: cubic pieces over knots spaced as fourth powers, dense where the
curve is steep. With 1024 knots a Swift curve with e0 of 1e-4 is met to 1e-9 of its value.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import FUSED_POINT

N_KNOTS = 1024
LARGEST_STRAIN = 4.0  # the table's end; beyond it the curve goes on straight in y
WIDTH = LARGEST_STRAIN**0.25 / (N_KNOTS - 1)  # of a piece, in y


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
    """Pieces of a hardening curve: (N_KNOTS, 4), the cubic a0 + a1 s + a2 s^2 + a3 s^3 [MPa] from each knot to the
    next, s from 0 to 1; knots at the strains y^4 for evenly spaced y. The last row goes on straight in y.

    Raises SceneError where the curve is not a finite stress above 0.
    """
    y = WIDTH * np.arange(N_KNOTS)
    value = np.asarray(curve(y**4), dtype=float) * np.ones(N_KNOTS)
    wrong = ~(np.isfinite(value) & (value > 0.0))
    if wrong.any():
        k = np.argmax(wrong)
        found = f"found {value[k]:g} MPa at plastic strain {y[k] ** 4:.3g}"
        raise SceneError(f"hardening curve: {found}, expected a finite stress above 0")
    # No overshoot between knots where the curve has a corner (Fritsch and Carlson 1980).
    limit = np.full(N_KNOTS, np.inf)
    secant = 3.0 * np.abs(np.diff(value))
    limit[:-1] = secant
    limit[1:] = np.minimum(limit[1:], secant)
    slope = np.clip(WIDTH * _slopes(curve, y), -limit, limit)
    rise, d0, d1 = np.diff(value), slope[:-1], slope[1:]
    table = np.zeros((N_KNOTS, 4))
    table[:, 0], table[:, 1] = value, slope
    table[:-1, 2], table[:-1, 3] = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
    table[-1, 1] = max(slope[-1], 0.0)  # above 0 for ever
    return table


def _slopes(curve, y):
    """Derivative with respect to y at the knots, by fourth-order differences; 0 at strain 0."""
    step = 1e-3 * (y[1] - y[0])

    def at(offset):
        return np.asarray(curve((y[1:] + offset) ** 4), dtype=float) * np.ones(len(y) - 1)

    slope = (at(-2 * step) - 8 * at(-step) + 8 * at(step) - at(2 * step)) / (12 * step)
    return np.concatenate([[0.0], slope])


@njit(**FUSED_POINT)
def place_of(strain):
    """y of a strain, and its place among the knots: row of the table plus s."""
    y = sqrt(sqrt(strain if strain > 0.0 else 0.0))
    return y, y * (1.0 / WIDTH)


@njit(**FUSED_POINT)
def piece(y, s, a0, a1, a2, a3):
    """Yield stress [MPa], and its slope with respect to the strain as numerator and denominator, from a row of the
    table."""
    y = y if y > 0.5 * WIDTH else 0.5 * WIDTH  # dy/dstrain is unbounded at 0: its value half-way stands in
    return a0 + s * (a1 + s * (a2 + s * a3)), a1 + s * (2.0 * a2 + s * 3.0 * a3), 4.0 * WIDTH * y * y * y


@njit(**FUSED_POINT)
def yield_stress(strain, table):
    """Yield stress [MPa] and its slope with respect to the strain, from the table of `tabulate`."""
    y, place = place_of(strain)
    i = int(place) if place < N_KNOTS - 1.0 else N_KNOTS - 1
    sy, rise, run = piece(y, place - i, table[i, 0], table[i, 1], table[i, 2], table[i, 3])
    return sy, rise / run
