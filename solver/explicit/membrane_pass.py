"""One pass over a sheet of membranes: strains, material and forces of a block of triangles while it is in the cache."""

from math import exp

import numpy as np
from numba import njit, prange

from ..elements.membrane import slot_forces, tangents
from ..elements.vectors import dot
from ..kernels import FUSED
from ..lanes import BLOCK, n_blocks, put, vector
from ..materials.block import E33, HP, METRIC, ROOM, SECOND
from .held import answer, keep, remember, work_of


@njit(parallel=True, cache=True, error_model="numpy")
def membrane_pass(
    u, cells, gradients, volume, normal, torsion, initial, shape, hardening, rate, elastic, held, past, remembers,
    keeps, metric, strain, plastic, equivalent, history, stress, thickness_strain, second_stress, slot_force, thickness,
    ratio, sums,
):  # fmt: skip
    """Fills slot_force (m, 3, 3), thickness (m,), ratio (m,) and sums (blocks,): see `shell_pass`."""
    n_tris, u, cells, gradients = len(cells), u.reshape(-1), cells.reshape(-1), gradients.reshape(-1)
    normal, slot_force = normal.reshape(-1), slot_force.reshape(-1)
    for block in prange(n_blocks(n_tris)):
        a, w, work, now = BLOCK * block, np.empty(ROOM), np.zeros(BLOCK), np.empty((BLOCK, past.shape[3]))
        n = min(BLOCK, n_tris - a)
        block_metrics(n, a, u, cells, gradients, w)
        answer(shape, hardening, rate, elastic, n, held[block, 0], past[block, 0], now, w)
        work_of(n, held[block, 0], w, 1.0, work)
        if remembers:
            remember(held[block, 0], past[block, 0], now, w)
        if keeps:
            keep(
                a, 1, n, now, w, metric, strain, plastic, equivalent, history, stress, thickness_strain, second_stress
            )  # fmt: skip
        block_forces(n, a, u, cells, gradients, volume, normal, torsion, w, slot_force)
        total = 0.0
        for p in range(n):
            hp1, hp2, _ = vector(w, HP, p)
            thickness[a + p], ratio[a + p] = initial * exp(-hp1 - hp2), exp(w[E33 + p])
            total += 0.5 * volume[a + p] * work[p]
        sums[block] = total


@njit(**FUSED, error_model="numpy")
def block_metrics(n, a, u, cells, gradients, w):
    """Fills METRIC of the n triangles from a on."""
    for p in range(n):
        a1, a2 = tangents(u, cells, gradients, a + p)
        put(w, METRIC, p, (dot(a1, a1), dot(a2, a2), dot(a1, a2)))


@njit(**FUSED, error_model="numpy")
def block_forces(n, a, u, cells, gradients, volume, normal, torsion, w, slot_force):
    """Fills the forces of the n triangles from a on."""
    for p in range(n):
        slot_forces(a + p, u, cells, gradients, volume, vector(w, SECOND, p), normal, torsion, slot_force)
