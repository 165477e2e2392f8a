"""Tools that tilt in explicit runs: statics by hand and against the implicit solver, energy, a resumed run."""

from dataclasses import replace

import numpy as np
import pytest

from solver import (
    Blank,
    Coulomb,
    Explicit,
    Implicit,
    Material,
    Membrane,
    Scene,
    Shell,
    Spring,
    Stage,
    Tool,
    VonMises,
    form,
)
from solver.contact.drive import ToolRun, build_drive, pivot_of
from solver.contact.search import Neighbourhood
from solver.explicit.contact import ToolContact
from solver.explicit.laws import KINEMATIC, PENALTY, TOUCH
from solver.sheet import build_sheet
from solver.state import State, new_contact, new_sheet
from tests.solver.contact.test_drive import stack
from tests.solver.lattice import Ball, Plane, square
from tests.solver.resuming import interrupted

# A yield stress names the time of a stage. A sheet between two plates has no energy of its own to hold a run's balance
# against.
STEEL = Material(206000.0, 0.3, VonMises(), lambda ep: 200.0 + 0.0 * ep, "ideal")
SLOW = Explicit(waves=40.0, drift=1e3)
PINS = [(15.0 + sx * 12.0, 15.0 + sy * 12.0, 0.0) for sx in (-1, 1) for sy in (-1, 1)]


def under_a_ball(lower, friction=None, place=(20.0, 15.0), radius=20.0, depth=0.5):
    """The stack of test_drive with a ball instead of its upper plate."""
    scene = stack(lower, {"travel": -depth}, n=4)
    scene = replace(scene, blank=replace(scene.blank, material=STEEL, element=Shell(3)))
    ball = Tool("ABOVE", Ball((*place, 1.0 + radius), radius), friction, travel=-depth)
    return replace(scene, stages=[replace(scene.stages[0], tools=[scene.stages[0].tools[0], ball])])


def late(results, column, share=0.1):
    """Mean of a column over the last share of a run."""
    values = np.array(results.history[column])
    return values[-max(int(share * len(values)), 1) :].mean()


def test_springs_at_pins_resist_tilt_as_in_the_implicit_solver():
    scene = under_a_ball({"spring": Spring(400.0, 1.0), "tilts": True, "at": PINS})
    # Contact sets in over the skins, in one solver before tools touch and in the other after it: thin ones.
    thin = Implicit(skin=3e-4)
    explicit, implicit = (
        form(scene, method, frames=2) for method in (replace(SLOW, waves=60.0, springback=thin), thin)
    )
    assert implicit.history["tilt_BELOW"][-1] > 0.1
    # The pad swings a little on its springs: means over half the stroke.
    strokes = np.linspace(0.2, 0.5, 61)
    for column in ("tilt_BELOW", "travel_BELOW", "force_ABOVE"):
        means = [np.interp(strokes, r.history["stroke"], r.history[column]).mean() for r in (explicit, implicit)]
        assert means[0] == pytest.approx(means[1], rel=0.02)
        each = [np.interp(strokes, r.history["stroke"], r.history[column]) for r in (explicit, implicit)]
        if column != "force_ABOVE":
            assert each[0] == pytest.approx(each[1], rel=0.06)


def free_plate(law, parameter, at, force=200.0):
    """A plate that may tilt on a lattice, as a ToolContact, with the sheet's masses and places."""
    mesh = square(4, 30.0)
    mesh.points[:, 2] = 0.5
    mesh.groups = {"all": mesh.groups["all"]}
    sheet = build_sheet(Blank(mesh, 1.0, STEEL, Membrane()))
    n = len(sheet.points)
    state = State(new_sheet(sheet.points, 0, len(sheet.elements.point_volume)), {"PLATE": new_contact(n)})
    tool = Tool("PLATE", Plane((0, 0, 1.0), (0, 0, -1)), force=force, tilts=True, at=at)
    drive = build_drive(tool, sheet, np.ones(n), None)
    run = ToolRun(
        tool, tool.unit_axis, 0.0, -1.0, drive, None, None, Neighbourhood(tool.surface, n), pivot=pivot_of(tool, sheet)
    )
    mass = 1e-8 * sheet.area
    contact = ToolContact(run, state.tools["PLATE"], (law, parameter), mass, np.ones((n, 3)), sheet.points, 4.0)
    return contact, mass, sheet


def test_a_free_plate_turns_as_a_rigid_body_of_four_times_the_sheets_mass():
    """A load beside the middle: travel and turn of the pivot by hand, and its work is the plate's kinetic energy."""
    at = np.array([18.0, 13.0, 1.0])
    contact, mass, sheet = free_plate(KINEMATIC, 0.0, at)
    dt, steps, force = 1e-7, 200, np.array([200.0, 0.0, 0.0])
    for _ in range(steps):
        contact.be_driven(-force, dt, dt)
    time = steps * dt
    # The mass of all points, turning about the pivot: M = 4 sum m v v for velocities z, a x r and b x r.
    r = sheet.points - at
    v = np.stack([np.tile([0.0, 0.0, 1.0], (len(r), 1)), np.cross([1.0, 0.0, 0.0], r), np.cross([0.0, 1.0, 0.0], r)])
    m = 4.0 * np.einsum("n,inc,jnc->ij", mass, v, v)
    wanted = np.linalg.solve(m, [-200.0 * time, 0.0, 0.0])  # velocity along z, spin about x and y
    assert contact.velocity == pytest.approx(wanted[0], rel=1e-3)
    assert contact.w[1] == pytest.approx([wanted[1], wanted[2], 0.0], rel=1e-3, abs=1e-9 * np.abs(wanted).max())
    work = -200.0 * contact.contact.travel[0]
    kinetic = 0.5 * wanted @ m @ wanted
    assert work == pytest.approx(kinetic, rel=0.01)


