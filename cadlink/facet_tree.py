"""Who is near among many facets: a complete binary tree of boxes, stored as a heap.

Node k has children 2k + 1 and 2k + 2; the leaves are its last half and hold LEAF items each. Every level is split at
the median of the longest side of each of its nodes, all nodes of a level at once, so that a tree over 10^5 facets is
built in a fraction of a second.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

LEAF = 4  # items in a leaf
DEPTH = 64  # of the stack of a walk


class FacetTree(NamedTuple):
    low: np.ndarray  # (n_nodes, 3) mm, lowest corner of each box
    high: np.ndarray  # (n_nodes, 3) mm
    order: np.ndarray  # (n_leaves * LEAF,) items leaf by leaf, -1 where a leaf has room


def build_facet_tree(low, high):
    """FacetTree over boxes low, high (n, 3), n >= 1."""
    n = len(low)
    levels = int(np.ceil(np.log2(max(1.0, n / LEAF))))
    n_leaves = 2**levels
    order = np.full(n_leaves * LEAF, -1)
    order[:n] = np.arange(n)
    centre = np.vstack([low + high, np.full((1, 3), np.inf)])  # row -1: room, sorted to the end
    for level in range(levels):
        group = order.reshape(2**level, -1)
        c = centre[group]
        real = np.isfinite(c)
        span = np.where(real, c, -np.inf).max(axis=1) - np.where(real, c, np.inf).min(axis=1)
        axis = span.argmax(axis=1)
        key = np.take_along_axis(c, axis[:, None, None], axis=2)[..., 0]
        # Room is shared by both halves: put it at the end of each.
        count = (group >= 0).sum(axis=1)
        group = np.take_along_axis(group, key.argsort(axis=1, kind="stable"), axis=1)
        half = group.shape[1] // 2
        kept = np.full_like(group, -1)
        left = (count + 1) // 2
        column = np.arange(half)
        kept[:, :half] = np.where(column < left[:, None], group[:, :half], -1)
        source = np.minimum(left[:, None] + column, group.shape[1] - 1)
        kept[:, half:] = np.where(column < (count - left)[:, None], np.take_along_axis(group, source, axis=1), -1)
        order = kept.reshape(-1)
    lows, highs = np.vstack([low, np.full((1, 3), np.inf)]), np.vstack([high, np.full((1, 3), -np.inf)])
    leaf = order.reshape(n_leaves, LEAF)
    rows_low, rows_high = [lows[leaf].min(axis=1)], [highs[leaf].max(axis=1)]
    while len(rows_low[0]) > 1:
        rows_low.insert(0, rows_low[0].reshape(-1, 2, 3).min(axis=1))
        rows_high.insert(0, rows_high[0].reshape(-1, 2, 3).max(axis=1))
    return FacetTree(np.vstack(rows_low), np.vstack(rows_high), order)


@njit(forceinline=True)
def node_distance(low, high, node, p):
    """Distance from a point to the box of a node [mm], 0 inside."""
    dx = max(0.0, max(low[node, 0] - p[0], p[0] - high[node, 0]))
    dy = max(0.0, max(low[node, 1] - p[1], p[1] - high[node, 1]))
    dz = max(0.0, max(low[node, 2] - p[2], p[2] - high[node, 2]))
    return sqrt(dx * dx + dy * dy + dz * dz)
