"""Whole runs of form(scene, Explicit()): against the implicit solver, with tools driven by forces, stopped, resumed."""

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numba
import numpy as np
import pytest

from solver import (
    Blank,
    Coulomb,
    Explicit,
    Implicit,
    Kinematic,
    Membrane,
    Penalty,
    Scene,
    SceneError,
    Shell,
    Stage,
    StepFailed,
    Tool,
    Touch,
    form,
)
from solver.explicit import stable_step
from tests.solver.lattice import Bar, Plane, square
from tests.solver.resuming import interrupt
from tests.solver.test_form import STEEL, punch_stretch
from tests.solver.test_springback import strip


def filtered(results, column, strokes, window):
    """A column averaged over a window of the stroke [mm]."""
    found = []
    for stroke in strokes:
        at = np.linspace(stroke - 0.5 * window, stroke + 0.5 * window, 21)
        found.append(np.interp(at, results.history["stroke"], results.history[column]).mean())
    return np.array(found)


def test_punch_stretch_agrees_with_the_implicit_solver():
    explicit, implicit = (form(punch_stretch(), method, frames=5) for method in (Explicit(), Implicit()))
    strokes = np.array([1.5, 2.5, 3.5, 4.5])
    forces = [filtered(r, "force_BALL", strokes, 0.5) for r in (explicit, implicit)]
    assert forces[0] == pytest.approx(forces[1], abs=0.02 * forces[1].max())
    thickness = [r.frames[-1].cell_fields["thickness"] for r in (explicit, implicit)]
    assert thickness[0] == pytest.approx(thickness[1], rel=2e-3)
    # Friction sets in at once here; there its elastic stick comes first.
    for name, tolerance in (("internal", 0.01), ("friction", 0.03)):
        assert explicit.energy[name] == pytest.approx(implicit.energy[name], rel=tolerance)
    assert abs(explicit.energy["imbalance"]) < 1e-3 * explicit.energy["external"]
    assert explicit.history["kinetic_share"][-1] < 1e-3


@pytest.mark.parametrize("contact", [Touch(0.0), Touch(1.0), Penalty()])
def test_the_other_contact_laws_agree_with_the_kinematic_one(contact):
    scene = punch_stretch(size=4.0, travel=3.0)
    kinematic, other = (form(scene, Explicit(contact=law, waves=8.0), frames=2) for law in (Kinematic(), contact))
    thickness = [r.frames[-1].cell_fields["thickness"] for r in (other, kinematic)]
    assert thickness[0] == pytest.approx(thickness[1], rel=5e-3)
    assert other.energy["internal"] == pytest.approx(kinematic.energy["internal"], rel=0.02)
    assert abs(other.energy["imbalance"]) < 0.01 * other.energy["external"]


def test_a_strip_between_die_and_holder_is_pulled_by_twice_its_friction():
    # seed section 5: F_H = 2 mu F_B
    mesh = square(10, 1.0)
    mesh.points *= [50.0, 10.0, 1.0]
    mesh.groups = {"right": mesh.groups["right"], "all": mesh.groups["all"]}
    blank = Blank(mesh, 1.0, STEEL, Membrane(), fixed={"all": "y"})
    oil = Coulomb(0.1)
    die = Tool("DIE", Plane((0.0, 0.0, -0.5), (0.0, 0.0, 1.0)), oil)
    holder = Tool("HOLDER", Plane((0.0, 0.0, 0.5), (0.0, 0.0, -1.0)), oil, force=5000.0)
    results = form(Scene(blank, [Stage([die, holder], moved={"right": (3.0, None, None)})]), Explicit(), frames=2)
    stroke = np.array(results.history["stroke"])
    late = (stroke > 0.5) & (stroke < 0.95)
    assert np.array(results.history["force_HOLDER"])[late] == pytest.approx(5000.0, rel=0.02)
    pulled = np.array(results.history["reaction_right_x"])[late].mean()
    assert pulled == pytest.approx(2.0 * 0.1 * 5000.0, rel=0.02)
    assert results.energy["friction"] == pytest.approx(1000.0 * 3.0, rel=0.03)


def test_one_and_two_threads_give_the_same_bits():
    before = numba.get_num_threads()
    try:
        points = []
        for n_threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
            numba.set_num_threads(n_threads)
            points.append(form(punch_stretch(size=4.0, travel=3.0), Explicit(waves=3.0), frames=2).frames[-1].points)
    finally:
        numba.set_num_threads(before)
    assert np.array_equal(*points)


