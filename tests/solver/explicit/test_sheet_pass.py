"""Passes over the sheet block by block give what passes array by array give; both serve laws of every kind."""

import numpy as np
import pytest

from solver import Blank, Chaboche, DecayingModulus, Explicit, Hill48, Law, Material, Membrane, Shell, Swift
from solver.explicit.sheet_pass import KEPT, ArrayByArray, InBlocks, build_pass
from solver.sheet import build_sheet
from solver.state import new_sheet
from tests.solver.lattice import square

CURVE, HILL = Swift(565.0, 0.007, 0.26), Hill48(1.79, 1.51, 2.27)
QUADRATIC = Material(206000.0, 0.3, HILL, CURVE)
MOVING = Material(
    206000.0, 0.3, HILL, Chaboche(CURVE, ((8000.0, 50.0), (1000.0, 0.0))), modulus=DecayingModulus(160000.0, 30.0)
)


def sheet_of(element, material):
    """A distorted sheet of 162 triangles, which is no multiple of a block, with planes of symmetry, free edges and
    sides that need slopes."""
    blank = Blank(square(9, 9.0, distort=0.25), 0.8, material, element)
    sheet = build_sheet(blank)
    n_points = len(sheet.elements.point_volume)
    states = [new_sheet(sheet.points, sheet.elements.n_slopes, n_points, material.n_history, False) for _ in range(2)]
    return sheet, states


def bend(sheet, state, t):
    """Move the sheet along a path that stretches, bends and returns."""
    x, y = sheet.points[:, 0], sheet.points[:, 1]
    state.x[:, 0], state.x[:, 1] = x * (1.0 + 0.03 * np.sin(t)), y * (1.0 - 0.01 * t)
    state.x[:, 2] = 0.6 * np.sin(0.9 * t) * np.cos(0.3 * x) * np.cos(0.25 * y)
    state.u[len(x) :, 0] = 0.05 * np.sin(t + np.arange(len(state.u) - len(x)))


@pytest.mark.parametrize(
    "element, material", [(Membrane(), QUADRATIC), (Shell(3), QUADRATIC), (Shell(3), MOVING)], ids=["0", "1", "2"]
)
def test_blocks_and_arrays_agree(element, material):
    sheet, (one, other) = sheet_of(element, material)
    in_blocks, by_arrays = InBlocks(sheet, one), ArrayByArray(sheet, other)
    total = 0.0
    for step, t in enumerate(np.linspace(0.0, 4.0, 17)[1:]):
        for state in (one, other):
            bend(sheet, state, t)
        sheet.elements.begin(one, material, Explicit(), in_blocks.ratio if step else None)
        work, expected = in_blocks.step(one, step % 5 == 0 or step == 15), by_arrays.step(other, True)
        total += abs(expected)
        assert work == pytest.approx(expected, abs=1e-10 * total)
        assert in_blocks.thickness == pytest.approx(by_arrays.thickness, rel=1e-12)
        assert in_blocks.ratio == pytest.approx(by_arrays.ratio, rel=1e-12)
        assert one.internal == pytest.approx(other.internal, rel=1e-9, abs=1e-10 * np.abs(other.internal).max())
        # Places beside these, without yielding and without a trace.
        u = one.u + 1e-4 * np.sin(np.arange(one.u.size)).reshape(one.u.shape)
        if material.modulus is None:
            forces = by_arrays.elastic_forces(u)
            assert in_blocks.elastic_forces(u) == pytest.approx(forces, rel=1e-9, abs=1e-9 * np.abs(forces).max())
    assert np.max(one.equivalent) > 0.02
    for name in KEPT:
        expected = getattr(other, name)
        assert getattr(one, name) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.max(np.abs(expected), initial=1.0))


def test_strains_are_those_of_the_last_step_kept():
    sheet, (state, _) = sheet_of(Shell(3), QUADRATIC)
    passes = InBlocks(sheet, state)
    bend(sheet, state, 0.5)
    passes.step(state, True)
    kept = state.stress.copy()
    bend(sheet, state, 1.0)
    passes.step(state, False)
    assert np.array_equal(state.stress, kept) and np.abs(kept).max() > 100.0
    # A pass that begins from what was kept goes on from there.
    again = InBlocks(sheet, state)
    assert again.held != pytest.approx(passes.held)
    passes.step(state, True)
    assert np.array_equal(InBlocks(sheet, state).held[:2], passes.held[:2])


class Elastic(Law):
    """Linear in logarithmic strain."""

    young, poisson, name, density = 206000.0, 0.3, "elastic", 7.85e-9
    initial_yield_stress = 1e8

    def respond(self, strain, old, new, dt):
        c, nu = self.young / (1.0 - self.poisson**2), self.poisson
        stiffness = c * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 - 0.5 * nu]])
        new.stress[:] = strain @ stiffness
        new.thickness_strain[:] = -nu / (1.0 - nu) * (strain[:, 0] + strain[:, 1])
        return np.broadcast_to(stiffness, (len(strain), 3, 3))


def test_a_law_of_ones_own():
    sheet, (state, _) = sheet_of(Shell(3), Elastic())
    passes = build_pass(sheet, state)
    assert isinstance(passes, ArrayByArray)
    bend(sheet, state, 0.3)
    sheet.elements.begin(state, Elastic(), Explicit())
    passes.step(state, True)
    assert passes.elastic_forces(state.u) == pytest.approx(state.internal, abs=1e-9 * np.abs(state.internal).max())
