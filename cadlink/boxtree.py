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
    centre = low + high
    order = np.arange(len(low))
    nodes, todo = [(0, len(order), -1)], [0]
    for node in todo:
        start, stop, _ = nodes[node]
        if stop - start <= LEAF:
            continue
        mine = order[start:stop]
        axis = np.ptp(centre[mine], axis=0).argmax()
        order[start:stop] = mine[np.argsort(centre[mine, axis], kind="stable")]
        middle, child = (start + stop) // 2, len(nodes)
        nodes[node] = start, stop, child
        nodes += [(start, middle, -1), (middle, stop, -1)]
        todo += [child, child + 1]
    tree = np.zeros(len(nodes), NODE)
    for record, (start, stop, child) in zip(tree, nodes, strict=True):
        record["start"], record["stop"], record["child"] = start, stop, child
    # Boxes from the leaves up: children follow their parent in the list.
    for record in tree[::-1]:
        if record["child"] < 0:
            items = order[record["start"] : record["stop"]]
            record["low"], record["high"] = low[items].min(axis=0), high[items].max(axis=0)
        else:
            pair = tree[record["child"] : record["child"] + 2]
            record["low"], record["high"] = pair["low"].min(axis=0), pair["high"].max(axis=0)
    return tree, order


@njit(forceinline=True, **POINT)
def box_distance(box, p):
    """Distance from a point to a box (a record with low and high), 0 inside."""
    dx = max(0.0, max(box.low[0] - p[0], p[0] - box.high[0]))
    dy = max(0.0, max(box.low[1] - p[1], p[1] - box.high[1]))
    dz = max(0.0, max(box.low[2] - p[2], p[2] - box.high[2]))
    return sqrt(dx * dx + dy * dy + dz * dz)
