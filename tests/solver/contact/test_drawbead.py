"""Drawbeads: strips pulled through them against statics by hand, on any mesh; their forces from their shape."""

from dataclasses import replace
from math import atan2, cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver import (
    Blank,
    Coulomb,
    Drawbead,
    Explicit,
    Hill48,
    Implicit,
    Ludwik,
    Material,
    Membrane,
    PlanarHill,
    RoundBead,
    Scene,
    SceneError,
    Shell,
    Stage,
    Swift,
    Tool,
    Voce,
    VonMises,
    form,
)
from solver.contact.drawbead import locate
from tests.solver.contact.test_drive import TIGHT, rotated
from tests.solver.implicit.test_equilibrium import check_tangent, pressed_sheet
from tests.solver.lattice import Plane, square
from tests.solver.resuming import interrupted
from tests.solver.strips import ELASTIC, pressed_strip

STEEL = Material(206000.0, 0.3, VonMises(), Swift(565.32, 0.007117, 0.2589))
ACROSS = [(22.3, -1.0, 0.0), (22.3, 11.0, 0.0)]  # the strip is 10 mm wide


def free_strip(distort=0.0, n=8, order=None, element=None, **stage):
    """A square of 40 mm on no tools, in its plane, pulled by its right side."""
    mesh = square(n, 40.0, distort=distort, seed=4)
    mesh.groups = {key: mesh.groups[key] for key in ("right", "all")}
    if order is not None:
        place = np.argsort(order)
        mesh.points, mesh.cells = mesh.points[order], place[mesh.cells][::-1]
        mesh.groups = {key: place[nodes] for key, nodes in mesh.groups.items()}
    blank = Blank(mesh, 1.0, ELASTIC, element or Membrane(), fixed={"all": "z"})
    return Scene(blank, [Stage(moved={"right": (0.8, 0.0, None)}, **stage)])


def pull(scene, method=None):
    results = form(scene, method or Implicit(), frames=2)
    assert results.finished
    return results


@pytest.mark.parametrize("distort", [0.0, 0.35])
@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
def test_a_bead_holds_its_restraint_times_its_length_on_any_mesh(distort, element):
    # Straight across: the pull is restraint times width to the last digit, wherever the nodes lie.
    bead = Drawbead("B", [(17.3, -5.0, 3.0), (17.3, 45.0, 3.0)], restraint=12.0)
    results = pull(free_strip(distort, drawbeads=[bead], element=element))
    # Its points stand for a tenth of a side each; at the sheet's edges one lies half off it.
    length = results.history["bead_B"][-1] / 12.0
    assert length == pytest.approx(40.0, abs=40.0 / 8 / 10)
    assert results.history["reaction_right_x"][-1] == pytest.approx(12.0 * length, rel=1e-6)
    # On a regular mesh the sheet moves straight on; a skew one bends a little in its plane and holds with its side.
    assert results.history["reaction_right_y"][-1] == pytest.approx(0.0, abs=1e-3 * 12.0 * 40.0)


def test_a_bead_along_an_inclined_line_pulls_across_itself():
    # Its force is along its normal: (restraint x length) (cos a, sin a), of which the right side feels both.
    angle = 0.4
    along = np.array([-sin(angle), cos(angle), 0.0])
    ends = [np.array([20.0, 20.0, 0.0]) + s * along for s in (-10.0, 10.0)]
    results = pull(free_strip(0.2, drawbeads=[Drawbead("B", ends, restraint=10.0)]))
    assert results.history["bead_B"][-1] == pytest.approx(200.0, rel=1e-9)
    assert results.history["reaction_right_x"][-1] == pytest.approx(200.0 * cos(angle), rel=1e-4)
    assert results.history["reaction_right_y"][-1] == pytest.approx(200.0 * sin(angle), rel=1e-4)


def test_a_bead_along_the_motion_holds_nothing():
    bead = Drawbead("B", [(5.0, 20.0, 0.0), (35.0, 20.0, 0.0)], restraint=10.0)
    results = pull(free_strip(drawbeads=[bead]))
    assert results.history["reaction_right_x"][-1] == pytest.approx(0.0, abs=1e-3)


def test_a_strip_through_a_bead_between_plates_and_its_uplift():
    # Pull = restraint w + 2 mu F_B; the uplift takes its share of the holder's force off the sheet.
    mu, force, restraint, uplift, width = 0.1, 5000.0, 60.0, 40.0, 10.0
    for holder, lifted in ((None, 0.0), ("HOLDER", uplift)):
        bead = Drawbead("B", ACROSS, restraint, uplift, holder=holder)
        results = pull(pressed_strip(Coulomb(mu), force=force, drawbeads=[bead]))
        length = results.history["bead_B"][-1] / restraint
        assert length == pytest.approx(width, rel=1e-9)
        wanted = restraint * length + 2.0 * mu * (force - lifted * length)
        assert results.history["reaction_front_x"][-1] == pytest.approx(wanted, rel=2e-4)
        assert results.history["force_HOLDER"][-1] == pytest.approx(force - lifted * length, rel=1e-6)
        assert results.history["uplift_B"][-1] == pytest.approx(uplift * length, rel=1e-9)
        # All of it is lost along the way but for the reversible stick, 0.1 mm in the bead.
        assert wanted * (0.5 - 0.1) < results.energy["friction"] < wanted * 0.5
        assert abs(results.energy["imbalance"]) < 0.01 * results.energy["external"]


