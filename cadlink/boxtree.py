"""Who is near: a binary tree of boxes round the items of a skin.

Built top-down, halving at the median of the longest side; a leaf holds at most LEAF items. The
query walks the nearer child first and drops what cannot beat the best distance so far.
"""

from math import sqrt

import numpy as np
from numba import njit

from cadlink.kernels import POINT

LEAF = 2


# Node k has children child, child + 1, or items order[start : stop] where child < 0.
NODE = np.dtype([("low", "f8", 3), ("high", "f8", 3), ("child", "i8"), ("start", "i8"), ("stop", "i8")])


def build_tree(low, high):
    """Nodes (NODE records) and item order of a tree over boxes low, high (n, 3)."""
    order, tree = np.arange(len(low)), np.zeros(2 * len(low), NODE)
    return tree[: plant(low, high, order, tree)], order


@njit(cache=True)
def plant(low, high, order, tree):
    """Fill the tree and put the items in its order; returns how many nodes there are."""
    tree[0].child, tree[0].stop, n_nodes = -1, len(order), 1
    node = 0
    while node < n_nodes:
        start, stop = tree[node].start, tree[node].stop
        if stop - start > LEAF:
            mine, axis, longest = order[start:stop].copy(), 0, -1.0
            for c in range(3):
                centre = low[mine, c] + high[mine, c]
                span = centre.max() - centre.min()
                if span > longest:
                    axis, longest = c, span
            key = low[mine, axis] + high[mine, axis]
            order[start:stop] = mine[np.argsort(key, kind="mergesort")]
            middle, child = (start + stop) // 2, n_nodes
            tree[node].child = child
            tree[child].child, tree[child].start, tree[child].stop = -1, start, middle
            tree[child + 1].child, tree[child + 1].start, tree[child + 1].stop = -1, middle, stop
            n_nodes += 2
        node += 1
    # Boxes from the leaves up: children follow their parent in the list.
    for node in range(n_nodes - 1, -1, -1):
        here = tree[node]
        for c in range(3):
            here.low[c], here.high[c] = np.inf, -np.inf
            for k in range(here.start, here.stop) if here.child < 0 else range(0):
                item = order[k]
                here.low[c], here.high[c] = min(here.low[c], low[item, c]), max(here.high[c], high[item, c])
            for k in range(here.child, here.child + 2) if here.child >= 0 else range(0):
                here.low[c], here.high[c] = min(here.low[c], tree[k].low[c]), max(here.high[c], tree[k].high[c])
    return n_nodes


@njit(forceinline=True, **POINT)
def box_distance(box, p):
    """Distance from a point to a box (a record with low and high), 0 inside."""
    dx = max(0.0, max(box.low[0] - p[0], p[0] - box.high[0]))
    dy = max(0.0, max(box.low[1] - p[1], p[1] - box.high[1]))
    dz = max(0.0, max(box.low[2] - p[2], p[2] - box.high[2]))
    return sqrt(dx * dx + dy * dy + dz * dz)
