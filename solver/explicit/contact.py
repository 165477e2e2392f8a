"""Rigid tools in explicit steps, three ways behind one call: kinematic, touch and penalty (theory.md 10).

Symbols, of one node: g gap of its skin after the predicted step, n the tool's normal there, w velocity of the tool;
v, u its velocity and place as predicted; m mass, N normal force, tau friction force. A law changes the velocity by
dv along n; then N = m dv/dtm. Friction takes from the tangential velocity relative to the tool what it needs to stop
it, and no more than mu dv.

A node that several tools touch meets them one after the other, those driven by a force first and those that stand
still last. Pinched between two, it is pushed by each out of the overlap that the other leaves: both feel a spring
of stiffness m/dt^2, the stiffest that a node can carry, and the last one is met exactly.
"""

from math import sqrt

import numpy as np
from numba import njit, prange

from ..contact.friction import coefficient, law_at
from ..contact.node_on_tool import OPEN, SLIP, STICK
from .method import Kinematic, Penalty, Touch

KINEMATIC, TOUCH, PENALTY = 0, 1, 2
BY_PATH = -1.0  # energy lost in contact is the force's work along the node's path
GRIP = 0.1  # part of the normal that has to lie along free directions


def law_of(contact, dt):
    """Number of a law and its parameter. dt : stable step at the stage's start [s]"""
    if isinstance(contact, Penalty):
        return PENALTY, contact.stiffness / dt**2
    if isinstance(contact, Touch):
        return TOUCH, float(contact.restitution)
    assert isinstance(contact, Kinematic)
    return KINEMATIC, 0.0


@njit(cache=True)
def wake(points, shift, place, distance, reach, before, normal_force, tau, status, near, local):
    """Fills near with the nodes that may lie closer to the tool than their reach, and local (n, 3) with their places in
    the tool's frame; opens those that were near before. Returns how many.

    points : the first n rows are nodes; shift : (3,) travel of the tool; place (n, 3), distance (n,): where each was
    projected last, in the tool's frame, and how far from it; the distance changes by no more than the node moves.
    """
    for k in range(before.shape[0]):
        node = before[k]
        normal_force[node], status[node] = 0.0, OPEN
        tau[node, 0] = tau[node, 1] = tau[node, 2] = 0.0
    count = 0
    s1, s2, s3 = shift[0], shift[1], shift[2]
    for node in range(reach.shape[0]):
        x1, x2, x3 = points[node, 0] - s1, points[node, 1] - s2, points[node, 2] - s3
        slack = distance[node] - reach[node]
        if slack > 0.0:
            moved = (x1 - place[node, 0]) ** 2 + (x2 - place[node, 1]) ** 2 + (x3 - place[node, 2]) ** 2
            if moved < slack * slack:
                continue
        near[count] = node
        local[count, 0], local[count, 1], local[count, 2] = x1, x2, x3
        count += 1
    return count


@njit(forceinline=True)
def bounce(gap, approach, pull, dt, restitution):
    """A step divided at the instant of first touch.

    gap : at the step's start; approach : velocity of the gap then; pull : its acceleration, constant
    returns : gap at the end, velocity of the gap as `predict` goes on from it, velocity squared that the bounce took.
    A node that comes to rest on the tool within the step stays there.
    """
    # First root of gap + approach tau + pull tau^2 / 2; a node already overlapping touches at once.
    tau = 0.0
    if gap > 0.0:
        # gap at the end is negative, so there is one root within the step
        root = sqrt(max(approach * approach - 2.0 * pull * gap, 0.0))
        tau = min(max(2.0 * gap / (root - approach), 0.0), dt) if root > approach else dt
    left = dt - tau
    impact = min(approach + pull * tau, 0.0)
    back = -restitution * impact
    end = back * left + 0.5 * pull * left * left
    if end <= 0.0:
        return 0.0, -gap / dt, BY_PATH
    return end, back + pull * left - 0.5 * pull * dt, impact * impact - back * back


