"""Nodes put back on the tools' exact faces after a linear step.

A correction of Newton's method moves nodes along straight lines and contact forces along the tangent of their law. On a
curved face the line's end is off by kappa dx^2 / 2, which the contact stiffness turns into a large force; where the law
is rounded, a force that falls to nothing would only be quartered each time; and a node that lands has gone through the
face. So each node goes along its normal to the gap that has the force foreseen for it (n normal, v the tool's movement)

    N* = N - N'(g) kn n . (dx - v),    g* = (lam - trial(N*)) / kn,

one that is foreseen to pull goes where the force ends, and one that would land goes where a small force begins; so does
one that merely grazes its tool, of which round-off says whether it touches, and whose force no slope foretells. What is
left for the next correction is what the sheet itself answers. Nodes that touch in several places stay where the step
takes them.
"""

from typing import NamedTuple

import numpy as np

from .drive import movement_of, to_space, to_tool
from .feet import SAME_WALL
from .node_on_tool import OPEN
from .normal_law import normal_slope, trial_of

LANDING = 0.1  # slope of the contact law where a node lands: its force is a hundredth of that at the rounding's middle
GRAZE = 1e-3  # slope below which a node bears nothing


class Foreseen(NamedTuple):
    """Contact of one tool where a step starts, and what the step does to it by the tangent.

    alone : (n,) nodes that bear here and touch nowhere else; away : (n,) those that bear nowhere
    normal : (n, 3); force, change : (n,) normal force there, and what the whole step adds [N]
    """

    alone: np.ndarray
    away: np.ndarray
    normal: np.ndarray
    force: np.ndarray
    change: np.ndarray


def places_touched(state):
    """How many feet of each node touch a tool, (n,)."""
    return np.sum([foot.status != OPEN for contact in state.tools.values() for foot in contact.feet], axis=0)


def foresee(runs, state, skin, dx, dw):
    """{tool: Foreseen} of a step of the nodes dx (n, 3) and of the driven tools dw (j,) [mm] from a state."""
    places, first, found = places_touched(state), 0, {}
    for run in runs:
        contact, move = state.tools[run.tool.name], dx
        if run.drive is not None:
            own = slice(first, first + 1 + len(run.drive.axes))
            first = own.stop
            move = dx - movement_of(run, state, dw[own])
        slope = normal_slope(contact.multiplier - run.kn * contact.gap, run.kn * skin, contact.normal_force < 0.0)
        change = -slope * run.kn * np.einsum("nc,nc->n", contact.normal, move)
        bears = (contact.status != OPEN) & (slope > GRAZE)
        away = (places == 0) | (places == 1) & (contact.status != OPEN) & ~bears
        normal, force = contact.normal.copy(), contact.normal_force.copy()
        found[run.tool.name] = Foreseen((places == 1) & bears, away, normal, force, change)
    return found


def put_back(runs, state, foreseen, step, half_thickness, skin, fixed):
    """Put the nodes of a state where a part of a step has led, along the exact faces.

    foreseen : of the whole step; half_thickness : (n,) and skin [mm] of the contact law; fixed : (n, 3) bool
    """
    for run in runs:
        contact, (alone, away, normal, force, change) = state.tools[run.tool.name], foreseen[run.tool.name]
        rest = contact.multiplier / run.kn  # gap at which the force would be the rounding's middle
        points = to_tool(run, contact, state.sheet.x)
        nodes, hit = run.neighbourhood.project(points, np.where(alone, np.inf, half_thickness + rest + skin))
        hit = to_space(run, contact, hit)
        gap, kn, rest = hit.distance - half_thickness[nodes], run.kn[nodes], rest[nodes]
        wanted = (force + step * change)[nodes]
        goal = rest - trial_of(wanted, kn * skin) / kn
        goal = np.where(wanted > 0.0, goal, np.maximum(gap, goal))
        same_wall = np.einsum("nc,nc->n", hit.normal, normal[nodes]) > SAME_WALL
        landed = np.where(away[nodes], np.maximum(gap, rest + (1.0 - LANDING) * skin), gap)
        move = np.where(alone[nodes] & same_wall, goal, landed) - gap
        state.sheet.x[nodes] += np.where(fixed[nodes], 0.0, move[:, None] * hit.normal)
