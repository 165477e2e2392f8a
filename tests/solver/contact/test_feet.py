"""Nodes that touch two or three walls at once: tangent, friction memory, and strips pressed into tight corners."""

import numpy as np
import pytest

from cadlink.feet import Feet
from solver import (
    Blank,
    Coulomb,
    Implicit,
    Material,
    Membrane,
    Newton,
    PlanarHill,
    Scene,
    Shell,
    Stage,
    Swift,
    Tool,
    form,
)
from solver.checkpoint import load_checkpoint, save_checkpoint
from solver.contact.drive import ToolRun, build_drive
from solver.contact.feet import feet_per_node, places
from solver.contact.search import Neighbourhood
from solver.energy import Energy
from solver.form import first_state
from solver.implicit.equilibrium import Equilibrium
from solver.implicit.increments import March
from solver.results import Results
from solver.sheet import build_sheet
from solver.state import State, new_contact, new_sheet
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of
from tests.solver.lattice import Plane, square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589))
T = 1.0


class Walls:
    """Planes that meet in a sharp corner, as a tool: every plane is a foot of every point."""

    def __init__(self, *normals):
        self.planes = [Plane((0.0, 0.0, 0.0), normal) for normal in normals]

    def tightest(self, side=1.0):
        return 0.0

    def all_feet(self, points):
        hits = [plane.project(points) for plane in self.planes]
        order = np.argsort([hit.distance for hit in hits], axis=0, kind="stable")
        return hits, order

    def project(self, points, seed=None):
        hits, order = self.all_feet(points)
        return pick(hits, order[0], np.arange(len(points)))

    def feet(self, points, hit, reach):
        hits, order = self.all_feet(points)
        owner = np.repeat(np.arange(len(points)), len(hits) - 1)
        found = pick(hits, order[1:].T.ravel(), owner)
        near = found.distance <= np.broadcast_to(reach, len(points))[owner]
        return Feet(owner[near], type(found)(*(values[near] for values in found)))


def pick(hits, which, rows):
    """The hit of plane which[k] at rows[k], as a Projection."""
    from cadlink import Projection

    fields = ("distance", "point", "normal", "curvature", "direction", "face", "seed")
    return Projection(*(np.stack([getattr(hit, name) for hit in hits])[which, rows] for name in fields))


def strip(n, m, length, width, lift=0.5):
    """A strip from x = 0 on, whose sides stay in their planes."""
    mesh = square(n, 1.0)
    x, y = np.meshgrid(np.linspace(0.0, length, n + 1), np.linspace(0.0, width, m + 1), indexing="ij")
    a = (np.arange(n)[:, None] * (m + 1) + np.arange(m)).ravel()
    b, c, d = a + m + 1, a + m + 2, a + 1
    mesh.points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, lift)])
    mesh.cells = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    ends = {"left": mesh.points[:, 0] == 0.0, "right": mesh.points[:, 0] == length}
    mesh.groups = {name: np.flatnonzero(chosen) for name, chosen in ends.items()}
    mesh.groups["all"] = np.arange(len(mesh.points))
    return mesh


def in_a_corner(mu, walls):
    """Nodes of a sheet in a corner of a tool that stands still and of one driven by a force, displaced at random."""
    mesh = square(2, 6.0, distort=0.1)
    mesh.groups.pop("symmetry_x"), mesh.groups.pop("symmetry_y")
    sheet = build_sheet(Blank(mesh, T, STEEL, Membrane()))
    friction = Coulomb(mu) if mu else None
    tools = [Tool("DIE", walls, friction, force=900.0)]
    stiffness = 2.0e4 * sheet.area
    hood = Neighbourhood(walls, 9)
    drive = build_drive(tools[0], sheet, stiffness, None)
    runs = [ToolRun(tools[0], tools[0].unit_axis, 0.0, -1.0, drive, stiffness, 0.1 * stiffness, hood)]
    old, new = (
        State(new_sheet(sheet.points, 0, len(sheet.elements.point_volume)), {"DIE": new_contact(9, 3)})
        for _ in range(2)
    )
    rng = np.random.default_rng(4)
    at = np.array([0.5, 0.5, 0.5]) - 4e-3 * rng.uniform(0.5, 1.0, (9, 3))
    old.sheet.x[:] = at
    old.tools["DIE"].travel[0] = 0.0
    equilibrium = Equilibrium(sheet, Stage(tools), runs, Implicit(), old)
    equilibrium.begin(old, new)
    equilibrium.half_thickness[:] = 0.5 * T
    equilibrium.evaluate(old, old, 1.0)
    new.copy_from(old)
    new.sheet.x[:] = at + 3e-3 * rng.uniform(-0.5, 0.5, (9, 3))
    new.tools["DIE"].travel[0] = -3e-4
    return equilibrium, old, new


