"""What the points of a sheet remember from step to step, as explicit passes read and write it: in blocks of triangles
(`lanes.py`), layer after layer, so that a pass meets it in the order of memory and in vectors.

Fields of a layer of a block: plastic strain HP, its equivalent EP, stress T. The strain is HP and what T takes
elastically.
"""

import numpy as np
from numba import njit

from ..kernels import FUSED, INNER
from ..lanes import BLOCK, copy, put, vector
from ..materials.block import E33, EP, HP, METRIC, SECOND, H, T, block_pull_back, block_strains
from ..materials.modulus import young_at
from ..materials.update import respond

OLD_HP, OLD_EP, OLD_T = (BLOCK * i for i in (0, 3, 4))
FIELDS = 7
KEPT = ("metric", "strain", "plastic", "equivalent", "history", "stress", "thickness_strain", "second_stress")


def hold(state, n_layers):
    """What a SheetState remembers: held (blocks, n_layers, FIELDS BLOCK), past (blocks, n_layers, BLOCK, k)."""
    m = len(state.equivalent) // n_layers
    blocks = -(-m // BLOCK)

    def laid_out(rows):
        width = rows.shape[1]
        padded = np.zeros((BLOCK * blocks, n_layers, width))
        padded[:m] = rows.reshape(m, n_layers, width)
        return padded.reshape(blocks, BLOCK, n_layers, width).transpose(0, 2, 1, 3)

    rows = np.hstack([state.plastic, state.equivalent[:, None], state.stress])
    held = np.ascontiguousarray(laid_out(rows).transpose(0, 1, 3, 2)).reshape(blocks, n_layers, FIELDS * BLOCK)
    return held, np.ascontiguousarray(laid_out(state.history))


@njit(**INNER, error_model="numpy")
def answer(shape, hardening, rate, elastic, flows, n, held, past, now, w):
    """Stresses of n points of one layer whose METRIC is in w, with what held and past (BLOCK, k) remember of them; now
    (BLOCK, k) is filled with the new history. Elastic ones, and no history, where flows is false."""
    copy(3, held, OLD_HP, w, HP)
    copy(1, held, OLD_EP, w, EP)
    block_strains(n, w)
    if flows:
        respond(shape, hardening, rate, elastic, n, w, past, now, False)
    else:
        respond_elastic(n, elastic, w)
    block_pull_back(n, w)


@njit(**FUSED, error_model="numpy")
def respond_elastic(n, elastic, w):
    """Fills T and E33 of a block as if nothing flowed."""
    nu = elastic.nu
    for p in range(n):
        (h1, h2, h3), (hp1, hp2, hp3) = vector(w, H, p), vector(w, HP, p)
        e1, e2, e3, young = h1 - hp1, h2 - hp2, h3 - hp3, young_at(elastic, w[EP + p])[0]
        c = young / (1.0 - nu * nu)
        put(w, T, p, (c * (e1 + nu * e2), c * (e2 + nu * e1), 0.5 * (1.0 - nu) * c * e3))
        w[E33 + p] = -nu / (1.0 - nu) * (e1 + e2) - hp1 - hp2


@njit(**FUSED, error_model="numpy")
def work_of(n, elastic, held, w, weight, work):
    """Adds to work (BLOCK,) weight times twice the work of the stresses over the step [mJ/mm^3]."""
    for p in range(n):
        (t1, t2, t3), (s1, s2, s3) = vector(w, T, p), vector(held, OLD_T, p)
        (h1, h2, h3), (hp1, hp2, hp3) = vector(w, H, p), vector(held, OLD_HP, p)
        over, nu = 1.0 / young_at(elastic, held[OLD_EP + p])[0], elastic.nu
        g1, g2, g3 = hp1 + over * (s1 - nu * s2), hp2 + over * (s2 - nu * s1), hp3 + 2.0 * (1.0 + nu) * over * s3
        work[p] += weight * ((t1 + s1) * (h1 - g1) + (t2 + s2) * (h2 - g2) + (t3 + s3) * (h3 - g3))


@njit(**INNER)
def remember(held, past, now, w):
    """What one layer of a block remembers from now on."""
    copy(3, w, HP, held, OLD_HP)
    copy(1, w, EP, held, OLD_EP)
    copy(3, w, T, held, OLD_T)
    for p in range(past.shape[0]):
        for i in range(past.shape[1]):
            past[p, i] = now[p, i]


@njit(**INNER)
def keep(first, step, n, now, w, metric, strain, plastic, equivalent, history, stress, thickness_strain, second_stress):
    """Fills the rows first, first + step, .. of a SheetState's arrays with n points of one layer."""
    for p in range(n):
        q = first + step * p
        for c in range(3):
            i = BLOCK * c + p
            metric[q, c], strain[q, c], plastic[q, c] = w[METRIC + i], w[H + i], w[HP + i]
            stress[q, c], second_stress[q, c] = w[T + i], w[SECOND + i]
        equivalent[q], thickness_strain[q] = w[EP + p], w[E33 + p]
        for c in range(now.shape[1]):
            history[q, c] = now[p, c]
