"""The damper of a tool on springs: critical against its swing, nothing against what the stage asks of it."""

from math import exp, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from solver.explicit.pacing import Pacing
from solver.explicit.spring_damper import BETA, GAMMA, SpringDamper, spring_stiffness

MASS, STIFFNESS = 2e-3, 800.0
OMEGA = sqrt(STIFFNESS / MASS)


def guided():
    """A tool along z on one spring."""
    drive = SimpleNamespace(stiffness=STIFFNESS)
    return SimpleNamespace(drive=drive, pivot=None, axis=np.array([0.0, 0.0, 1.0]))


def tilting():
    """A tool along z on three springs at pins beside its pivot, free to tilt about x and y."""
    pins = np.array([[30.0, 0.0, 0.0], [-10.0, 20.0, 0.0], [-10.0, -25.0, 0.0]])
    axes, lever = np.eye(3)[:2], 15.0
    drive = SimpleNamespace(stiffness=STIFFNESS, pins=pins, axes=axes, lever=lever)
    run = SimpleNamespace(drive=drive, pivot=np.zeros(3), axis=np.array([0.0, 0.0, 1.0]))
    return run, SimpleNamespace(tilt=np.zeros(3), travel=np.zeros(1))


def test_a_tool_let_go_does_not_swing_but_returns_on_a_triple_root():
    damper = SpringDamper(guided(), None, np.array([[MASS]]))
    damper.b[:] = 1.0  # the stage has long gone on, and the tool has stood still
    x, v, dt = 1.0, np.zeros(1), 1e-4 / OMEGA
    # p = -1/sqrt 3 three times: x = (1 + a s + b s^2) exp(-s/sqrt 3) with x'(0) = 0 and x''(0) = -1.
    p = 1.0 / sqrt(3.0)
    a, b = p, 0.5 * (p * p - 1.0)
    for step in range(150_000):
        v = v + dt * (-STIFFNESS * x + damper.force(v, 1.0, dt)) / MASS
        x = x + dt * float(v[0])
        if step % 10_000 == 0:
            s = (step + 1) * 1e-4
            assert x == pytest.approx((1.0 + a * s + b * s * s) * exp(-p * s), abs=1e-3)
    # All that the spring held is what the damper took.
    assert damper.work == pytest.approx(0.5 * STIFFNESS * 1.0**2, rel=5e-3)


def test_a_movement_that_follows_the_stage_is_not_resisted():
    damper, pacing = SpringDamper(guided(), None, np.array([[MASS]])), Pacing(20.0 / OMEGA, 0.5, 0.0)
    dt = pacing.duration / 1000
    way = 30.0 * np.array([pacing.fraction(k * dt) for k in range(1001)])
    for speed in np.diff(way) / dt:
        assert abs(damper.force(np.array([speed]), speed / 30.0, dt)[0]) < 1e-9 * MASS * OMEGA * 30.0 / pacing.duration
    # A movement that sets in, or leaves what it was, is followed within some swings.
    first = damper.force(np.array([50.0]), 0.1, dt)
    for _ in range(10_000):
        last = damper.force(np.array([50.0]), 0.1, dt)
    assert abs(last[0]) < 1e-6 * abs(first[0])


def test_a_tool_is_damped_in_full_where_the_stage_stands():
    damper = SpringDamper(guided(), None, np.array([[MASS]]))
    assert damper.force(np.array([3.0]), 0.0, 1e-6)[0] == pytest.approx(-8.0 / (3.0 * sqrt(3.0)) * MASS * OMEGA * 3.0)


def test_springs_at_pins_are_damped_in_each_of_their_modes():
    run, contact = tilting()
    stiffness = spring_stiffness(run, contact)
    # A third of the spring at each pin, that moves by z + theta x r along the axis.
    x, y = run.drive.pins[:, 0], run.drive.pins[:, 1]
    along = np.stack([np.ones(3), y / 15.0, -x / 15.0])
    assert stiffness == pytest.approx(STIFFNESS / 3.0 * along @ along.T)
    inertia = np.diag([1.0, 1.4, 0.7]) * MASS + 0.1 * MASS
    damper = SpringDamper(run, contact, inertia)
    # With the stage long gone on (b = 1), rates, a and coordinates have each mode's root -omega/sqrt(3) three times.
    inverse, zero, eye = np.linalg.inv(inertia), np.zeros((3, 3)), np.eye(3)
    pull = inverse @ damper.modes * (GAMMA * damper.omega)
    follow = (BETA * damper.omega)[:, None]
    whole = np.block(
        [
            [-pull @ damper.modes.T, pull, -inverse @ stiffness],
            [follow * damper.modes.T, -follow * eye, zero],
            [eye, zero, zero],
        ]
    )
    omega = np.sqrt(np.linalg.eigvals(inverse @ stiffness).real)
    found = np.sort(np.linalg.eigvals(whole).real)
    # A triple root is known to the cube root of round-off.
    assert found == pytest.approx(np.sort(np.repeat(-omega / sqrt(3.0), 3)), rel=1e-3)
    damper.b[:] = 1.0
    rates = np.array([1.0, -2.0, 3.0])
    assert inverse @ damper.force(rates, 1.0, 1e-12) == pytest.approx(whole[:3, :3] @ rates, rel=1e-6)
