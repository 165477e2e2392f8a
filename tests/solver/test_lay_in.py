"""A part that has sprung back is struck again: where it is laid, how the press closes on it, what cannot be done."""

from dataclasses import replace

import numpy as np
import pytest

from solver import Blank, Coulomb, Explicit, Implicit, Scene, SceneError, Shell, Stage, StepFailed, Tool, form
from solver.lay_in import lift_out
from tests.solver.lattice import Bar, Corner, Plane
from tests.solver.resuming import interrupted
from tests.solver.strips import flat_strip
from tests.solver.test_form import STEEL, punch_stretch

OIL = Coulomb(0.1)
PUNCH = Tool("PUNCH", Corner((10.0, 0.5), 4.0, (-1, 1)), OIL, travel=-12.0)
DIE = Tool("DIE", Corner((11.1, -0.5), 5.0, (1, -1)), OIL)
BASE = Tool("BASE", Plane((0.0, 0.0, -12.55)), OIL)
HOME = replace(PUNCH, travel=None, to=-12.03)  # leaves the sheet on the base 1.02 mm


def bent(*stages, n=24):
    """Half a U, one element wide: bent freely over the die's edge, sprung back, and what comes then."""
    mesh = flat_strip(24.0, 2.0, n)
    mesh.groups["symmetry_x"] = mesh.groups["back"]
    blank = Blank(mesh, 1.0, STEEL, Shell(7), fixed={"all": "y"})
    return Scene(blank, [Stage([PUNCH, DIE], name="bend"), Stage(name="springback"), *stages])


def overlap(tool, points):
    return float(np.max(0.5 - tool.surface.project(points).distance))


@pytest.mark.parametrize("method", [Implicit(), pytest.param(Explicit(), marks=pytest.mark.slow)])
def test_a_sprung_part_is_struck_again(method):
    results = form(bent(Stage([HOME, DIE, BASE], name="restrike"), Stage(name="let go")), method, frames=1)
    # Frames are start and end of each stage.
    bend, sprung, laid, struck, free = (results.frames[k].points for k in (1, 3, 4, 5, 7))
    assert [frame.stage for frame in results.frames[3:6]] == ["springback", "restrike", "restrike"]
    # It did not fit into the die any more, and lies on its edge as it came out of it.
    assert overlap(DIE, sprung) > 0.2
    assert laid - sprung == pytest.approx((laid - sprung)[0] * np.ones((len(laid), 1)), abs=1e-12)
    assert (laid - sprung)[0, :2] == pytest.approx([0.0, 0.0]) and laid[0, 2] - sprung[0, 2] > 1.0
    # What is left is by how much bending has thinned it.
    assert overlap(DIE, laid) == pytest.approx(0.0, abs=1e-3) and overlap(BASE, laid) < 0.0
    (told,) = [note for note in results.notes if "was lifted" in note]
    assert told.startswith("stage 'restrike': the part overlapped DIE, BASE by up to")
    # Struck, its bottom lies between base and punch, its wall between the tools.
    assert results.history["travel_PUNCH"][-1] == pytest.approx(-12.03, abs=1e-12)
    assert max(overlap(tool, struck) for tool in (DIE, BASE)) < 0.01
    bottom = struck[:, 0] < 5.0
    assert struck[bottom, 2] == pytest.approx(-12.04, abs=0.02)
    assert results.finished and abs(results.energy["imbalance"]) < 0.01 * results.energy["external"]
    # A second strike leaves less to spring back.
    opened = [after[-1, 0] - before[-1, 0] for before, after in ((bend, sprung), (struck, free))]
    assert abs(opened[1]) <= abs(opened[0])


def test_a_run_resumes_in_a_restrike(tmp_path):
    scene = bent(Stage([HOME, DIE, BASE], name="restrike"), n=12)
    whole = form(scene, frames=4)
    rest = interrupted(
        scene, None, tmp_path / "u.pvd", 4, lambda progress: progress.stage == "restrike" and progress.stroke > 14.0
    )
    assert rest.history["stroke"][-1] == pytest.approx(whole.history["stroke"][-1], abs=1e-9)
    # Stroke and travel go on together: one is the other from the restrike's start on.
    struck = np.array(rest.history["stage"]) == "restrike"
    run = np.array(rest.history["stroke"])[struck] + np.array(rest.history["travel_PUNCH"])[struck]
    assert run == pytest.approx(run[-1] * np.ones(struck.sum()), abs=1e-9)
    assert rest.frames[-1].points == pytest.approx(whole.frames[-1].points, abs=1e-3)


