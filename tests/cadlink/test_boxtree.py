"""The tree of boxes: every item in one leaf, boxes that hold what is below them, large ones apart from small ones."""

import numpy as np
import pytest

from cadlink.boxtree import DEEP, LEAF, build_tree


def walked(tree):
    """Level of each node, from the root down; children follow their parents."""
    level = np.zeros(len(tree), int)
    for node in range(len(tree)):
        child = tree[node]["child"]
        if child >= 0:
            level[child : child + 2] = level[node] + 1
    return level


def boxes(kind, rng):
    """low, high (n, 3) of n boxes."""
    if kind == "random":
        low = rng.random((300, 3))
        return low, low + 0.1 * rng.random((300, 3))
    if kind == "same":
        return np.zeros((300, 3)), np.ones((300, 3))
    # Each a tenth of the one before, all with one corner in common: best halved one by one.
    size = 0.1 ** np.arange(300.0)[:, None]
    return np.zeros((300, 3)), size * np.ones(3)


@pytest.mark.parametrize("kind", ["random", "same", "nested"])
def test_every_item_is_in_one_leaf_of_a_tree_that_is_not_deep(kind):
    low, high = boxes(kind, np.random.default_rng(0))
    tree, order = build_tree(low, high)
    leaves = tree[tree["child"] < 0]
    held = np.concatenate([order[leaf["start"] : leaf["stop"]] for leaf in leaves])
    assert sorted(held) == list(range(len(low)))
    assert (leaves["stop"] - leaves["start"] <= LEAF).all()
    for node in tree:
        mine = order[node["start"] : node["stop"]]
        assert (node["low"] == low[mine].min(axis=0)).all() and (node["high"] == high[mine].max(axis=0)).all()
    # Below DEEP levels the number of items is halved from level to level.
    assert walked(tree).max() <= DEEP + 1 + np.ceil(np.log2(len(low) / LEAF))


def test_a_large_face_parts_from_the_small_ones_on_it():
    """A plate with eight by eight small boxes in one corner: it hangs from the root, alone."""
    i, j = np.meshgrid(np.arange(8.0), np.arange(8.0))
    low = np.vstack([[0.0, 0.0, 0.0], np.stack([i.ravel(), j.ravel(), np.zeros(64)], axis=1)])
    high = low + np.vstack([[100.0, 100.0, 0.0], np.ones((64, 3))])
    tree, order = build_tree(low, high)
    child = tree[0]["child"]
    assert [0] in [list(order[node["start"] : node["stop"]]) for node in tree[child : child + 2]]
