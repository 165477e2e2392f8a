import numpy as np
import pytest
from numba import njit

from solver import HockettSherby, Ludwik, SceneError, Sum, Swift, Table, Voce
from solver.materials.hardening import tabulate, yield_stress


@njit
def look_up(strain, table):
    return yield_stress(strain, table)


SMOOTH = [
    Swift(565.32, 0.007117, 0.2589),
    Swift(589.0, 1e-4, 0.216),
    Voce(120.0, 200.0, 12.0),
    HockettSherby(120.0, 400.0, 3.0, 0.8),
    Sum(((0.4, Swift(500.0, 0.002, 0.2)), (0.6, Voce(150.0, 150.0, 8.0)))),
]


@pytest.mark.parametrize("curve", SMOOTH)
def test_table_meets_a_smooth_curve(curve):
    table = tabulate(curve)
    strains = np.concatenate([[0.0], np.geomspace(1e-6, 3.9, 500)])
    values = np.array([look_up(e, table) for e in strains])
    assert values[:, 0] == pytest.approx(curve(strains), rel=1e-8)
    inner = strains[strains > 1e-4]
    step = 1e-6 * inner
    slope = (curve(inner + step) - curve(inner - step)) / (2 * step)
    assert values[-len(inner) :, 1] == pytest.approx(slope, rel=3e-4, abs=1e-6 * curve(0.0))


def test_slope_is_the_derivative_of_the_tabulated_value():
    table = tabulate(SMOOTH[0])
    for strain in np.geomspace(1e-4, 5.0, 60):
        step = 1e-6 * strain
        numeric = (look_up(strain + step, table)[0] - look_up(strain - step, table)[0]) / (2 * step)
        assert look_up(strain, table)[1] == pytest.approx(numeric, rel=1e-5)


def test_measured_points_are_met_without_overshoot():
    curve = Table([0.0, 0.05, 0.2, 0.5], [150.0, 220.0, 300.0, 340.0])
    table = tabulate(curve)
    strains = np.linspace(0.0, 0.6, 400)
    values = np.array([look_up(e, table)[0] for e in strains])
    assert np.diff(values).min() >= -1e-9
    assert values == pytest.approx(curve(strains), abs=0.5)


def test_ludwik_starts_at_its_yield_stress():
    assert look_up(0.0, tabulate(Ludwik(150.0, 300.0, 0.5)))[0] == pytest.approx(150.0)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Swift(-1.0, 0.01, 0.2),
        lambda: Swift(500.0, 0.01, 1.5),
        lambda: Table([0.1, 0.2], [100.0, 120.0]),
        lambda: Table([0.0, 0.2], [100.0, -120.0]),
        lambda: tabulate(lambda e: 100.0 - 200.0 * e),
    ],
)
def test_what_is_no_hardening_curve_is_refused(wrong):
    with pytest.raises(SceneError):
        wrong()
