"""Gravity against the hanging strip and the sagging beam; pilots that hold a hole."""

import numpy as np
import pytest

from solver import (
    Blank,
    Explicit,
    Implicit,
    Material,
    Membrane,
    Scene,
    SceneError,
    Shell,
    Stage,
    Tool,
    Voce,
    VonMises,
    form,
)
from tests.solver.lattice import Plane, square
from tests.solver.strips import flat_strip

G = 9810.0
HEAVY = 7.85e-6  # tonne/mm^3: a thousand times steel's, so that a short strip feels it
ELASTIC = Material(206000.0, 0.0, VonMises(), Voce(5000.0, 0.0, 1.0), density=HEAVY)


@pytest.mark.parametrize("method", [Implicit(), Explicit(waves=60.0, damping=1.0)])
def test_a_hanging_strip_stretches_under_its_weight(method):
    length, width, thickness = 100.0, 10.0, 1.0
    mesh = flat_strip(length, width, 40)
    blank = Blank(mesh, thickness, ELASTIC, Membrane(), fixed={"all": "yz", "back": "x"})
    stage = Stage(gravity=(G, 0.0, 0.0), moved={"back": (0.0, None, None)})
    results = form(Scene(blank, [stage]), method, frames=2)
    stretch = results.frames[-1].points[mesh.groups["front"], 0] - length
    # rho g L^2 / 2E, and the share of the strains' squares
    wanted = HEAVY * G * length**2 / (2.0 * ELASTIC.young)
    tolerance = 3e-3 if isinstance(method, Implicit) else 0.02
    assert stretch == pytest.approx(wanted, rel=tolerance)
    weight = HEAVY * G * length * width * thickness
    assert -results.history["reaction_back_x"][-1] == pytest.approx(weight, rel=tolerance)


def test_a_plate_on_two_supports_sags_like_a_beam():
    # 5 q L^4 / (384 E I), Poisson's ratio 0; half of it, with a plane of symmetry at mid-span.
    span, width, thickness, n = 200.0, 10.0, 1.0, 20
    mesh = flat_strip(0.5 * span, width, n)
    mesh.groups["symmetry_x"] = mesh.groups["back"]
    density = 7.85e-9
    material = Material(206000.0, 0.0, VonMises(), Voce(5000.0, 0.0, 1.0), density=density)
    blank = Blank(mesh, thickness, material, Shell(3), fixed={"front": "z", "all": "y"})
    results = form(Scene(blank, [Stage(gravity=(0.0, 0.0, -G))]), frames=1)
    sag = -results.frames[-1].points[mesh.groups["back"], 2]
    load = density * G * thickness
    wanted = 5.0 * load * span**4 / (384.0 * material.young * thickness**3 / 12.0)
    assert sag == pytest.approx(wanted, rel=0.01)


def test_gravity_stays_from_stage_to_stage_and_goes_with_the_last():
    mesh = flat_strip(100.0, 10.0, 10)
    blank = Blank(mesh, 1.0, ELASTIC, Membrane(), fixed={"all": "yz", "back": "x"})
    down = (G, 0.0, 0.0)
    results = form(
        Scene(blank, [Stage(gravity=down), Stage(gravity=down), Stage(forces={"front": (1.0, 0, 0)})]), frames=1
    )
    ends = [frame.points[mesh.groups["front"], 0].mean() - 100.0 for frame in results.frames]
    weighed = HEAVY * G * 100.0**2 / (2.0 * ELASTIC.young)
    by_stage = dict(zip((frame.stage for frame in results.frames), ends))
    assert len(by_stage) == 1  # all are called draw; the frames tell the order
    assert max(ends) == pytest.approx(weighed, rel=3e-3)
    assert ends[-1] == pytest.approx(1.0 * 100.0 / (ELASTIC.young * 10.0), rel=1e-3)
    assert ends[-2] == pytest.approx(weighed, rel=3e-3)


def test_pilots_hold_a_node_group_across_the_tools_axis():
    mesh = square(6, 30.0)
    mesh.points[:, 2] = 0.5
    mesh.groups = {"all": mesh.groups["all"], "right": mesh.groups["right"], "pin": np.array([24])}
    blank = Blank(mesh, 1.0, ELASTIC, Membrane())
    plates = [Tool("BELOW", Plane()), Tool("ABOVE", Plane((0, 0, 1.0), (0, 0, -1)), force=500.0)]
    stage = Stage(plates, forces={"right": (120.0, 0.0, 0.0)}, pilots=["pin"])
    results = form(Scene(blank, [stage]), frames=1)
    assert results.frames[-1].points[24, :2] == pytest.approx(mesh.points[24, :2], abs=1e-12)
    assert results.history["reaction_pin_x"][-1] == pytest.approx(-120.0, rel=1e-6)
    assert results.history["reaction_pin_y"][-1] == pytest.approx(0.0, abs=1e-3)
    assert "group pin keeps its place across the tools' axis" in str(results.plan)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Stage(gravity=(0.0, 1.0)), r"gravity: found \(0.0, 1.0\), expected 3 numbers in mm/s\^2"),
        (lambda: Stage(pilots=["a"], moved={"a": (0, 0, 0)}), "pilots: group 'a' is moved too"),
        (lambda: Stage([Tool("A", Plane(), axis=(1, 1, 0), travel=1.0)], pilots=["a"]), "expected x, y or z"),
    ],
)
def test_what_makes_no_sense_is_one_line(make, message):
    with pytest.raises(SceneError, match=message):
        make()