@pytest.mark.parametrize("law", [KINEMATIC, TOUCH, PENALTY])
def test_a_turning_plate_pushes_where_it_goes_and_feels_the_moment(law):
    """A plate that turns meets nodes at rest: they leave with its velocity there, and its impulse is theirs."""
    contact, mass, sheet = free_plate(law, {KINEMATIC: 0.0, TOUCH: 0.0, PENALTY: 1e11}[law], (15.0, 15.0, 1.0))
    dt, n = 1e-6, len(sheet.points)
    contact.rates[:] = -3.0, 40.0, 90.0
    contact.be_driven(np.zeros(3), dt, dt)
    u, v, u_new, v_new = sheet.points.copy(), np.zeros((n, 3)), sheet.points.copy(), np.zeros((n, 3))
    half = np.full(n, 0.5)
    if law == PENALTY:  # looks at the step's start
        contact.meet(u, v, half, dt, dt, u_new, v_new)
        contact.be_driven(np.zeros(3), dt, dt)
    contact.meet(u, v, half, dt, dt, u_new, v_new)
    sums = dict.fromkeys(("external", "contact", "friction"), 0.0)
    contact.work(v, v_new, u_new, dt, sums)
    touched = contact.contact.status > 0
    assert 0 < touched.sum() < n
    there = contact.w[0] + np.cross(contact.w[1], sheet.points - contact.w[2])
    assert (there[touched, 2] < 0.0).all()
    if law != PENALTY:
        assert v_new[touched, 2] == pytest.approx(there[touched, 2], rel=1e-4)
    push = mass[:, None] * (v_new - v) / dt
    arm = u_new - contact.w[2]
    moment = np.cross(arm, push).sum(axis=0)
    drive = contact.run.drive
    assert contact.reaction[0] == pytest.approx(-push[:, 2].sum(), rel=1e-9)
    assert contact.reaction[1:] == pytest.approx(-drive.axes @ moment / drive.lever, rel=1e-4)
    # What the tool gives is what the nodes get and the contact loses.
    kinetic = 0.5 * float(mass @ np.sum(v_new**2, axis=1))
    assert sums["external"] == pytest.approx(kinetic + sums["contact"], rel=1e-9)


def test_energies_balance_where_a_tool_tilts():
    scene = under_a_ball(
        {"spring": Spring(900.0, 50.0), "tilts": True, "at": (13.0, 14.0, 0.0)}, Coulomb(0.2), (17.0, 16.0), 200.0, 1.0
    )
    results = form(scene, SLOW, frames=2)
    given = late(results, "force_ABOVE") * 1.0
    assert abs(results.energy["imbalance"]) < 0.02 * abs(given)
    assert results.history["tilt_BELOW"][-1] > 0.01


def test_in_a_half_model_a_holder_tilts_about_the_normal_of_the_plane_only():
    mesh = square(4, 30.0)
    mesh.points[:, 2] = 0.5
    mesh.groups = {"all": mesh.groups["all"], "symmetry_y": mesh.groups["symmetry_y"]}
    blank = Blank(mesh, 1.0, STEEL, Shell(3), fixed={"all": "xy"})
    pins = [(3.0, 0.0, 0.0), (27.0, 0.0, 0.0)]
    pad = Tool("BELOW", Plane(), spring=Spring(800.0, 1.0), tilts=True, at=pins)
    ball = Tool("ABOVE", Ball((20.0, 0.0, 21.0), 20.0), travel=-0.5)
    results = form(Scene(blank, [Stage([pad, ball])]), SLOW, frames=1)
    matrix = results.frames[-1].tool_turns["BELOW"]
    assert matrix[1] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12) and abs(matrix[0, 2]) > 1e-3


def test_a_tilting_run_resumes_with_its_spin(tmp_path):
    scene = under_a_ball({"spring": Spring(400.0, 1.0), "tilts": True, "at": PINS})
    method = Explicit(waves=20.0, drift=1e3)
    whole = form(scene, method, frames=2)

    rest = interrupted(scene, method, tmp_path / "pad.pvd", 2, lambda progress: progress.stroke > 0.3)
    assert rest.finished
    # The same run, to round-off: projections start from other seeds. A pad that swings makes 1e-16 into 1e-4.
    assert rest.history["iterations"] == whole.history["iterations"]
    soon = np.array(whole.history["stroke"]) < 0.35
    for column in ("tilt_BELOW", "travel_BELOW", "force_ABOVE"):
        one, other = (np.array(r.history[column]) for r in (rest, whole))
        assert one[soon] == pytest.approx(other[soon], rel=1e-9, abs=1e-9 * np.abs(other).max())
        assert one[-1] == pytest.approx(other[-1], rel=0.01)
