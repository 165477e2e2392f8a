import numpy as np
import pytest
from numba import njit
from scipy.linalg import logm

from solver.materials.logarithmic_strain import log_strain_gradient, log_strain_second


@njit
def strain(y, h):
    log_strain_gradient(y[0], y[1], y[2], h, np.empty((3, 3)))


@njit
def derivatives(y, t, first, second):
    log_strain_gradient(y[0], y[1], y[2], np.empty(3), first)
    log_strain_second(y[0], y[1], y[2], t, second)


def evaluate(y):
    h = np.empty(3)
    strain(np.asarray(y, float), h)
    return h


STATES = [
    (0.0, 0.0, 0.0),
    (1e-9, -2e-9, 1e-9),
    (0.1, 0.1, 1e-7),
    (0.2, -0.1, 0.15),
    (1.5, -0.35, 0.3),
    (3.0, 0.2, -2.0),
    (-0.2, 0.6, 0.05),
]


@pytest.mark.parametrize("y", STATES)
def test_strain_is_half_the_matrix_logarithm_of_the_metric(y):
    metric = np.array([[1 + 2 * y[0], y[2]], [y[2], 1 + 2 * y[1]]])
    expected = 0.5 * logm(metric)
    got = evaluate(y)
    assert got == pytest.approx([expected[0, 0], expected[1, 1], 2 * expected[0, 1]], rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("y", STATES)
def test_derivatives_match_finite_differences(y):
    y, t = np.array(y), np.array([130.0, -70.0, 45.0])
    first, second = np.empty((3, 3)), np.empty((3, 3))
    derivatives(y, t, first, second)
    step = 1e-5
    numeric = np.empty((3, 3))
    numeric_second = np.empty((3, 3))
    plus, minus, scratch = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for j in range(3):
        e = np.eye(3)[j] * step
        numeric[:, j] = (evaluate(y + e) - evaluate(y - e)) / (2 * step)
        derivatives(y + e, t, plus, scratch)
        derivatives(y - e, t, minus, scratch)
        numeric_second[:, j] = (t @ plus - t @ minus) / (2 * step)
    assert first == pytest.approx(numeric, rel=1e-8, abs=1e-8)
    assert second == pytest.approx(numeric_second, rel=1e-7, abs=1e-6)
    assert second == pytest.approx(second.T)


@pytest.mark.parametrize("v", [0.01, 0.1])
def test_the_branches_of_phi_agree_where_they_meet(v):
    t = np.array([130.0, -70.0, 45.0])
    sides = []
    for shear in (np.sqrt(v) - 1e-12, np.sqrt(v) + 1e-12):
        first, second = np.empty((3, 3)), np.empty((3, 3))
        derivatives((0.0, 0.0, shear), t, first, second)
        sides.append((evaluate((0.0, 0.0, shear)), first, second))
    for below, above in zip(*sides):
        assert below == pytest.approx(above, rel=1e-11, abs=1e-9)
