"""Friction laws: their limits and slopes, tangents against finite differences, and strips with exact answers."""

import logging
from dataclasses import replace
from math import exp

import numpy as np
import pytest
from numba import njit

from solver import (
    ByFace,
    Coulomb,
    CoulombPressure,
    CoulombVelocity,
    Explicit,
    Implicit,
    Newton,
    SceneError,
    Stage,
    Stribeck,
    Tool,
    form,
)
from solver.contact.friction import Laws, coefficient, laws_of
from solver.contact.node_on_tool import SLIP, STICK
from tests.solver.contact.test_node_on_tool import TOOLS, force, near_skin, near_surface
from tests.solver.lattice import Plane
from tests.solver.strips import capstan, pressed_strip
from tests.solver.test_form import punch_stretch

OIL = Stribeck(0.15, 0.02, 1e-5, 1e-3, viscosity=5e-7, roughness=1e-3)
LAWS = {
    "Coulomb": Coulomb(0.12),
    "pressure": CoulombPressure(0.12, 10.0, 0.8),
    "velocity": CoulombVelocity(0.2, 0.08, 40.0),
    "Stribeck": OIL,
}


@njit
def mu_of(row, p, v):
    return coefficient(row, p, v)


def mu(law, p, v):
    return mu_of(laws_of(ByFace(law, {}), 1).rows[0], p, v)


def test_stribeck_has_its_limits_and_its_middle():
    def at(number):  # the lubrication number, at 10 MPa
        return mu(OIL, 10.0, number * 10.0 * OIL.roughness / OIL.viscosity)[0]

    assert at(0.0) == OIL.boundary
    # tanh(2 log10(L / L_m) / log10(L_b / L_h)), four decades off the middle of two: tanh(4)
    edge = 0.5 * (OIL.boundary - OIL.hydrodynamic) * (1.0 - np.tanh(4.0))
    assert at(1e-8) == pytest.approx(OIL.boundary - edge, rel=1e-12)
    assert at(1.0) == pytest.approx(OIL.hydrodynamic + edge, rel=1e-12)
    assert at(1e-4) == pytest.approx(0.085, rel=1e-12)
    # theory.md 7 written out at L_b
    by_theory = 0.5 * (0.17 + 0.13 * np.tanh(np.log10(1e-5**2 / 1e-8) / np.log10(1e-2)))
    assert at(1e-5) == pytest.approx(by_theory, rel=1e-12)
    assert mu(OIL, 0.0, 1.0)[0] == OIL.hydrodynamic


def test_pressure_and_velocity_laws_by_hand():
    assert mu(LAWS["pressure"], 10.0, 0.0)[0] == pytest.approx(0.12)
    assert mu(LAWS["pressure"], 320.0, 0.0)[0] == pytest.approx(0.06)  # 32^-0.2
    assert mu(LAWS["pressure"], 0.0, 0.0) == (pytest.approx(0.12 * 1e-3**-0.2), 0.0, 0.0)
    assert mu(LAWS["velocity"], 5.0, 0.0)[0] == 0.2
    assert mu(LAWS["velocity"], 5.0, 40.0)[0] == pytest.approx(0.08 + 0.12 / exp(1.0))


