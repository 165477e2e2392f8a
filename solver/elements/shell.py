"""Shell triangle with translations only: metric shared with the neighbours, curvature from the turns across the sides
(theory_shell.md 3 and 4).

Symbols: x_k nodes of a triangle, k = 0..2; l_k,a gradients of its shape functions, so that l_i points inward from
side i and is 1/h_i long, h_i the altitude; a_b = l_k,b x_k tangent vectors, a^b = A^bc a_c their duals, n unit normal.
Across side i, x_q the apex; in the initial plane, unfolded, it is at sum_k b_ik p_k of the nodes' places p_k, and
rho_i = -b_ii is the altitude there relative to h_i. d_i = x_q - b_ik x_k is how far it is from where the triangle would
go on to. Nothing else is needed of the neighbour, whose own tangent vectors are g_b = a_b - l_i,b d_i/rho_i.

Metric C = OWN a.a + SHARED sum_i G^i.G^i, G^i = (a + rho g^i)/(1 + rho) the mean by areas of the two triangles' tangent
vectors, the neighbour's turned about the side into this one's plane; a without a neighbour. In the plane these are the
mid-side gradients of theory_shell.md 3, with a part of the triangle's own. Unfolded so, d is shorter, d.d - 2 rho s r
with r = s/(2 rho - d.a^l) and s below; exact where the neighbour keeps its altitude. With c = SHARED/(1 + rho)
C_ab = a_a.a_b + sum_i c (l_a l_b (d.d + 2 s r)/(1 + rho) - l_a d.a_b - l_b d.a_a).
(Folded, the mean gradient is shorter by sin(theta/2)^2 where the surface turns by theta: coarse curved meshes locked.
The mean of the two metrics does not fold, but exceeds the metric of the mean by the variance of the gradients. In
compression that variance releases work, resisted by the mean alone: rims zigzagged, triangle by triangle.)

Curvature k_ab = -2 sum_i l_i,a l_i,b t_i from the turns t_i of the sides, t = s/F, s = d.n,
F = 1 + rho - d.a^l, a^l = l_b a^b. Where the surface turns by theta between two equal triangles t = h tan(theta/2),
which grows with any fold; with sin(theta)/2 the moment would vanish as the fold closes. An edge slope phi adds h phi.

With y = (dd - d^b da_b) and nu_b = n.da_b the turn varies by dt = (n + t a^l).y/F + t^2 A^bc l_b nu_c, and r as t does,
with 2 rho - d.a^l for F; d(s r) = (2 r n + r^2 a^l).y + r^2 s A^bc l_b nu_c.
"""

import numpy as np
from numba import njit, prange

from ..kernels import FUSED
from ..lanes import BLOCK, give, put, vector
from .patches import SHARED
from .triangle_block import (
    A1,
    A2,
    ACROSS,
    APEX,
    B1,
    B2,
    INVERSE,
    L1,
    L2,
    LEVER,
    NORMAL,
    OVER_REACH,
    RHO,
    SHARED_FIELDS,
    SIDE,
    SLOPE,
    apex_offset,
    block_frames,
    block_reflect,
)
from .vectors import dot, plus, scaled

METRIC, KAPPA, NORMAL_FORCE, MOMENT = (BLOCK * i for i in range(SHARED_FIELDS, SHARED_FIELDS + 12, 3))
FORCE, ON_KAPPA, ON_A1, ON_A2, ON_0, ON_1, ON_2 = (BLOCK * i for i in range(SHARED_FIELDS + 12, SHARED_FIELDS + 33, 3))
ROOM = BLOCK * (SHARED_FIELDS + 33)


@njit(parallel=True, cache=True, error_model="numpy")
def shell_strains(u, blocks, metric, kappa):
    """Mean metric and curvature of every triangle.

    u : (n + k, 3) node places, then edge slopes in the first column; blocks : TriangleBlocks
    fills metric (m, 3) = C11 C22 C12 and kappa (m, 3) = [11, 22, 2*12] [1/mm]
    """
    n_tris, u, metric, kappa = metric.shape[0], u.reshape(-1), metric.reshape(-1), kappa.reshape(-1)
    for block in prange(blocks.sides.shape[0]):
        a, w, across = BLOCK * block, np.empty(ROOM), np.empty(3 * ACROSS)
        n = min(BLOCK, n_tris - a)
        block_frames(n, block, u, blocks, w, across)
        block_strains(n, block, blocks, w, across)
        give(n, w, METRIC, metric[3 * a :])
        give(n, w, KAPPA, kappa[3 * a :])


