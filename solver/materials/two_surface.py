"""The founding paper's mixed hardening with two surfaces (theory.md 4), for any locus.

Symbols: p equivalent plastic strain; m = (T - alpha)/s_y, phi(m) = 1, n the normal there; q strain the outer surface
has grown by; H = Y'(q).

    inner surface    phi(T - alpha) = s_y, of constant size
    outer surface    phi(T) = Y(q), the tensile curve
    v = (Y - s_y) m - alpha leads from the stress to the point of the outer surface with the same normal
    delta = n . v    distance of the two along the normal, 0 or more, and 0 where they touch
    d alpha = E_p v/delta dp,  E_p = H + h0 (delta/delta_0)^power,  d delta = -E_p dp     while delta > 0
    alpha = (Y - s_y) m,  dq = dp                                                         once they touch

delta_0 is the distance at the last start of loading: where the flow has turned by more than a right angle, or where
the distance exceeds delta_0. Unloading and reloading the same way is no new start, so that it leaves no trace in
the curve. Over an increment m stays at its end value; the equation for delta is then integrated by Gauss-Legendre
quadrature, exactly up to the quadrature, for any increment: dp = int d delta/E_p.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import INNER, POINT
from .dispatch import POINTS
from .hardening import tabulate, yield_stress

# Columns of the history.
ALPHA, LAST, START, GROWN = 0, 3, 6, 7
FLATTEST = 1e-6  # of h0: E_p never falls below, so that the surfaces touch after a finite strain


@dataclass(frozen=True)
class TwoSurface:
    """Mixed hardening with two surfaces.

    curve : tensile curve Y, a hardening curve
    yield_stress : radius of the inner surface [MPa], at most the curve's first value
    h0 : modulus that the distance adds at the start of loading [MPa]
    power : of the distance, 0 or more
    """

    curve: Callable
    yield_stress: float
    h0: float
    power: float

    n_history = 8

    def __post_init__(self):
        if not callable(self.curve):
            raise SceneError(f"two-surface curve: found {self.curve!r}, expected a curve such as Swift")
        for name, value in (("yield_stress", self.yield_stress), ("h0", self.h0)):
            if not (np.isfinite(value) and value > 0.0):
                raise SceneError(f"two-surface {name}: found {value!r}, expected MPa above 0")
        if not (np.isfinite(self.power) and self.power >= 0.0):
            raise SceneError(f"two-surface power: found {self.power!r}, expected a number of 0 or more")
        first = float(np.ravel(self.curve(np.zeros(1)))[0])
        if self.yield_stress > first * (1.0 + 1e-12):
            found = f"found {self.yield_stress:g} MPa, and a curve that starts at {first:g} MPa"
            raise SceneError(f"two-surface yield_stress: {found}, expected the inner surface inside the outer one")

    @property
    def initial_yield_stress(self):
        """MPa."""
        return float(self.yield_stress)

    def data(self):
        """Numbers for the kernels. Raises SceneError where the curve is not one that rises."""
        points, weights = np.polynomial.legendre.leggauss(20)
        t, w = 0.5 * (points + 1.0), 0.5 * weights
        table = tabulate(self.curve)
        if (np.diff(table[:, 0]) < 0.0).any():
            raise SceneError("two-surface curve: found a stress that falls, expected a curve that rises or stays level")
        # Clustered where delta ends: x = x1 + (x0 - x1) t^3.
        nodes = np.ascontiguousarray(np.column_stack([t**3, 3.0 * t * t * w]))
        # The outer surface rests at its first size until the surfaces touch: its slope there, which the table's knots,
        # too dense at strain 0, do not give.
        h = np.finfo(float).eps ** (1.0 / 3.0)
        first, near, far = (float(np.ravel(self.curve(np.array([strain])))[0]) for strain in (0.0, h, 2.0 * h))
        slope = max((4.0 * near - 3.0 * first - far) / (2.0 * h), 0.0)
        return TwoSurfaceData(table, nodes, float(self.yield_stress), float(self.h0), float(self.power), slope)


class TwoSurfaceData(NamedTuple):
    """table : of the tensile curve; nodes : (k, 2) places and weights of the quadrature; slope : Y'(0)"""

    table: np.ndarray
    nodes: np.ndarray
    sy: float
    h0: float
    power: float
    slope: float


@njit(**POINT)
def two_surface_backstress(data, past, alpha):
    for i in range(3):
        alpha[i] = past[ALPHA + i]


@njit(**POINT)
def distance_between(data, outer, past, n):
    """delta: n . m = 1, so that n . v = Y - s_y - n . alpha; never negative, the inner surface lies inside."""
    along = n[0] * past[ALPHA] + n[1] * past[ALPHA + 1] + n[2] * past[ALPHA + 2]
    delta = outer - data.sy - along
    return delta if delta > 1e-12 * data.sy else 0.0