@pytest.mark.parametrize("name", LAWS)
def test_slopes_by_pressure_and_velocity(name):
    law = LAWS[name]
    for p, v in ((0.5, 3.0), (8.0, 40.0), (90.0, 700.0)):
        _, by_p, by_v = mu(law, p, v)
        dp, dv = 1e-6 * p, 1e-6 * v
        assert by_p == pytest.approx((mu(law, p + dp, v)[0] - mu(law, p - dp, v)[0]) / (2 * dp), rel=1e-6, abs=1e-12)
        assert by_v == pytest.approx((mu(law, p, v + dv)[0] - mu(law, p, v - dv)[0]) / (2 * dv), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("status", [STICK, SLIP])
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("surface", TOOLS)
def test_tangent_with_slopes_of_the_coefficient(surface, name, status):
    tool, rng = TOOLS[surface], np.random.default_rng(11)
    area, lapse = 8.0, 0.002
    rows = laws_of(ByFace(LAWS[name], {}), 1).rows
    laws = Laws(rows, np.zeros(1, np.int64), np.array([area]), np.array([lapse]))
    for _ in range(4):
        x_old = near_skin(tool, rng, -2e-3)
        n_old = tool.project(x_old).normal
        pull = np.cross(n_old[0], rng.standard_normal(3))
        slide = 2e-4 if status == STICK else 0.1
        x = near_surface(tool, x_old + slide * pull / np.linalg.norm(pull), -2.5e-3)
        move = 1e-4 * np.array([0.3, -0.2, 0.5])
        before = 0.5 * np.cross(n_old, [[0.3, 0.5, 0.1]]), n_old, np.array([STICK])

        def f(x, x_old=x_old, move=move, before=before):
            return force(tool, x, x_old, move, np.zeros(3), before, np.nan, 30.0, laws)

        _, k, state, tau, normal_force = f(x)
        assert state == status
        if status == SLIP:
            n = tool.project(x).normal[0]
            du = (x - x_old)[0] - move
            speed = np.linalg.norm(du - (du @ n) * n) / lapse
            limit = mu(LAWS[name], normal_force / area, speed)[0] * normal_force
            assert np.linalg.norm(tau) == pytest.approx(limit, rel=1e-12)
        step = 1e-7
        numeric = np.empty((3, 3))
        for c in range(3):
            e = step * np.eye(3)[[c]]
            numeric[:, c] = -(f(x + e)[0] - f(x - e)[0]) / (2 * step)
        assert k == pytest.approx(numeric, abs=5e-6 * np.abs(numeric).max())


def pulling_force(scene, method=None, late=0.5):
    """Mean over the later part of the stage of the force at the front [N], along x."""
    results = form(scene, method or Implicit(), frames=4)
    assert results.finished
    stroke = np.array(results.history["stroke"]) / results.history["stroke"][-1]
    return np.array(results.history["reaction_front_x"])[stroke > late].mean()


@pytest.mark.parametrize("name", LAWS)
def test_a_strip_between_plates_takes_twice_the_coefficient_of_its_pressure_and_speed(name):
    law, force, speed = LAWS[name], 5000.0, 60.0
    scene = pressed_strip(law, force=force, speed=speed)
    # 10 mm^2 of sheet per mm; it slides as a whole, at the speed of its front.
    wanted = 2.0 * force * mu(law, force / 500.0, speed)[0]
    # The strip's elongation makes its back end slower, by 1e-3 or so.
    assert pulling_force(scene) == pytest.approx(wanted, rel=2e-3)


def test_stribeck_friction_falls_as_the_press_goes_faster():
    forces = [pulling_force(pressed_strip(OIL, speed=speed)) for speed in (1e-6, 2e-1 / OIL.viscosity * 1e-5, 1e9)]
    assert forces[0] == pytest.approx(1e4 * OIL.boundary, rel=1e-3)
    assert forces[2] == pytest.approx(1e4 * OIL.hydrodynamic, rel=1e-3)
    assert forces[0] > forces[1] > forces[2]


def test_the_capstan_is_met():
    tension, angle = 200.0, 0.5 * np.pi
    scene, _ = capstan(Coulomb(0.15), tension, angle=angle)
    results = form(scene, frames=2)
    pulled = -results.history["reaction_front_z"][-1]
    assert pulled == pytest.approx(tension * exp(0.15 * angle), rel=2e-3)


@pytest.mark.parametrize("exponent", [0.7, 0.9])
def test_a_strip_over_a_cylinder_with_friction_that_follows_the_pressure(exponent):
    # dT/dphi = mu p R w with p = T / (R w): T^(1 - a) = T_0^(1 - a) + (1 - a) mu (R w p_0)^(1 - a) phi
    tension, width, angle = 200.0, 2.0, 0.5 * np.pi
    law = CoulombPressure(0.15, 4.0, exponent)
    scene, bend = capstan(law, tension, width=width, angle=angle)
    results = form(scene, frames=2)
    rest = 1.0 - exponent
    wanted = (tension**rest + rest * law.mu * (bend * width * law.pressure) ** rest * angle) ** (1.0 / rest)
    assert -results.history["reaction_front_z"][-1] == pytest.approx(wanted, rel=2e-3)


class TwoFaces(Plane):
    """A plane whose face is 1 beyond x = 25.5."""

    def project(self, points, seed=None):
        hit = super().project(points, seed)
        hit.face = (points[:, 0] > 25.5).astype(int)
        return hit


def test_each_face_of_a_tool_has_its_law():
    die = TwoFaces((0.0, 0.0, -0.5), (0.0, 0.0, 1.0))
    rough = ByFace(None, {1: Coulomb(0.2)})
    scene = pressed_strip(None, die=die)
    tools = [replace(scene.stages[0].tools[0], friction=rough), scene.stages[0].tools[1]]
    scene = replace(scene, stages=[replace(scene.stages[0], tools=tools)])
    # Nodes at 30, 35, 40, 45 mm and half of that at 50: 4.5 of 10 elements, under the same pressure.
    assert pulling_force(scene) == pytest.approx(0.2 * 5000.0 * 0.45, rel=2e-3)


@pytest.mark.parametrize("name", ["pressure", "velocity", "Stribeck"])
def test_newton_stays_quadratic(name, caplog):
    scene = punch_stretch(size=4.0, mu=0.0)
    ball = replace(scene.stages[0].tools[0], friction=LAWS[name])
    scene = replace(scene, stages=[replace(scene.stages[0], tools=[ball], speed=50.0)])
    with caplog.at_level(logging.INFO, logger="cadlink"):
        results = form(scene, Implicit(newton=Newton(residual=1e-9, correction=1e-6)), frames=5)
    assert results.finished and results.energy["friction"] > 0.0
    orders = []
    for line in (r.message for r in caplog.records if r.message.startswith("fraction")):
        r = np.array([float(text) for text in line.split("residuals")[1].split()])
        for a, b, c in zip(r, r[1:], r[2:]):
            if 1e-2 > a > b > c > 3e-13 and b > 1e-8:
                orders.append(np.log(c / b) / np.log(b / a))
    assert len(orders) >= 3
    assert np.median(orders) > 1.8


def test_explicit_friction_follows_pressure_and_the_stage_s_own_speed():
    # The tools' speed in the run is another one; in the middle of the stroke it is twice the mean. Friction grows with
    # speed here: where it falls, a strip sticks and slips by itself.
    speed, seen, faster = 30.0, {}, CoulombVelocity(0.08, 0.2, 40.0)
    middle = mu(faster, 10.0, 2.0 * speed)[0]
    for law in (Coulomb(0.12), LAWS["pressure"], Coulomb(middle), faster):
        results = form(pressed_strip(law, travel=3.0, speed=speed), Explicit(waves=300.0), frames=1)
        stroke = np.array(results.history["stroke"])
        seen[law] = np.array(results.history["reaction_front_x"])[(stroke > 0.45) & (stroke < 0.55)].mean()
    assert seen[LAWS["pressure"]] == pytest.approx(seen[Coulomb(0.12)], rel=1e-3)  # 0.12 at its 10 MPa
    assert seen[faster] == pytest.approx(seen[Coulomb(middle)], rel=0.01)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: CoulombPressure(0.1, 0.0, 0.9), "friction pressure: found 0.0, expected a number above 0"),
        (lambda: CoulombVelocity(0.1, -0.1, 1.0), "friction coefficient at speed: found -0.1, expected a number of 0"),
        (lambda: Stribeck(0.1, 0.01, 1e-3, 1e-4, 1e-7, 1e-3), "L_hydrodynamic: found 0.0001, expected a number above"),
        (lambda: ByFace(None, {"top": Coulomb(0.1)}), "by face: found face 'top', expected its index, 0 or more"),
        (lambda: Tool("DIE", Plane(), 0.1), "tool 'DIE' friction: found 0.1, expected one of Coulomb"),
        (lambda: Stage([Tool("P", Plane(), OIL, travel=1.0)]), "stage 'draw' speed: missing, expected mm/s: .*'P'"),
        (lambda: Stage(speed=0.0), "stage 'draw' speed: found 0.0, expected mm/s above 0"),
    ],
)
def test_what_makes_no_sense_is_one_line(make, message):
    with pytest.raises(SceneError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_the_plan_names_laws_and_speed():
    scene = pressed_strip(ByFace(OIL, {3: Coulomb(0.05)}), speed=60.0)
    text = str(scene.plan())
    assert "Stribeck friction, 0.15 boundary to 0.02 hydrodynamic; friction 0.05 on face(s) 3" in text
    assert "60 mm/s: it lasts 0.00833 s" in text


def test_units_do_not_matter():
    # Metres and pascals in place of millimetres and megapascals: forces stay newtons, seconds seconds.
    scene = punch_stretch(size=5.0, mu=0.0, travel=3.0)
    law = replace(OIL, boundary=0.2)
    at_speed = replace(scene.stages[0], speed=50.0, tools=[replace(scene.stages[0].tools[0], friction=law)])
    first = form(replace(scene, stages=[at_speed]), frames=1).frames[-1]
    blank, tool = scene.blank, scene.stages[0].tools[0]
    mesh = replace(blank.mesh, points=1e-3 * blank.mesh.points)
    hardening = blank.material.hardening
    material = replace(
        blank.material, young=1e6 * blank.material.young, hardening=replace(hardening, K=1e6 * hardening.K)
    )
    ball = type(tool.surface)(1e-3 * tool.surface.centre, 1e-3 * tool.surface.radius)
    law = replace(law, viscosity=1e6 * law.viscosity, roughness=1e-3 * law.roughness)
    punch = replace(tool, surface=ball, friction=law, travel=1e-3 * tool.travel)
    blank = replace(blank, mesh=mesh, thickness=1e-3 * blank.thickness, material=material)
    stage = replace(scene.stages[0], speed=0.05, tools=[punch])
    second = form(replace(scene, blank=blank, stages=[stage]), frames=1).frames[-1]
    assert 1e3 * second.points == pytest.approx(first.points, abs=1e-7)
    assert second.cell_fields["strain_major"].max() > 0.01