@njit(**FUSED, error_model="numpy")
def block_strains(n, block, blocks, w, across):
    """Fills METRIC and KAPPA of a block."""
    for p in range(n):
        a1, a2 = vector(w, A1, p), vector(w, A2, p)
        put(w, METRIC, p, (dot(a1, a1), dot(a2, a2), dot(a1, a2)))
        put(w, KAPPA, p, (0.0, 0.0, 0.0))
    for i in range(3):
        side, there = blocks.sides[block][SIDE * i :], across[ACROSS * i :]
        for p in range(n):
            d = apex_offset(w, there, p, side[B1 + p], side[B2 + p])
            a1, a2, normal = vector(w, A1, p), vector(w, A2, p), vector(w, NORMAL, p)
            l1, l2, (i11, i22, i12) = side[L1 + p], side[L2 + p], vector(w, INVERSE, p)
            d1, d2, s, over = dot(d, a1), dot(d, a2), dot(d, normal), side[OVER_REACH + p]
            away = l1 * (i11 * d1 + i12 * d2) + l2 * (i12 * d1 + i22 * d2)
            dd, c = over * (dot(d, d) + 2.0 * s * s / (2.0 * side[RHO + p] - away)), SHARED * over
            m11, m22, m12 = vector(w, METRIC, p)
            m11 += c * l1 * (l1 * dd - 2.0 * d1)
            m22 += c * l2 * (l2 * dd - 2.0 * d2)
            m12 += c * (l1 * l2 * dd - l1 * d2 - l2 * d1)
            put(w, METRIC, p, (m11, m22, m12))
            turn = s / (1.0 + side[RHO + p] - away) + side[LEVER + p] * there[SLOPE + p]
            put(w, KAPPA, p, plus(vector(w, KAPPA, p), -2.0 * turn, (l1 * l1, l2 * l2, 2.0 * l1 * l2)))


@njit(parallel=True, cache=True, error_model="numpy")
def shell_forces(u, blocks, area, result, force):
    """Fills force (m, 9, 3): forces of every triangle on its slots [N]; of an edge slope the first column.

    result : (m, 6) resultants N, M. With m = -2 M_ab l_a l_b of a side, p = c N_ab l_a l_b/(1 + rho) and the tilting
    q = m (n + t a^l)/F + p (2 r n + r^2 a^l) the force on its d is -c N_ab l_a a_b + p d + q, and on a_b
    N_ab (a_a - sum c l_a d) + (m t^2 + p r^2 s) A^bc l_c n - d^b q.
    """
    n_tris, u, result, force = area.shape[0], u.reshape(-1), result.reshape(-1), force.reshape(-1)
    for block in prange(blocks.sides.shape[0]):
        a, w, across = BLOCK * block, np.empty(ROOM), np.empty(3 * ACROSS)
        n = min(BLOCK, n_tris - a)
        block_frames(n, block, u, blocks, w, across)
        for p in range(n):
            q = 6 * (a + p)
            put(w, NORMAL_FORCE, p, (result[q], result[q + 1], result[q + 2]))
            put(w, MOMENT, p, (result[q + 3], result[q + 4], result[q + 5]))
        block_forces(n, block, blocks, area[a:], w, across)
        for p in range(n):
            for i in range(3):
                to, there = 27 * (a + p) + 3 * i, across[ACROSS * i :]
                force[to], force[to + 1], force[to + 2] = vector(w, ON_0 + 3 * BLOCK * i, p)
                force[to + 9], force[to + 10], force[to + 11] = vector(there, APEX, p)
                force[to + 18], force[to + 19], force[to + 20] = there[SLOPE + p], 0.0, 0.0


