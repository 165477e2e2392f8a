"""The suspension cup: its tools close on the sheet; under a tenth of the holder's force the flange wrinkles."""

from pathlib import Path

import numpy as np
import pytest

from cadlink import read_step
from plugins.scene_file import SceneFile
from solver import form
from solver.implicit.method import Newton

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "coupelle"
THICKNESS, CLEARANCE, STROKE, RADIUS = 0.8, 0.1, 17.45, 75.0
FLATNESS, WAVES = 0.3, 12


def test_closed_tools_leave_room_for_the_sheet_and_no_more_than_the_clearance():
    parts = read_step(FOLDER / "coupelle.step")
    die, punch = parts["DIE"].surface(), parts["PUNCH"].surface()
    bottom = parts["PUNCH"].bounding_box[0][2]
    assert bottom == pytest.approx(THICKNESS, abs=0.03)
    angle, radius = np.meshgrid(np.linspace(0.1, 6.0, 9), np.linspace(1.0, 33.0, 20))
    points = np.column_stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel(), 0.0 * angle.ravel()])
    # From the die's face along its normal, half way through the gap.
    foot = die.project(points - [0.0, 0.0, 20.0])
    middle = foot.point + 0.5 * THICKNESS * foot.normal
    travel = THICKNESS - bottom - STROKE
    gap = die.project(middle).distance + punch.project(middle - [0.0, 0.0, travel]).distance
    inside = np.hypot(*foot.point[:, :2].T) < 33.0
    assert inside.sum() > 100
    assert gap[inside].min() > THICKNESS and gap[inside].max() < THICKNESS + CLEARANCE


def test_a_tenth_of_the_force_lets_the_flange_wrinkle_at_no_more_than_twice_the_cost():
    smooth, wrinkled = (drawn(name) for name in ("full_force", "tenth_force"))
    for results, _ in (smooth, wrinkled):
        still = results.in_equilibrium()
        assert still[-1] and np.array(results.history["residual"])[still].max() <= Newton().residual
        assert results.history["thinning_max"][-1] < 0.2

    # Under the full force the rim is as flat as the tools, and shortens as it is drawn in.
    angle, rim = smooth[1]
    assert np.ptp(rim[:, 2]) < 0.02
    assert length(angle, rim) == pytest.approx(arc(angle, rim), rel=1e-3)
    assert arc(angle, rim) < 0.98 * RADIUS * np.pi / 2

    # Under a tenth its length goes into the waves it was delivered with, as high as a rim makes that keeps its length.
    angle, rim = wrinkled[1]
    share = [abs(np.trapezoid(rim[:, 2] * np.cos(n * angle), angle)) for n in range(2, 25, 2)]
    assert 2 * (1 + int(np.argmax(share))) == WAVES
    assert length(angle, rim) == pytest.approx(RADIUS * np.pi / 2, rel=0.01)
    wavelength = 4.0 * arc(angle, rim) / WAVES
    assert np.ptp(rim[:, 2]) == pytest.approx(height_of_waves(wavelength, 2 * np.pi * RADIUS / WAVES), rel=0.1)
    assert wrinkled[0].history["travel_BLANK_HOLDER"][-1] > 10 * FLATNESS

    assert sum(wrinkled[0].history["iterations"]) <= 2 * sum(smooth[0].history["iterations"])
    assert len(wrinkled[0].history["stroke"]) <= 2 * len(smooth[0].history["stroke"])


def drawn(name):
    """Results of a scene, and its rim at the end: angles (k,) and points (k, 3), from plane to plane of symmetry."""
    scene = SceneFile.read(FOLDER / f"{name}.toml").build()
    results = form(scene, frames=20)
    flat = np.asarray(scene.blank.mesh.points)
    rim = np.flatnonzero(np.hypot(flat[:, 0], flat[:, 1]) > RADIUS - 1e-6)
    angle = np.arctan2(flat[rim, 1], flat[rim, 0])
    order = np.argsort(angle)
    return results, (angle[order], results.frames[-1].points[rim[order]])


def length(angle, rim):
    """Of the curve through the rim's nodes [mm]."""
    from scipy.interpolate import CubicSpline

    points = CubicSpline(angle, rim)(np.linspace(angle[0], angle[-1], 50 * len(angle)))
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def arc(angle, rim):
    """Of the circle the rim goes round, seen from above [mm]."""
    return float(np.trapezoid(np.hypot(rim[:, 0], rim[:, 1]), angle))


def height_of_waves(wavelength, along):
    """From trough to crest of a sine wave that is `along` mm long in a wavelength [mm]."""
    x = np.linspace(0.0, 2.0 * np.pi, 1001)
    heights = np.linspace(0.0, wavelength, 1001)
    slopes = np.pi / wavelength * heights[:, None] * np.cos(x)
    lengths = wavelength * np.sqrt(1.0 + slopes**2).mean(axis=1)
    return float(np.interp(along, lengths, heights))
