"""The tools' way over a stage's time."""

import numpy as np
import pytest

from solver import Explicit
from solver.explicit.pacing import Pacing, pace, wave_time
from tests.solver.explicit.patch import motion
from tests.solver.lattice import square


@pytest.mark.parametrize("ramp", [0.1, 0.35, 0.5])
def test_the_way_is_smooth_and_its_time_is_found_back(ramp):
    pacing = Pacing(2.0, ramp, 0.5)
    times = np.linspace(0.0, 2.0, 2001)
    way = np.array([pacing.fraction(t) for t in times])
    assert (way[0], way[-1]) == (0.0, 1.0)
    speed = np.gradient(way, times)
    assert (speed >= 0.0).all() and speed.max() == pytest.approx(0.5 / (1.0 - ramp), rel=1e-3)
    # A cosine: the acceleration stays below pi/2 of the top speed over the ramp.
    assert np.abs(np.gradient(speed, times)).max() <= 1.01 * 0.5 * np.pi * speed.max() / (2.0 * ramp)
    assert way + way[::-1] == pytest.approx(1.0)
    for fraction in (1e-6, 0.1, 0.5, 0.987):
        assert pacing.fraction(pacing.time(fraction)) == pytest.approx(fraction, rel=1e-12)
    assert pacing.time(-0.5) == -0.25
    assert [pacing.readiness(t) for t in (-0.5, -0.25, 0.1)] == pytest.approx([0.0, 0.5, 1.0])


def test_a_stage_lasts_a_number_of_waves_whatever_the_density():
    sheet = motion(square(4, 20.0), 1.0).sheet
    material = sheet.blank.material
    # The modelled quarter reaches 20 mm from its middle, a corner of the mesh.
    speed = np.sqrt(material.initial_yield_stress / 7.85e-9)
    assert wave_time(sheet, 7.85e-9) == pytest.approx(20.0 / speed)
    assert wave_time(sheet, 4 * 7.85e-9) == pytest.approx(40.0 / speed)
    assert pace(sheet, Explicit(waves=5.0)).duration == pytest.approx(100.0 / speed)