def test_the_explicit_solver_holds_as_much():
    bead = Drawbead("B", ACROSS, 60.0, 40.0, holder="HOLDER")
    scene = pressed_strip(Coulomb(0.1), travel=3.0, drawbeads=[bead])
    none = replace(scene, stages=[replace(scene.stages[0], drawbeads=())])
    seen = []
    for s in (scene, none):
        results = form(s, Explicit(waves=150.0), frames=1)
        stroke = np.array(results.history["stroke"])
        mid = (stroke > 0.45) & (stroke < 0.55)
        seen.append(np.array(results.history["reaction_front_x"])[mid].mean())
        assert abs(results.energy["imbalance"]) < 0.02 * results.energy["external"]
    implicit = pull(scene).history["bead_B"][-1]
    length = implicit / 60.0
    assert seen[0] - seen[1] == pytest.approx(implicit - 2.0 * 0.1 * 40.0 * length, rel=0.03)


def test_the_order_of_nodes_and_the_place_of_the_scene_do_not_matter():
    bead = Drawbead("B", [(12.0, 3.0, 0.0), (19.0, 22.0, 0.0), (15.0, 38.0, 0.0)], restraint=15.0)
    scene = free_strip(0.3, drawbeads=[bead])
    first = form(scene, TIGHT, frames=1)
    order = np.random.default_rng(1).permutation(81)
    second = form(free_strip(0.3, order=order, drawbeads=[bead]), TIGHT, frames=1)
    assert second.frames[-1].points[np.argsort(order)] == pytest.approx(first.frames[-1].points, abs=1e-8)
    # Turned by a quarter about z, where the axes the supports hold are still axes.
    turned = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    placed = rotated(scene, turned, np.array([3.0, -2.0, 5.0]))
    there = replace(bead, curve=np.asarray(bead.curve) @ turned.T + [3.0, -2.0, 5.0])
    stage = replace(placed.stages[0], drawbeads=[there], moved={"right": (0.0, 0.8, None)})
    third = form(replace(placed, stages=[stage]), TIGHT, frames=1)
    assert third.history["bead_B"][-1] == pytest.approx(first.history["bead_B"][-1], rel=1e-9)
    wanted = first.frames[-1].points @ turned.T + [3.0, -2.0, 5.0]
    assert third.frames[-1].points == pytest.approx(wanted, abs=1e-8)


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
@pytest.mark.parametrize("restraint", [5.0, 1e5])
def test_tangent_with_a_bead_that_slips_or_sticks_and_lifts_a_tilting_plate(restraint, element):
    bead = Drawbead("B", [(1.0, 1.5, 0.0), (4.0, 4.6, 0.0)], restraint, 150.0, holder="PLATE")
    check_tangent(*pressed_sheet(0.15, element, "tilting", drawbeads=[bead]))


def test_points_find_the_triangle_below_them():
    mesh = square(5, 10.0, distort=0.4, seed=2)
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 11.0, (400, 3))
    triangle, shares = locate(points, np.array([0.0, 0.0, 1.0]), mesh.points, mesh.cells)
    on = ((points[:, :2] >= 0.0) & (points[:, :2] <= 10.0)).all(axis=1)
    assert np.array_equal(triangle >= 0, on)
    found = np.einsum("qa,qac->qc", shares, mesh.points[mesh.cells[triangle]])
    assert found[on, :2] == pytest.approx(points[on, :2], abs=1e-12)
    # Of two sheets on top of each other the nearer one.
    double = np.vstack([mesh.points, mesh.points + [0.0, 0.0, 3.0]])
    cells = np.vstack([mesh.cells, mesh.cells + len(mesh.points)])
    triangle, _ = locate(points, np.array([0.0, 0.0, 1.0]), double, cells)
    assert np.array_equal(triangle[on] >= len(mesh.cells), points[on, 2] > 1.5)


def test_a_run_with_a_bead_and_a_tilting_holder_resumes_from_its_checkpoint(tmp_path):
    bead = Drawbead("B", ACROSS, 60.0, 40.0, holder="HOLDER")
    holder = {"force": 5000.0, "tilts": True, "at": (26.0, 5.0, 0.0)}
    scene = pressed_strip(Coulomb(0.1), holder=holder, drawbeads=[bead])
    whole = form(scene, frames=4)

    rest = interrupted(scene, None, tmp_path / "strip.pvd", 4, lambda progress: progress.fraction > 0.6)
    assert rest.finished
    for column in ("bead_B", "tilt_HOLDER", "reaction_front_x"):
        assert rest.history[column][-1] == pytest.approx(whole.history[column][-1], rel=1e-5)


