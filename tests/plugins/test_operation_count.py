"""Operations are counted where they happen."""

import numpy as np
import pytest

from plugins.operation_count import SIDE, counted, counted_apart


def test_operations_of_a_small_kernel():
    def kernel(x, factor, y):
        room = np.empty(1)
        for i in range(len(x)):
            room[0] = x[i] * x[i]
            y[i] = abs(-(room[0] + factor) / 2.0)

    x, y, counts = np.arange(5.0), np.zeros(5), {}
    counted(kernel, "small", counts)(x, 3.0, y)
    assert counts == {"small": 3 * 5}
    assert y == pytest.approx((x**2 + 3.0) / 2.0)
    assert y.dtype == float and np.empty(1).dtype == float


def test_operations_of_a_step():
    found = counted_apart()
    # Of an unknown without damping: v + dtm (external - internal)/m as four operations and a factor, u + dt v as two.
    n_nodes, n_tris = (SIDE + 1) ** 2, 2 * SIDE**2
    assert found["membrane"]["predict"] == pytest.approx(3 * 7 * n_nodes / n_tris, rel=0.01)
    # A layer of a shell costs what the one point of a membrane does, but for how its metric is found.
    layer = 0.5 * (found["shell, 7 layers"]["shell_pass"] - found["shell, 5 layers"]["shell_pass"])
    assert layer == pytest.approx(found["membrane"]["membrane_pass"], rel=0.25)
    assert found["shell, 5 layers"]["shell_pass"] > 5 * layer
