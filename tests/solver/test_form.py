"""Whole runs on small scenes with tools in closed form."""

import logging
from dataclasses import replace
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cadlink import Disc, mesh_blank
from solver import (
    Blank,
    Coulomb,
    Implicit,
    Increments,
    Material,
    Membrane,
    Newton,
    PlanarHill,
    Scene,
    SceneError,
    Stage,
    StepFailed,
    Swift,
    Tool,
    VonMises,
    form,
)
from tests.solver.lattice import Ball, Plane, square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589), "mild steel")
OSU = Material(69004.0, 0.3, VonMises(), Swift(589.0, 1e-4, 0.216), "OSU")


def punch_stretch(size=2.5, travel=5.0, mu=0.15, arrangement="structured", **options):
    """A clamped disc of radius 20, stretched by a ball of radius 10."""
    mesh = mesh_blank(Disc(20.0), size, arrangement=arrangement, symmetry=("x", "y"))
    blank = Blank(mesh, 1.0, STEEL, Membrane(), fixed={"rim": "xyz"})
    friction = Coulomb(mu) if mu else None
    ball = Tool("BALL", Ball((0.0, 0.0, 12.0), 10.0), friction, travel=-travel)
    return Scene(blank, [Stage([ball], **options)])


def test_newton_converges_quadratically_with_friction(caplog):
    with caplog.at_level(logging.INFO, logger="cadlink"):
        results = form(punch_stretch(), Implicit(newton=Newton(residual=1e-9, correction=1e-6)), frames=5)
    orders = []
    for line in (r.message for r in caplog.records if r.message.startswith("fraction")):
        r = np.array([float(text) for text in line.split("residuals")[1].split()])
        # Three residuals in a row inside the basin and above round-off.
        for a, b, c in zip(r, r[1:], r[2:]):
            if 1e-2 > a > b > c > 3e-13 and b > 1e-8:
                orders.append(np.log(c / b) / np.log(b / a))
    assert results.finished
    assert len(orders) >= 5
    assert np.median(orders) > 1.8


def test_punch_force_balances_the_sheet_and_energy_is_conserved():
    results = form(punch_stretch(), Implicit(newton=Newton(residual=1e-8)), frames=5)
    energy = results.energy
    assert abs(energy["imbalance"]) < 0.01 * energy["external"]
    assert energy["friction"] > 0.0
    assert results.history["travel_BALL"][0] < -1.5  # the ball first closed a distance of 2 - 0.5 mm
    # The whole part's force, though a quarter is modelled: work = integral of force over travel.
    force, travel = np.abs(results.history["force_BALL"]), np.abs(results.history["stroke"])
    work = np.trapezoid(np.append(0.0, force), np.append(0.0, travel))
    assert work == pytest.approx(energy["external"], rel=1e-6)


def test_without_friction_nothing_slides_against_resistance():
    results = form(punch_stretch(mu=0.0), frames=2)
    assert results.energy["friction"] == 0.0
    assert "friction" in str(results.plan).split("Skipped")[1]


def test_halving_the_torsion_stiffness_changes_nothing_a_user_reads():
    # The same increments for both, and nothing left out of balance.
    method = Implicit(Newton(residual=1e-6, correction=1e-6), Increments(largest=0.1))
    half = replace(method, torsion=0.5 * method.torsion)
    full, halved = (form(punch_stretch(), m, frames=5) for m in (method, half))
    for a, b in zip(full.frames[1:], halved.frames[1:]):
        assert halved.at("force_BALL", b.stroke) == pytest.approx(full.at("force_BALL", a.stroke), rel=1e-3)
        assert b.cell_fields["thickness"] == pytest.approx(a.cell_fields["thickness"], rel=1e-3)


