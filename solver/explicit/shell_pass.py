"""One pass over a sheet of shells: strains, material and forces of a block of triangles while it is in the cache.

Symbols as in `elements/section.py`: a fibre at height Z = z lam has the metric FLAT + Z (BEND + Z CURL); Z_k sums
w Z^k S over the layers.
"""

from math import exp

import numpy as np
from numba import njit, prange

from ..elements.section import fibres, mixed, third_form_row
from ..elements.shell import KAPPA, MOMENT, NORMAL_FORCE, ON_0, ROOM, block_forces, block_strains
from ..elements.shell import METRIC as MIDDLE
from ..elements.triangle_block import ACROSS, APEX, SIDE, SLOPE, block_frames
from ..kernels import FUSED, INNER
from ..lanes import BLOCK, clear, put, vector
from ..materials.block import E33, HP, METRIC, SECOND
from ..materials.block import ROOM as ROOM_OF_POINTS
from ..prefetch import fetch
from .block_nodes import add, bring, hand_over
from .held import FIELDS, answer, keep, remember, work_of

# Fields beside the elements': of the layers, and sums over them.
FLAT, BEND, CURL, Z0, Z1, Z2 = (ROOM + BLOCK * i for i in range(0, 18, 3))
PLASTIC, THICKENED, WORK = (ROOM + BLOCK * i for i in range(18, 21))
ROOM_OF_PASS = ROOM + 21 * BLOCK


@njit(parallel=True, cache=True, error_model="numpy")
def shell_pass(
    u, blocks, area, metric0, kappa0, form0, inverse, height, weight, stretch, initial, shape, hardening, rate,
    elastic, held, past, flows, keeps, metric, strain, plastic, equivalent, history, stress, thickness_strain,
    second_stress, nodes, force, thickness, ratio, sums,
):  # fmt: skip
    """Fills force, at the rows of each block of nodes (BlockNodes) [N]; thickness (m,), what it would be unloaded [mm];
    ratio, where it is (m,) and not empty, thickness over the initial one; sums (blocks,), work of the stresses over
    the step [mJ].

    metric0, kappa0, form0, inverse (m, 3), height, weight (n_layers,), stretch (m,), initial : of ShellElements; the
    first three empty where all triangles were flat
    shape, hardening, rate, elastic : the material; held, past : of `held.hold`, renewed where flows is true; elsewhere
    the sheet answers elastically
    metric .. second_stress : of SheetState, filled where keeps is true

    Contact takes the unloaded thickness: if it followed the elastic part, some 1e-4 of it, a step late, an edge pressed
    against a wall would feed on its own waves.
    """
    n_tris, n_layers, u = area.shape[0], height.shape[0], u.reshape(-1)
    metric0, kappa0, form0, inverse = metric0.reshape(-1), kappa0.reshape(-1), form0.reshape(-1), inverse.reshape(-1)
    memory, sides, part = held.reshape(-1), blocks.sides.reshape(-1), 3 * SIDE // n_layers + 1
    rows_of_force, local = force.reshape(-1), nodes.local.reshape(-1)
    for block in prange(blocks.sides.shape[0]):
        a, w, across, own = BLOCK * block, np.empty(ROOM_OF_PASS), np.empty(3 * ACROSS), np.empty(3 * nodes.most + 3)
        points, now = np.empty(ROOM_OF_POINTS), np.empty((BLOCK, past.shape[3]))
        a3, n = 3 * a, min(BLOCK, n_tris - a)
        bring(block, nodes, u, own)
        block_frames(n, block, own, blocks, w, across)
        block_strains(n, block, blocks, w, across)
        if metric0.shape[0] > 0:
            block_fibres(n, metric0[a3:], kappa0[a3:], form0[a3:], inverse[a3:], w)
        else:
            block_flat_fibres(n, inverse[a3:], w)
        clear(12, w, Z0)
        # What the next block begins with.
        fetch(inverse, a3 + 3 * BLOCK, 3 * BLOCK)
        fetch(area, a + BLOCK, BLOCK)
        fetch(stretch, a + BLOCK, BLOCK)
        fetch(thickness, a + BLOCK, BLOCK)
        fetch(rows_of_force, 3 * nodes.first[block + 1], 3 * nodes.most)
        fetch(local, 9 * (a + BLOCK), 9 * BLOCK)
        for layer in range(n_layers):
            # What comes two layers on, and a part of the next block's constants.
            fetch(memory, (block * n_layers + layer + 2) * FIELDS * BLOCK, FIELDS * BLOCK)
            fetch(sides, (block + 1) * 3 * SIDE + layer * part, part)
            block_layer(n, height[layer], stretch[a:], w, points)
            answer(shape, hardening, rate, elastic, flows, n, held[block, layer], past[block, layer], now, points)
            add_layer(n, weight[layer], height[layer], stretch[a:], initial, points, w)
            work_of(n, elastic, held[block, layer], points, weight[layer], w[WORK:])
            if flows:
                remember(held[block, layer], past[block, layer], now, points)
            if keeps:
                keep(
                    n_layers * a + layer, n_layers, n, now, points, metric, strain, plastic, equivalent, history,
                    stress, thickness_strain, second_stress,
                )  # fmt: skip
        block_resultants(n, inverse[a3:], w)
        block_forces(n, block, blocks, area[a:], w, across)
        for i in range(own.shape[0]):
            own[i] = 0.0
        add_forces(n, nodes.local[a:], w, across, own)
        hand_over(block, nodes, own, force)
        total = 0.0
        for p in range(n):
            thickness[a + p] = initial * exp(w[PLASTIC + p])
            total += 0.5 * initial * area[a + p] * w[WORK + p]
        sums[block] = total
        if ratio.shape[0] > 0:
            for p in range(n):
                ratio[a + p] = exp(w[THICKENED + p])