@pytest.mark.parametrize("mu", [0.0, 0.02, 0.3])
@pytest.mark.parametrize("normals", [[(1, 0, 0), (0, 0, 1)], [(1, 0, 0), (0, 1, 0), (0.1, -0.1, 1)]])
def test_tangent_of_several_feet(normals, mu):
    """Contact alone: blocks, row and column of the tool and its corner against differences of the contact forces."""
    equilibrium, old, new = in_a_corner(mu, Walls(*normals))
    x, travel = new.sheet.x.copy(), new.tools["DIE"].travel.copy()

    def forces(dx, dw):
        new.sheet.x[:] = x + dx
        new.tools["DIE"].travel[:] = travel + dw
        equilibrium.contact[:] = 0.0
        equilibrium.first = False
        equilibrium._touch(equilibrium.tools[0], old, new)
        return equilibrium.contact.copy(), new.tools["DIE"].force.copy()

    push, on_tool = forces(0.0, 0.0)
    assert [int((foot.status > 0).sum()) for foot in new.tools["DIE"].feet[: len(normals)]] == [9] * len(normals)
    assert push.sum(axis=0) == pytest.approx(-on_tool)
    assert new.tools["DIE"].push == pytest.approx(push)
    blocks, step = equilibrium.contact_blocks["DIE"].copy(), 1e-8
    scale = np.abs(blocks).max()
    for axis in range(3):
        e = step * np.eye(3)[axis]
        numeric = -(forces(e, 0.0)[0] - forces(-e, 0.0)[0]) / (2 * step)
        assert blocks[:, :, axis] == pytest.approx(numeric, abs=1e-5 * scale)
    numeric = (forces(0.0, step)[1] - forces(0.0, -step)[1]) / (2 * step)
    axis = equilibrium.tools[0].axis
    assert -blocks.sum(axis=0) @ axis == pytest.approx(numeric, abs=1e-5 * 9 * scale)


def test_a_foot_takes_the_place_of_the_wall_it_was_on():
    """Whichever wall is nearest now; a new wall takes a place that nobody held."""
    x, y, z = np.eye(3)
    turned = np.array([np.sin(0.1), 0.0, np.cos(0.1)])
    then = np.array([[z, x, 0 * x]] * 4)
    touched = np.array([[True, True, False], [True, True, False], [False, True, False], [True, False, False]])
    normals = np.array([[x, turned, y], [turned, 0 * x, 0 * x], [x, z, 0 * x], [y, 0 * x, 0 * x]])
    exists = np.array([[True, True, True], [True, False, False], [True, True, False], [True, False, False]])
    place = places(normals, exists, then, touched)
    assert place[0].tolist() == [1, 0, 2]
    assert place[1, 0] == 0
    assert place[2, :2].tolist() == [1, 0]
    assert place[3, 0] == 1  # away from the floor, on another wall: no friction is carried over


def test_only_tight_corners_are_searched():
    tight, wide = (part_of(shapes.l_profile(radius)).surface() for radius in (0.3, 1.2))
    assert feet_per_node(tight, T) == 3 and feet_per_node(wide, T) == 1 and feet_per_node(Plane(), T) == 1
    assert feet_per_node(wide, 2.2) == 3
    mesh = strip(2, 1, 4.0, 2.0)
    plans = [str(Scene(Blank(mesh, T, STEEL), [Stage([Tool("DIE", s)])]).plan()) for s in (tight, wide)]
    assert "contact with DIE: up to three feet per node" in plans[0].split("Skipped")[0]
    assert "further feet of a node" in plans[1].split("Skipped")[1]


def stop(radius, element, mu=0.1, pressure=60.0):
    """A strip on the floor of an L, pressed down and then pushed with its edge against the wall by 0.02 mm.

    The edge's nodes are 0.5 above the floor and, in the end, 0.5 from the wall: farther than the fillet of 0.3 reaches.
    """
    mesh = strip(20, 2, 20.0, 2.0, 2.0 + 0.5 * T - 1e-3)
    start = 2.0 + 0.5 * T + 0.1
    mesh.points += [start, 2.0, 0.0]
    part = part_of(long_l(radius))
    blank = Blank(mesh, T, STEEL, element, fixed={"all": "y"})
    die = Tool("DIE", part.surface(), Coulomb(mu) if mu else None)
    return Scene(blank, [Stage([die], pressure=pressure, moved={"right": (-0.12, None, None)})])