@njit(**FUSED, error_model="numpy")
def block_forces(n, block, blocks, area, w, across):
    """Fills ON_0, ON_1 and ON_2 of a block from NORMAL_FORCE and MOMENT, and what is across with the forces on it.
    area : (n,)"""
    sides = blocks.sides[block]
    for p in range(n):
        size, (n11, n22, n12), (m11, m22, m12) = area[p], vector(w, NORMAL_FORCE, p), vector(w, MOMENT, p)
        put(w, FORCE, p, (size * n11, size * n22, size * n12))
        put(w, ON_KAPPA, p, (-2.0 * (size * m11), -2.0 * (size * m22), -4.0 * (size * m12)))
    for p in range(n):
        a1, a2, (n11, n22, n12) = vector(w, A1, p), vector(w, A2, p), vector(w, FORCE, p)
        put(w, ON_A1, p, plus(scaled(n11, a1), n12, a2))
        put(w, ON_A2, p, plus(scaled(n12, a1), n22, a2))
        put(w, ON_0, p, (0.0, 0.0, 0.0))
        put(w, ON_1, p, (0.0, 0.0, 0.0))
        put(w, ON_2, p, (0.0, 0.0, 0.0))
    for i in range(3):
        side, there = sides[SIDE * i :], across[ACROSS * i :]
        for p in range(n):
            b1, b2 = side[B1 + p], side[B2 + p]
            d = apex_offset(w, there, p, b1, b2)
            a1, a2, normal = vector(w, A1, p), vector(w, A2, p), vector(w, NORMAL, p)
            l1, l2, (i11, i22, i12) = side[L1 + p], side[L2 + p], vector(w, INVERSE, p)
            (n11, n22, n12), (m11, m22, m12) = vector(w, FORCE, p), vector(w, ON_KAPPA, p)
            low1, low2 = dot(d, a1), dot(d, a2)
            d1, d2 = i11 * low1 + i12 * low2, i12 * low1 + i22 * low2
            up1, up2 = i11 * l1 + i12 * l2, i12 * l1 + i22 * l2
            rho, over, s, away = side[RHO + p], side[OVER_REACH + p], dot(d, normal), l1 * d1 + l2 * d2
            c, below, r = SHARED * over, 1.0 / (1.0 + rho - away), s / (2.0 * rho - away)
            m, t = m11 * l1 * l1 + m22 * l2 * l2 + m12 * l1 * l2, s * below
            p1, p2 = c * (n11 * l1 + n12 * l2), c * (n12 * l1 + n22 * l2)
            pull = over * (p1 * l1 + p2 * l2)
            raised, tipped = m * below + 2.0 * pull * r, m * below * t + pull * r * r
            nodded = m * t * t + pull * r * r * s
            tilt = plus(plus(scaled(raised, normal), tipped * up1, a1), tipped * up2, a2)
            on_d = plus(plus(plus(tilt, -p1, a1), -p2, a2), pull, d)
            on_a1, on_a2 = plus(vector(w, ON_A1, p), -p1, d), plus(vector(w, ON_A2, p), -p2, d)
            put(w, ON_A1, p, plus(plus(on_a1, nodded * up1, normal), -d1, tilt))
            put(w, ON_A2, p, plus(plus(on_a2, nodded * up2, normal), -d2, tilt))
            put(w, ON_0, p, plus(vector(w, ON_0, p), b1 + b2 - 1.0, on_d))
            put(w, ON_1, p, plus(vector(w, ON_1, p), -b1, on_d))
            put(w, ON_2, p, plus(vector(w, ON_2, p), -b2, on_d))
            put(there, APEX, p, on_d)
            there[SLOPE + p] = m * side[LEVER + p]
        block_reflect(block, blocks, i, there)
    for p in range(n):
        on_a1, on_a2 = vector(w, ON_A1, p), vector(w, ON_A2, p)
        put(w, ON_0, p, plus(plus(vector(w, ON_0, p), sides[L1 + p], on_a1), sides[L2 + p], on_a2))
        put(w, ON_1, p, plus(plus(vector(w, ON_1, p), sides[SIDE + L1 + p], on_a1), sides[SIDE + L2 + p], on_a2))
        put(
            w, ON_2, p, plus(plus(vector(w, ON_2, p), sides[2 * SIDE + L1 + p], on_a1), sides[2 * SIDE + L2 + p], on_a2)
        )