@njit(**FUSED, error_model="numpy")
def block_fibres(n, metric0, kappa0, form0, inverse, w):
    """Fills FLAT, BEND and CURL of a block. metric0, kappa0, form0, inverse : (3 n,)"""
    for p in range(n):
        i, j, k = 3 * p, 3 * p + 1, 3 * p + 2
        flat, bend, curl = fibres(
            vector(w, MIDDLE, p), vector(w, KAPPA, p), (metric0[i], metric0[j], metric0[k]),
            (kappa0[i], kappa0[j], kappa0[k]), (form0[i], form0[j], form0[k]), (inverse[i], inverse[j], inverse[k]),
        )  # fmt: skip
        put(w, FLAT, p, flat)
        put(w, BEND, p, bend)
        put(w, CURL, p, curl)


@njit(**FUSED, error_model="numpy")
def block_flat_fibres(n, inverse, w):
    """The same of triangles that were flat in a metric of 1, 1, 0. inverse : (3 n,)"""
    nil = (0.0, 0.0, 0.0)
    for p in range(n):
        own = inverse[3 * p], inverse[3 * p + 1], inverse[3 * p + 2]
        flat, bend, curl = fibres(vector(w, MIDDLE, p), vector(w, KAPPA, p), (1.0, 1.0, 0.0), nil, nil, own)
        put(w, FLAT, p, flat)
        put(w, BEND, p, bend)
        put(w, CURL, p, curl)


@njit(**FUSED, error_model="numpy")
def block_layer(n, height, stretch, w, points):
    """Fills METRIC of one layer's points."""
    for p in range(n):
        z, (f1, f2, f3), (b1, b2, b3), (c1, c2, c3) = (
            height * stretch[p], vector(w, FLAT, p), vector(w, BEND, p), vector(w, CURL, p)
        )  # fmt: skip
        put(points, METRIC, p, (f1 + z * (b1 + z * c1), f2 + z * (b2 + z * c2), f3 + z * (b3 + z * c3)))


@njit(**FUSED, error_model="numpy")
def add_layer(n, weight, height, stretch, thickness, points, w):
    """Adds a layer's stresses and thickness strains to the sums over the thickness."""
    for p in range(n):
        of, z, (s1, s2, s3) = weight * thickness, height * stretch[p], vector(points, SECOND, p)
        (n1, n2, n3), (m1, m2, m3), (q1, q2, q3) = vector(w, Z0, p), vector(w, Z1, p), vector(w, Z2, p)
        s1, s2, s3 = of * s1, of * s2, of * s3
        put(w, Z0, p, (n1 + s1, n2 + s2, n3 + s3))
        s1, s2, s3 = z * s1, z * s2, z * s3
        put(w, Z1, p, (m1 + s1, m2 + s2, m3 + s3))
        put(w, Z2, p, (q1 + z * s1, q2 + z * s2, q3 + z * s3))
    for p in range(n):
        hp1, hp2, _ = vector(points, HP, p)
        w[PLASTIC + p] -= weight * (hp1 + hp2)
        w[THICKENED + p] += weight * points[E33 + p]


@njit(**FUSED, error_model="numpy")
def block_resultants(n, inverse, w):
    """Fills NORMAL_FORCE and MOMENT of a block from the sums over its layers. inverse : (3 n,)"""
    for p in range(n):
        (k1, k2, k3), (m1, m2, m3), (q1, q2, q3) = vector(w, KAPPA, p), vector(w, Z1, p), vector(w, Z2, p)
        b11, b12, b21, b22 = mixed(k1, k2, k3, inverse[3 * p], inverse[3 * p + 1], inverse[3 * p + 2])
        r1, r2, r3 = third_form_row(q1, q2, q3, b11, b12, b21, b22)
        put(w, NORMAL_FORCE, p, vector(w, Z0, p))
        put(w, MOMENT, p, (m1 + r1, m2 + r2, m3 + r3))


@njit(**INNER)
def add_forces(n, local, w, across, at):
    """Adds the forces of the triangles of a block to its rows. local : (n, 9)"""
    for p in range(n):
        for i in range(3):
            there = across[ACROSS * i :]
            add(at, local[p, i], w, ON_0 + 3 * BLOCK * i, p)
            add(at, local[p, 3 + i], there, APEX, p)
            at[3 * np.intp(local[p, 6 + i])] += there[SLOPE + p]
