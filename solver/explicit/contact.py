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
from types import SimpleNamespace

import numpy as np
from numba import njit, prange
from scipy.linalg import eigh

from ..contact.drive import lanes, spins, to_space, to_tool
from ..contact.feet import MOST
from ..contact.node_on_tool import OPEN, SLIP, STICK
from .corners import Walls, meet_walls
from .laws import BY_PATH, GRIP, KINEMATIC, PENALTY, answer, grip_of, velocity_at

FEW = 1000  # nodes that one thread meets sooner than several begin


@njit(cache=True)
def wake(points, travel, axis, place, distance, reach, before, normal_force, tau, status, near):
    """Fills near with the nodes that may lie closer to the tool than their reach, and their rows of place with where
    they are now; opens those that were near before. Returns how many. What is not a number is near nothing.

    points : the first n rows are nodes; travel (1,) of the tool along its axis (3,); place (n, 3), distance (n,):
    where each was projected last, in the tool's frame, and how far from it; it changes by no more than the node moves.
    """
    for k in range(before.shape[0]):
        node = before[k]
        normal_force[node], status[node] = 0.0, OPEN
        tau[node, 0] = tau[node, 1] = tau[node, 2] = 0.0
    count = 0
    s1, s2, s3 = travel[0] * axis[0], travel[0] * axis[1], travel[0] * axis[2]
    for node in range(reach.shape[0]):
        x1, x2, x3 = points[node, 0] - s1, points[node, 1] - s2, points[node, 2] - s3
        slack = distance[node] - reach[node]
        moved = (x1 - place[node, 0]) ** 2 + (x2 - place[node, 1]) ** 2 + (x3 - place[node, 2]) ** 2
        if not (moved < np.inf) or (slack > 0.0 and moved < slack * slack):
            continue
        near[count] = node
        place[node, 0], place[node, 1], place[node, 2] = x1, x2, x3
        count += 1
    return count


