"""Operations are counted where they happen."""

import numpy as np
import pytest

from plugins.operation_count import counted, counted_apart


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
    # A triangle hands a force of three numbers to each of its three nodes, which add them up.
    assert found["membrane"]["gather_forces"] == 9.0
    # A return map costs the same for each layer, whatever else a shell does.
    for layers in (5, 7):
        ratio = found[f"shell, {layers} layers"]["update_quadratic"] / found["membrane"]["update_quadratic"]
        assert ratio == pytest.approx(layers, rel=0.1)
    seven, five = found["shell, 7 layers"], found["shell, 5 layers"]
    assert seven["shell_forces"] == five["shell_forces"] and seven["resultants"] > five["resultants"]
