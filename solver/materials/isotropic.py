"""Isotropic hardening for the general return map: no backstress, the yield surface grows by the tabulated curve."""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..kernels import POINT
from .dispatch import POINTS
from .hardening import yield_stress


class CurveData(NamedTuple):
    """table : of `hardening.tabulate`"""

    table: np.ndarray


@njit(**POINT)
def no_backstress(data, past, alpha):
    alpha[:] = 0.0


@njit(**POINT)
def begin_nothing(data, shape, past, m, n, h):
    return 0.0


@njit(**POINT)
def harden_by_curve(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work):
    alpha[:] = 0.0
    alpha_g[:] = 0.0
    alpha_m[:] = 0.0
    return yield_stress(ep + dg, data.table)


@njit(**POINT)
def remember_nothing(data, shape, ep, past, begun, dg, m, n, h, now, work):
    pass


POINTS["backstress", CurveData] = no_backstress
POINTS["begin", CurveData] = begin_nothing
POINTS["harden", CurveData] = harden_by_curve
POINTS["remember", CurveData] = remember_nothing
