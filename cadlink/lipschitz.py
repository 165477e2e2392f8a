"""Who may have come near: a distance changes by no more than its point moves."""

import numpy as np
from numba import njit

from cadlink.kernels import POINT


@njit(forceinline=True, **POINT)
def stays_far(p, place, i, slack):
    """Whether a point at p has not moved from place[i] by as much as its distance there was above its reach, its slack
    [mm]. One that is not a number is far."""
    moved = (p[0] - place[i, 0]) ** 2 + (p[1] - place[i, 1]) ** 2 + (p[2] - place[i, 2]) ** 2
    return not moved < np.inf or (slack > 0.0 and moved < slack * slack)
