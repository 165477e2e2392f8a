"""Tools that carry loads: springs, stops, riding, and tilt, against statics by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver import (
    Blank,
    Coulomb,
    Explicit,
    Implicit,
    Membrane,
    Newton,
    Scene,
    SceneError,
    Spring,
    Stage,
    Tool,
    form,
)
from solver.contact.drive import turn
from solver.recording import current_areas
from tests.solver.lattice import Ball, Plane, square
from tests.solver.strips import ELASTIC
from tests.solver.test_form import punch_stretch

TIGHT = Implicit(newton=Newton(residual=1e-10, correction=1e-9))


def stack(lower, upper, length=30.0, n=6, held="xy"):
    """A sheet 1 mm thick, held in its plane, between two plates."""
    mesh = square(n, length)
    mesh.points[:, 2] = 0.5
    mesh.groups = {"all": mesh.groups["all"]}
    blank = Blank(mesh, 1.0, ELASTIC, Membrane(), fixed={"all": held})
    below = Tool("BELOW", Plane(), **lower)
    above = Tool("ABOVE", Plane((0, 0, 1.0), (0, 0, -1)), **upper)
    return Scene(blank, [Stage([below, above])])


def last(results, column):
    return results.history[column][-1]


@pytest.mark.parametrize("theta", [1e-9, 3e-3, 0.0099, 0.0101, 1.2])
def test_a_turn_is_the_exact_rotation(theta):
    axis = np.array([0.6, -0.8, 0.0])
    assert turn(theta * axis) == pytest.approx(Rotation.from_rotvec(theta * axis).as_matrix(), abs=1e-15)


@pytest.mark.parametrize("method", [Implicit(), Explicit(waves=400.0, drift=0.5)])
def test_a_pad_on_a_spring_gives_way_by_hooke_s_law(method):
    # The upper plate comes down by 2 mm and takes the sheet and the pad along. The sheet between two plates passes all
    # work on: no energy of its own to hold an explicit run's balance against.
    results = form(stack({"spring": Spring(300.0, 500.0)}, {"travel": -2.0}, held="x"), method, frames=4)
    assert results.finished
    late = np.array(results.history["stroke"]) > 1.2
    travel = np.array(results.history["stroke"])[late]
    pushed = -np.array(results.history["travel_BELOW"])[late]
    assert pushed == pytest.approx(travel, abs=0.02)
    # Explicit forces are means over some steps; the pad has a mass there.
    tolerance = 1e-3 if isinstance(method, Implicit) else 0.03
    # The force on the pad is along -z, its axis +z.
    assert -np.array(results.history["force_BELOW"])[late].mean() == pytest.approx(
        500.0 + 300.0 * pushed.mean(), rel=tolerance
    )


def test_a_spring_stays_pushed_back_from_stage_to_stage():
    scene = stack({"spring": Spring(300.0, 500.0)}, {"travel": -1.0})
    scene = replace(scene, stages=[scene.stages[0], scene.stages[0]])
    results = form(scene, frames=1)
    assert last(results, "travel_BELOW") == pytest.approx(-2.0, abs=0.01)
    assert -last(results, "force_BELOW") == pytest.approx(500.0 + 300.0 * 2.0, rel=3e-3)


def test_a_pad_bottoms_out_at_its_stop():
    # Lighter than the spring at the stop: 500 + 300 * 0.7 = 710 N. Heavier: the stop takes the rest.
    for force, stop, wanted in ((710.0, 1.0, 0.7), (2000.0, 1.0, 1.0)):
        results = form(stack({"spring": Spring(300.0, 500.0), "stop": stop}, {"force": force}), frames=1)
        assert last(results, "force_ABOVE") == pytest.approx(force, rel=1e-6)
        assert -last(results, "travel_BELOW") == pytest.approx(wanted, abs=2e-3)


def test_a_pad_that_rides_on_a_tool_is_pushed_by_its_spring_alone():
    # The lower plate is a counter-punch of 400 N + 100 N/mm; punch and pad come down together, by 1.5 mm.
    scene = stack({"spring": Spring(100.0, 400.0)}, {"travel": -1.5})
    pad = Tool("PAD", Plane((0, 0, 1.0), (0, 0, -1)), spring=Spring(1000.0, 150.0), rides_on="ABOVE")
    stage = scene.stages[0]
    results = form(replace(scene, stages=[replace(stage, tools=[*stage.tools, pad])]), frames=2)
    assert last(results, "travel_PAD") == pytest.approx(-1.5, abs=1e-3)
    assert last(results, "force_PAD") == pytest.approx(150.0, abs=2.0)
    assert last(results, "force_PAD") + last(results, "force_ABOVE") == pytest.approx(550.0, rel=1e-3)


def test_a_tilting_holder_stands_as_its_point_of_action_says():
    # Rigid plates with a spring at each node, in series through the sheet: theta = F e / sum k_i y_i^2, to the left.
    # The force is such that no node is in the rounded start of the contact law, 3e-3 mm wide.
    force, offset = 4e5, 2.0
    scene = stack({}, {"force": force, "tilts": True, "at": (15.0 + offset, 15.0, 1.0)})
    results = form(scene, TIGHT, frames=1)
    frame = results.frames[-1]
    points = frame.points
    normal = frame.point_fields["contact_pressure"]  # of either plate, at nodes of current area
    area = np.zeros(len(points))
    np.add.at(area, scene.blank.mesh.cells.ravel(), 30.0**2 / 72 / 3.0)
    assert last(results, "force_ABOVE") == pytest.approx(force, rel=1e-8)
    weight = normal * area
    assert (weight @ points[:, 0]) / weight.sum() == pytest.approx(15.0 + offset, abs=1e-3)
    assert (weight @ points[:, 1]) / weight.sum() == pytest.approx(15.0, abs=1e-3)
    stiffness = 3.0 * ELASTIC.young * 1.0 / scene.blank.mesh_size**2 * area
    theta = force * offset / (0.5 * stiffness @ (points[:, 0] - 15.0) ** 2)
    assert np.radians(last(results, "tilt_ABOVE")) == pytest.approx(theta, rel=1e-3)
    # The side with the point of action goes down: a turn about +y.
    assert frame.tool_turns["ABOVE"][0, 2] > 0.0


def test_pins_share_the_force_and_a_guided_holder_stays_level():
    pins = [(11.0, 15.0, 1.0), (23.0, 15.0, 1.0)]
    two = form(stack({}, {"force": 1000.0, "tilts": True, "at": pins}), TIGHT, frames=1)
    one = form(stack({}, {"force": 1000.0, "tilts": True, "at": (17.0, 15.0, 1.0)}), TIGHT, frames=1)
    assert last(two, "tilt_ABOVE") == pytest.approx(last(one, "tilt_ABOVE"), rel=1e-6)
    guided = form(stack({}, {"force": 1000.0, "at": (17.0, 15.0, 1.0)}), TIGHT, frames=1)
    pressure = guided.frames[-1].point_fields["contact_pressure"]
    assert "tilt_ABOVE" not in guided.history
    assert pressure == pytest.approx(np.full(len(pressure), 1000.0 / 30.0**2), rel=1e-6)


def test_springs_at_pins_resist_tilt():
    # Four springs under a plate that a ball pushes down off its middle: M = F e = 4 (k / 4) a^2 theta.
    # The ball touches the sheet at the node below it alone; nodes at the left edge rest on the rising plate.
    k, a, e, depth = 400.0, 12.0, 5.0, 0.5
    pins = [(15.0 + sx * a, 15.0 + sy * a, 0.0) for sx in (-1, 1) for sy in (-1, 1)]
    scene = stack({"spring": Spring(k, 1.0), "tilts": True, "at": pins}, {"travel": -depth})
    ball = Tool("ABOVE", Ball((15.0 + e, 15.0, 21.0), 20.0), travel=-depth)
    stage = replace(scene.stages[0], tools=[scene.stages[0].tools[0], ball])
    results = form(replace(scene, stages=[stage]), frames=1)
    force = abs(last(results, "force_ABOVE"))
    theta = np.radians(last(results, "tilt_BELOW"))
    frame = results.frames[-1]
    resting = frame.point_fields["contact_pressure"] * current_areas(scene.blank.mesh.cells, frame.points)
    resting[np.argmax(resting)] = 0.0
    moment = (force - resting.sum()) * e + resting @ (frame.points[:, 0] - 15.0)
    assert theta == pytest.approx(moment / (k * a * a), rel=2e-3)
    assert force == pytest.approx(1.0 - k * last(results, "travel_BELOW"), rel=1e-6)


def rotated(scene, turned, shift):
    """A scene as a whole in another place. turned : (3, 3)"""
    mesh = scene.blank.mesh
    moved = type(mesh)(points=mesh.points @ turned.T + shift, cells=mesh.cells, groups=mesh.groups)
    blank = replace(scene.blank, mesh=moved, rolling=turned @ scene.blank.rolling)
    stages = []
    for stage in scene.stages:
        tools = []
        for tool in stage.tools:
            surface = tool.surface
            if isinstance(surface, Plane):
                there = Plane(turned @ surface.at + shift, turned @ surface.n)
            else:
                there = Ball(turned @ surface.centre + shift, surface.radius)
            at = None if tool.at is None else np.asarray(tool.at) @ turned.T + shift
            tools.append(replace(tool, surface=there, axis=turned @ tool.unit_axis, at=at))
        stages.append(replace(stage, tools=tools))
    return replace(scene, blank=blank, stages=stages)


def test_a_tilting_tool_does_not_care_where_the_scene_stands():
    # A holder off the middle, and a pull that its friction holds.
    scene = stack(
        {"friction": Coulomb(0.2)}, {"friction": Coulomb(0.2), "force": 4e4, "tilts": True, "at": (18.0, 14.0, 1.0)}
    )
    mesh = scene.blank.mesh
    mesh.groups["right"] = np.flatnonzero(mesh.points[:, 0] == 30.0)
    pull = np.array([3000.0, 500.0, 0.0])
    scene = replace(
        scene, blank=replace(scene.blank, fixed={}), stages=[replace(scene.stages[0], forces={"right": pull})]
    )
    turned = Rotation.from_euler("xyz", [0.3, -0.7, 1.1]).as_matrix()
    shift = np.array([20.0, -5.0, 7.0])
    other = rotated(scene, turned, shift)
    other = replace(other, stages=[replace(other.stages[0], forces={"right": turned @ pull})])
    method = Implicit(newton=Newton(residual=1e-9, correction=1e-9))
    first, second = (form(s, method, frames=1) for s in (scene, other))
    assert last(first, "tilt_ABOVE") > 1e-3
    assert last(second, "tilt_ABOVE") == pytest.approx(last(first, "tilt_ABOVE"), rel=1e-6)
    assert second.frames[-1].points == pytest.approx(first.frames[-1].points @ turned.T + shift, abs=1e-8)


def test_in_a_half_model_a_holder_tilts_about_the_normal_of_the_plane_only():
    mesh = square(6, 30.0)
    mesh.points[:, 2] = 0.5
    mesh.groups = {"all": mesh.groups["all"], "symmetry_y": mesh.groups["symmetry_y"]}
    blank = Blank(mesh, 1.0, ELASTIC, Membrane(), fixed={"all": "xy"})

    def half(at):
        holder = Tool("ABOVE", Plane((0, 0, 1.0), (0, 0, -1)), force=1000.0, tilts=True, at=at)
        return Scene(blank, [Stage([Tool("BELOW", Plane()), holder])])

    results = form(half((17.0, 0.0, 1.0)), TIGHT, frames=1)
    assert last(results, "force_ABOVE") == pytest.approx(1000.0, rel=1e-8)
    matrix = results.frames[-1].tool_turns["ABOVE"]
    assert matrix[1] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12) and matrix[0, 2] > 0.0
    with pytest.raises(SceneError, match="'ABOVE' at: found y = 3 mm, expected a point of action on the plane"):
        form(half((17.0, 3.0, 1.0)), TIGHT, frames=1)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Tool("A", Plane(), force=1.0, spring=Spring(1.0)), "found force and spring, expected at most one"),
        (lambda: Tool("A", Plane(), travel=1.0, tilts=True), "tool 'A' tilts: found beside no force or spring"),
        (lambda: Tool("A", Plane(), force=1.0, stop=-1.0), "tool 'A' stop: found -1.0, expected a number above 0"),
        (lambda: Tool("A", Plane(), force=1.0, at=(1.0, 2.0)), r"tool 'A' at: found \(1.0, 2.0\), expected a point"),
        (lambda: Tool("A", Plane(), spring=3.0), r"spring: found 3.0, expected Spring\(stiffness, preload\)"),
        (lambda: Spring(-1.0), "spring stiffness: found -1.0, expected N/mm above 0"),
        (
            lambda: Stage([Tool("A", Plane(), force=1.0, rides_on="B"), Tool("B", Plane())]),
            r"tool 'A' rides on 'B', expected a tool that travels in this stage, one of \[\]",
        ),
    ],
)
def test_what_makes_no_sense_is_one_line(make, message):
    with pytest.raises(SceneError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_quarter_model_cannot_tilt():
    scene = punch_stretch(size=5.0)
    holder = Tool("HOLDER", Plane((0, 0, 0.5), (0, 0, -1)), force=1.0, tilts=True)
    with pytest.raises(SceneError, match="'HOLDER' tilts: found symmetry planes x, y, which keep it straight"):
        form(replace(scene, stages=[Stage([holder])]))


def test_energies_balance_where_a_tool_tilts():
    scene = stack({"spring": Spring(900.0, 50.0), "tilts": True, "at": (13.0, 14.0, 0.0)}, {"travel": -1.0})
    ball = Tool("ABOVE", Ball((17.0, 16.0, 201.0), 200.0), Coulomb(0.2), travel=-1.0)
    results = form(replace(scene, stages=[Stage([scene.stages[0].tools[0], ball])]), frames=4)
    assert abs(results.energy["imbalance"]) < 0.02 * (50.0 * 1.0 + 0.5 * 900.0)
