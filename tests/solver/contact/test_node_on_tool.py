"""Tangents of contact and friction against finite differences, on tools of every curvature."""

import numpy as np
import pytest
from numba import njit

from solver.contact.node_on_tool import OPEN, SLIP, STICK, contact_forces, hessian_of_distance
from solver.contact.normal_law import EASE, Flow, elastic_force, force_of, no_flow, normal_slope, trial_of
from tests.solver.lattice import Ball, Bar, Plane

TOOLS = {
    "plane": Plane((0.0, 0.0, 0.0), (0.2, -0.1, 1.0)),
    "convex ball": Ball((0.0, 0.0, -5.0), 5.0),
    "bar": Bar((0.0, 0.0, -3.0), 3.0),
}
KN, KT = 5.0e4, 2.0e4
HARD = 900.0  # MPa of pressure for a strain of one


def flowing(force, hardening=HARD):
    """Flow of one node 0.8 mm thick that bears this force on 1 mm^2, and more by its hardening [MPa]."""
    one = np.ones(1)
    curve = np.array([0.0, 1.0]), np.array([force, force + hardening])
    return Flow(0.0 * one, 0.8 * one, one, *curve)


def near_skin(tool, rng, gap):
    """A point at a gap from the skin."""
    point = rng.uniform(-1.5, 1.5, (1, 3)) * [1.0, 1.0, 0.2] + [0.0, 0.0, 0.3]
    hit = tool.project(point)
    return hit.point + (0.4 + gap) * hit.normal


def force(tool, x, x_old, move, travel, before, mu, lam=0.0, laws=None, flow=None):
    """Contact force (3,), stiffness (3, 3), status and friction of one node of a sheet 0.8 mm thick."""
    hit = tool.project(x - travel)
    one = np.ones(1)
    f, k, tau, n_new = np.zeros((1, 3)), np.zeros((1, 3, 3)), np.zeros((1, 3)), np.zeros((1, 3))
    normal_force, gap, state = np.zeros(1), np.zeros(1), np.zeros(1, np.int64)
    contact_forces(
        np.zeros(1, np.int64), hit.distance, hit.normal, hit.curvature, hit.direction, hit.face, 0.4 * one, 1e-12,
        False, lam * one, KN * one, KT * one, flow or no_flow(1), mu, laws, *before, x, x_old + move, f, k,
        normal_force, tau, n_new, gap, state,
    )  # fmt: skip
    return f[0], k[0], state[0], tau[0], normal_force[0]


@pytest.mark.parametrize("lam, flow", [(0.0, None), (80.0, None), (0.0, flowing(90.0)), (80.0, flowing(90.0))])
@pytest.mark.parametrize("status", [STICK, SLIP])
@pytest.mark.parametrize("name", TOOLS)
def test_tangent_of_normal_and_friction_force(name, status, lam, flow):
    tool, rng = TOOLS[name], np.random.default_rng(7)
    for _ in range(5):
        x_old = near_skin(tool, rng, -2e-3)
        n_old = tool.project(x_old).normal
        pull = rng.standard_normal(3)
        pull -= (pull @ n_old[0]) * n_old[0]
        slide = 1e-3 if status == STICK else 0.3
        x = x_old + slide * pull / np.linalg.norm(pull)
        x = near_surface(tool, x, -2.5e-3)
        move = np.array([0.001, -0.002, 0.0005]) * (0.1 if status == STICK else 1.0)
        tau_old = 5.0 * np.cross(n_old, [[0.3, 0.5, 0.1]])
        before = tau_old, n_old, np.array([STICK])
        f, k, state, tau, normal_force = force(tool, x, x_old, move, np.zeros(3), before, 0.3, lam, flow=flow)
        assert state == status
        assert abs(tau @ tool.project(x).normal[0]) < 1e-9 * np.linalg.norm(f)
        assert np.linalg.norm(tau) <= 0.3 * normal_force * (1 + 1e-12)
        assert flow is None or normal_force > flow.force[0]
        step = 1e-7
        numeric = np.empty((3, 3))
        for c in range(3):
            e = np.zeros((1, 3))
            e[0, c] = step
            up = force(tool, x + e, x_old, move, np.zeros(3), before, 0.3, lam, flow=flow)[0]
            down = force(tool, x - e, x_old, move, np.zeros(3), before, 0.3, lam, flow=flow)[0]
            numeric[:, c] = -(up - down) / (2 * step)
        assert k == pytest.approx(numeric, abs=2e-6 * KN)


