"""One pass over a sheet of membranes: strains, material and forces of a block of triangles while it is in the cache."""

from math import exp

import numpy as np
from numba import njit, prange

from ..elements.membrane import node_forces, tangents
from ..elements.vectors import dot
from ..kernels import FUSED, INNER
from ..lanes import BLOCK, n_blocks, put, vector
from ..materials.block import E33, HP, METRIC, ROOM, SECOND
from ..prefetch import fetch
from .block_nodes import add, hand_over
from .held import FIELDS, answer, keep, remember, work_of


@njit(parallel=True, cache=True, error_model="numpy")
def membrane_pass(
    u, cells, gradients, volume, normal, torsion, initial, shape, hardening, rate, elastic, held, past, flows,
    keeps, metric, strain, plastic, equivalent, history, stress, thickness_strain, second_stress, nodes, force,
    thickness, ratio, sums,
):  # fmt: skip
    """Fills force, thickness (m,), ratio and sums (blocks,): see `shell_pass`."""
    n_tris, u, cells, gradients = len(cells), u.reshape(-1), cells.reshape(-1), gradients.reshape(-1)
    normal, memory, local = normal.reshape(-1), held.reshape(-1), nodes.local.reshape(-1)
    for block in prange(n_blocks(n_tris)):
        a, w, work, now = BLOCK * block, np.empty(ROOM), np.zeros(BLOCK), np.empty((BLOCK, past.shape[3]))
        forces = np.empty(9 * BLOCK)
        n = min(BLOCK, n_tris - a)
        # What the blocks after this one begin with.
        fetch(memory, (block + 2) * FIELDS * BLOCK, FIELDS * BLOCK)
        fetch(cells, 3 * (a + 2 * BLOCK), 3 * BLOCK)
        fetch(gradients, 6 * (a + 2 * BLOCK), 6 * BLOCK)
        fetch(normal, 3 * (a + 2 * BLOCK), 3 * BLOCK)
        fetch(local, 3 * (a + 2 * BLOCK), 3 * BLOCK)
        fetch(thickness, a + 2 * BLOCK, BLOCK)
        fetch(volume, a + 2 * BLOCK, BLOCK)
        block_metrics(n, a, u, cells, gradients, w)
        answer(shape, hardening, rate, elastic, flows, n, held[block, 0], past[block, 0], now, w)
        work_of(n, elastic, held[block, 0], w, 1.0, work)
        if flows:
            remember(held[block, 0], past[block, 0], now, w)
        if keeps:
            keep(
                a, 1, n, now, w, metric, strain, plastic, equivalent, history, stress, thickness_strain, second_stress
            )  # fmt: skip
        at = np.zeros(3 * nodes.most + 3)
        block_forces(n, a, u, cells, gradients, volume, normal, torsion, w, forces)
        add_forces(n, nodes.local[a:], forces, at)
        hand_over(block, nodes, at, force)
        total = 0.0
        for p in range(n):
            hp1, hp2, _ = vector(w, HP, p)
            thickness[a + p] = initial * exp(-hp1 - hp2)
            total += 0.5 * volume[a + p] * work[p]
        sums[block] = total
        if ratio.shape[0] > 0:
            for p in range(n):
                ratio[a + p] = exp(w[E33 + p])


@njit(**FUSED, error_model="numpy")
def block_metrics(n, a, u, cells, gradients, w):
    """Fills METRIC of the n triangles from a on."""
    for p in range(n):
        a1, a2 = tangents(u, cells, gradients, a + p)
        put(w, METRIC, p, (dot(a1, a1), dot(a2, a2), dot(a1, a2)))


@njit(**FUSED, error_model="numpy")
def block_forces(n, a, u, cells, gradients, volume, normal, torsion, w, forces):
    """Fills forces (9 BLOCK,), three fields for each node, of the n triangles from a on."""
    for p in range(n):
        on_0, on_1, on_2 = node_forces(a + p, u, cells, gradients, volume, vector(w, SECOND, p), normal, torsion)
        put(forces, 0, p, on_0)
        put(forces, 3 * BLOCK, p, on_1)
        put(forces, 6 * BLOCK, p, on_2)


@njit(**INNER)
def add_forces(n, local, forces, at):
    """Adds the forces of the triangles of a block to its rows. local : (n, 3)"""
    for p in range(n):
        for i in range(3):
            add(at, local[p, i], forces, 3 * BLOCK * i, p)
