"""From triangles to nodes: fixed patterns, gathered in a fixed order (no races, the same bits on any
number of threads)."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange


class Pattern(NamedTuple):
    """Which triangle slots meet in a node, and in a 3 x 3 block of the stiffness matrix.

    node_first (n + 1,), node_slot: slots 3 tri + i of each node
    block_row, block_column (n_blocks,): nodes of each block, sorted by row, then column
    block_first (n_blocks + 1,), block_slot: slots 9 tri + 3 i + j of each block
    diagonal (n,): block of each node with itself
    """

    node_first: np.ndarray
    node_slot: np.ndarray
    block_row: np.ndarray
    block_column: np.ndarray
    block_first: np.ndarray
    block_slot: np.ndarray
    diagonal: np.ndarray


def build_pattern(cells, n_nodes):
    """Pattern of a mesh. cells : (m, 3)"""
    flat = cells.ravel()
    node_slot = np.argsort(flat, kind="stable")
    node_first = np.searchsorted(flat[node_slot], np.arange(n_nodes + 1))
    pair = np.repeat(cells, 3, axis=1).ravel() * n_nodes + np.tile(cells, (1, 3)).ravel()
    block_slot = np.argsort(pair, kind="stable")
    key, block_first = np.unique(pair[block_slot], return_index=True)
    row, column = np.divmod(key, n_nodes)
    return Pattern(
        node_first,
        node_slot,
        row,
        column,
        np.append(block_first, len(pair)),
        block_slot,
        np.flatnonzero(row == column),
    )


@njit(parallel=True, cache=True)
def gather_forces(slot_force, node_first, node_slot, force):
    """Fills force (n, 3) with the sum over each node's slots of slot_force (m, 3, 3)."""
    slots = slot_force.reshape(-1, 3)
    for node in prange(force.shape[0]):
        for c in range(3):
            total = 0.0
            for k in range(node_first[node], node_first[node + 1]):
                total += slots[node_slot[k], c]
            force[node, c] = total


@njit(parallel=True, cache=True)
def gather_blocks(stiffness, block_first, block_slot, blocks):
    """Fills blocks (n_blocks, 3, 3) with the sum over each block's slots of stiffness (m, 3, 3, 3, 3)."""
    for block in prange(blocks.shape[0]):
        for c in range(3):
            for d in range(3):
                total = 0.0
                for k in range(block_first[block], block_first[block + 1]):
                    slot = block_slot[k]
                    total += stiffness[slot // 9, (slot % 9) // 3, c, slot % 3, d]
                blocks[block, c, d] = total


@njit(parallel=True, cache=True)
def gather_thickness(thickness, area, node_first, node_slot, nodal):
    """Fills nodal (n,) with the area-weighted mean thickness of each node's triangles [mm]."""
    for node in prange(nodal.shape[0]):
        total = weight = 0.0
        for k in range(node_first[node], node_first[node + 1]):
            tri = node_slot[k] // 3
            total += thickness[tri] * area[tri]
            weight += area[tri]
        nodal[node] = total / weight