@pytest.mark.parametrize("hardening", [0.0, HARD, 50.0 * HARD])
def test_a_node_of_metal_that_flows_bears_what_its_hardening_lets_it(hardening):
    def pressed(overlap, flow):
        x = np.array([[0.0, 0.0, 0.4 - overlap]])
        nothing = np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1, np.int64)
        return force(Plane(), x, x, np.zeros(3), np.zeros(3), nothing, 0.0, flow=flow)[4]

    flow = flowing(100.0, hardening)
    least = 100.0 / KN  # overlap at which it begins
    assert pressed(0.5 * least, flow) == pytest.approx(50.0)
    assert pressed(least, flow) == pytest.approx(100.0)
    # KN (overlap - s/2) = 100 + hardening s / t
    s = 200.0 / (hardening / 0.8 + 0.5 * KN)
    borne = 100.0 + hardening * s / 0.8
    assert pressed(3.0 * least, flow) == pytest.approx(borne + EASE * (300.0 - borne))
    assert pressed(3.0 * least, None) == pytest.approx(300.0)


def test_the_law_is_one_for_a_node_and_for_arrays():
    band, trial = 2.0, np.array([-3.0, -2.0, -1.0, 0.0, 1.9, 2.0, 5.0])
    one = np.array([elastic(f, band) for f in trial])
    assert force_of(trial, band) == pytest.approx(one[:, 0])
    assert normal_slope(trial, band, np.zeros(7, dtype=bool)) == pytest.approx(one[:, 1])
    assert trial_of(one[1:, 0], band) == pytest.approx(trial[1:])


@njit
def elastic(trial, band):
    return elastic_force(trial, band, False)


def near_surface(tool, x, gap):
    hit = tool.project(x)
    return hit.point + (0.4 + gap) * hit.normal


def test_slip_tangent_is_unsymmetric_and_stick_on_a_plane_symmetric():
    tool = Plane()
    x_old = np.array([[0.0, 0.0, 0.399]])
    before = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([STICK])
    slid = force(tool, x_old + [[0.1, 0.0, 0.0]], x_old, np.zeros(3), np.zeros(3), before, 0.2)[1]
    stuck = force(tool, x_old + [[1e-5, 0.0, 0.0]], x_old, np.zeros(3), np.zeros(3), before, 0.2)[1]
    assert slid[0, 2] == pytest.approx(-0.2 * KN)
    assert slid[2, 0] == 0.0
    assert stuck == pytest.approx(np.diag([KT, KT, KN]))


def test_friction_is_turned_with_the_normal_without_changing_its_size():
    ball = TOOLS["convex ball"]
    x_old = near_surface(ball, np.array([[0.0, 0.0, 0.5]]), -1e-2)
    n_old = ball.project(x_old).normal
    tau_old = np.array([[3.0, 4.0, 0.0]])
    x = near_surface(ball, np.array([[0.0, 1e-9, 0.5]]), -1e-2)
    tool = Ball((0.0, -1.0, -5.0), 5.0)  # another ball, whose normal at the node differs by 11 degrees
    x = near_surface(tool, x, -1e-2)
    tau = force(tool, x, x, np.zeros(3), np.zeros(3), (tau_old, n_old, np.array([STICK])), 10.0)[3]
    assert np.linalg.norm(tau) == pytest.approx(5.0)
    assert tau @ tool.project(x).normal[0] == pytest.approx(0.0, abs=1e-12)


def test_a_new_contact_starts_without_friction_history():
    tool = Plane()
    x = np.array([[0.0, 0.0, 0.39]])
    before = np.array([[100.0, 0.0, 0.0]]), np.zeros((1, 3)), np.array([OPEN])
    # A node that left has no friction force left to carry: the caller stores zero with OPEN.
    before[0][:] = 0.0
    assert force(tool, x, x, np.zeros(3), np.zeros(3), before, 0.2)[3] == pytest.approx(np.zeros(3))


def test_an_open_node_has_no_force():
    f, k, state, *_ = force(
        Plane(), np.array([[0.0, 0.0, 0.5]]), np.zeros((1, 3)), np.zeros(3), np.zeros(3),
        (np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1, np.int64)), 0.2,
    )  # fmt: skip
    assert not f.any() and not k.any() and state == OPEN


@njit
def hessian(d, n, curvature, e1, h):
    hessian_of_distance(d, n, curvature, e1, h)


@pytest.mark.parametrize("name", TOOLS)
def test_hessian_of_distance_is_the_derivative_of_the_normal(name):
    tool, x = TOOLS[name], np.array([[0.3, -0.2, 0.7]])
    hit = tool.project(x)
    h = np.empty((3, 3))
    hessian(hit.distance[0], hit.normal[0], hit.curvature[0], hit.direction[0], h)
    for c in range(3):
        e = 1e-6 * np.eye(3)[c]
        numeric = (tool.project(x + e).normal - tool.project(x - e).normal)[0] / 2e-6
        assert h[:, c] == pytest.approx(numeric, abs=1e-8)