def test_node_order_and_rigid_motion_do_not_matter():
    scene = punch_stretch(size=4.0)
    mesh = scene.blank.mesh
    order = np.random.default_rng(2).permutation(len(mesh.points))
    place = np.argsort(order)
    shuffled = SimpleNamespace(
        points=mesh.points[order],
        cells=place[mesh.cells][::-1],
        groups={k: place[v] for k, v in mesh.groups.items()},
    )
    tight = Implicit(newton=Newton(residual=1e-10, correction=1e-9))
    first = form(scene, tight, frames=2).frames[-1]
    second = form(replace(scene, blank=replace(scene.blank, mesh=shuffled)), tight, frames=2).frames[-1]
    assert second.points[place] == pytest.approx(first.points, abs=1e-6)

    turn = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    turned = SimpleNamespace(
        points=mesh.points @ turn.T,
        cells=mesh.cells,
        groups={
            **mesh.groups,
            "symmetry_x": mesh.groups["symmetry_y"],
            "symmetry_y": mesh.groups["symmetry_x"],
        },
    )
    blank = replace(scene.blank, mesh=turned, rolling=(0.0, 1.0, 0.0))
    third = form(replace(scene, blank=blank), tight, frames=2).frames[-1]
    assert third.points == pytest.approx(first.points @ turn.T, abs=1e-6)


def test_one_and_two_threads_give_the_same_bits():
    before = numba.get_num_threads()
    try:
        points = []
        for n_threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
            numba.set_num_threads(n_threads)
            points.append(form(punch_stretch(size=4.0), frames=2).frames[-1].points)
    finally:
        numba.set_num_threads(before)
    assert np.array_equal(*points)


def bulge(size, frames=20):
    """Dome height and polar strain at the pressure of benchmarks.md G, h = 20 (OSU, r = 1, a = 50, t0 = 1)."""
    mesh = mesh_blank(Disc(50.0), size, arrangement="structured", symmetry=("x", "y"))
    blank = Blank(mesh, 1.0, OSU, Membrane(), fixed={"rim": "xyz"})
    frame = form(Scene(blank, [Stage(pressure=-9.230447)]), frames=frames).frames[-1]
    radius = np.hypot(*mesh.points[mesh.cells].mean(axis=1)[:, :2].T)
    thinning = frame.cell_fields["strain_major"] + frame.cell_fields["strain_minor"]
    # The pole's strain: even parabola through the triangles of the inner third.
    inner = radius < 17.0
    terms = np.column_stack([np.ones(inner.sum()), radius[inner] ** 2, radius[inner] ** 4])
    return frame.points[:, 2].max(), -np.linalg.lstsq(terms, thinning[inner], rcond=None)[0][0]


def test_hydraulic_bulge_meets_the_converged_membrane():
    # The reference's thickness strain is minus the sum of the two total strains in the plane.
    height, strain = bulge(2.5, frames=100)
    assert height == pytest.approx(20.0, rel=5e-4)
    assert strain == pytest.approx(-0.264063, rel=0.007)


@pytest.mark.slow
def test_hydraulic_bulge_error_falls_at_second_order():
    sizes = np.array([10.0, 5.0, 2.5, 1.25])
    values = np.array([bulge(size, frames=100) for size in sizes])
    # Against the finest mesh, extrapolated with the next (Richardson): no figure of another program needed.
    limit = values[-1] + (values[-1] - values[-2]) / 3.0
    error = np.abs(values[:3] - limit)
    orders = np.log2(error[:-1] / error[1:])
    assert orders[:, 0].mean() > 1.7
    assert orders[:, 1].mean() > 1.7


def test_a_run_resumes_from_its_checkpoint(tmp_path):
    scene = punch_stretch(size=4.0)

    whole = form(scene, frames=4)

    def stop(progress):
        if progress.fraction > 0.6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        form(scene, save=tmp_path / "cup.pvd", frames=4, watch=stop)
    assert (tmp_path / "checkpoint.h5").exists()
    rest = form(scene, save=tmp_path / "cup.pvd", frames=4, resume=True)
    assert rest.finished
    assert rest.history["stroke"][-1] == pytest.approx(5.0)
    assert rest.history["force_BALL"][-1] == pytest.approx(whole.history["force_BALL"][-1], rel=1e-5)
    assert rest.energy["external"] == pytest.approx(whole.energy["external"], rel=1e-5)
    with pytest.raises(SceneError, match="another scene"):
        form(punch_stretch(size=4.0, mu=0.3), save=tmp_path / "cup.pvd", frames=4, resume=True)


