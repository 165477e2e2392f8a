"""Tools close on a sheet until they first touch it."""

import numpy as np
import pytest

from solver import SceneError, Stage, Tool
from solver.motion import place_tools
from tests.solver.lattice import Corner

# A deep wall that leans away from a punch by half a degree, as dense as a line; the punch's edge has a radius of 2 mm.
LEAN = np.radians(0.5)
WALL = np.array([10.3, 0.0, -40.0]) + np.linspace(0.0, 60.0, 6001)[:, None] * [np.sin(LEAN), 0.0, np.cos(LEAN)]
HALF = np.full(len(WALL), 0.5)  # whose nodes, 0.01 mm apart, tell it to 1e-3 mm
EDGE = Corner((10.0, 0.0), 2.0, (-1, 1))


@pytest.mark.parametrize("duty", [{"travel": -1.0}, {"force": 100.0}, {"to": -30.0}])
def test_a_punch_slides_along_a_steep_wall_until_it_touches(duty):
    # The edge's centre is then 2 + 0.5 mm from the line, (x - 8) cos - (z - z_0) (-sin) = 2.5.
    height = -40.0 + (2.5 / np.cos(LEAN) + 8.0 - 10.3) / np.tan(LEAN)
    placed = place_tools(Stage([Tool("PUNCH", EDGE, **duty)]), WALL, HALF)
    travel, press = placed["PUNCH"]
    assert press == -1.0
    assert travel == pytest.approx(height - 2.0, abs=1e-3)


def test_a_tool_that_passes_the_sheet_either_way_is_refused():
    beside = np.column_stack([np.full(100, 12.0), np.zeros(100), np.linspace(-5.0, 5.0, 100)])
    with pytest.raises(SceneError, match="stage 'draw', tool 'PUNCH': its axis .* runs along the blank"):
        place_tools(Stage([Tool("PUNCH", EDGE, force=100.0)]), beside, np.full(100, 0.5))
