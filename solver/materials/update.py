"""One pass over the points of a sheet, whatever the law: metrics in, stresses out."""

import numpy as np
from numba import njit, prange
from numba.extending import overload

from ..kernels import POINT
from ..lanes import BLOCK, give, n_blocks, take
from .block import E33, EP, HP, METRIC, ROOM, SECOND, H, T, block_pull_back, block_pull_back_stiffness, block_strains
from .quadratic_return import Modes, respond_quadratic
from .return_map import respond_general


def respond(shape, hardening, rate, elastic, n, w, past, now, stiffened):
    """Answers the strains H in a block w (`block.py`) of n points: fills T and the new HP, EP, E33; C where stiffened
    is true; and now (n, k), the new history from past (n, k), another array. One equation where the locus has modes."""
    block = respond_quadratic if isinstance(shape, Modes) else respond_general
    block(shape, hardening, rate, elastic, n, w, past, now, stiffened)


@overload(respond, jit_options=POINT)
def _respond(shape, hardening, rate, elastic, n, w, past, now, stiffened):
    block = respond_quadratic if shape.instance_class is Modes else respond_general

    def chosen(shape, hardening, rate, elastic, n, w, past, now, stiffened):
        return block(shape, hardening, rate, elastic, n, w, past, now, stiffened)

    return chosen


@njit(parallel=True, cache=True, error_model="numpy")
def update_points(
    shape, hardening, rate, elastic, metric, hp_old, ep_old, past, s, ds_de, strain, hp, ep, now, stress,
    thickness_strain,
):  # fmt: skip
    """Stress of every point from its metric.

    shape, hardening, rate, elastic : of `Material.compiled`
    metric : (p, 3) C11 C22 C12; hp_old : (p, 3); ep_old : (p,); past : (p, k)
    fills s (p, 3) second Piola-Kirchhoff [MPa]; ds_de (p, 3, 3) its derivative with respect to the Green strain
    [E11, E22, 2 E12], left out where ds_de is empty; strain H (p, 3); hp (p, 3); ep (p,); now (p, k); stress T (p, 3),
    conjugate to H; thickness_strain (p,) H33
    """
    n_points, metric, hp_old, s = metric.shape[0], metric.reshape(-1), hp_old.reshape(-1), s.reshape(-1)
    strain, hp, stress, stiffened = strain.reshape(-1), hp.reshape(-1), stress.reshape(-1), ds_de.shape[0] > 0
    for block in prange(n_blocks(n_points)):
        a, w = BLOCK * block, np.empty(ROOM)
        a3, n = 3 * a, min(BLOCK, n_points - a)
        take(n, metric[a3:], w, METRIC)
        take(n, hp_old[a3:], w, HP)
        for p in range(n):
            w[EP + p] = ep_old[a + p]
        block_strains(n, w)
        respond(shape, hardening, rate, elastic, n, w, past[a : a + n], now[a : a + n], stiffened)
        block_pull_back(n, w)
        # One array at a time: the compiler gives up where it has to tell many apart.
        give(n, w, H, strain[a3:])
        give(n, w, T, stress[a3:])
        give(n, w, HP, hp[a3:])
        give(n, w, SECOND, s[a3:])
        for p in range(n):
            ep[a + p], thickness_strain[a + p] = w[EP + p], w[E33 + p]
        if stiffened:
            block_pull_back_stiffness(n, w, ds_de[a:])
