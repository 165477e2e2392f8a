"""Strain-rate factor on the size of the yield surface.

The rate is that of the equivalent plastic strain over the increment, dg/dt. Where no dt is given, as in quasi-static
forming, the factor is 1 and costs nothing.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import POINT


class RateData(NamedTuple):
    """factor = 1 + (dg/dt/reference)^exponent, or (1 + dg/dt/reference)^exponent where `outside`; inverse_dt 0: none"""

    reference: float
    exponent: float
    outside: bool
    inverse_dt: float


NO_RATE = RateData(1.0, 1.0, False, 0.0)


def _check(kind, **values):
    for name, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise SceneError(f"{kind} {name}: found {value!r}, expected a number above 0")


@dataclass(frozen=True)
class CowperSymonds:
    """1 + (rate/D)^(1/P). D : 1/s; P : 1 or more"""

    D: float
    P: float

    def __post_init__(self):
        _check("Cowper-Symonds", D=self.D, P=self.P)
        if self.P < 1.0:
            raise SceneError(f"Cowper-Symonds P: found {self.P!r}, expected a number of 1 or more")

    def data(self, dt):
        """RateData of an increment of dt seconds."""
        return RateData(float(self.D), 1.0 / self.P, False, 1.0 / dt)


@dataclass(frozen=True)
class PowerLawRate:
    """(1 + rate/reference)^m, which is rate^m at rates far above the reference. reference : 1/s; m : 0 up to 1"""

    reference: float
    m: float

    def __post_init__(self):
        _check("power-law rate", reference=self.reference)
        if not 0.0 <= self.m <= 1.0:
            raise SceneError(f"power-law rate m: found {self.m!r}, expected 0 up to 1")

    def data(self, dt):
        """RateData of an increment of dt seconds."""
        return RateData(float(self.reference), float(self.m), True, 1.0 / dt)


def rate_data(rate, dt):
    """RateData for an increment of dt seconds, or without a rate where rate or dt is None."""
    if rate is None or dt is None:
        return NO_RATE
    if not dt > 0.0:
        raise SceneError(f"increment of time: found {dt!r}, expected seconds above 0")
    return rate.data(float(dt))


@njit(**POINT)
def rate_factor(dg, rate):
    """Factor on the yield stress and its derivative with respect to dg."""
    if rate.inverse_dt == 0.0:
        return 1.0, 0.0
    scale = rate.inverse_dt / rate.reference
    relative = dg * scale
    if rate.outside:
        factor = (1.0 + relative) ** rate.exponent
        return factor, rate.exponent * scale * factor / (1.0 + relative)
    relative = max(relative, 1e-30)  # a finite slope at dg = 0
    power = relative**rate.exponent
    return 1.0 + power, rate.exponent * scale * power / relative
