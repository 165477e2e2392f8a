"""A block's own rows of unknowns, where its triangles read places and add up forces: little goes through memory, as a
node's slots are in few blocks."""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..elements.assembly import build_corners
from ..kernels import FUSED_POINT, INNER
from ..lanes import BLOCK, vector


class BlockNodes(NamedTuple):
    """rows: of all blocks, one after the other; first (blocks + 1,): where each block's begin; local (m, k): row of
    each slot within its block, those that are not there one after the last; most: rows of a block, at most"""

    rows: np.ndarray
    first: np.ndarray
    local: np.ndarray
    most: int


def build_block_nodes(slots):
    """BlockNodes of slots (m, k), -1 where there is none, and the Corners that gather their rows."""
    m, k = slots.shape
    n_rows, blocks = slots.max() + 1, -(-m // BLOCK)
    block = np.repeat(np.arange(m) // BLOCK, k)
    there = slots.ravel() >= 0
    key, inverse = np.unique(block[there] * n_rows + slots.ravel()[there], return_inverse=True)
    first = np.searchsorted(key, n_rows * np.arange(blocks + 1))
    local = np.diff(first)[block]
    local[there] = inverse.ravel() - first[block[there]]
    rows = key % n_rows
    nodes = BlockNodes(rows.astype(np.uint32), first, local.reshape(m, k).astype(np.uint16), int(np.diff(first).max()))
    return nodes, build_corners(rows[:, None], n_rows)


@njit(**INNER)
def bring(block, nodes, u, own):
    """Fills own (3 most + 3,) with a block's rows of u (3 n_rows,), and one more for slots that are not there."""
    first, count = nodes.first[block], nodes.first[block + 1] - nodes.first[block]
    for row in range(count + 1):
        place = 3 * np.intp(nodes.rows[first + (row if row < count else 0)])
        own[3 * row], own[3 * row + 1], own[3 * row + 2] = u[place], u[place + 1], u[place + 2]


@njit(**FUSED_POINT)
def add(at, row, values, field, p):
    """Adds three fields of one point to a row of at (3 rows,)."""
    v1, v2, v3 = vector(values, field, p)
    i = 3 * np.intp(row)
    at[i], at[i + 1], at[i + 2] = at[i] + v1, at[i + 1] + v2, at[i + 2] + v3


@njit(**INNER)
def hand_over(block, nodes, at, force):
    """Fills a block's rows of force (rows of all blocks, 3) with its sums at (3 most + 3,)."""
    first = nodes.first[block]
    for row in range(nodes.first[block + 1] - first):
        force[first + row, 0], force[first + row, 1], force[first + row, 2] = (
            at[3 * row],
            at[3 * row + 1],
            at[3 * row + 2],
        )
