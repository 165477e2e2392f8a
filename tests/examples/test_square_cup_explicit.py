"""The square cup, explicit against implicit."""

import numpy as np
import pytest

from plugins.cup_problem import cup_scene
from solver import Explicit, Implicit, form

WINDOW = 1.0  # mm, over which the punch force is averaged


@pytest.mark.slow
@pytest.mark.parametrize("metal, worst", [("steel", 0.01), ("aluminium", 0.02)])
def test_punch_force_and_thickness_agree_with_the_implicit_solver(metal, worst):
    """The example's mesh and depth, every triangle of it."""
    scene, _ = cup_scene(metal, 2.5, 40.0)
    explicit, implicit = (form(scene, method) for method in (Explicit(), Implicit()))
    strokes = np.linspace(1.0, 39.0, 381)
    forces = []
    for results in (explicit, implicit):
        at = strokes[:, None] + np.linspace(-0.5 * WINDOW, 0.5 * WINDOW, 21)
        forces.append(np.interp(at, results.history["stroke"], results.history["force_PUNCH"]).mean(axis=1))
    assert forces[0] == pytest.approx(forces[1], abs=0.02 * forces[1].max())
    for frames in zip(explicit.frames, implicit.frames, strict=True):
        thickness = [frame.cell_fields["thickness"] for frame in frames]
        assert thickness[0] == pytest.approx(thickness[1], rel=worst)
    held = np.array(explicit.history["force_BLANK_HOLDER"])[np.array(explicit.history["stroke"]) > 1.0]
    assert held.mean() == pytest.approx(19600.0, rel=0.01)
    assert explicit.history["kinetic_share"][-1] < 0.01
    assert abs(explicit.energy["imbalance"]) < 2e-3 * explicit.energy["external"]