def test_a_stage_that_cannot_begin_keeps_what_was_formed(tmp_path):
    lid = Tool("LID", Plane((0.0, 0.0, 4.0), (0.0, 0.0, -1.0)))
    scene = bent(Stage([HOME, DIE, BASE, lid], name="restrike"), n=12)
    line = "stage 'restrike', tool 'BASE': overlaps the formed part by .* 'LID' is in the way of lifting it"
    with pytest.raises(StepFailed, match=line) as failure:
        form(scene, save=tmp_path / "u.pvd", frames=1)
    assert "\n" not in str(failure.value)
    results = failure.value.results
    assert not results.finished and results.history["stage"][-1] == "springback"
    # The last good state is the sprung part; from it the run comes to the same line.
    assert overlap(DIE, results.frames[-1].points) > 0.2
    with pytest.raises(StepFailed, match=line):
        form(scene, save=tmp_path / "u.pvd", frames=1, resume=True)


# A wall of 10 degrees, of nodes as dense as a line: lifted by one millimetre it is farther from the bar by sin 10.
LEAN = np.radians(10.0)
ALONG = np.array([np.sin(LEAN), 0.0, np.cos(LEAN)])
WALL = np.linspace(0.0, 20.0, 20001)[:, None] * ALONG - [0.0, 0.0, 15.0]
HALF = np.full(len(WALL), 0.5)
FREE = np.zeros(WALL.shape, dtype=bool)


def bar(depth):
    """A bar of radius 3 that the wall's lower half overlaps by a depth."""
    normal = np.array([np.cos(LEAN), 0.0, -np.sin(LEAN)])
    return Tool("POST", Bar(WALL[10000] + (3.0 + 0.5 - depth) * normal, 3.0))


@pytest.mark.parametrize("depth", [0.2, 0.7])
def test_a_wall_is_lifted_by_its_overlap_over_the_sine_of_its_lean(depth):
    stage = Stage([bar(depth), Tool("PUNCH", Plane((0.0, 0.0, 50.0), (0.0, 0.0, -1.0)), travel=-1.0)])
    shift, told = lift_out(stage, WALL, HALF, FREE)
    assert shift == pytest.approx([0.0, 0.0, depth / np.sin(LEAN)], abs=1e-5)
    assert f"overlapped POST by up to {depth:.3g} mm" in told
    # Pressed from the other side it goes the other way: no way out, but through the bar.
    upward = Stage([bar(depth), Tool("PUNCH", Plane((0.0, 0.0, -50.0)), travel=1.0)])
    with pytest.raises(SceneError, match="tool 'POST' is in the way of lifting it along"):
        lift_out(upward, WALL, HALF, FREE)


def test_what_fits_is_not_lifted():
    stage = Stage([bar(0.05), Tool("PUNCH", Plane((0.0, 0.0, 50.0), (0.0, 0.0, -1.0)), travel=-1.0)])
    shift, told = lift_out(stage, WALL, HALF, FREE)
    assert not shift.any() and told == ""


def test_gravity_lays_a_part_on_a_fixture():
    shift, _ = lift_out(Stage([bar(0.2)], gravity=(0.0, 0.0, -9810.0)), WALL, HALF, FREE)
    assert shift == pytest.approx([0.0, 0.0, 0.2 / np.sin(LEAN)], abs=1e-5)


def test_what_cannot_be_lifted_is_told_with_its_stage_and_tool():
    punch = Tool("PUNCH", Plane((0.0, 0.0, 50.0), (0.0, 0.0, -1.0)), force=100.0)
    pressed, alone = Stage([bar(0.2), punch], name="strike"), Stage([bar(0.2)], name="strike")
    start = "stage 'strike', tool 'POST': overlaps the formed part by 0.2 mm, and "
    held = FREE.copy()
    held[0, 2] = True
    for stage, supports, touching, line in (
        (alone, FREE, (), "nothing presses the part into it"),
        (pressed, held, (), "the blank's supports hold the part along"),
        (pressed, FREE, ("PUNCH",), "tool 'PUNCH' still holds the part, expected a springback stage before"),
    ):
        with pytest.raises(SceneError, match=start + line):
            lift_out(stage, WALL, HALF, supports, touching)


def test_a_slight_overlap_is_no_blow_to_an_explicit_sheet():
    # A clamped disc lies 0.05 mm deep in a plate: 1e-4 of stretch at its rim, but put back in one step it would fly.
    scene = punch_stretch(size=4.0)
    stage = Stage([Tool("PLATE", Plane((0.0, 0.0, -0.45)))])
    last = form(replace(scene, stages=[stage]), Explicit(waves=4.0), frames=1).frames[-1]
    inside = np.linalg.norm(scene.blank.mesh.points, axis=1) < 15.0
    # Nothing holds it down: it swings on.
    assert last.points[inside, 2] == pytest.approx(0.055, abs=0.0051)
    assert last.cell_fields["plastic_strain"].max() == 0.0
