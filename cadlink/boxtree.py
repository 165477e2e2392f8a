"""Who is near: a binary tree of boxes round the items of a skin.

Built top-down; a leaf holds at most LEAF items. A node is halved where it costs least to walk: a box is met as often as
its surface is large, so halves of n1 and n2 items with surfaces S1 and S2 cost n1 S1 + n2 S2 (Goldsmith & Salmon 1987,
Automatic creation of object hierarchies for ray tracing). So a large face parts from the small ones beside it, and
half as many boxes are looked at as with halves of as many items each.

The query walks the nearer child first and drops what cannot beat the best distance so far.
"""

from math import sqrt

import numpy as np
from numba import njit

from cadlink.kernels import POINT

LEAF = 2
DEEP = 24  # levels, below which nodes are halved by number: no tree is so deep that a stack overflows


# Node k has children child, child + 1, or items order[start : stop] where child < 0.
NODE = np.dtype([("low", "f8", 3), ("high", "f8", 3), ("child", "i8"), ("start", "i8"), ("stop", "i8")])


def build_tree(low, high):
    """Nodes (NODE records) and item order of a tree over boxes low, high (n, 3)."""
    order, tree = np.arange(len(low)), np.zeros(2 * len(low), NODE)
    return tree[: plant(low, high, order, tree)], order


@njit
def surfaces(low, high, items, size):
    """Fill size (n,) with half the surface of the box round the first 1, 2, .. n of these items [mm^2]."""
    a, b = np.full(3, np.inf), np.full(3, -np.inf)
    for k in range(len(items)):
        for c in range(3):
            a[c], b[c] = min(a[c], low[items[k], c]), max(b[c], high[items[k], c])
        x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        size[k] = x * y + y * z + z * x


@njit
def halve(low, high, mine, deep):
    """Put these items in the order in which they are best halved; returns how many make the first half."""
    n, least, middle = len(mine), np.inf, 0
    given, first, last = mine.copy(), np.empty(n), np.empty(n)
    for axis in range(3):
        along = given[np.argsort(low[given, axis] + high[given, axis], kind="mergesort")]
        surfaces(low, high, along, first)
        surfaces(low, high, along[::-1], last)
        before = least
        for k in range(1, n):
            cost = abs(n - 2.0 * k) if deep else k * first[k - 1] + (n - k) * last[n - k - 1]
            if cost < least:
                least, middle = cost, k
        if least < before:
            mine[:] = along
    return middle


@njit(cache=True)
def plant(low, high, order, tree):
    """Fill the tree and put the items in its order; returns how many nodes there are."""
    tree[0].child, tree[0].stop, n_nodes = -1, len(order), 1
    level = np.zeros(len(tree), np.int64)
    node = 0
    while node < n_nodes:
        start, stop = tree[node].start, tree[node].stop
        if stop - start > LEAF:
            middle = start + halve(low, high, order[start:stop], level[node] > DEEP)
            child = n_nodes
            tree[node].child = child
            tree[child].child, tree[child].start, tree[child].stop = -1, start, middle
            tree[child + 1].child, tree[child + 1].start, tree[child + 1].stop = -1, middle, stop
            level[child : child + 2] = level[node] + 1
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
