"""Contact laws node by node, against mechanics of one mass (benchmarks.md M)."""

import sys
from pathlib import Path

import numpy as np
import pytest

from solver.explicit.central_differences import predict
from solver.explicit.contact import meet_tool
from solver.explicit.laws import KINEMATIC, PENALTY, TOUCH

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "examples" / "dropped_mass"))
from dropped_mass import CRITICAL, GRAVITY, HEIGHT, MASS, drop, first_top

# Spread of the first top over the drop, by share of the critical step (benchmarks.md M).
SPREAD = {0.05: (0.9975, 1.0025), 0.1: (0.9925, 1.0075), 0.2: (0.978, 1.023), 0.4: (0.906, 1.104), 0.6: (0.64, 1.56)}


@pytest.mark.parametrize("share", SPREAD)
def test_penalty_gives_and_takes_energy(share):
    ratio = first_top(PENALTY, share, phases=100 if share < 0.2 else 300)
    low, high = SPREAD[share]
    assert 1.0 - ratio.min() == pytest.approx(1.0 - low, rel=0.15)
    assert ratio.max() - 1.0 == pytest.approx(high - 1.0, rel=0.15)


def test_penetration_of_the_penalty():
    # delta = mg/k (1 + sqrt(1 + 2 k h/(mg))), 1.410558 mm at k = 1e6 N/m
    _, heights, _ = drop(PENALTY, 0.01 * CRITICAL)
    assert heights.min() == pytest.approx(-1.410558e-3, rel=1e-4)


@pytest.mark.parametrize("share", [0.5, 0.95, 7.0])
def test_touch_keeps_the_height_of_a_thousand_bounces(share):
    tops = drop(TOUCH, share * CRITICAL, 1000)[2]
    assert tops == pytest.approx(HEIGHT, rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_touch_keeps_the_height_of_a_thousand_bounces_at_any_steps(seed):
    """Each step of another length, anything below the penalty's critical one."""
    rng = np.random.default_rng(seed)
    lowest = rng.uniform(0.1, 0.9)
    steps = iter(lambda: float(rng.uniform(lowest, 1.0)) * CRITICAL, None)
    tops = drop(TOUCH, steps, 1000)[2]
    assert tops == pytest.approx(np.full(1000, HEIGHT), rel=1e-3)  # what is asked for
    assert tops[-1] == pytest.approx(HEIGHT, rel=1e-8)


def slide(law, mu, speed, pull=0.0, dt=1e-3, steps=400):
    """A mass pressed on a plane by its weight, with a velocity and a pull along x. Yields place, velocity, forces."""
    u, v, u_new, v_new = (np.zeros((1, 3)) for _ in range(4))
    v[0] = speed, 0.0, 0.0
    mass, half, external = np.array([MASS]), np.zeros(1), np.array([[pull, 0.0, -MASS * GRAVITY]])
    nothing, fixed, free = np.zeros((1, 3)), np.zeros((1, 3), dtype=bool), np.ones((1, 3))
    gap, force, tau, status = np.zeros(1), np.zeros(1), np.zeros((1, 3)), np.zeros(1, dtype=np.int64)
    normal, near, rest = np.zeros((1, 3)), np.zeros(1, dtype=np.int64), np.zeros((3, 3))
    parameter = {KINEMATIC: 0.0, TOUCH: 0.0, PENALTY: 0.05 / dt**2}[law]
    for _ in range(steps):
        predict(u, v, mass, external, nothing, fixed, nothing, 0.0, dt, dt, 0.0, u_new, v_new)
        distance = (u if law == PENALTY else u_new)[:, 2].copy()
        meet_tool(
            law, parameter, near, distance, np.array([[0.0, 0.0, 1.0]]), near, half, mass, free, mu, None, rest, dt, dt,
            v, u_new, v_new, gap, force, normal, tau, status, np.zeros(1),
        )  # fmt: skip
        u, u_new, v, v_new = u_new, u, v_new, v
        yield u[0].copy(), v[0].copy(), force[0], tau[0].copy()


@pytest.mark.parametrize("law", [KINEMATIC, TOUCH])
def test_a_sliding_mass_stops_where_its_energy_is_rubbed_away(law):
    mu, speed = 0.3, 1.0
    path = list(slide(law, mu, speed))
    place, velocity, force, _ = path[-1]
    assert velocity == pytest.approx(np.zeros(3), abs=1e-12)
    assert place[0] == pytest.approx(speed**2 / (2.0 * mu * GRAVITY), rel=5e-3)
    assert place[2] == pytest.approx(0.0, abs=1e-12)
    assert force == pytest.approx(MASS * GRAVITY)
    for _, v, n, tau in path[:-1]:
        assert np.linalg.norm(tau) <= mu * n * (1.0 + 1e-12)
        assert v[0] >= -1e-12


@pytest.mark.parametrize("law", [KINEMATIC, TOUCH, PENALTY])
def test_friction_inside_the_cone_holds_and_outside_it_slides(law):
    # A penalty's normal force swings between 0 and twice the weight as the mass is let go: it may slip.
    mu = 0.5
    held = list(slide(law, mu, 0.0, pull=0.5 * mu * MASS * GRAVITY))[-1]
    if law != PENALTY:
        assert held[0][0] == pytest.approx(0.0, abs=1e-12)
        assert held[3][0] == pytest.approx(-0.5 * mu * MASS * GRAVITY)
    sliding = list(slide(law, mu, 0.0, pull=2.0 * mu * MASS * GRAVITY))[-1]
    assert sliding[1][0] == pytest.approx(mu * GRAVITY * 0.4, rel=0.02)


@pytest.mark.parametrize("law", [KINEMATIC, TOUCH])
def test_a_node_lands_on_the_plane_and_its_impulse_is_its_momentum(law):
    dt, mass = 0.1, 2.0
    u, v = np.array([[0.0, 0.0, 0.05]]), np.array([[0.0, 0.0, -1.0]])
    u_new, v_new = u + dt * v, v.copy()
    gap, force, tau, status = np.zeros(1), np.zeros(1), np.zeros((1, 3)), np.zeros(1, dtype=np.int64)
    lost = np.zeros(1)
    meet_tool(
        law, 1.0, np.zeros(1, dtype=np.int64), u_new[:, 2].copy(), np.array([[0.0, 0.0, 1.0]]),
        np.zeros(1, dtype=np.int64), np.zeros(1), np.array([mass]), np.ones((1, 3)), 0.0, None, np.zeros((3, 3)), dt,
        dt, v, u_new, v_new, gap, force, np.zeros((1, 3)), tau, status, lost,
    )  # fmt: skip
    assert force[0] * dt == pytest.approx(mass * (v_new[0, 2] - v[0, 2]))
    if law == KINEMATIC:
        assert u_new[0, 2] == pytest.approx(0.0, abs=1e-15)
    else:
        # Half the step down, half of it up again, without loss.
        assert u_new[0, 2] == pytest.approx(0.05) and v_new[0, 2] == pytest.approx(1.0)
        assert lost[0] == 0.0
