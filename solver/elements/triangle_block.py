"""Shell triangles taken together, in blocks (`lanes.py`), for their strains and forces.

Their nodes' places are gathered into w: w[X0 + p] is the first coordinate of node 0 of triangle p. A loop branches
nowhere. Where nothing lies across a side, the apex there is infinitely far away, 1/(1 + rho) = 0 and
1/(2 rho - ..) = 0, so that it adds nothing; a side without an edge slope has a lever of 0; the few mirrored sides are
reflected between two loops.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..kernels import FUSED, FUSED_POINT
from ..lanes import BLOCK, put, vector
from .vectors import dot, inverse_and_normal, minus, plus, scaled

# Constants of a side, side after side: l_i,a; b_ik of the two nodes after the first; rho; 1/(1 + rho); lever.
L1, L2, B1, B2, RHO, OVER_REACH, LEVER = (BLOCK * i for i in range(7))
SIDE = 7 * BLOCK
# Fields of w: places of the own nodes; E1, E2 from the first to the others; a_1, a_2, n; A11, A22, A12.
X0, X1, X2, E1, E2, A1, A2, NORMAL, INVERSE = (BLOCK * i for i in range(0, 27, 3))
SHARED_FIELDS = 27  # strains' and forces' own follow
# Fields of what lies across, side after side: place of the apex, edge slope. An array of its own: places in w that the
# compiler does not know could be those that a loop writes.
APEX, SLOPE, ACROSS = 0, 3 * BLOCK, 4 * BLOCK


class TriangleBlocks(NamedTuple):
    """Constants of m triangles as kernels pass over them.

    rows (m, 9): row of the unknown in each slot; the first node's where there is none. Unsigned: nothing wraps round
    sides (n_blocks, 3 SIDE): constants of the sides
    mirrored (k, 3): triangle, side and row in planes of the sides that see a mirror image, in order of the triangles
    first (n_blocks + 1,): where the blocks' begin among them
    planes (p, 4): unit normal, and place along it [mm]
    """

    rows: np.ndarray
    sides: np.ndarray
    mirrored: np.ndarray
    first: np.ndarray
    planes: np.ndarray


def build_blocks(gradients, patches):
    """TriangleBlocks of Patches. gradients : (m, 3, 2) of the shape functions [1/mm]"""
    m = len(gradients)
    n_blocks = (m + BLOCK - 1) // BLOCK
    there = patches.slots >= 0
    rho = np.where(there[:, 3:6], -np.einsum("mii->mi", patches.beyond), np.inf)
    sides = np.zeros((n_blocks * BLOCK, 3, 7))
    sides[:m, :, :2] = gradients
    sides[:m, :, 2:4] = np.where(there[:, 3:6, None], patches.beyond[:, :, 1:], 0.0)
    sides[:m, :, 4], sides[:m, :, 5], sides[:m, :, 6] = rho, 1.0 / (1.0 + rho), patches.lever
    tri, side = np.nonzero(patches.image >= 0)
    return TriangleBlocks(
        np.where(there, patches.slots, patches.slots[:, :1]).astype(np.uint32),
        np.ascontiguousarray(sides.reshape(n_blocks, BLOCK, 21).transpose(0, 2, 1)).reshape(n_blocks, 3 * SIDE),
        np.column_stack([tri, side, patches.image[tri, side]]),
        np.searchsorted(tri, BLOCK * np.arange(n_blocks + 1)),
        patches.planes,
    )


@njit(**FUSED, error_model="numpy")
def block_frames(n, block, u, blocks, w, across):
    """Gathers the nodes of the n triangles of a block and what lies across their sides; fills the frames.
    u : (3 n_rows,)"""
    sides = blocks.sides[block]
    for p in range(n):
        for k in range(3):
            row = 3 * np.intp(blocks.rows[block * BLOCK + p, k])
            put(w, 3 * BLOCK * k, p, (u[row], u[row + 1], u[row + 2]))
    for p in range(n):
        x0 = vector(w, X0, p)
        e1, e2 = minus(vector(w, X1, p), x0), minus(vector(w, X2, p), x0)
        a1 = plus(scaled(sides[SIDE + L1 + p], e1), sides[2 * SIDE + L1 + p], e2)
        a2 = plus(scaled(sides[SIDE + L2 + p], e1), sides[2 * SIDE + L2 + p], e2)
        i11, i22, i12, normal = inverse_and_normal(a1, a2)
        put(w, E1, p, e1)
        put(w, E2, p, e2)
        put(w, A1, p, a1)
        put(w, A2, p, a2)
        put(w, INVERSE, p, (i11, i22, i12))
        put(w, NORMAL, p, normal)
    for i in range(3):
        block_across(n, block, u, blocks, i, across[ACROSS * i :])


@njit(**FUSED, error_model="numpy")
def block_across(n, block, u, blocks, i, across):
    """Gathers the apices across side i, and its edge slopes."""
    a = block * BLOCK
    for p in range(n):
        row = 3 * np.intp(blocks.rows[a + p, 3 + i])
        put(across, APEX, p, (u[row], u[row + 1], u[row + 2]))
        across[SLOPE + p] = u[3 * np.intp(blocks.rows[a + p, 6 + i])]
    for k in range(blocks.first[block], blocks.first[block + 1]):
        tri, side, row = blocks.mirrored[k]
        if side == i:
            plane, p = blocks.planes[row], tri - a
            reflect(across, APEX, p, plane)
            put(across, APEX, p, plus(vector(across, APEX, p), 2.0 * plane[3], (plane[0], plane[1], plane[2])))


@njit(**FUSED_POINT)
def apex_offset(w, across, p, b1, b2):
    """d: of the apex across, from where the triangle goes on."""
    d = minus(vector(across, APEX, p), vector(w, X0, p))
    return plus(plus(d, -b1, vector(w, E1, p)), -b2, vector(w, E2, p))


@njit(**FUSED_POINT)
def reflect(w, field, p, plane):
    """Turns three fields into their mirror image. plane : (4,) unit normal first"""
    normal, v = (plane[0], plane[1], plane[2]), vector(w, field, p)
    put(w, field, p, plus(v, -2.0 * dot(normal, v), normal))


@njit(**FUSED, error_model="numpy")
def block_reflect(block, blocks, i, across):
    """Reflects the forces on the apices that side i of a block sees in a mirror."""
    for k in range(blocks.first[block], blocks.first[block + 1]):
        tri, side, row = blocks.mirrored[k]
        if side == i:
            reflect(across, APEX, tri - block * BLOCK, blocks.planes[row])
