"""Nodes that several walls of a tool hold at once, against mechanics of one mass and against the implicit solver."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from solver import Blank, Coulomb, Explicit, Implicit, Membrane, Scene, Shell, Stage, Tool, form
from solver.contact.drive import ToolRun
from solver.contact.search import Neighbourhood
from solver.explicit import corners
from solver.explicit.central_differences import predict
from solver.explicit.contact import ToolContact
from solver.explicit.corners import TRUST, content, meet_walls
from solver.explicit.laws import BY_PATH, KINEMATIC, PENALTY, TOUCH
from solver.form import first_state
from solver.sheet import build_sheet
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of
from tests.solver.contact.test_feet import STEEL, T, stop, strip
from tests.solver.contact.test_feet import Walls as Planes

MASS, DT = 2.0, 1e-3
SOFT = 0.05  # stiffness of a penalty, over m/dt^2
DAMPING = 0.5 * np.sqrt(SOFT) / DT  # [1/s]


def meet(law, parameter, normals, u, v, u_new, v_new, mu=0.0, w=None, free=None):
    """One node meets walls through the origin. Returns forces (3 walls,), friction (3 walls, 3), status and energy
    lost."""
    k = len(normals)
    normal, force, tau = np.zeros((1, 3, 3)), np.zeros((1, 3)), np.zeros((1, 3, 3))
    normal[0, :k] = normals
    place = u if law == PENALTY else u_new
    gap, status, lost = np.full((1, 3), np.inf), np.zeros((1, 3), dtype=np.int64), np.zeros(1)
    gap[0, :k] = normals @ place[0]
    meet_walls(
        law, parameter, np.zeros(1, dtype=np.int64), gap, normal, np.zeros((1, 3), dtype=np.int64), np.array([k]),
        np.zeros(1), np.array([MASS]), np.ones((1, 3)) if free is None else free, mu, None,
        np.zeros((3, 3)) if w is None else w, DT, DT, v, u_new, v_new, force, tau, status, lost,
    )  # fmt: skip
    return force[0], tau[0], status[0], lost[0]


def pressed(law, normals, load, mu=0.0, steps=300, loads=None, w=None, start=(0.0, 0.0, 0.0)):
    """A mass at rest in walls through the origin, under a load (3,) N. Yields place, velocity, forces, friction."""
    parameter = {KINEMATIC: 0.0, TOUCH: 0.0, PENALTY: SOFT / DT**2}[law]
    u, v = np.array([start], float), np.zeros((1, 3))
    nothing, fixed = np.zeros((1, 3)), np.zeros((1, 3), dtype=bool)
    damping = DAMPING if law == PENALTY else 0.0
    for step in range(steps):
        u_new, v_new = np.zeros((1, 3)), np.zeros((1, 3))
        external = np.array([load if loads is None else loads[step]], float)
        predict(
            u, v, np.array([MASS]), external, nothing, fixed, nothing, 0.0, DT, DT, damping, u_new, v_new,
        )  # fmt: skip
        force, tau, _, _ = meet(law, parameter, normals, u, v, u_new, v_new, mu, w)
        u, v = u_new, v_new
        yield u[0].copy(), v[0].copy(), force, tau


def groove(half_angle):
    """Walls of a groove along y that opens upwards, (2, 3)."""
    s, c = np.sin(half_angle), np.cos(half_angle)
    return np.array([[c, 0.0, s], [-c, 0.0, s]])


def random_walls(rng, k):
    normals = rng.standard_normal((k, 3))
    return normals / np.linalg.norm(normals, axis=1)[:, None]


@pytest.mark.parametrize("k", [1, 2, 3])
def test_walls_are_contented_by_the_smallest_push(k):
    rng = np.random.default_rng(k)
    met = 0
    for _ in range(300):
        normals, b = random_walls(rng, k), rng.standard_normal(k)
        gram, x = normals @ normals.T, np.zeros(k)
        if np.linalg.eigvalsh(gram)[0] < 0.05:
            continue
        content(gram, b, k, x)
        rest = gram @ x - b
        assert (x >= 0.0).all() and rest.min() > -1e-9 and np.abs(x * rest).max() < 1e-9
        met += np.count_nonzero(x) == k
        # The same push in whatever order the walls come.
        order = rng.permutation(k)
        other = np.zeros(k)
        content(gram[np.ix_(order, order)], b[order], k, other)
        assert other == pytest.approx(x[order], abs=1e-9)
    assert met > 10


def test_walls_that_face_each_other_push_as_springs_and_come_to_share():
    # A sheet 0.1 too thick for its slot: springs of equal stiffness hold it in the middle, each with m/dt^2 0.05.
    x, place, b = np.zeros(2), 0.04, 0.0
    gram = np.array([[1.0, -1.0], [-1.0, 1.0]])
    for _ in range(60):
        b = np.array([0.05 - place, 0.05 + place])
        content(gram, b, 2, x)
        place += x[0] - x[1]
    assert place == pytest.approx(0.0, abs=1e-12)
    assert x == pytest.approx([0.05, 0.05])


@pytest.mark.parametrize("law", [KINEMATIC, TOUCH, PENALTY])
@pytest.mark.parametrize("degrees", [15.0, 30.0, 60.0])
def test_a_wedge_presses_on_both_walls_of_a_groove(law, degrees):
    """Down force F: N = F/(2 sin a) on each; pulled along the groove, it slides from mu F/sin a on."""
    a, mu, down = np.radians(degrees), 0.2, 100.0
    hold = mu * down / np.sin(a)
    *_, (place, velocity, force, tau) = pressed(law, groove(a), (0.0, 0.0, -down), mu)
    # The damping that brings a penalty's springs to rest takes its part of the load in each step.
    part = 1.0 / (1.0 + 0.5 * DAMPING * DT) if law == PENALTY else 1.0
    assert force[:2] == pytest.approx([part * down / (2.0 * np.sin(a))] * 2, rel=1e-6)
    assert velocity == pytest.approx(np.zeros(3), abs=1e-6)
    held = list(pressed(law, groove(a), (0.0, 0.9 * hold, -down), mu))
    if law != PENALTY:
        assert place == pytest.approx(np.zeros(3), abs=1e-12)
        assert held[-1][0] == pytest.approx(np.zeros(3), abs=1e-12)
        assert held[-1][3].sum(axis=0) == pytest.approx([0.0, -0.9 * hold, 0.0], abs=1e-9 * down)
        *_, (place, velocity, force, tau) = pressed(law, groove(a), (0.0, 1.5 * hold, -down), mu)
        # Half of what holds is too much: it speeds up steadily, half a step less than the load has acted.
        assert velocity[1] == pytest.approx(0.5 * hold / MASS * 300 * DT, rel=1e-6)
        assert np.linalg.norm(tau[:2], axis=1) == pytest.approx(mu * force[:2])
    else:
        assert np.abs(held[-1][1]).max() < 1e-6


@pytest.mark.parametrize(
    "law, restitution", [(KINEMATIC, 0.0), (TOUCH, 0.0), (TOUCH, 0.6), (TOUCH, 1.0), (PENALTY, 0.0)]
)
@pytest.mark.parametrize("k", [1, 2, 3])
def test_impulses_balance_and_no_energy_is_gained(law, restitution, k):
    rng = np.random.default_rng(10 * k + law)
    parameter = restitution if law == TOUCH else 0.2 / DT**2
    for _ in range(200):
        normals = random_walls(rng, k)
        if np.linalg.eigvalsh(normals @ normals.T)[0] < 0.05:
            continue
        # Where all walls meet, at random, on a tool that moves; its walls are looked at in the origin.
        tool = 0.3 * rng.standard_normal(3)
        w = np.vstack([tool, np.zeros((2, 3))])
        v = rng.standard_normal((1, 3))
        u = np.zeros((1, 3)) - (DT * tool if law != PENALTY else 1e-3 * normals.sum(axis=0))
        v_new, u_new = v.copy(), u + DT * v
        force, tau, _, lost = meet(law, parameter, normals, u, v, u_new, v_new, 0.3, w)
        impulse = (force[:k, None] * normals + tau[:k]).sum(axis=0) * DT
        assert MASS * (v_new - v)[0] == pytest.approx(impulse, abs=1e-12)
        assert (np.linalg.norm(tau, axis=1) <= 0.3 * force * (1.0 + 1e-9)).all()
        if law != PENALTY and restitution == 0.0:
            assert (normals @ u_new[0] >= -1e-12 * DT).all()
        if law != PENALTY:
            before, after = np.linalg.norm(v[0] - tool), np.linalg.norm(v_new[0] - tool)
            assert after <= before * (1.0 + 1e-9)
        assert lost == BY_PATH or lost >= 0.0


def test_a_bounce_between_walls_keeps_its_energy():
    # Two walls at right angles send a node back where it came from.
    normals = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    v = np.array([[-3.0, 0.5, -1.0]])
    u, v_new = np.zeros((1, 3)), v.copy()
    u_new = u + DT * v
    force, _, _, _ = meet(TOUCH, 1.0, normals, u, v, u_new, v_new)
    assert v_new[0] == pytest.approx([3.0, 0.5, 1.0])
    assert u_new[0] == pytest.approx(DT * v_new[0])
    assert force[:2] == pytest.approx([6.0 * MASS / DT, 2.0 * MASS / DT])


def test_a_pressed_node_does_not_chatter_when_its_nearest_wall_changes():
    """The load turns to and fro between the walls of a corner: the node stays, and each wall has its share of now."""
    normals = groove(np.radians(35.0))
    angle = 0.5 * np.sin(np.linspace(0.0, 20.0, 400))
    loads = 50.0 * np.column_stack([np.sin(angle), 0.0 * angle, -np.cos(angle)])
    for load, (place, velocity, force, tau) in zip(
        loads, pressed(KINEMATIC, normals, None, 0.1, len(loads), loads), strict=True
    ):
        assert place == pytest.approx(np.zeros(3), abs=1e-15) and np.abs(velocity).max() < 1e-12
        assert force[:2] @ normals == pytest.approx(-load)
        assert np.abs(tau).max() < 1e-9


def test_walls_are_remembered_exactly_and_looked_for_seldom():
    """A node slides along the fillet's neighbourhood of an L: distances as a full search tells them, few searches."""
    surface, half = part_of(shapes.l_profile(0.3)).surface(), 0.5
    walls, searched = corners.Walls(surface, 1), []
    feet = surface.feet
    walls.surface = SimpleNamespace(feet=lambda *arguments: searched.append(1) or feet(*arguments))
    thickness, node = np.array([half]), np.zeros(1, dtype=np.int64)
    way = np.linspace(0.7, 0.495, 400)
    several = 0
    for x in way:
        local = np.array([[2.0 + x, 3.0, 2.0 + 0.499]])
        hit = surface.project(local)
        cornered = walls.look(node, local, hit, thickness)
        owner, further = feet(local, hit, half)
        if len(owner):
            assert len(cornered) == 1
            distance, normal, _, count = walls.at(node, local)
            assert count[0] >= 2
            exact = np.sort([hit.distance[0], further.distance[0]])
            assert np.sort(distance[0])[:2] == pytest.approx(exact, abs=10.0 * TRUST**3 * half)
            assert np.sort(normal[0, :2] @ [1.0, 0.0, 1.0]) == pytest.approx([1.0, 1.0], abs=TRUST**2)
            several += 1
    assert several > 5
    assert 1 < len(searched) < 40


