"""What the points of a sheet remember from step to step, as explicit passes read and write it: in blocks of triangles
(`lanes.py`), layer after layer, so that a pass meets it in the order of memory and in vectors.

Fields of a layer of a block: plastic strain HP, its equivalent EP, stress T. The strain is HP and what T takes
elastically.
"""

import numpy as np
from numba import njit

from ..kernels import FUSED, INNER
from ..lanes import BLOCK, vector
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
def answer(shape, hardening, rate, elastic, n, held, past, now, w):
    """Stresses of n points of one layer whose METRIC is in w, with what held and past (BLOCK, k) remember of them; now
    (BLOCK, k) is filled with the new history."""
    w[HP : HP + 3 * BLOCK] = held[OLD_HP : OLD_HP + 3 * BLOCK]
    w[EP : EP + BLOCK] = held[OLD_EP : OLD_EP + BLOCK]
    block_strains(n, w)
    respond(shape, hardening, rate, elastic, n, w, past, now, False)
    block_pull_back(n, w)


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
    held[OLD_HP : OLD_HP + 3 * BLOCK] = w[HP : HP + 3 * BLOCK]
    held[OLD_EP : OLD_EP + BLOCK] = w[EP : EP + BLOCK]
    held[OLD_T : OLD_T + 3 * BLOCK] = w[T : T + 3 * BLOCK]
    past[:] = now


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