def test_a_run_resumes_from_its_checkpoint(tmp_path):
    scene, method = punch_stretch(size=4.0, travel=3.0), Explicit(waves=6.0)
    whole = form(scene, method, frames=4)

    writer = tmp_path / "cup.pvd"
    interrupt(scene, method, writer, 4, lambda progress: progress.stroke > 1.6)
    with pytest.raises(SceneError, match="expected the same method"):
        form(scene, Implicit(), save=writer, frames=4, resume=True)
    rest = form(scene, method, save=writer, frames=4, resume=True)
    assert rest.finished
    assert rest.history["stroke"][-1] == pytest.approx(3.0)
    assert rest.frames[-1].points == pytest.approx(whole.frames[-1].points, abs=2e-3)
    assert rest.energy["internal"] == pytest.approx(whole.energy["internal"], rel=2e-3)


@pytest.mark.parametrize("stable_looks", [0, 4])
def test_an_unstable_run_stops_in_one_line_with_its_last_state(tmp_path, monkeypatch, stable_looks):
    """Steps too long from the first one on, and from some look at the stable step on."""
    scene, method = punch_stretch(size=4.0, travel=3.0), Explicit(waves=12.0)
    looks, limit = [], stable_step.StableStep.limit

    def too_long(self, state):
        looks.append(limit(self, state))
        # A stage's first two looks are the sheet's with its supports and without them.
        return (2.0 if len(looks) > stable_looks else 1.0) * looks[-1]

    with monkeypatch.context() as patched:
        patched.setattr(stable_step.StableStep, "limit", too_long)
        with pytest.raises(StepFailed, match="lower safety below") as failure:
            form(scene, method, save=tmp_path / "cup.pvd", frames=4)
    assert "\n" not in str(failure.value)
    results = failure.value.results
    assert bool(results.history) == (stable_looks > 0)
    last = results.frames[-1].points
    assert np.isfinite(last).all()
    with h5py.File(tmp_path / "checkpoint.h5") as file:
        assert np.array_equal(file["sheet/u"][: len(last)], last)
    # What was saved is good: with steps that are stable the run goes on from there to its end.
    if not stable_looks:
        rest = form(scene, method, save=tmp_path / "cup.pvd", frames=4, resume=True)
        whole = form(scene, method, frames=4)
        assert np.array_equal(rest.frames[-1].points, whole.frames[-1].points)
    else:
        reached = results.history["stroke"][-1]
        assert 0.0 < reached < 3.0
        rest = form(scene, replace(method, drift=0.5), save=tmp_path / "cup.pvd", frames=4, resume=True)
        assert rest.history["stroke"][: len(results.history["stroke"])] == results.history["stroke"]
    assert rest.finished and rest.history["stroke"][-1] == pytest.approx(3.0)
    assert np.isfinite(rest.frames[-1].points).all()


@pytest.mark.slow
def test_springback_runs_implicitly_after_explicit_forming():
    blank = Blank(strip(20.0, 4.0, 10), 1.0, STEEL, Shell(9), fixed={"all": "y"})
    tools = [
        Tool("PUNCH", Bar((0.0, 0.0, 6.0), 5.0), Coulomb(0.1), travel=-6.0),
        Tool("POST", Bar((14.0, 0.0, -4.5), 4.0), Coulomb(0.1)),
    ]
    scene = Scene(blank, [Stage(tools), Stage(name="springback")])
    found = [form(scene, method, frames=3) for method in (Explicit(), Implicit())]
    opened = [np.ptp(r.frames[3].points[:, 2]) - np.ptp(r.frames[-1].points[:, 2]) for r in found]
    assert abs(opened[1]) > 0.1  # mm: there is springback to compare
    assert opened[0] == pytest.approx(opened[1], rel=0.05)
    assert found[0].history["force_PUNCH"][-1] == 0.0
    assert np.abs(found[0].frames[-1].points - found[1].frames[-1].points).max() < 0.05


def test_explicit_goes_on_from_an_implicit_state():
    """Two stages, the first one implicit: the sheet's state is handed over as it is."""

    class First(SimpleNamespace):
        """Implicit in the stage called first, explicit after it."""

        def describe(self):
            return "mixed"

        def of(self, stage):
            return Implicit() if stage.name == "first" else Explicit()

    near = punch_stretch(size=4.0, travel=2.0)
    punch = near.stages[0].tools[0]
    scene = Scene(near.blank, [Stage([punch], name="first"), Stage([punch], name="second")])
    mixed, implicit = form(scene, First(), frames=2), form(scene, Implicit(), frames=2)
    assert mixed.frames[-1].cell_fields["thickness"] == pytest.approx(
        implicit.frames[-1].cell_fields["thickness"], rel=3e-3
    )
    assert mixed.energy["internal"] == pytest.approx(implicit.energy["internal"], rel=0.02)
