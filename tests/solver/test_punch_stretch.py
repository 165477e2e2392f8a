"""Stretching by a hemispherical punch with friction, where a membrane is honest: against an axisymmetric solution
(benchmarks.md F.2), and against itself with half the torsion stiffness."""

from dataclasses import replace

import numpy as np
import pytest

from plugins.stretch_problems import PUNCHES, THICKNESS, punch_errors, punch_scene
from solver import Implicit, Increments, Shell, form

RUBBED = PUNCHES["friction 0.17"]


def test_force_thickness_and_half_the_torsion_stiffness():
    method = Implicit(increments=Increments(largest=0.1))
    scene = punch_scene(RUBBED, 4.0, travel=10.0)
    full, half = (form(scene, m, frames=2) for m in (method, replace(method, torsion=0.5 * method.torsion)))
    for force, strain in punch_errors(RUBBED, scene, full).values():
        assert force == pytest.approx(0.0, abs=0.015)
        assert strain is None or strain < 0.005
    for stroke in (5.0, 10.0):
        assert half.at("force_PUNCH", stroke) == pytest.approx(full.at("force_PUNCH", stroke), rel=1e-3)
    a, b = (r.frames[-1].cell_fields["thickness"] for r in (full, half))
    assert b == pytest.approx(a, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", PUNCHES)
def test_force_and_thickness_to_30_mm(name):
    # A tenth as thick and ten times as strong: the mid-surface keeps its distance from the tools, as the reference's.
    scene = punch_scene(PUNCHES[name], 1.5, thinner=10.0)
    errors = punch_errors(PUNCHES[name], scene, form(scene, frames=6))
    assert len(errors) == 6
    for force, strain in errors.values():
        assert force == pytest.approx(0.0, abs=0.005)
        assert strain is None or strain < 0.005


@pytest.mark.slow
def test_what_thickness_and_bending_change():
    def force(**options):
        results = form(punch_scene(RUBBED, 2.5, **options), frames=6)
        return np.array([abs(results.at("force_PUNCH", depth)) for depth in RUBBED.force])

    thin, membrane, shell = force(thinner=10.0), force(), force(element=Shell(7))
    # A sheet of real thickness lies nearer to the punch the thinner it grows: it is drawn by (t0 - t) / 2 less.
    depth = np.array(list(RUBBED.force), float)
    thinning = [strains[0] for strains in RUBBED.thinning.values()]
    lag = 0.5 * THICKNESS * (1.0 - np.exp(np.interp(depth, [0.0, *RUBBED.thinning], [0.0, *thinning])))
    expected = -lag * np.gradient(thin, depth)
    assert membrane - thin == pytest.approx(expected, abs=0.3 * np.abs(expected).max())
    # Bending over punch and shoulder takes force too, and relatively the more of it the shallower the dome.
    bending = shell / membrane - 1.0
    assert (bending > 0.0).all() and (bending < 0.03).all()
    assert bending[0] > 2.0 * bending[-1]
