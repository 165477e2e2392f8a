"""The square cup, explicit against implicit, with the defaults of both."""

import numpy as np
import pytest

from plugins.bench_explicit import cup
from solver import Explicit, Implicit, form

WINDOW = 1.0  # mm, over which the punch force is averaged


@pytest.mark.slow
def test_punch_force_and_thickness_agree_with_the_implicit_solver():
    scene = cup(5.0, 20.0)
    explicit, implicit = (form(scene, method, frames=4) for method in (Explicit(), Implicit()))
    strokes = np.linspace(1.0, 19.0, 37)
    forces = []
    for results in (explicit, implicit):
        at = strokes[:, None] + np.linspace(-0.5 * WINDOW, 0.5 * WINDOW, 21)
        forces.append(np.interp(at, results.history["stroke"], results.history["force_PUNCH"]).mean(axis=1))
    assert forces[0] == pytest.approx(forces[1], abs=0.02 * forces[1].max())
    thickness = [results.frames[-1].cell_fields["thickness"] for results in (explicit, implicit)]
    assert thickness[0] == pytest.approx(thickness[1], rel=0.02)
    held = np.array(explicit.history["force_BLANK_HOLDER"])[np.array(explicit.history["stroke"]) > 1.0]
    assert held.mean() == pytest.approx(19600.0, rel=0.01)
    assert explicit.history["kinetic_share"][-1] < 0.01
    assert abs(explicit.energy["imbalance"]) < 2e-3 * explicit.energy["external"]
