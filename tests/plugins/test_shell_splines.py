"""The smooth shell that stands beside the triangles as a reference."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from plugins import bench_shell
from plugins.shell_problems import PROBLEMS
from plugins.shell_splines import SplineShell, energy_derivatives, spline_path

CYLINDER = PROBLEMS["pinched cylinder"]


def test_the_derivatives_of_the_energy():
    rng = np.random.default_rng(1)
    q = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], *np.zeros((3, 3))]) + 0.1 * rng.standard_normal((5, 3))
    stiffness, curvature = np.array([[1.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.35]]), np.array([-0.01, 0.0, 0.0])
    gradient, hessian, room = np.empty((5, 3)), np.empty((5, 3, 5, 3)), np.empty((5, 3, 5, 3))
    up, down, step = np.empty((5, 3)), np.empty((5, 3)), 1e-6
    energy_derivatives(q, curvature, stiffness, 1.0, gradient, hessian)
    for i in range(5):
        for c in range(3):
            change = np.zeros((5, 3))
            change[i, c] = step
            more = energy_derivatives(q + change, curvature, stiffness, 1.0, up, room)
            less = energy_derivatives(q - change, curvature, stiffness, 1.0, down, room)
            assert (more - less) / (2.0 * step) == pytest.approx(gradient[i, c], abs=1e-9)
            assert (up - down) / (2.0 * step) == pytest.approx(hessian[i, c], abs=1e-8)


@pytest.mark.parametrize("degree, points, tolerance", [(3, 2, 5e-3), (4, 3, 2e-3)])
def test_the_pinched_cylinder_in_linear_theory(degree, points, tolerance):
    # 164.24 E t/P (Lindberg and others, 1969), a series: P is the whole cylinder's load, a quarter of it the model's.
    shell = SplineShell(CYLINDER, (32, 32), degree, points)
    internal, tangent = shell.evaluate(np.zeros(shell.n))
    assert np.abs(internal).max() < 1e-9  # N: the tube is at rest
    under, _ = shell.probes(shell.solver(tangent)(shell.load()))
    assert under * CYLINDER.young * CYLINDER.thickness / 12000.0 == pytest.approx(164.24, rel=tolerance)


def test_a_large_movement_of_the_open_cylinder():
    # Beside the load, published and smooth shell agree; under it, a point load digs in without shear.
    case = PROBLEMS["open cylinder"]
    path = []
    for row in spline_path(SplineShell(case, (16, 12), 4, 3), 0.2):
        path.append(row)
        if row[0] > 0.25:
            break
    path, rows = np.array(path), case.curve[case.curve[:, 0] <= 0.25]
    found = CubicSpline(path[:, 0], path)(rows[:, 0])[:, 2:]
    assert found == pytest.approx(rows[:, 2:], abs=0.005 * rows[-1, 2])


@pytest.mark.slow
def test_the_rows_of_the_pinched_cylinder_are_those_of_the_splines():
    path = np.array(list(spline_path(SplineShell(CYLINDER, (56, 56)), 83.0 / 60.0)))
    rise = CubicSpline(path[:, 1], path)
    for row in CYLINDER.smooth[1:]:
        (place,) = CubicSpline(path[:, 1], path[:, 0] - row[0]).roots(extrapolate=False)  # the load never falls
        assert rise(place)[1:] == pytest.approx(row[1:], abs=0.01)  # mm; between points of the path


def test_the_smooth_shells_material_is_linear_in_green_strain():
    law = bench_shell.SaintVenantKirchhoff(1000.0, 0.25)
    state = law.new_state(1)
    law.update(np.array([[1.2, 0.9, 0.05]]), law.new_state(1), state)  # E11 = 0.1, E22 = -0.05, 2 E12 = 0.05
    c = 1000.0 / (1.0 - 0.25**2)
    expected = [c * (0.1 - 0.25 * 0.05), c * (0.25 * 0.1 - 0.05), 0.375 * c * 0.05]
    assert state.second_stress[0] == pytest.approx(expected, rel=1e-12)
    assert state.tangent[0] @ [0.1, -0.05, 0.05] == pytest.approx(expected, rel=1e-12)


@pytest.mark.slow
def test_the_triangles_fold_the_pinched_cylinder_as_the_smooth_shell_does():
    row = bench_shell.measure("pinched cylinder", "lattice", 2)
    assert max(abs(error) for error, _ in row["smooth"].values()) < 0.01
    assert max(away for _, away in row["smooth"].values()) < 0.01
