"""What a block of points (`lanes.py`) has in common whatever the law: its fields, strains from the metric, and the way
back to stresses and stiffnesses of the metric.

A law finds METRIC and the history HP, EP of the points in w, and fills H, T and the new HP, EP and E33.

Symbols: METRIC C11, C22, C12; H logarithmic strain [11, 22, 2*12], E33 that across the sheet; HP plastic part, EP
equivalent plastic strain; G = dH/dE; T stress conjugate to H; SECOND the second Piola-Kirchhoff stress S; C = dT/dH;
LOG = ln det C; UU = u^2; HALF = 1/(2 m); F Phi and its derivatives; the rest as in `logarithmic_strain.py`.
"""

from math import log

from numba import njit

from ..kernels import FUSED, POINT
from ..lanes import BLOCK, put, vector
from .logarithmic_strain import (
    NEAR,
    conjugate,
    invariants,
    log_strain,
    log_strain_gradient,
    log_strain_second,
    phi_closed,
    phi_series,
    phi_series_second,
)

METRIC, H, T, SECOND, HP = (BLOCK * i for i in range(0, 15, 3))
EP, E33, M, HALF, D, S, GROWN, V, F0, F1, F2, UU, LOG = (BLOCK * i for i in range(15, 28))
G11, G12, G13, G21, G22, G23, G31, G32, G33 = (BLOCK * i for i in range(28, 37))
C11, C12, C13, C21, C22, C23, C31, C32, C33 = (BLOCK * i for i in range(37, 46))
SHARED, OWN = 46, 18  # fields; the law's own follow
ROOM = BLOCK * (SHARED + OWN)


@njit(**FUSED, error_model="numpy")
def block_strains(n, w):
    """Fills H of the n points of a block from METRIC."""
    far = 0
    for p in range(n):
        c11, c22, c12 = vector(w, METRIC, p)
        m, d, s, grown = invariants(c11, c22, c12)
        both = 1.0 / (m * (2.0 + grown))
        over, u = both * (2.0 + grown), grown * both * m
        v = (d * d + s * s) * over * over
        w[M + p], w[HALF + p], w[D + p], w[S + p], w[GROWN + p] = m, 0.5 * over, d, s, grown
        w[V + p], w[UU + p] = v, u * u
        w[F0 + p], w[F1 + p] = phi_series(v)
        w[LOG + p] = 2.0 * u * phi_series(u * u)[0]
        far += 0 if (v < NEAR) & (u * u < NEAR) else 1
    if far > 0:
        for p in range(n):
            if not w[V + p] < NEAR:
                w[F0 + p], w[F1 + p], _ = phi_closed(w[V + p])
            if not w[UU + p] < NEAR:
                w[LOG + p] = log(1.0 + w[GROWN + p])
    for p in range(n):
        put(w, H, p, log_strain(w[HALF + p], w[D + p], w[S + p], w[LOG + p], w[F0 + p]))


@njit(**FUSED, error_model="numpy")
def block_pull_back(n, w):
    """Fills SECOND = G^T T of a block."""
    for p in range(n):
        over, (t1, t2, t3) = 1.0 / (1.0 + w[GROWN + p]), vector(w, T, p)
        put(w, SECOND, p, conjugate(
            w[M + p], w[HALF + p], w[D + p], w[S + p], over, w[F0 + p], w[F1 + p], t1, t2, t3
        ))  # fmt: skip


@njit(**FUSED, error_model="numpy")
def block_pull_back_stiffness(n, w, tangent):
    """Fills tangent (n, 3, 3) = dS/dE from T and C of a block."""
    far = 0
    for p in range(n):
        w[F2 + p] = phi_series_second(w[V + p])
        far += 0 if w[V + p] < NEAR else 1
    if far > 0:
        for p in range(n):
            if not w[V + p] < NEAR:
                _, _, w[F2 + p] = phi_closed(w[V + p])
    for p in range(n):
        over = 1.0 / (1.0 + w[GROWN + p])
        g = log_strain_gradient(w[M + p], w[HALF + p], w[D + p], w[S + p], over, w[F0 + p], w[F1 + p])
        w[G11 + p], w[G12 + p], w[G13 + p], w[G21 + p], w[G22 + p] = g[0], g[1], g[2], g[3], g[4]
        w[G23 + p], w[G31 + p], w[G32 + p], w[G33 + p] = g[5], g[6], g[7], g[8]
    # C becomes G^T C G in place, column by column and then row by row.
    for p in range(n):
        for row in (C11, C21, C31):
            c1, c2, c3 = w[row + p], w[row + BLOCK + p], w[row + 2 * BLOCK + p]
            w[row + p] = c1 * w[G11 + p] + c2 * w[G21 + p] + c3 * w[G31 + p]
            w[row + BLOCK + p] = c1 * w[G12 + p] + c2 * w[G22 + p] + c3 * w[G32 + p]
            w[row + 2 * BLOCK + p] = c1 * w[G13 + p] + c2 * w[G23 + p] + c3 * w[G33 + p]
    for p in range(n):
        for column in (C11, C12, C13):
            c1, c2, c3 = w[column + p], w[column + 3 * BLOCK + p], w[column + 6 * BLOCK + p]
            w[column + p] = w[G11 + p] * c1 + w[G21 + p] * c2 + w[G31 + p] * c3
            w[column + 3 * BLOCK + p] = w[G12 + p] * c1 + w[G22 + p] * c2 + w[G32 + p] * c3
            w[column + 6 * BLOCK + p] = w[G13 + p] * c1 + w[G23 + p] * c2 + w[G33 + p] * c3
    for p in range(n):
        over, (t1, t2, t3) = 1.0 / (1.0 + w[GROWN + p]), vector(w, T, p)
        k11, k22, k33, k12, k13, k23 = log_strain_second(
            w[M + p], w[HALF + p], w[D + p], w[S + p], over, w[F1 + p], w[F2 + p], t1, t2, t3
        )
        w[C11 + p], w[C22 + p], w[C33 + p] = w[C11 + p] + k11, w[C22 + p] + k22, w[C33 + p] + k33
        w[C12 + p], w[C13 + p], w[C23 + p] = w[C12 + p] + k12, w[C13 + p] + k13, w[C23 + p] + k23
        w[C21 + p], w[C31 + p], w[C32 + p] = w[C21 + p] + k12, w[C31 + p] + k13, w[C32 + p] + k23
    for p in range(n):
        for i in range(3):
            for j in range(3):
                tangent[p, i, j] = w[C11 + (3 * i + j) * BLOCK + p]


@njit(**POINT)
def take_stiffness(w, p, c):
    """Puts C (3, 3) of one point into its block."""
    w[C11 + p], w[C12 + p], w[C13 + p] = c[0, 0], c[0, 1], c[0, 2]
    w[C21 + p], w[C22 + p], w[C23 + p] = c[1, 0], c[1, 1], c[1, 2]
    w[C31 + p], w[C32 + p], w[C33 + p] = c[2, 0], c[2, 1], c[2, 2]
