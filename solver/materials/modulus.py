"""Young's modulus that falls with plastic strain, as unloading curves of sheets show (Yoshida, Uemori and Fujiwara,
IJP 18 (2002) 633-659): E(ep) = E - (E - E_a) (1 - exp(-xi ep)).

The elastic strain is what the stress gives back with the modulus of the plastic strain reached, T = De(E(ep)) (H - Hp),
so that unloading from a plastic strain has that one slope, however it was reached.
"""

from dataclasses import dataclass
from math import exp
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import POINT


@dataclass(frozen=True)
class DecayingModulus:
    """E_a : modulus after large plastic strain [MPa]; xi : rate of its fall"""

    E_a: float
    xi: float

    def __post_init__(self):
        if not (np.isfinite(self.E_a) and self.E_a > 0.0):
            raise SceneError(f"modulus E_a: found {self.E_a!r}, expected MPa above 0")
        if not (np.isfinite(self.xi) and self.xi >= 0.0):
            raise SceneError(f"modulus xi: found {self.xi!r}, expected a number of 0 or more")


class Elastic(NamedTuple):
    """young : MPa; nu; lost : E - E_a [MPa], 0 where the modulus stays; xi"""

    young: float
    nu: float
    lost: float
    xi: float


@njit(**POINT)
def young_at(elastic, ep):
    """Young's modulus after a plastic strain [MPa], and its slope."""
    if elastic.lost == 0.0:
        return elastic.young, 0.0
    left = exp(-elastic.xi * ep)
    return elastic.young - elastic.lost * (1.0 - left), -elastic.lost * elastic.xi * left
