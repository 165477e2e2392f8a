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
from .laws import BY_PATH, GRIP, KINEMATIC, PENALTY, TOUCH, answer, grip_of, velocity_at

FEW = 1000  # nodes that one thread meets sooner than several begin


# Counting references to their arrays would take most of these functions' time, testing divisors some of it.
POINT = {"_nrt": False, "error_model": "numpy"}


@njit(forceinline=True, **POINT)
def row(a, i):
    """Row i (3,) of a."""
    return a[i, 0], a[i, 1], a[i, 2]


@njit(forceinline=True, **POINT)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(forceinline=True, **POINT)
def open_node(node, normal_force, tau, status):
    if status[node] != OPEN:
        normal_force[node], status[node] = 0.0, OPEN
        tau[node, 0] = tau[node, 1] = tau[node, 2] = 0.0


@njit(forceinline=True, **POINT)
def meet_node(
    node, law, parameter, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """One node of `meet_tool`; whether it touches."""
    d, n, f = distance[node] - half_thickness[node], row(normal, node), row(free, node)
    gap[node] = d
    hold = f[0] * n[0] * n[0] + f[1] * n[1] * n[1] + f[2] * n[2] * n[2]
    if d >= 0.0 or hold < GRIP:
        open_node(node, normal_force, tau, status)
        return False
    # Relative to the tool, now and half a step ago.
    m, tool = mass[node], velocity_at(w, u_new[node])
    now = (v_new[node, 0] - tool[0], v_new[node, 1] - tool[1], v_new[node, 2] - tool[2])
    then = (v[node, 0] - tool[0], v[node, 1] - tool[1], v[node, 2] - tool[2])
    vn, before = dot(now, n), dot(then, n)
    # Along the normal.
    gain, lift, taken = answer(law, parameter, d, vn, before, dt, dtm)
    if law == TOUCH:
        lost[node] = 0.5 * m * taken / hold if taken >= 0.0 else BY_PATH
    dv, lift, per_dt = gain / hold, lift / hold, m / dtm
    force = per_dt * dv
    # Across it. A law's speed is the one that the node has, not what the step would give it without friction.
    slide = (now[0] - vn * n[0], now[1] - vn * n[1], now[2] - vn * n[2])
    sliding = sqrt(dot(slide, slide))
    speed = 0.0 if laws is None else sqrt(max(dot(then, then) - before * before, 0.0))
    stopped = dv * grip_of(mu, laws, face[node], node, force, speed)
    factor = 0.0
    if stopped > 0.0 and sliding > 0.0:
        factor = -min(1.0, stopped / sliding)
    status[node] = STICK if stopped > 0.0 and sliding <= stopped else SLIP
    normal_force[node] = force
    for c in range(3):
        slowed = factor * slide[c]
        tau[node, c] = per_dt * slowed
        n_new[node, c] = n[c]
        v_new[node, c] += f[c] * (dv * n[c] + slowed)
        u_new[node, c] += f[c] * (lift * n[c] + dt * slowed)
    return True


@njit(cache=True)
def meet_few(
    law, parameter, near, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """`meet_tool` on one thread."""
    touching = between = 0
    for k in range(near.shape[0]):
        for node in range(between, near[k]):
            open_node(node, normal_force, tau, status)
        between = near[k] + 1
        touching += meet_node(
            near[k], law, parameter, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
            u_new, v_new, gap, normal_force, n_new, tau, status, lost,
        )  # fmt: skip
    for node in range(between, half_thickness.shape[0]):
        open_node(node, normal_force, tau, status)
    return touching


@njit(parallel=True, cache=True)
def meet_tool(
    law, parameter, near, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, gap, normal_force, n_new, tau, status, lost,
):  # fmt: skip
    """Opens all nodes, puts back those that overlap a tool, and gives these their friction. Returns how many touch.

    parameter : restitution of a touch; stiffness of a penalty over the node's mass [1/s^2]
    near : (k,) nodes that may overlap, in order
    distance (n,), normal (n, 3), face (n,) of their projection after the predicted step (penalty: before it)
    mu : coefficient of friction; laws : Laws in its place where it is more than a number, or None
    half_thickness (n,), mass (n,); free : (n, 3) 1 where a node may move; w : (3, 3) of the tool, see velocity_at;
    v : before the step
    changes u_new, v_new (n, 3); fills normal_force (n,), tau (n, 3), status (n,), gap (n,) of near nodes, n_new (n, 3)
    of those that touch, and of these for the law of touch lost (n,) mJ, or BY_PATH
    """
    touching = 0
    for node in prange(half_thickness.shape[0]):
        open_node(node, normal_force, tau, status)
    for k in prange(near.shape[0]):
        touching += meet_node(
            near[k], law, parameter, distance, normal, face, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
            u_new, v_new, gap, normal_force, n_new, tau, status, lost,
        )  # fmt: skip
    return touching


@njit(cache=True)
def contact_work(
    near, normal_force, normal, tau, lost, v, v_new, u_new, w, axis, dtm, mass, free, impulse, pressing,
):  # fmt: skip
    """Adds the impulse on the tool (3,) and the normal one on its nodes, pressing (n,) [N s]. Returns the work of the
    tool, and of what holds its nodes, lost in contact, lost in friction [mJ], the force on the sheet along the tool's
    axis [N], mass of the touching nodes [tonne].

    lost : (n,) mJ, or BY_PATH; u_new : (n, 3) where the nodes are
    """
    driven = collided = rubbed = touching = 0.0
    total = (0.0, 0.0, 0.0)
    for k in range(near.shape[0]):
        node = near[k]
        pressed = normal_force[node]
        if pressed == 0.0:
            continue
        touching += mass[node]
        pressing[node] += pressed * dtm
        tool, n, rub = velocity_at(w, u_new[node]), row(normal, node), row(tau, node)
        force = (pressed * n[0] + rub[0], pressed * n[1] + rub[1], pressed * n[2] + rub[2])
        total = (total[0] + force[0], total[1] + force[1], total[2] + force[2])
        # Velocity relative to the tool, in the middle of the step.
        along = across = 0.0
        for c in range(3):
            pace = 0.5 * (v[node, c] + v_new[node, c]) - tool[c]
            along += n[c] * pace
            across += rub[c] * pace
            driven += force[c] * tool[c]
            if free[node, c] == 0.0:
                # What holds the node takes this force, over the node's way.
                driven -= force[c] * (pace + tool[c])
        if lost[node] == BY_PATH:
            collided -= pressed * along * dtm
        else:
            collided += lost[node]
        rubbed -= across
    for c in range(3):
        impulse[c] -= total[c] * dtm
    return driven * dtm, collided, rubbed * dtm, dot(total, axis), touching


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
        # Nodes that may touch, and how many do: any may have before.
        self.room = np.empty(n, dtype=np.int64)
        self.near, self.n_touching = self.room[:0], n
        self.lost = np.full(n, BY_PATH)
        self.walls = Walls(run.tool.surface, n) if contact.further else None
        self.cornered = self.near
        # Velocities of the free coordinates (drive.py): travel, and tilts times a length [mm/s].
        n_tilts = 0 if run.drive is None else len(run.drive.axes)
        self.rates = np.zeros(1 + n_tilts)
        self.w, self.at, self.shift = np.zeros((3, 3)), self.here(), np.zeros(3)
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
        self.pressing = np.zeros(n)  # normal one on the nodes since the sheet last gave way to it (pinch.py) [N s]

    @property
    def velocity(self):
        """Along the axis [mm/s]."""
        return self.rates[0]

    def here(self):
        """Where the tool is, as a ContactState tells it."""
        return SimpleNamespace(travel=self.contact.travel.copy(), tilt=self.contact.tilt.copy())

    def place_pivot(self):
        """How far the tool has travelled; velocity and place of the point it turns about."""
        run = self.run
        np.multiply(run.axis, self.contact.travel, out=self.shift)
        self.w[0] = self.rates[0] * run.axis
        if run.pivot is not None:
            self.w[2] = run.pivot + self.shift

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
        shift = self.shift if at is contact else at.travel * run.axis
        if run.pivot is not None:
            points, shift = to_tool(run, at, points[: len(half_thickness)]), np.zeros(3)
        count = watch.look(points, shift, half_thickness, self.room)
        self.near = near = self.room[:count]
        if not count and not self.n_touching:
            return
        hit, cornered = watch.hit, ()
        if self.walls is not None:
            self.leave_corners()
            cornered = self.walls.look(near, watch.place, hit, half_thickness)
            if len(cornered):
                near = np.setdiff1d(near, cornered, assume_unique=True)
        if run.pivot is not None:
            hit = to_space(run, at, hit)
        meet = meet_few if count < FEW else meet_tool
        self.n_touching = meet(
            self.law, self.parameter, near, hit.distance, hit.normal, hit.face, half_thickness, self.mass, self.free,
            self.mu, run.laws, self.w, dt, dtm, v, u_new, v_new, contact.gap, contact.normal_force,
            contact.normal, contact.friction_force, contact.status, self.lost,
        )  # fmt: skip
        if len(cornered):
            self.meet_corners(cornered, watch.place, half_thickness, dt, dtm, v, u_new, v_new)

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
        self.n_touching += k

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
        feet = [(self.contact, self.near)] if self.n_touching else []
        if len(self.cornered):
            feet += [(foot, self.cornered) for foot in self.contact.further]
        along = touching = 0.0
        for foot, nodes in feet:
            driven, collided, rubbed, push, held = contact_work(
                nodes, foot.normal_force, foot.normal, foot.friction_force, self.lost, v, v_new, u_new, self.w,
                self.run.axis, dtm, self.mass, self.free, self.impulse, self.pressing,
            )  # fmt: skip
            sums["external"] += driven
            sums["contact"] += collided
            sums["friction"] += rubbed
            along, touching = along + push, touching + held
        if self.run.drive is not None:
            self.bounce_before = self.bounce
            self.reaction, self.bounce = self.reacted(u_new, self.near, -along, touching)

    def record(self, half_thickness, squeeze, span):
        """Finish the contact's state: its force is the mean over the span [s] since the last record. squeeze : elastic
        one of what two tools pinch (n,) [mm], half of it at either: an implicit stage finds its own force by it"""
        contact = self.contact
        contact.force[:] = self.impulse / span
        self.impulse[:] = 0.0
        far = np.ones(len(half_thickness), dtype=bool)
        far[self.near] = False
        contact.gap[far] = (self.run.neighbourhood.distance - half_thickness)[far]
        for foot in contact.feet:
            known = (foot.status != OPEN) & ((self.law == KINEMATIC) | (squeeze > 0.0))
            foot.gap[:] = np.where(known, -0.5 * squeeze, foot.gap)
            foot.multiplier[:] = np.maximum(foot.normal_force - 0.5 * self.run.kn * squeeze, 0.0)


def touch_tools(tools, u, v, half_thickness, dt, dtm, u_new, v_new, sums):
    """Let the nodes touch the tools, one after the other, at the end of their predicted step; add the step's work to
    sums [mJ]."""
    for tool in tools:
        tool.meet(u, v, half_thickness, dt, dtm, u_new, v_new)
    for tool in tools:
        tool.work(v, v_new, u_new, dtm, sums)


def in_order(tools):
    """Tools in the order in which nodes meet them: driven by a force, travelling, standing still."""
    return sorted(tools, key=lambda run: 0 if run.drive is not None else 1 if run.tool.travel is not None else 2)