@njit(forceinline=True, _nrt=False)  # counting references to its arrays would take most of its time
def meet_node(
    node, law, parameter, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """One node of `meet_tool`."""
    d = distance[node] - half_thickness[node]
    gap[node], normal_force[node], status[node] = d, 0.0, OPEN
    for c in range(3):
        tau[node, c] = 0.0
    if d >= 0.0:
        return
    m, tool = mass[node], velocity_at(w, u_new[node])
    hold = vn = before = 0.0
    for c in range(3):
        hold += free[node, c] * normal[node, c] * normal[node, c]
        vn += (v_new[node, c] - tool[c]) * normal[node, c]
        before += (v[node, c] - tool[c]) * normal[node, c]
    lost[node] = BY_PATH
    if hold < GRIP:
        return
    # Along the normal.
    gain, lift, taken = answer(law, parameter, d, vn, before, dt, dtm)
    if taken >= 0.0:
        lost[node] = 0.5 * m * taken / hold
    dv, lift = gain / hold, lift / hold
    force = m * dv / dtm
    # Across it. A law's speed is the one that the node has, not what the step would give it without friction.
    sliding = across = 0.0
    for c in range(3):
        slide = v_new[node, c] - tool[c] - vn * normal[node, c]
        tau[node, c] = slide
        sliding += slide * slide
        across += (v[node, c] - tool[c]) ** 2
    sliding = sqrt(sliding)
    speed = sqrt(max(across - before * before, 0.0))
    stopped = dv * grip_of(mu, laws, face[node], node, force, speed)
    factor = 0.0
    if stopped > 0.0 and sliding > 0.0:
        factor = -min(1.0, stopped / sliding)
    status[node] = STICK if stopped > 0.0 and sliding <= stopped else SLIP
    normal_force[node] = force
    for c in range(3):
        slowed = factor * tau[node, c]
        tau[node, c] = m * slowed / dtm
        n_new[node, c] = normal[node, c]
        v_new[node, c] += free[node, c] * (dv * normal[node, c] + slowed)
        u_new[node, c] += free[node, c] * (lift * normal[node, c] + dt * slowed)


@njit(cache=True)
def meet_few(
    law, parameter, near, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """`meet_tool` on one thread."""
    for k in range(near.shape[0]):
        meet_node(
            near[k], law, parameter, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
            u_new, v_new, gap, normal_force, n_new, tau, status, lost,
        )  # fmt: skip


@njit(parallel=True, cache=True)
def meet_tool(
    law, parameter, near, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """Puts the nodes that overlap a tool back, and gives them their friction.

    parameter : restitution of a touch; stiffness of a penalty over the node's mass [1/s^2]
    near : (k,) nodes; distance (n,), normal (n, 3), face (n,) of their projection after the predicted step (penalty:
    before it); mu : coefficient of friction; laws : Laws in its place where it is more than a number, or None
    half_thickness (n,), mass (n,); free : (n, 3) 1 where a node may move; w : (3, 3) of the tool, see velocity_at;
    v : before the step
    changes u_new, v_new (n, 3); fills gap (n,), normal_force (n,), n_new (n, 3), tau (n, 3), status (n,) of these
    nodes, and lost (n,) mJ, or BY_PATH
    """
    for k in prange(near.shape[0]):
        meet_node(
            near[k], law, parameter, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
            u_new, v_new, gap, normal_force, n_new, tau, status, lost,
        )  # fmt: skip


@njit(cache=True)
def contact_work(near, normal_force, normal, tau, lost, v, v_new, u_new, w, axis, dtm, mass, free, impulse):
    """Adds the impulse on the tool (3,) [N s]. Returns the work of the tool, and of what holds its nodes, lost in
    contact, lost in friction [mJ], the force on the sheet along the tool's axis [N], mass of the touching nodes
    [tonne].

    lost : (n,) mJ, or BY_PATH; u_new : (n, 3) where the nodes are
    """
    driven = collided = rubbed = along = touching = 0.0
    for k in range(near.shape[0]):
        node = near[k]
        if normal_force[node] == 0.0:
            continue
        touching += mass[node]
        by_path = lost[node] == BY_PATH
        if not by_path:
            collided += lost[node]
        tool = velocity_at(w, u_new[node])
        for c in range(3):
            push = normal_force[node] * normal[node, c]
            path = (0.5 * (v[node, c] + v_new[node, c]) - tool[c]) * dtm
            driven += (push + tau[node, c]) * tool[c] * dtm
            if free[node, c] == 0.0:
                # What holds the node takes this force, over the node's way.
                driven -= (push + tau[node, c]) * (path + tool[c] * dtm)
            if by_path:
                collided -= push * path
            rubbed -= tau[node, c] * path
            along += (push + tau[node, c]) * axis[c]
            impulse[c] -= (push + tau[node, c]) * dtm
    return driven, collided, rubbed, along, touching


class ToolContact:
    """One tool of a stage: who is near, where they meet it, and the tool's own movement.

    run : ToolRun; contact : ContactState, filled in place; law : (number, parameter); mass : (n,); free : (n, 3)
    x : (n, 3) of the nodes at the stage's start; weight : mass of a tool driven by a force, over the sheet's. It is
    spread like the sheet's, so that it turns as sluggishly as it travels.
    """

    def __init__(self, run, contact, law, mass, free, x, weight):
        self.run, self.contact = run, contact
        self.law, self.parameter = law
        self.mass, self.free, self.mu = mass, free, run.tool.mu
        n = len(contact.status)
        self.room = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        self.near = self.room[0][:0]
        self.lost = np.zeros(n)
        self.walls = Walls(run.tool.surface, n) if contact.further else None
        self.cornered = self.room[0][:0]
        # Velocities of the free coordinates (drive.py): travel, and tilts times a length [mm/s].
        n_tilts = 0 if run.drive is None else len(run.drive.axes)
        self.rates = np.zeros(1 + n_tilts)
        self.w, self.at = np.zeros((3, 3)), self.here()
        self.place_pivot()
        sheet = mass[:n]
        self.inertia = np.full((1, 1), weight * sheet.sum())
        if n_tilts:
            v = lanes(run, contact, spins(run, contact)[0], x)
            self.inertia = weight * np.einsum("n,jnc,knc->jk", sheet, v, v)
        self.inverse = np.linalg.inv(self.inertia)
        # Of the sheet on these coordinates [N]; and what the damper of its bounce makes of it, now and a step before.
        touching = np.flatnonzero(contact.touching)
        self.reaction, self.bounce = self.reacted(x, touching, float(contact.force @ run.axis), sheet[touching].sum())
        self.bounce_before = self.bounce
        self.impulse = np.zeros(3)  # on the tool since the last record [N s]

    @property
    def velocity(self):
        """Along the axis [mm/s]."""
        return self.rates[0]

    def here(self):
        """Where the tool is, as a ContactState tells it."""
        return SimpleNamespace(travel=self.contact.travel.copy(), tilt=self.contact.tilt.copy())

    def place_pivot(self):
        """Velocity and place of the point the tool turns about."""
        run = self.run
        self.w[0] = self.rates[0] * run.axis
        if run.pivot is not None:
            self.w[2] = run.pivot + self.contact.travel[0] * run.axis

    def travel_to(self, travel, dt):
        """Move a tool of prescribed travel over a step."""
        if self.law == PENALTY:
            self.at = self.here()
        self.rates[0] = (travel - self.contact.travel[0]) / dt
        self.contact.travel[0] = travel
        self.place_pivot()

    def be_driven(self, load, dt, dtm):
        """Move a tool by the load (j,) [N] on its free coordinates, the sheet's reaction, and the damping of its bounce
        on the sheet.

        The sheet holds it as springs of stiffness m/dt^2. The damper, of critical strength, is the change of a multiple
        of the reaction: it resists no steady movement, and leaves no impulse behind when a node lets go.
        """
        contact, drive = self.contact, self.run.drive
        if self.law == PENALTY:
            self.at = self.here()
        force = load + self.reaction + self.bounce - self.bounce_before
        self.rates += dtm * self.inverse @ force
        contact.travel[0] += dt * self.rates[0]
        if len(drive.axes):
            tilts = self.rates[1:]
            contact.tilt += dt / drive.lever * tilts @ drive.axes
            self.w[1] = tilts @ spins(self.run, contact)[0][1:]
        self.place_pivot()

    def meet(self, u, v, half_thickness, dt, dtm, u_new, v_new):
        """Let the nodes touch the tool at the end of their predicted step."""
        contact, watch, run = self.contact, self.run.neighbourhood, self.run
        points, at = (u, self.at) if self.law == PENALTY else (u_new, contact)
        travel = at.travel
        if run.pivot is not None:
            points, travel = to_tool(run, at, points[: len(half_thickness)]), np.zeros(1)
        self.room = self.room[::-1]
        count = wake(
            points, travel, run.axis, watch.place, watch.distance, half_thickness, self.near, contact.normal_force,
            contact.friction_force, contact.status, self.room[0],
        )  # fmt: skip
        self.near = near = self.room[0][:count]
        watch.n_asked += len(half_thickness)
        if self.walls is not None:
            self.leave_corners()
        if not count:
            return
        watch.follow(near)
        hit = watch.hit
        if self.walls is not None:
            cornered = self.walls.look(near, watch.place, hit, half_thickness)
            if len(cornered):
                self.meet_corners(cornered, watch.place, half_thickness, dt, dtm, v, u_new, v_new)
                near = np.setdiff1d(near, cornered, assume_unique=True)
        if run.pivot is not None:
            hit = to_space(run, at, hit)
        meet = meet_few if count < FEW else meet_tool
        meet(
            self.law, self.parameter, near, hit.distance, hit.normal, hit.face, half_thickness, self.mass, self.free,
            self.mu, run.laws, self.w, dt, dtm, v, u_new, v_new, contact.gap, contact.normal_force,
            contact.normal, contact.friction_force, contact.status, self.lost,
        )  # fmt: skip

    def leave_corners(self):
        """Open the further feet of nodes that had some."""
        for foot in self.contact.further:
            foot.normal_force[self.cornered], foot.status[self.cornered] = 0.0, OPEN
            foot.friction_force[self.cornered], foot.gap[self.cornered] = 0.0, np.inf
        self.cornered = self.cornered[:0]

    def meet_corners(self, nodes, place, half_thickness, dt, dtm, v, u_new, v_new):
        """Let nodes (k,) of those at place (n, 3) in the tool's frame touch all walls of a tight corner."""
        run, k = self.run, len(nodes)
        distance, normal, face, n_walls = self.walls.at(nodes, place)
        gap = distance - half_thickness[nodes, None]
        force, tau, status = np.zeros((k, MOST)), np.zeros((k, MOST, 3)), np.zeros((k, MOST), dtype=np.int64)
        meet_walls(
            self.law, self.parameter, nodes, gap, normal, face, n_walls, half_thickness, self.mass, self.free,
            self.mu, run.laws, self.w, dt, dtm, v, u_new, v_new, force, tau, status, self.lost,
        )  # fmt: skip
        for j, foot in enumerate(self.contact.feet):
            foot.gap[nodes], foot.normal_force[nodes], foot.normal[nodes] = gap[:, j], force[:, j], normal[:, j]
            foot.friction_force[nodes], foot.status[nodes] = tau[:, j], status[:, j]
        self.cornered = nodes

    def reacted(self, x, nodes, along, touching):
        """What the sheet does to the free coordinates (j,) [N], and that times the damper of the tool's bounce on it.

        x : (n, 3); nodes : that may touch; along : their force along the axis [N]; touching : their mass

        The tool, of inertia M, bounces on B/dt^2, where B is the mass of the touching nodes as seen along their
        normals. With B phi = mu M phi its modes have omega dt = sqrt(mu), and are damped critically by
        sum 2/sqrt(mu) (M phi)(phi .) of the change of the reaction.
        """
        if len(self.rates) == 1:
            damper = 2.0 * sqrt(self.inertia[0, 0] / touching) if touching > 0.0 else 0.0
            return np.array([along]), np.array([damper * along])
        contact = self.contact
        v = lanes(self.run, contact, spins(self.run, contact)[0], x[nodes])
        reaction = -np.einsum("nc,jnc->j", contact.push[nodes], v)
        across = np.einsum("jnc,nc->jn", v, contact.normal[nodes])
        held = (self.mass[nodes] * (contact.status[nodes] != OPEN) * across) @ across.T
        mu, phi = eigh(held, self.inertia)
        there = mu > 1e-9 * mu[-1]
        phi, mu = phi[:, there], mu[there]
        return reaction, self.inertia @ phi @ (2.0 / np.sqrt(mu) * (phi.T @ reaction))

    def work(self, v, v_new, u_new, dtm, sums):
        """Add the step's work of the tool, contact and friction to sums [mJ], once all tools have been met."""
        feet = [(self.contact, self.near)]
        if len(self.cornered):
            feet += [(foot, self.cornered) for foot in self.contact.further]
        along = touching = 0.0
        for foot, nodes in feet:
            if len(nodes):
                driven, collided, rubbed, push, held = contact_work(
                    nodes, foot.normal_force, foot.normal, foot.friction_force, self.lost, v, v_new, u_new, self.w,
                    self.run.axis, dtm, self.mass, self.free, self.impulse,
                )  # fmt: skip
                sums["external"] += driven
                sums["contact"] += collided
                sums["friction"] += rubbed
                along, touching = along + push, touching + held
        if self.run.drive is not None:
            self.bounce_before = self.bounce
            self.reaction, self.bounce = self.reacted(u_new, self.near, -along, touching)

    def record(self, half_thickness, span):
        """Finish the contact's state: its force is the mean over the span [s] since the last record."""
        contact = self.contact
        contact.force[:] = self.impulse / span
        self.impulse[:] = 0.0
        far = np.ones(len(half_thickness), dtype=bool)
        far[self.near] = False
        contact.gap[far] = (self.run.neighbourhood.distance - half_thickness)[far]
        for foot in contact.feet:
            if self.law == KINEMATIC:
                foot.gap[foot.status != OPEN] = 0.0
            foot.multiplier[:] = foot.normal_force


def in_order(tools):
    """Tools in the order in which nodes meet them: driven by a force, travelling, standing still."""
    return sorted(tools, key=lambda run: 0 if run.drive is not None else 1 if run.tool.travel is not None else 2)