@njit(parallel=True, cache=True)
def meet_tool(
    law, parameter, near, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """Puts the nodes that overlap a tool back, and gives them their friction.

    parameter : restitution of a touch; stiffness of a penalty over the node's mass [1/s^2]
    near : (k,) nodes; distance (k,), normal (k, 3), face (k,) of their projection after the predicted step (penalty:
    before it); mu : coefficient of friction; laws : Laws in its place where it is more than a number, or None
    half_thickness (n,), mass (n,); free : (n, 3) 1 where a node may move; w : (3,) mm/s;
    v : before the step
    changes u_new, v_new (n, 3); fills gap (n,), normal_force (n,), n_new (n, 3), tau (n, 3), status (n,) of these
    nodes, and lost (n,) mJ, or BY_PATH
    """
    for k in prange(near.shape[0]):
        node = near[k]
        m = mass[node]
        d = distance[k] - half_thickness[node]
        gap[node] = d
        hold = vn = 0.0
        for c in range(3):
            hold += free[node, c] * normal[k, c] * normal[k, c]
            vn += (v_new[node, c] - w[c]) * normal[k, c]
        normal_force[node], status[node], lost[node] = 0.0, OPEN, BY_PATH
        for c in range(3):
            tau[node, c] = 0.0
        if d >= 0.0 or hold < GRIP:
            continue
        # Along the normal.
        if law == KINEMATIC:
            dv = -d / (dt * hold)
            lift = dt * dv
        elif law == PENALTY:
            dv = -d * parameter * dtm / hold
            lift = dt * dv
        else:
            before = 0.0
            for c in range(3):
                before += (v[node, c] - w[c]) * normal[k, c]
            pull = (vn - before) / dtm
            start = d - dt * vn
            end, after, taken = bounce(start, vn - 0.5 * dt * pull, pull, dt, parameter)
            if taken >= 0.0:
                lost[node] = 0.5 * m * taken / hold
            dv, lift = (after - vn) / hold, (end - d) / hold
        force = m * dv / dtm
        # Across it.
        sliding = 0.0
        for c in range(3):
            slide = free[node, c] * (v_new[node, c] - w[c] - vn * normal[k, c])
            tau[node, c] = slide
            sliding += slide * slide
        sliding = sqrt(sliding)
        stopped = mu * dv
        if laws is not None:
            row = laws.rows[law_at(laws.law_of_face, face[k])]
            # The speed it has, not the one that the step would give it without friction.
            along = across = 0.0
            for c in range(3):
                along += (v[node, c] - w[c]) * normal[k, c]
                across += (v[node, c] - w[c]) ** 2
            speed = sqrt(max(across - along * along, 0.0)) / laws.lapse[0]
            stopped = dv * coefficient(row, max(force, 0.0) / laws.area[node], speed)[0]
        factor = 0.0
        if stopped > 0.0 and sliding > 0.0:
            factor = -min(1.0, stopped / sliding)
        status[node] = STICK if stopped > 0.0 and sliding <= stopped else SLIP
        normal_force[node] = force
        for c in range(3):
            slowed = factor * tau[node, c]
            tau[node, c] = m * slowed / dtm
            n_new[node, c] = normal[k, c]
            v_new[node, c] += free[node, c] * dv * normal[k, c] + slowed
            u_new[node, c] += free[node, c] * lift * normal[k, c] + dt * slowed


@njit(cache=True)
def contact_work(near, normal_force, normal, tau, lost, v, v_new, w, axis, dtm, mass, impulse):
    """Adds the impulse on the tool (3,) [N s]. Returns work of the tool, lost in contact, lost in friction [mJ], the
    force on the sheet along the tool's axis [N], mass of the touching nodes [tonne]."""
    driven = collided = rubbed = along = touching = 0.0
    for k in range(near.shape[0]):
        node = near[k]
        if normal_force[node] == 0.0:
            continue
        touching += mass[node]
        by_path = lost[node] == BY_PATH
        if not by_path:
            collided += lost[node]
        for c in range(3):
            push = normal_force[node] * normal[node, c]
            path = (0.5 * (v[node, c] + v_new[node, c]) - w[c]) * dtm
            driven += (push + tau[node, c]) * w[c] * dtm
            if by_path:
                collided -= push * path
            rubbed -= tau[node, c] * path
            along += (push + tau[node, c]) * axis[c]
            impulse[c] -= (push + tau[node, c]) * dtm
    return driven, collided, rubbed, along, touching


class ToolContact:
    """One tool of a stage: who is near, where they meet it, and the tool's own movement.

    run : ToolRun; contact : ContactState, filled in place; law : (number, parameter); mass : (n,); free : (n, 3);
    inertia : of a tool driven by a force [tonne]
    """

    def __init__(self, run, contact, law, mass, free, inertia):
        self.run, self.contact, self.inertia = run, contact, inertia
        self.law, self.parameter = law
        self.mass, self.free = mass, free
        n = len(contact.status)
        self.room = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        self.near, self.local = self.room[0][:0], np.empty((n, 3))
        self.lost = np.zeros(n)
        self.velocity = 0.0  # along the axis [mm/s]
        # Of the sheet along the axis, in the last step and the one before [N], and the mass that felt it.
        self.reaction = self.reaction_before = float(contact.force @ run.axis)
        self.touching = float(mass[: len(contact.status)][contact.status != OPEN].sum())
        self.impulse = np.zeros(3)  # on the tool since the last record [N s]

    def travel_to(self, travel, dt):
        """Move a tool of prescribed travel over a step."""
        self.velocity = (travel - self.contact.travel[0]) / dt
        self.contact.travel[0] = travel

    def be_driven(self, load, dt, dtm):
        """Move a tool by its load, the sheet's reaction, and the damping of its bounce on the sheet.

        The sheet holds it as springs of stiffness m/dt^2, omega dt = sqrt(sum m/M). The damper of critical strength
        acts on the change of the reaction, so that it resists no steady movement.
        """
        change = self.reaction - self.reaction_before
        bounce = 2.0 * np.sqrt(self.inertia / self.touching) * change if self.touching > 0.0 else 0.0
        self.velocity += dtm / self.inertia * (self.run.press * load + self.reaction + bounce)
        self.contact.travel[0] += dt * self.velocity

    def meet(self, u, v, half_thickness, dt, dtm, u_new, v_new):
        """Let the nodes touch the tool at the end of their predicted step."""
        contact, watch = self.contact, self.run.neighbourhood
        w = self.velocity * self.run.axis
        shift, points = contact.travel[0] * self.run.axis, u_new
        if self.law == PENALTY:
            shift, points = shift - dt * w, u
        self.room = self.room[::-1]
        count = wake(
            points, shift, watch.place, watch.distance, half_thickness, self.near, contact.normal_force,
            contact.friction_force, contact.status, self.room[0], self.local,
        )  # fmt: skip
        self.near = near = self.room[0][:count]
        watch.n_asked += len(half_thickness)
        watch.n_projected += count
        if not count:
            return
        hit = watch.project_these(near, self.local[:count])
        meet_tool(
            self.law, self.parameter, near, hit.distance, hit.normal, hit.face, half_thickness, self.mass, self.free,
            self.run.tool.mu, self.run.laws, w, dt, dtm, v, u_new, v_new, contact.gap, contact.normal_force,
            contact.normal, contact.friction_force, contact.status, self.lost,
        )  # fmt: skip

    def work(self, v, v_new, dtm, sums):
        """Add the step's work of the tool, contact and friction to sums [mJ], once all tools have been met."""
        contact, axis = self.contact, self.run.axis
        driven, collided, rubbed, along, self.touching = contact_work(
            self.near, contact.normal_force, contact.normal, contact.friction_force, self.lost, v, v_new,
            self.velocity * axis, axis, dtm, self.mass, self.impulse,
        )  # fmt: skip
        sums["external"] += driven
        sums["contact"] += collided
        sums["friction"] += rubbed
        self.reaction_before, self.reaction = self.reaction, -along

    def record(self, half_thickness, span):
        """Finish the contact's state: its force is the mean over the span [s] since the last record."""
        contact = self.contact
        contact.force[:] = self.impulse / span
        self.impulse[:] = 0.0
        far = np.ones(len(half_thickness), dtype=bool)
        far[self.near] = False
        contact.gap[far] = (self.run.neighbourhood.distance - half_thickness)[far]
        if self.law == KINEMATIC:
            contact.gap[contact.status != OPEN] = 0.0
        contact.multiplier[:] = contact.normal_force


def in_order(tools):
    """Tools in the order in which nodes meet them: driven by a force, travelling, standing still."""
    return sorted(tools, key=lambda run: 0 if run.drive is not None else 1 if run.tool.travel is not None else 2)
