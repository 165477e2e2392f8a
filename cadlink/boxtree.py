"""Who is near: a binary tree of boxes round the items of a skin.

Built top-down, halving at the median of the longest side; a leaf holds at most LEAF items. The
query walks the nearer child first and drops what cannot beat the best distance so far.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

LEAF = 2
DEPTH = 64  # of the stack; the tree is balanced, so 2^64 items


class BoxTree(NamedTuple):
    """Node k has children child[k], child[k] + 1, or items order[start[k] : stop[k]] if child < 0."""

    low: np.ndarray  # (n_nodes, 3)
    high: np.ndarray  # (n_nodes, 3)
    child: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    order: np.ndarray  # (n_items,)


def build_tree(low, high):
    """BoxTree over boxes low, high (n, 3)."""
    n = len(low)
    room = max(1, 2 * n)
    tree = BoxTree(
        np.zeros((room, 3)),
        np.zeros((room, 3)),
        np.full(room, -1, np.int64),
        np.zeros(room, np.int64),
        np.zeros(room, np.int64),
        np.arange(n),
    )
    used = fill_tree(low, high, *tree)
    return BoxTree(*(a[:used].copy() for a in tree[:5]), tree.order)


@njit(cache=True)
def fill_tree(low, high, node_low, node_high, child, start, stop, order):
    stop[0] = len(order)
    used, node = 1, 0
    while node < used:
        a, b = start[node], stop[node]
        for c in range(3):
            node_low[node, c], node_high[node, c] = np.inf, -np.inf
            for k in range(a, b):
                node_low[node, c] = min(node_low[node, c], low[order[k], c])
                node_high[node, c] = max(node_high[node, c], high[order[k], c])
        if b - a > LEAF:
            # Halve at the median along the axis on which the centres spread most.
            axis, widest = 0, -1.0
            for c in range(3):
                least, most = np.inf, -np.inf
                for k in range(a, b):
                    centre = low[order[k], c] + high[order[k], c]
                    least, most = min(least, centre), max(most, centre)
                if most - least > widest:
                    axis, widest = c, most - least
            centres = np.empty(b - a)
            for k in range(a, b):
                centres[k - a] = low[order[k], axis] + high[order[k], axis]
            mine = order[a:b].copy()
            rank = np.argsort(centres)
            for k in range(a, b):
                order[k] = mine[rank[k - a]]
            middle = (a + b) // 2
            child[node] = used
            start[used], stop[used] = a, middle
            start[used + 1], stop[used + 1] = middle, b
            used += 2
        node += 1
    return used


@njit(forceinline=True)
def box_distance(low, high, k, x, y, z):
    """Distance from a point to box k, 0 inside."""
    dx = max(0.0, max(low[k, 0] - x, x - high[k, 0]))
    dy = max(0.0, max(low[k, 1] - y, y - high[k, 1]))
    dz = max(0.0, max(low[k, 2] - z, z - high[k, 2]))
    return sqrt(dx * dx + dy * dy + dz * dz)
