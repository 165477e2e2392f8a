import numpy as np
import pytest
from scipy.linalg import logm

from solver.materials.block import BLOCK
from solver.materials.law import pull_back, strains
from solver.materials.logarithmic_strain import NEAR
from tests.solver.materials.paths import green


def evaluate(y):
    """H (3,) at a Green strain y (3,)."""
    h = np.empty((1, 3))
    strains(green(np.atleast_2d(np.asarray(y, float))), h)
    return h[0]


def derivatives(y, t):
    """dH/dy (3, 3) and t_k d2H_k/dy dy (3, 3), as the pull-back of unit stresses and of t without a stiffness."""
    stress = np.vstack([np.eye(3), t])
    s, second = np.empty((4, 3)), np.empty((4, 3, 3))
    pull_back(green(np.tile(np.asarray(y, float), (4, 1))), stress, np.zeros((4, 3, 3)), s, second)
    return s[:3], second[3]


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
    first, second = derivatives(y, t)
    step = 1e-5
    numeric, numeric_second = np.empty((3, 3)), np.empty((3, 3))
    for j in range(3):
        e = np.eye(3)[j] * step
        numeric[:, j] = (evaluate(y + e) - evaluate(y - e)) / (2 * step)
        numeric_second[:, j] = (t @ derivatives(y + e, t)[0] - t @ derivatives(y - e, t)[0]) / (2 * step)
    assert first == pytest.approx(numeric, rel=1e-8, abs=1e-8)
    assert second == pytest.approx(numeric_second, rel=1e-7, abs=1e-6)
    assert second == pytest.approx(second.T)


def test_series_and_closed_form_agree_where_they_meet():
    # v = y3^2 of a pure shear, and u of an equibiaxial strain, reach NEAR.
    t = np.array([130.0, -70.0, 45.0])
    u = np.sqrt(NEAR)
    grown = 2 * u / (1 - u)
    for at, direction in (((0, 0, u), (0, 0, 1)), ((0.5 * (np.sqrt(1 + grown) - 1),) * 2 + (0.0,), (1, 1, 0))):
        below, above = (np.array(at) + side * 1e-12 * np.array(direction) for side in (-1, 1))
        assert evaluate(below) == pytest.approx(evaluate(above), rel=1e-11, abs=1e-11)
        for one, other in zip(derivatives(below, t), derivatives(above, t)):
            assert one == pytest.approx(other, rel=1e-10, abs=1e-9)


def test_a_small_strain_keeps_its_digits():
    # ln(1 + 2 y) of stretch along an axis: an elastic strain is a small part of a metric near 1.
    for y in (1e-9, 1e-6, 1e-3):
        y = 0.5 * (1.0 + 2.0 * y - 1.0)  # as the metric stores it
        assert evaluate((y, 0.0, 0.0))[0] == pytest.approx(0.5 * np.log1p(2 * y), rel=1e-15)


def test_a_point_does_not_see_the_others_of_its_block():
    # The same bits wherever it stands: in vector lanes, in the rest of a block, beside points that need closed forms.
    y = np.random.default_rng(0).uniform(-0.1, 0.1, (3 * BLOCK + 5, 3))
    y[::7] *= 4.0
    together = np.empty_like(y)
    strains(green(y), together)
    assert (together == [evaluate(point) for point in y]).all()
    order = np.random.default_rng(1).permutation(len(y))
    shuffled = np.empty_like(y)
    strains(green(y[order]), shuffled)
    assert (shuffled == together[order]).all()
