"""Metal between two tools, pressed beyond its flow stress, in both solvers."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from solver import (
    Blank,
    Coulomb,
    CoulombPressure,
    Explicit,
    Implicit,
    Increments,
    Material,
    Membrane,
    Penalty,
    PlanarHill,
    Scene,
    Shell,
    Stage,
    Swift,
    Tool,
    form,
)
from tests.solver.lattice import Ball, Plane, square
from tests.solver.resuming import interrupted

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589))
THIN = 3e-4  # skin, a tenth of the default: closed forms know nothing of it
FINE = Implicit(increments=Increments(first=1e-3, largest=1e-3), skin=THIN)
EXPLICIT = Explicit(springback=FINE)
STIFFNESS = 0.5 * FINE.penalty * STEEL.young * 1.0 / 2.5**2  # of the whole thickness, 1 mm, on a mesh of 2.5 [MPa/mm]
SKIN = 2.0 * THIN  # of both sides [mm]: the explicit solver's contact sets in over it once tools touch, not before


def sheet(n=8, length=20.0, element=None):
    """Held in its plane: what tools press out of it goes nowhere."""
    mesh = square(n, length)
    mesh.groups = {"all": np.arange(len(mesh.points))}
    return Blank(mesh, 1.0, STEEL, element or Membrane(), fixed={"all": "xy"})


def borne(squeeze):
    """Pressure [MPa] of a sheet 1 mm thick that is pressed thinner by squeeze (n,) [mm], for good and elastically."""
    given = np.linspace(0.0, 0.1, 20001)
    pressure = np.sqrt(0.5 * (1.0 + STEEL.locus.r)) * STEEL.hardening(given)
    flowing = np.interp(squeeze, given + pressure / STIFFNESS, pressure)
    return np.minimum(np.maximum(STIFFNESS * squeeze, 0.0), flowing)


def test_a_pressed_sheet_bears_its_flow_stress_and_stays_as_thin_as_it_was_pressed():
    deep = 0.03
    die, top = Tool("DIE", Plane((0.0, 0.0, -0.5))), Plane((0.0, 0.0, 0.5), (0, 0, -1))
    punch = Tool("PUNCH", top, axis=(0, 0, -1), travel=deep)
    feeler = Tool("FEELER", top, axis=(0, 0, -1), force=10.0)
    results = form(Scene(sheet(), [Stage([die, punch], name="press"), Stage([die, feeler], name="feel")]), FINE)
    history = {name: np.array(values) for name, values in results.history.items()}
    pressing = history["stage"] == "press"
    way, pressure = history["travel_PUNCH"][pressing], np.abs(history["force_PUNCH"][pressing]) / 400.0
    assert len(way) > 20
    # Contact sets in over its skin.
    flows = way > 0.01
    assert pressure[flows] == pytest.approx(borne(way[flows]), rel=0.01)
    # What is elastic comes back: a tool that hardly presses finds the rest.
    left = deep - borne(np.array([deep]))[0] / STIFFNESS
    assert history["travel_FEELER"][-1] == pytest.approx(left, abs=SKIN)
    assert history["squeeze_max"][-1] == pytest.approx(left, abs=SKIN)


@pytest.mark.parametrize("element", [Membrane(), Shell(5)], ids=["membrane", "shell"])
@pytest.mark.parametrize("method", [FINE, EXPLICIT], ids=["implicit", "explicit"])
def test_what_rests_on_one_node_sinks_until_others_bear_with_it(method, element):
    """A ball of 500 mm pressed into a sheet on a plane, node by node."""
    blank, radius, deep = sheet(element=element), 500.0, 0.03
    middle = np.array([10.0, 10.0])
    die = Tool("DIE", Plane((0.0, 0.0, -0.5)))
    ball = Tool("BALL", Ball((*middle, 0.5 + radius), radius), axis=(0, 0, -1), travel=deep)
    results = form(Scene(blank, [Stage([die, ball])]), method, frames=2)
    sag = np.sum((blank.mesh.points[:, :2] - middle) ** 2, axis=1) / (2.0 * radius)
    fields = results.frames[-1].point_fields
    expected = borne(deep - sag - (SKIN if method is EXPLICIT else 0.0))
    found = fields["contact_pressure"]
    flows = deep - sag > 0.004
    assert flows.sum() == 13
    # The tools leave no other room to what they pinch.
    assert fields["squeeze"][flows] == pytest.approx((deep - sag)[flows], abs=2e-4)
    assert found[flows] == pytest.approx(expected[flows], rel=0.03 if method is FINE else 0.05)
    # Those next to them feel the skin over which contact sets in, and those of a shell its bending.
    assert (found[~flows] < 0.25 * expected.max()).all()
    assert found[sag > deep + 0.006] == pytest.approx(0.0, abs=1e-4 * expected.max())


class Mixed(SimpleNamespace):
    """A method for either stage."""

    def describe(self):
        return "mixed"

    def of(self, stage):
        return getattr(self, stage.name)


BORNE = 300.0  # MPa, well beyond first yield
SQUEEZE = np.interp(BORNE, borne(np.linspace(0.0, 0.1, 10001)), np.linspace(0.0, 0.1, 10001))  # under it [mm]


def pressed(first, second, frames=2):
    """A holder's load, borne at once in a stage that does nothing else, and held in another. Results"""
    die = Tool("DIE", Plane((0.0, 0.0, -0.5)))
    holder = Tool("HOLDER", Plane((0.0, 0.0, 0.5), (0, 0, -1)), axis=(0, 0, -1), force=BORNE * 400.0)
    stages = [Stage([die, holder], name=name) for name in ("press", "hold")]
    return form(Scene(sheet(), stages), Mixed(press=first, hold=second), frames=frames)