@njit(**POINT)
def begin_two_surface(data, shape, past, m, n, h):
    """1 where loading starts anew, else 0."""
    outer, _ = yield_stress(past[GROWN], data.table)
    turned = n[0] * past[LAST] + n[1] * past[LAST + 1] + n[2] * past[LAST + 2]
    return 1.0 if turned <= 0.0 or distance_between(data, outer, past, n) > past[START] else 0.0


@njit(**POINT)
def modulus(x, flat, data):
    """E_p at delta = x delta_0 [MPa]."""
    if data.power == 2.0:  # twenty times for each guess of delta: pow would take most of the time
        return flat + data.h0 * x * x
    return flat + data.h0 * max(x, 0.0) ** data.power


@njit(**INNER)
def strain_between(data, flat, begin, end):
    """Plastic strain in which delta falls from begin to end, both in delta_0, over delta_0/MPa."""
    total = 0.0
    for i in range(data.nodes.shape[0]):
        total += data.nodes[i, 1] / modulus(end + (begin - end) * data.nodes[i, 0], flat, data)
    return (begin - end) * total


@njit(**POINT)
def approach(data, flat, begin, strain):
    """Where delta, in delta_0, ends after a strain over delta_0/MPa; it is known not to reach 0.

    The strain is a convex, falling function of the end, so that Newton comes from the left without a bracket.
    """
    x = max(begin - strain * modulus(begin, flat, data), 0.0)
    for _ in range(60):
        excess = strain_between(data, flat, begin, x) - strain
        step = excess * modulus(x, flat, data)
        x = min(max(x + step, 0.0), begin)
        if abs(step) <= 1e-14 * begin:
            break
    return x


@njit(**INNER)
def follow(data, past, begun, dg, n):
    """Scalars of an increment: outer size Y before, delta, delta_0; the share of delta left, -1 where they touched,
    with its derivatives with respect to dg and delta; the outer surface's growth in strain; Y and Y' after."""
    outer, slope = yield_stress(past[GROWN], data.table)
    flat = max(slope if past[GROWN] > 0.0 else data.slope, FLATTEST * data.h0)
    delta = distance_between(data, outer, past, n)
    start = delta if begun > 0.0 else past[START]
    grown, left, left_g, left_d, grown_d = dg, -1.0, 0.0, 0.0, 0.0
    if delta > 0.0:
        x = delta / start
        whole = start * strain_between(data, flat, x, 0.0)
        e = modulus(x, flat, data)
        if dg < whole:
            grown = 0.0
            end = approach(data, flat, x, dg / start)
            e_end = modulus(end, flat, data)
            left = end / x
            left_g = -e_end / delta
            left_d = e_end * dg / (delta * delta) if begun > 0.0 else (e_end / e - left) / delta
        else:
            grown = dg - whole
            grown_d = -whole / delta if begun > 0.0 else -1.0 / e
    after, slope_after = yield_stress(past[GROWN] + grown, data.table)
    return outer, delta, start, left, left_g, left_d, grown, grown_d, after, slope_after


@njit(**POINT)
def harden_two_surface(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work):
    outer, _, _, left, left_g, left_d, _, grown_d, after, slope_after = follow(data, past, begun, dg, n)
    for i in range(3):
        # d delta/dm = -h alpha
        delta_m = -(h[i, 0] * past[ALPHA] + h[i, 1] * past[ALPHA + 1] + h[i, 2] * past[ALPHA + 2])
        for j in range(3):
            v = (outer - data.sy) * m[j] - past[ALPHA + j]
            if left >= 0.0:
                alpha_m[j, i] = -v * left_d * delta_m
            else:
                alpha_m[j, i] = slope_after * m[j] * grown_d * delta_m
        alpha_m[i, i] += (1.0 - left) * (outer - data.sy) if left >= 0.0 else after - data.sy
    for j in range(3):
        v = (outer - data.sy) * m[j] - past[ALPHA + j]
        if left >= 0.0:
            alpha[j] = past[ALPHA + j] + (1.0 - left) * v
            alpha_g[j] = -left_g * v
        else:
            alpha[j] = (after - data.sy) * m[j]
            alpha_g[j] = slope_after * m[j]
    return data.sy, 0.0


@njit(**POINT)
def remember_two_surface(data, shape, ep, past, begun, dg, m, n, h, now, work):
    outer, _, start, left, _, _, grown, _, after, _ = follow(data, past, begun, dg, n)
    for j in range(3):
        v = (outer - data.sy) * m[j] - past[ALPHA + j]
        now[ALPHA + j] = past[ALPHA + j] + (1.0 - left) * v if left >= 0.0 else (after - data.sy) * m[j]
        now[LAST + j] = m[j]
    now[START] = start if left >= 0.0 else 0.0
    now[GROWN] = past[GROWN] + grown


POINTS["backstress", TwoSurfaceData] = two_surface_backstress
POINTS["begin", TwoSurfaceData] = begin_two_surface
POINTS["harden", TwoSurfaceData] = harden_two_surface
POINTS["remember", TwoSurfaceData] = remember_two_surface
