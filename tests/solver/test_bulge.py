"""Hydraulic bulge: pressure and the pole's thinning against the converged membrane (benchmarks.md G)."""

import pytest

from plugins.stretch_problems import DOME, bulge_errors, bulge_scene
from solver import Membrane, Shell, form


@pytest.mark.parametrize(("element", "size"), [(Membrane(), 2.5), (Shell(5), 2.5)], ids=["membrane", "shell"])
def test_pressure_and_pole_at_four_heights(element, size):
    scene = bulge_scene(size, element)
    errors = bulge_errors(scene, form(scene, frames=100))
    assert errors.keys() == DOME.keys()
    for pressure, strain in errors.values():
        # A shell of t/a = 1/50 with a rim that may turn bends next to nothing.
        assert pressure == pytest.approx(0.0, abs=0.005)
        assert strain == pytest.approx(0.0, abs=0.005)
