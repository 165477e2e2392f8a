"""Nodes that a linear step takes off a curved tool go back onto it with the force foreseen for them."""

from types import SimpleNamespace

import numpy as np
import pytest

from solver.contact.drive import ToolRun
from solver.contact.node_on_tool import OPEN, SLIP
from solver.contact.put_back import LANDING, foresee, put_back
from solver.contact.search import Neighbourhood
from solver.state import new_contact
from tests.solver.lattice import Ball

RADIUS, HALF, SKIN = 20.0, 0.5, 2e-3
KN = 4.0e4 * np.ones(4)
FREE = np.zeros((4, 3), bool)


def law(gap, lam):
    """Normal force of the rounded law [N]."""
    trial, band = lam - KN * gap, KN * SKIN
    rounded = np.maximum(trial + band, 0.0) ** 2 / (4.0 * band)
    return np.where(trial > band, trial, rounded)


@pytest.fixture
def touching():
    """Four nodes on a ball: pressed hard, pressed lightly, about to leave, and near it without touching."""
    tool = SimpleNamespace(name="BALL")
    run = ToolRun(
        tool, np.array([0.0, 0.0, 1.0]), 0.0, 1.0, None, KN, KN, Neighbourhood(Ball((0, 0, -RADIUS), RADIUS), 4)
    )
    angle = np.array([0.0, 0.05, 0.1, 0.15])
    normal = np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    gap = np.array([-4e-3, 1e-3, 1.5e-3, 3e-3])
    contact = new_contact(4)
    contact.multiplier[:] = [20.0, 0.0, 0.0, 0.0]
    contact.gap[:], contact.normal[:], contact.normal_force[:] = gap, normal, law(gap, contact.multiplier)
    contact.status[:] = [SLIP, SLIP, SLIP, OPEN]
    x = (RADIUS + HALF + gap)[:, None] * normal - [0.0, 0.0, RADIUS]
    return run, SimpleNamespace(sheet=SimpleNamespace(x=x), tools={"BALL": contact})


@pytest.mark.parametrize("step", [0.3, 1.0])
def test_nodes_slide_along_the_face_with_the_forces_of_the_tangent(touching, step):
    run, state = touching
    contact, x = state.tools["BALL"], state.sheet.x
    force = contact.normal_force.copy()
    # A long way along the face, a little up and down: the last but one lifts, the last one goes through the face.
    along = np.cross([0.0, 1.0, 0.0], contact.normal)
    dx = 0.5 * along + np.array([-1e-3, 2e-4, 1e-2, -2e-2])[:, None] * contact.normal
    foreseen = foresee([run], state, SKIN, dx, np.zeros(0))
    x += step * dx
    put_back([run], state, foreseen, step, HALF * np.ones(4), SKIN, FREE)
    gap = np.linalg.norm(x + [0.0, 0.0, RADIUS], axis=1) - RADIUS - HALF
    now = law(gap, contact.multiplier)
    # The law's own slope at the start, by differences.
    small = 1e-9
    slope = (law(contact.gap + small, contact.multiplier) - law(contact.gap - small, contact.multiplier)) / (2 * small)
    tangent = force + step * slope * np.sum(dx * contact.normal, axis=1)
    assert now[:2] == pytest.approx(tangent[:2], rel=1e-6)
    assert now[2] == pytest.approx(max(tangent[2], 0.0), abs=1e-9)
    assert gap[3] == pytest.approx((1.0 - LANDING) * SKIN)
    assert 0.0 < now[3] < 0.01 * KN[3] * SKIN


def test_held_unknowns_and_nodes_that_touch_twice_stay_where_the_step_takes_them(touching):
    run, state = touching
    other = new_contact(4)
    other.status[1] = SLIP
    state.tools["OTHER"] = other
    dx = np.tile([0.5, 0.0, 0.0], (4, 1))
    fixed = FREE.copy()
    fixed[0, 2] = True
    foreseen = foresee([run], state, SKIN, dx, np.zeros(0))
    state.sheet.x += dx
    before = state.sheet.x.copy()
    put_back([run], state, foreseen, 1.0, HALF * np.ones(4), SKIN, fixed)
    assert state.sheet.x[1] == pytest.approx(before[1], abs=0.0)
    assert state.sheet.x[0, 2] == before[0, 2] and state.sheet.x[0, 0] != before[0, 0]