@pytest.mark.parametrize("radius, searches", [(0.3, True), (1.2, False)])
def test_only_tools_with_tight_corners_have_walls(radius, searches):
    scene = stop(radius, Membrane())
    sheet = build_sheet(scene.blank)
    contact = first_state(scene, sheet, Explicit()).tools["DIE"]
    tool = scene.stages[0].tools[0]
    run = ToolRun(tool, tool.unit_axis, 0.0, 0.0, None, None, None, Neighbourhood(tool.surface, len(sheet.points)))
    n = len(sheet.points)
    made = ToolContact(run, contact, (KINEMATIC, 0.0), np.ones(n), np.ones((n, 3)), sheet.points, 4.0)
    assert (made.walls is not None) == searches


# Small blanks that hardly store energy: slow and well damped, with room for the waves of the first touch.
SLOW = Explicit(waves=60.0, damping=1.0, drift=0.2)


@pytest.mark.parametrize("element", [Membrane(), pytest.param(Shell(5), marks=pytest.mark.slow)])
def test_a_strip_pushed_into_a_tight_corner_is_held_by_both_walls(element):
    """On the floor of an L under 60 MPa, pushed by 0.11 mm, 0.1 of it free: the wall takes E/(1 - nu^2) A du/l."""
    scene = stop(0.3, element, mu=0.0)
    scene = replace(scene, stages=[replace(scene.stages[0], moved={"right": (-0.11, None, None)})])
    results = form(scene, SLOW, frames=1)
    left = scene.blank.mesh.groups["left"]
    assert results.contact["several_feet"] == 3
    area, length = 2.0 * T, 20.0
    pushed = 206000.0 / (1.0 - 0.3**2) * area * 0.01 / length
    assert -results.history["reaction_right_x"][-1] == pytest.approx(pushed, rel=5e-3)
    assert -results.history["force_DIE"][-1] == pytest.approx(60.0 * 40.0, rel=0.01)
    # Nothing has flowed: half the thickness it has unloaded from the floor and from the wall.
    edge = results.frames[-1].points[left][:, [0, 2]] - 2.0
    assert edge == pytest.approx(np.full((3, 2), 0.5 * T), abs=1e-9)
    assert results.energy["kinetic"] < 1e-6 * results.energy["internal"]
    assert abs(results.energy["imbalance"]) < 0.01 * results.energy["external"]


