"""The strip of the founding paper: F_H = 2 mu F_B, and F_V of a strip of elements (its own derivation in strip.py)."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "strip_pull_out" / "strip.py"
spec = importlib.util.spec_from_file_location("strip", SCRIPT)
strip = importlib.util.module_from_spec(spec)
spec.loader.exec_module(strip)
START = 2.0 * strip.SIZE


def compared(count, kind):
    """Mean and ripple relative to those of a strip of elements, exactly, at the same travels; and its Results."""
    travel, force, results = strip.pull_out(count, kind)
    assert results.finished
    mean, ripple = strip.mean_and_ripple(travel, force, START)
    exact, exact_ripple = strip.mean_and_ripple(travel, strip.exact_forces(travel, count), START)
    if kind == "exact":
        fine = np.linspace(0.0, travel[-1], 1601)
        assert ripple <= strip.mean_and_ripple(fine, strip.exact_forces(fine, count), START)[1]
    return mean / exact, ripple / exact_ripple, results


def test_the_exact_value_in_the_middle_of_a_long_bend_is_that_of_the_table():
    """benchmarks.md J: n nodes that each turn by (pi / 2) / n; the mean of the moving strip is near it."""
    for count, table in ((3.0, 1174.46), (6.0, 1171.16)):
        mean, ripple = strip.mean_and_ripple(x := np.linspace(0.0, 5.0, 201), strip.exact_forces(x, count), 0.0)
        assert mean == pytest.approx(table, rel=1e-3) and 0.0 < ripple < 0.02 * table
    travel = np.linspace(0.0, 5.0, 41)
    assert strip.exact_forces(travel, 60.0) == pytest.approx(1000.0 * np.exp(0.05 * np.pi), rel=1e-4)


def test_the_exact_strip_stretches_in_proportion_to_its_softness(monkeypatch):
    """Stiff, its elements keep their length; half as stiff, they stretch twice as much, and so much more it takes."""
    x, forces = np.array([5.3]), {}
    for softness in (0.0, 1.0, 2.0):
        monkeypatch.setattr(strip, "STIFFNESS", strip.STIFFNESS / softness if softness else 1e30)
        forces[softness] = strip.exact_forces(x, 3.0)[0]
        monkeypatch.undo()
    assert forces[2.0] - forces[0.0] == pytest.approx(2.0 * (forces[1.0] - forces[0.0]), rel=0.02)
    assert abs(forces[1.0] - forces[0.0]) > 0.1
    bend = strip.bend_radius(3.0)
    legs = np.diff(strip.path(strip.nodes_on_path(x, bend, np.full((1, 12), strip.SIZE)), bend), axis=1)
    assert np.linalg.norm(legs, axis=-1) == pytest.approx(strip.SIZE, rel=1e-12)


def test_straight_out():
    """2 mu F_B while the strip slides; a single increment may fall short of it."""
    travel, force, results = strip.pull_out(3.0, "exact", "out")
    assert results.finished
    assert np.median(force) == pytest.approx(1000.0, rel=1e-4)
    assert np.abs(force - 1000.0).max() < 0.02 * 1000.0


def test_over_the_bend_on_exact_faces_and_on_facets():
    mean, ripple, results = compared(3.0, "exact")
    assert mean == pytest.approx(1.0, abs=1e-3) and ripple == pytest.approx(1.0, abs=0.02)
    assert results.contact["foot_error"] < 1e-9 and not results.contact["several_feet"]
    assert results.history["torsion_share"][-1] < 1e-3
    # Element normals: the parasitic stiffness of the paper's Fig. 9.
    _, facets, _ = compared(3.0, "element")
    assert facets > 3.0 * ripple


@pytest.mark.slow
@pytest.mark.parametrize("count", strip.COUNTS)
def test_every_surface(count):
    found = {kind: compared(count, kind)[:2] for kind in strip.KINDS}
    assert found["exact"][0] == pytest.approx(1.0, abs=1e-3)
    assert found["nagata"][0] == pytest.approx(1.0, abs=1e-3)
    assert found["exact"][1] == pytest.approx(1.0, abs=0.02)
    assert found["element"][1] > 1.2 * found["exact"][1]
