"""Who may have come near: a distance changes by no more than its point moves."""

import numpy as np
from numba import njit

from cadlink.kernels import POINT


@njit(forceinline=True, **POINT)
def stays_far(p, place, i, slack):
    """Whether a point cannot have come into its reach.

    p : (3,) mm, where it is; place : (n, 3) mm, where each was looked at last; i : its row there
    slack : mm, by how much its distance there was above its reach
    returns : True for a point that has moved by less than its slack, or is not a number
    """
    moved = (p[0] - place[i, 0]) ** 2 + (p[1] - place[i, 1]) ** 2 + (p[2] - place[i, 2]) ** 2
    return not moved < np.inf or (slack > 0.0 and moved < slack * slack)