@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_an_edge_driven_into_a_groove_shares_its_load(mu):
    """60 degrees: a force F along the bisector presses with F on each wall, friction or not: nothing slides there."""
    cos, sin = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    mesh = strip(6, 2, 6.0, 2.0, 0.0)
    mesh.points += [0.5 * T / sin + 0.01, 0.0, 0.0]
    walls = Planes((sin, 0.0, cos), (sin, 0.0, -cos))
    blank = Blank(mesh, T, STEEL, Shell(3), fixed={"all": "y", "right": "yz"})
    tool = Tool("GROOVE", walls, Coulomb(mu) if mu else None, axis=(1, 0, 0))
    scene = Scene(blank, [Stage([tool], moved={"right": (-0.03, None, None)})])
    explicit, implicit = (form(scene, method, frames=1) for method in (SLOW, Implicit()))
    pushed = [-r.history["reaction_right_x"][-1] for r in (explicit, implicit)]
    # The implicit solver's contact gives by part of its skin.
    assert pushed[0] == pytest.approx(pushed[1], rel=0.05)
    assert -explicit.history["force_GROOVE"][-1] == pytest.approx(pushed[0], rel=0.01)
    pressure = explicit.frames[-1].point_fields["contact_pressure"]
    area = np.zeros(len(pressure))
    np.add.at(area, np.asarray(mesh.cells).ravel(), 2.0 * 6.0 / 24 / 3.0)
    assert np.count_nonzero(pressure) == 3
    assert pressure @ area == pytest.approx(2.0 * pushed[0], rel=0.01)
    assert explicit.energy["kinetic"] < 1e-6 * explicit.energy["internal"]