def test_beyond_the_limit_pressure_the_run_stops_with_one_line_and_its_results():
    mesh = mesh_blank(Disc(50.0), 10.0, arrangement="structured", symmetry=("x", "y"))
    scene = Scene(Blank(mesh, 1.0, OSU, Membrane(), fixed={"rim": "xyz"}), [Stage(pressure=-13.0)])
    with pytest.raises(StepFailed, match="finds no rest since.*; refine the mesh or lower the load") as caught:
        form(scene, frames=5)
    assert "\n" not in str(caught.value)
    # The maximum of the converged membrane is 11.03 MPa, near h = 31.
    results = caught.value.results
    assert 10.5 / 13.0 < np.array(results.history["stroke"])[results.in_equilibrium()][-1] < 11.5 / 13.0


def sheet_on_plate(**tool):
    mesh = square(3, 30.0)
    mesh.points[:, 2] = 0.5
    blank = Blank(mesh, 1.0, STEEL, Membrane())
    return Scene(blank, [Stage([Tool("PLATE", Plane()), Tool("TOP", Plane((0, 0, 1.0), (0, 0, -1)), **tool)])])


def test_blank_holder_force_is_balanced_by_the_plate():
    results = form(sheet_on_plate(force=1000.0), frames=1)
    assert results.history["force_TOP"][-1] == pytest.approx(1000.0, rel=1e-6)
    assert results.history["force_PLATE"][-1] == pytest.approx(-1000.0, rel=1e-6)


def test_blank_holder_gap_is_kept():
    results = form(sheet_on_plate(gap=1.2), frames=1)
    assert results.history["travel_TOP"][-1] == pytest.approx(0.2, abs=1e-6)
    assert results.history["force_TOP"][-1] == pytest.approx(0.0, abs=1e-6)


def test_a_tool_that_never_meets_the_blank_is_refused():
    scene = punch_stretch()
    away = Tool("BALL", Ball((200.0, 0.0, 12.0), 10.0), travel=-5.0)
    with pytest.raises(SceneError, match="'BALL'.*never meets the blank"):
        form(replace(scene, stages=[Stage([away])]))


def test_a_die_the_blank_misses_is_refused():
    scene = punch_stretch()
    tools = [*scene.stages[0].tools, Tool("DIE", Ball((300.0, 0.0, -12.0), 10.0))]
    with pytest.raises(SceneError, match="'DIE': the blank misses it"):
        form(replace(scene, stages=[Stage(tools)]))


def test_a_tool_inside_the_blank_is_refused():
    scene = punch_stretch()
    tools = [*scene.stages[0].tools, Tool("DIE", Plane((0.0, 0.0, 0.2)))]
    with pytest.raises(SceneError, match="'DIE': overlaps the blank by 0.7 mm"):
        form(replace(scene, stages=[Stage(tools)]))


def test_a_tool_travels_to_a_place_wherever_it_touches_the_blank():
    scene = punch_stretch(size=4.0)
    ball = replace(scene.stages[0].tools[0], travel=None, to=-3.5)
    found = form(replace(scene, stages=[Stage([ball])]), frames=2)
    # From 12 - 10 - 0.5 mm above it, two millimetres into the sheet.
    same = form(replace(scene, stages=[Stage([replace(ball, to=None, travel=-2.0)])]), frames=2)
    assert found.history["travel_BALL"][-1] == pytest.approx(-3.5, abs=1e-12)
    assert found.history["stroke"] == pytest.approx(same.history["stroke"], abs=1e-6)
    assert found.frames[-1].points == pytest.approx(same.frames[-1].points, abs=1e-6)
    assert "until -3.5 mm from its place in the CAD file" in str(found.plan)


def test_a_tool_that_touches_the_blank_beyond_where_it_should_go_is_refused():
    scene = punch_stretch(size=4.0)
    ball = replace(scene.stages[0].tools[0], travel=None, to=-1.0)
    with pytest.raises(SceneError, match="stage 'draw', tool 'BALL' to: found -1 mm, expected beyond -1.5 mm"):
        form(replace(scene, stages=[Stage([ball])]))
    with pytest.raises(SceneError, match="tool 'BALL': found travel and to, expected at most one of them"):
        replace(ball, travel=-1.0)