# Forces from the shape


def test_the_wrap_of_a_bead_is_that_of_a_common_tangent():
    bead, t = RoundBead(6.0, 3.0, 16.0, 7.0), 1.0
    theta = bead.wrap(t)
    # From the shoulder's middle round to the bead's along the tangent: both ends are where they should be.
    shoulder, nose = np.array([11.0, -3.0]), np.array([0.0, 1.0 - 7.0 + 6.0])
    normal = np.array([-sin(theta), cos(theta)])
    start, end = nose - 6.5 * normal, shoulder + 3.5 * normal
    assert atan2(*(end - start)[::-1]) == pytest.approx(theta, rel=1e-12)
    assert RoundBead(6.0, 3.0, 16.0, 1e-9).wrap(t) == pytest.approx(0.0, abs=1e-9)


def test_a_perfectly_plastic_sheet_costs_its_moment_in_each_bend():
    # Six changes of curvature, each the plane strain moment s t^2 / 4 times 1 / R; frictionless.
    t, stress = 0.8, 300.0
    plastic = Material(206000.0, 0.3, VonMises(), Voce(stress, 0.0, 1.0))
    bead = RoundBead(5.0, 2.0, 14.0, 5.0)
    moment = 2.0 / sqrt(3.0) * stress * t * t / 4.0
    frictionless, _ = bead.forces(plastic, t, 0.0)
    assert frictionless == pytest.approx(moment * (4.0 / 2.4 + 2.0 / 5.4), rel=1e-12)
    # With friction: Swift's chain, written out.
    mu, theta, bends = 0.12, bead.wrap(t), [moment / r for r in (2.4, 5.4, 2.4)]
    first = bends[0] * exp(mu * theta) + bends[0]
    second = (first + bends[1]) * exp(2.0 * mu * theta) + bends[1]
    third = (second + bends[2]) * exp(mu * theta) + bends[2]
    restraint, uplift = bead.forces(plastic, t, mu)
    assert restraint == pytest.approx(third, rel=1e-12)
    assert uplift == pytest.approx((first + bends[1]) * (1.0 + exp(2.0 * mu * theta)) * sin(theta), rel=1e-12)


def test_hardening_in_a_bead_is_the_work_of_strain_added_up():
    # s = K e: six bends on one radius add work K F^2 y^2 kappa^2 / 2, up to six times the curvature.
    t, K, r = 1.0, 900.0, 4.5
    linear = Material(206000.0, 0.3, VonMises(), Ludwik(1e-9, K, 1.0))
    restraint, _ = RoundBead(r - 0.5, r - 0.5, 30.0, 3.0).forces(linear, t, 0.0)
    assert restraint == pytest.approx(4.0 / 3.0 * K * (6.0 / r) ** 2 * t**3 / 24.0, rel=1e-8)


def test_friction_anisotropy_and_direction_count():
    bead = RoundBead(5.0, 2.0, 14.0, 5.0)
    plain = bead.forces(STEEL, 0.8, 0.1)
    normal = bead.forces(replace(STEEL, locus=PlanarHill(1.77)), 0.8, 0.1)
    assert normal[0] > plain[0]  # plane strain factor (1 + r) / sqrt(1 + 2 r), in stress and in strain
    assert (1.0 + 1.77) / sqrt(1.0 + 2.0 * 1.77) > 2.0 / sqrt(3.0)
    sheet = replace(STEEL, locus=Hill48(1.79, 1.51, 2.27))
    along, across = bead.forces(sheet, 0.8, 0.1)[0], bead.forces(sheet, 0.8, 0.1, direction=0.5 * pi)[0]
    assert abs(along / across - 1.0) > 0.01
    assert bead.forces(STEEL, 0.8, 0.15)[0] > plain[0] > bead.forces(STEEL, 0.8, 0.0)[0]


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Drawbead("B", [(0, 0, 0)], 1.0), r"drawbead 'B' curve: found shape \(1, 3\), expected 2 or more"),
        (lambda: Drawbead("B", [(0, 0, 0), (0, 0, 0)], 1.0), "'B' curve: found two equal points in a row"),
        (lambda: Drawbead("B", ACROSS, -1.0), "'B' restraint: found -1.0, expected N/mm, 0 or more"),
        (lambda: Stage(drawbeads=[Drawbead("B", ACROSS, 1.0)] * 2), "share a name, expected a name each"),
        (
            lambda: Stage([Tool("DIE", Plane())], drawbeads=[Drawbead("B", ACROSS, 1.0, holder="DIE")]),
            "drawbead 'B' holder: found 'DIE', expected a tool of stage 'draw' that a force or spring bears",
        ),
        (lambda: RoundBead(5.0, 2.0, 1.0, 0.0), "drawbead shape depth: found 0.0, expected mm above 0"),
        (lambda: RoundBead(5.0, 2.0, 4.0, 7.0).wrap(1.0), "expected room for the sheet of 1 mm"),
    ],
)
def test_what_makes_no_sense_is_one_line(make, message):
    with pytest.raises(SceneError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
