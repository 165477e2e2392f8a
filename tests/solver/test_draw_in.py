import numpy as np
import pytest

from solver import Blank, Material, Membrane, SceneError, Swift, VonMises
from solver.draw_in import RimGauge
from solver.sheet import build_sheet
from tests.solver.lattice import square

STEEL = Material(206000.0, 0.3, VonMises(), Swift(565.32, 0.007117, 0.2589))


def quarter():
    mesh = square(4, 10.0)
    mesh.groups["rim"] = np.union1d(mesh.groups["right"], mesh.groups["top"])
    return build_sheet(Blank(mesh, 1.0, STEEL, Membrane()))


@pytest.mark.parametrize(
    "direction, radius",
    [((1, 0, 0), 10.0), ((0, 1, 0), 10.0), ((1, 1, 0), np.hypot(10, 10)), ((2, 1, 0), np.hypot(10, 5))],
)
def test_the_rim_is_found_along_a_ray(direction, radius):
    gauge = RimGauge(quarter(), direction, "D")
    assert gauge.start == pytest.approx(radius)
    sheet = quarter()
    assert gauge.read(0.9 * sheet.points) == pytest.approx(0.1 * radius)


def test_a_ray_that_misses_the_rim_is_refused():
    with pytest.raises(SceneError, match="misses the rim"):
        RimGauge(quarter(), (-1.0, -1.0, 0.0), "D")


def test_a_direction_out_of_the_plane_is_refused():
    with pytest.raises(SceneError, match="leaves the blank's plane"):
        RimGauge(quarter(), (0.0, 0.0, 1.0), "D")
