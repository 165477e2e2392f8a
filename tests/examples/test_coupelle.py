"""The suspension cup's tools close on the sheet."""

from pathlib import Path

import numpy as np
import pytest

from cadlink import read_step

FILE = Path(__file__).resolve().parents[2] / "examples" / "coupelle" / "coupelle.step"
THICKNESS, CLEARANCE, STROKE = 0.8, 0.1, 17.45


def test_closed_tools_leave_room_for_the_sheet_and_no_more_than_the_clearance():
    parts = read_step(FILE)
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
