"""The seam between element and material: a user's own law, state objects, histories."""

import numpy as np
import pytest

from solver import Blank, Implicit, Material, Newton, PlanarHill, Scene, Stage, Swift, form
from solver.materials.law import Law
from tests.solver.lattice import square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589), "mild steel")


class LinearElastic(Law):
    """Linear in logarithmic strain; remembers the largest strain seen, to use its history."""

    young, poisson, name = 70000.0, 0.33, "linear"
    initial_yield_stress = 100.0
    n_history = 1

    def respond(self, strain, old, new, dt):
        nu = self.poisson
        c = self.young / (1.0 - nu**2)
        stiffness = c * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 - 0.5 * nu]])
        new.stress[:] = strain @ stiffness
        new.thickness_strain[:] = -nu / (1.0 - nu) * (strain[:, 0] + strain[:, 1])
        new.history[:, 0] = np.maximum(old.history[:, 0], np.abs(strain).max(axis=1))
        return np.broadcast_to(stiffness, (len(strain), 3, 3))


def random_metric(n, size=0.1, seed=0):
    y = np.random.default_rng(seed).uniform(-size, size, (n, 3))
    return np.column_stack([1 + 2 * y[:, 0], 1 + 2 * y[:, 1], y[:, 2]])


def pulled(material, fixed=None):
    """A strip stretched by 2 % along x, thickness and width free to change."""
    mesh = square(4, 20.0)
    x = mesh.points[:, 0]
    mesh.groups = {"left": np.flatnonzero(x == x.min()), "right": np.flatnonzero(x == x.max()), "corner": np.array([0])}
    stage = Stage(moved={"right": (0.02 * (x.max() - x.min()), None, 0.0)})
    blank = Blank(mesh, 1.0, material, fixed={"left": "xz", "corner": "y"})
    return form(Scene(blank, [stage]), Implicit(newton=Newton(residual=1e-10, correction=1e-8)), frames=1)


def test_a_users_own_law_is_one_short_class_and_runs_in_the_solver():
    results = pulled(LinearElastic())
    strain = np.log(1.02)
    fields = results.frames[-1].cell_fields
    assert fields["strain_major"] == pytest.approx(strain, rel=1e-9)
    assert fields["strain_minor"] == pytest.approx(-0.33 * strain, rel=1e-6)
    # Kirchhoff stress E ln(1.02), divided by the ratio of volumes.
    volume = np.exp((1 - 2 * 0.33) * strain)
    assert fields["stress"][:, 0] == pytest.approx(70000.0 * strain / volume, rel=1e-6)
    assert "linear: LinearElastic, plane stress" in str(results.plan)


@pytest.mark.parametrize("material", [STEEL, LinearElastic()])
def test_stress_is_the_same_without_the_tangent(material):
    metric = random_metric(50)
    old, full, bare = (material.new_state(50) for _ in range(3))
    bare.tangent[:] = np.nan
    material.update(metric, old, full)
    material.update(metric, old, bare, tangent=False)
    assert np.isnan(bare.tangent).all()
    for name in ("strain", "plastic", "equivalent", "history", "stress", "thickness_strain", "second_stress"):
        assert (getattr(bare, name) == getattr(full, name)).all(), name


def test_tangent_of_a_users_own_law_matches_finite_differences():
    material, metric, step = LinearElastic(), random_metric(20), 1e-6
    old, at, plus, minus = (material.new_state(20) for _ in range(4))
    material.update(metric, old, at)
    for j, shift in enumerate(np.diag([2.0, 2.0, 1.0]) * step):
        material.update(metric + shift, old, plus)
        material.update(metric - shift, old, minus)
        numeric = (plus.second_stress - minus.second_stress) / (2 * step)
        assert at.tangent[:, :, j] == pytest.approx(numeric, rel=1e-7, abs=1e-3)


def test_history_exists_only_where_the_law_needs_it():
    assert STEEL.new_state(7).history.shape == (7, 0)
    assert LinearElastic().new_state(7).history.shape == (7, 1)