def long_l(radius):
    """The L of shapes.l_profile with a longer floor."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    # The floor goes on under the strip; where it meets the profile nothing turns.
    longer = BRepPrimAPI_MakeBox(gp_Pnt(9.0, 0, 0), 21.0, 6.0, 2.0).Solid()
    profile = shapes.l_profile(radius) if radius else shapes.l_profile_sharp()
    body = BRepAlgoAPI_Fuse(profile, longer)
    body.SimplifyResult()
    return shapes.solid_in(body.Shape())


@pytest.mark.parametrize("element", [Membrane(), Shell(5)])
@pytest.mark.parametrize("radius", [0.3, 0.0])
def test_a_strip_pushed_into_a_tight_corner_touches_both_walls(radius, element):
    scene = stop(radius, element)
    cuts = []
    results = form(scene, frames=1, watch=lambda p: cuts.append(p.n_cut_backs))
    # The floating strip takes cut-backs to settle on the floor; the corner takes none.
    assert results.finished and cuts[-1] == cuts[0]
    left, cells = scene.blank.mesh.groups["left"], np.asarray(scene.blank.mesh.cells)
    edge = results.frames[-1].points[left] - [2.0, 0.0, 2.0]
    thickness = results.frames[-1].cell_fields["thickness"]
    half = 0.5 * np.array([thickness[(cells == node).any(axis=1)].mean() for node in left])
    gaps = edge[:, [0, 2]] - half[:, None]
    skin = Implicit().skin * T
    # Both walls hold the edge: nowhere deeper than the overlap allowed, and near enough to carry force.
    assert gaps.min() > -Implicit().penetration * T - 1e-3 * T and gaps.max() < skin
    # Balance: what the wall takes is what pushes, less the floor's friction; the floor takes the pressure.
    assert -results.history["force_DIE"][-1] == pytest.approx(60.0 * 40.0, rel=5e-3)
    push = -results.history["reaction_right_x"][-1]
    assert push > 1.2 * 0.1 * 60.0 * 40.0


def test_an_edge_lowered_into_a_groove_shares_its_load_between_both_walls():
    """60 degrees, no friction: a force F along the bisector presses with F / (2 sin 30) = F on each wall."""
    cos, sin = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    mesh = strip(6, 2, 6.0, 2.0, 0.0)
    mesh.points += [0.5 * T / sin + 0.01, 0.0, 0.0]  # along the bisector, x
    groove = Walls((sin, 0.0, cos), (sin, 0.0, -cos))
    blank = Blank(mesh, T, STEEL, Shell(3), fixed={"all": "y", "right": "yz"})
    scene = Scene(blank, [Stage([Tool("GROOVE", groove, axis=(1, 0, 0))], moved={"right": (-0.03, None, None)})])
    kept = {}
    method = Implicit(Newton(residual=1e-6, correction=1e-6))
    results = form(scene, method, frames=1, watch=lambda p: kept.update(cuts=p.n_cut_backs))
    assert results.finished and kept["cuts"] == 0
    push = -results.history["reaction_right_x"][-1]
    assert push > 100.0
    assert -results.history["force_GROOVE"][-1] == pytest.approx(push, rel=1e-5)
    area = results.frames[-1].point_fields["contact_pressure"]
    assert np.count_nonzero(area) == 3
    edge = results.frames[-1].points[mesh.groups["left"]]
    gaps = np.stack([edge[:, 0] * sin + edge[:, 2] * cos, edge[:, 0] * sin - edge[:, 2] * cos]) - 0.5 * T
    assert gaps == pytest.approx(np.broadcast_to(gaps.mean(), gaps.shape), abs=2e-3 * T)


def test_a_corner_of_a_sheet_pushed_into_three_planes():
    """The floor and two walls hold one node; it stops where all three are half a thickness away."""
    mesh = square(4, 4.0)
    mesh.groups = {"far": np.flatnonzero(mesh.points[:, :2].sum(axis=1) > 7.9), "all": np.arange(25)}
    mesh.points += [0.5 * T + 0.02, 0.5 * T + 0.01, 0.5 * T]
    box = Walls((1, 0, 0), (0, 1, 0), (0, 0, 1))
    push = Stage([Tool("BOX", box, Coulomb(0.1))], pressure=20.0, moved={"far": (-0.04, -0.04, None)})
    results = form(Scene(Blank(mesh, T, STEEL, Shell(3)), [push]), frames=1)
    assert results.finished
    gaps = results.frames[-1].points[0] - 0.5 * T
    assert np.abs(gaps).max() < Implicit().skin * T


def test_further_feet_survive_a_checkpoint(tmp_path):
    scene = stop(0.3, Membrane())
    sheet = build_sheet(scene.blank)
    first, second = (first_state(scene, sheet, Implicit()) for _ in range(2))
    rng = np.random.default_rng(0)
    for foot in first.tools["DIE"].feet:
        foot.friction_force[:] = rng.standard_normal(foot.friction_force.shape)
        foot.status[:] = rng.integers(0, 3, len(foot.status))
    place = March(0.5, 0.1, np.zeros(sheet.held.shape), {"DIE": 0.0}, {"DIE": (0.0, 0.0)})
    save_checkpoint(tmp_path / "here.h5", scene, Implicit(), (0, place), first, Results(None), Energy())
    load_checkpoint(tmp_path / "here.h5", scene, Implicit(), second, Results(None), Energy())
    third = first_state(scene, sheet, Implicit())
    third.copy_from(first)
    for mine, loaded, copied in zip(*(state.tools["DIE"].feet for state in (first, second, third))):
        for name, values in mine.arrays().items():
            assert np.array_equal(values, loaded.arrays()[name]) and np.array_equal(values, copied.arrays()[name])