@pytest.mark.parametrize("second", [Implicit(skin=THIN), EXPLICIT], ids=["implicit", "explicit"])
@pytest.mark.parametrize("first", [Implicit(skin=THIN), EXPLICIT], ids=["implicit", "explicit"])
def test_a_holder_presses_a_sheet_as_thin_whichever_solver_forms_and_goes_on(first, second):
    history = {name: np.array(values) for name, values in pressed(first, second).history.items()}
    held, way = history["stage"] == "hold", history["travel_HOLDER"]
    assert way[-1] == pytest.approx(SQUEEZE + (SKIN if second is EXPLICIT else 0.0), rel=0.015)
    assert history["squeeze_max"][-1] == pytest.approx(way[-1], rel=1e-3)
    # It goes on from where it was: a solver that pressed too little presses on, nothing springs back.
    assert way[~held][-1] == pytest.approx(SQUEEZE, rel=0.1 if first is EXPLICIT else 0.005)
    assert np.abs(np.diff(way[held])).max() < 0.05 * SQUEEZE
    assert (way[held] > way[~held][-1] - 1.1 * SKIN).all()


@pytest.mark.parametrize("frames", [2, 300])
def test_stops_of_an_explicit_run_do_not_press_its_sheet_thinner(frames):
    """They cut steps short, and a short step is a stiff contact."""
    assert pressed(EXPLICIT, EXPLICIT, frames).history["travel_HOLDER"][-1] == pytest.approx(SQUEEZE + SKIN, rel=0.015)


def test_metal_flows_under_a_penalty_too():
    contact = Penalty()
    method = replace(EXPLICIT, contact=contact)
    results = pressed(method, method)
    step = float(re.search(r"steps of (\S+) s", results.notes[0])[1])
    # A soft one gives by more than the sheet would.
    spring = 0.5 * contact.stiffness * STEEL.density / step**2
    assert spring < STIFFNESS
    for_good = SQUEEZE - BORNE / STIFFNESS
    assert results.history["travel_HOLDER"][-1] == pytest.approx(for_good + BORNE / spring, rel=0.01)


@pytest.mark.parametrize(
    "method, oil",
    # Friction that asks for the nodes' areas. (An implicit run resumed with it takes other increments.)
    [(FINE, None), (FINE, Coulomb(0.1)), (EXPLICIT, None), (EXPLICIT, CoulombPressure(0.1, 50.0, 0.9))],
    ids=["implicit", "implicit, friction", "explicit", "explicit, friction by pressure"],
)
def test_a_run_that_resumes_knows_how_far_its_sheet_was_flattened(method, oil, tmp_path):
    die = Tool("DIE", Plane((0.0, 0.0, -0.5)), oil)
    ball = Tool("BALL", Ball((10.0, 10.0, 500.5), 500.0), oil, axis=(0, 0, -1), travel=0.03)
    mesh = square(8, 20.0)
    mesh.groups = {"all": np.arange(len(mesh.points)), "edge": np.flatnonzero(mesh.points[:, 0] == 0.0)}
    blank = Blank(mesh, 1.0, STEEL, Membrane(), fixed={"all": "y"})
    scene = Scene(blank, [Stage([die, ball], moved={"edge": (-0.1, None, None)})])
    whole = form(scene, method, frames=4)
    rest = interrupted(scene, method, tmp_path / "run.pvd", 4, lambda progress: progress.stroke > 0.02)
    for name in ("squeeze", "contact_pressure"):
        ends = [results.frames[-1].point_fields[name] for results in (rest, whole)]
        assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-7 * ends[1].max())
    assert whole.frames[-1].point_fields["squeeze"].max() > 0.02
