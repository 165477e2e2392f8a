"""A node in a corner tighter than half the sheet: two or three walls of one tool at once, each pressing and rubbing.

Symbols, of one node: d_k, n_k gap and normal of wall k; F which directions are free; x_k >= 0 velocity it gains from
wall k, dv = sum x_k F n_k. The law (laws.py) says what the node has to gain along each normal, b_k; then

    w_k = n_k . dv - b_k >= 0,   x_k >= 0,   w_k x_k = 0

is the smallest dv that contents all walls, whichever is nearest, so that nothing jumps where two change places. A
wall not overlapped takes part by how far the others may push the node before it does, b_k = -d_k/dt. For a bounce,
b_k = -(1 + e) v_k, it is Moreau's law of impact: no energy is gained. Friction takes from what still slides along all
pressing walls what it needs to stop it, and no more than sum mu_k x_k; each wall has its share. Walls that face each
other, less than a sheet apart, cannot both be contented: they then are springs of stiffness m/dt^2, the stiffest that
a node can carry.

A wall is remembered with the curvature it has at its foot and looked for anew once the node has moved by a small part
of its half thickness, so that the search for all feet runs in few steps, and never for nodes far from such a corner.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from ..contact.feet import MOST
from ..contact.node_on_tool import OPEN, SLIP, STICK, hessian_of_distance
from ..contact.search import rows_of
from .laws import BY_PATH, GRIP, PENALTY, TOUCH, answer, grip_of, velocity_at

ROOM = 0.5  # of half the thickness: how much farther than the skin walls are looked for
TRUST = 0.01  # of half the thickness: how far a node moves on walls remembered
FACING = 0.15  # rad: walls that enclose less of an angle are a slot


class Memory(NamedTuple):
    """Walls of n nodes in the tool's frame, the nearest of each first.

    count : (n,) walls, 1 where only the nearest matters; place (n, 3): where they were looked for, and trust (n,): how
    far from it they are good for, over half the thickness
    distance (n, 3), normal (n, 3, 3), bend (n, 3, 3, 3) Hessian of the distance [1/mm], face (n, 3)
    """

    count: np.ndarray
    place: np.ndarray
    trust: np.ndarray
    distance: np.ndarray
    normal: np.ndarray
    bend: np.ndarray
    face: np.ndarray


@njit(cache=True)
def outdated(near, now, half_thickness, place, trust, found):
    """Fills found with those of near nodes (k,), at now (n, 3), whose walls are to be looked for. Returns how many."""
    count = 0
    for k in range(near.shape[0]):
        node = near[k]
        moved = 0.0
        for c in range(3):
            moved += (now[node, c] - place[node, c]) ** 2
        # Not a number before the first look.
        if not moved <= (trust[node] * half_thickness[node]) ** 2:
            found[count] = node
            count += 1
    return count


@njit(cache=True)
def remember(nodes, points, half_thickness, owner, distance, normal, curvature, direction, face, walls):
    """Puts walls into memory: rows (f,) of nodes' feet, in order of their owners, the nearest of each first.

    nodes (k,), points (k, 3); owner (f,) their rows
    """
    for k in range(nodes.shape[0]):
        walls.count[nodes[k]] = 0
        for c in range(3):
            walls.place[nodes[k], c] = points[k, c]
    for f in range(owner.shape[0]):
        node = nodes[owner[f]]
        j = walls.count[node]
        walls.count[node] = j + 1
        walls.distance[node, j], walls.face[node, j] = distance[f], face[f]
        for c in range(3):
            walls.normal[node, j, c] = normal[f, c]
        hessian_of_distance(distance[f], normal[f], curvature[f], direction[f], walls.bend[node, j])
    for k in range(nodes.shape[0]):
        node = nodes[k]
        half = half_thickness[node]
        slack = ROOM * half
        for j in range(1, walls.count[node]):
            slack = min(slack, walls.distance[node, j] - half)
        walls.trust[node] = max(0.5 * slack / half, TRUST)
        # Farther walls than a look's life reaches are of no concern before the next.
        if slack > TRUST * half:
            walls.count[node] = 1


@njit(cache=True)
def walls_now(nodes, now, walls, distance, normal):
    """Fills distance (k, 3) and normal (k, 3, 3) of the walls of nodes (k,), at now (n, 3)."""
    for k in range(nodes.shape[0]):
        node = nodes[k]
        for j in range(walls.count[node]):
            d, n, bend = walls.distance[node, j], walls.normal[node, j], walls.bend[node, j]
            distance[k, j] = wall_now(d, n, bend, walls.place[node], now[node], normal[k, j])


@njit(forceinline=True)
def wall_now(distance, normal, bend, place, x, now):
    """Distance of a wall from x (3,), to second order from where it was found, and its normal in now (3,)."""
    d, size = distance, 0.0
    for i in range(3):
        turned = 0.0
        for j in range(3):
            turned += bend[i, j] * (x[j] - place[j])
        d += (normal[i] + 0.5 * turned) * (x[i] - place[i])
        now[i] = normal[i] + turned
        size += now[i] * now[i]
    size = sqrt(size)
    for i in range(3):
        now[i] /= size
    return d


@njit(cache=True)
def content(a, b, n, x):
    """Fills x (n,) with the solution of a x - b >= 0, x >= 0, (a x - b) x = 0; a (n, n) Gram matrix of n <= 3 walls.

    Every choice of pressing walls is tried, fewest first. Where none will do, or only walls that face each other, each
    wall is a spring of the node's own stiffness m/dt^2, which a diagonal twice as large is.
    """
    scale = 0.0
    for k in range(n):
        scale = max(scale, b[k])
        x[k] = 0.0
    if scale <= 0.0:
        return
    for soft in range(2):
        for wanted in range(1, n + 1):
            for choice in range(1, 1 << n):
                if (choice & 1) + (choice >> 1 & 1) + (choice >> 2 & 1) != wanted:
                    continue
                if _solve(a, b, n, choice, 1.0 + soft, x) and _is_content(a, b, n, 1.0 + soft, 1e-12 * scale, x):
                    return


@njit(forceinline=True)
def _is_content(a, b, n, diagonal, small, x):
    """Whether x (n,) presses only, and leaves no wall wanting more than `small`."""
    for k in range(n):
        rest = (diagonal - 1.0) * a[k, k] * x[k] - b[k]
        for j in range(n):
            rest += a[k, j] * x[j]
        if not (x[k] >= 0.0 and rest >= -small):
            return False
    return True


@njit(forceinline=True)
def _solve(a, b, n, choice, diagonal, x):
    """x (n,) of a x = b on the chosen rows, by elimination, 0 elsewhere; False where the rows' walls face each other.
    diagonal : factor on that of a"""
    lower = np.zeros((3, 3))
    y = np.zeros(3)
    for k in range(n):
        x[k] = 0.0
        if not choice >> k & 1:
            continue
        y[k] = b[k]
        for j in range(k + 1):
            if not choice >> j & 1:
                continue
            rest = a[k, j] if j < k else diagonal * a[k, k]
            for i in range(j):
                rest -= lower[k, i] * lower[j, i]
            if j < k:
                lower[k, j] = rest / lower[j, j]
                y[k] -= lower[k, j] * y[j]
            else:
                if rest <= FACING * FACING * a[k, k]:
                    return False
                lower[k, k] = sqrt(rest)
                y[k] /= lower[k, k]
    for k in range(n - 1, -1, -1):
        if choice >> k & 1:
            rest = y[k]
            for i in range(k + 1, n):
                rest -= lower[i, k] * x[i]
            x[k] = rest / lower[k, k]
    return True


@njit(parallel=True, cache=True)
def meet_walls(
    law, parameter, nodes, gap, normal, face, count, half_thickness, mass, free, mu, laws, w, dt, dtm, v,
    u_new, v_new, normal_force, tau, status, lost,
):  # fmt: skip
    """`meet_tool` for nodes with several walls.

    nodes : (k,); gap (k, 3 walls), normal (k, 3, 3), face (k, 3) of the first count (k,) walls
    changes u_new, v_new (n, 3); fills normal_force (k, 3), tau (k, 3, 3), status (k, 3), and lost (n,) mJ, or BY_PATH
    """
    for k in prange(nodes.shape[0]):
        node = nodes[k]
        m, n = mass[node], count[k]
        drift, drift_before = np.empty(3), np.empty(3)
        tool = velocity_at(w, u_new[node])
        for c in range(3):
            drift[c], drift_before[c] = v_new[node, c] - tool[c], v[node, c] - tool[c]
        # What each wall wants.
        gain, lift, taken = np.zeros(3), np.zeros(3), np.zeros(3)
        x, y = np.zeros(3), np.zeros(3)
        gram = np.zeros((3, 3))
        lost[node] = BY_PATH
        for j in range(n):
            normal_force[k, j], status[k, j] = 0.0, OPEN
            vn = before = 0.0
            for c in range(3):
                tau[k, j, c] = 0.0
                vn += drift[c] * normal[k, j, c]
                before += drift_before[c] * normal[k, j, c]
                for i in range(n):
                    gram[j, i] += free[node, c] * normal[k, j, c] * normal[k, i, c]
            if gram[j, j] < GRIP:
                # Nothing can move along this normal.
                gain[j] = lift[j] = -np.inf
                gram[j, j] = 1.0
            elif gap[k, j] < 0.0:
                gain[j], lift[j], taken[j] = answer(law, parameter, gap[k, j], vn, before, dt, dtm)
            else:
                gain[j], lift[j] = -gap[k, j] / dt, -gap[k, j]
                if law == TOUCH:
                    gain[j] = min(gain[j], -(1.0 + parameter) * vn)
        if law == PENALTY:
            for j in range(n):
                x[j] = max(gain[j], 0.0) / gram[j, j]
                y[j] = dt * x[j]
        else:
            content(gram, gain, n, x)
            content(gram, lift, n, y)
        # Along the normals; and what then slides, orthogonal to all that press.
        pressing, limit, speed = 0, 0.0, 0.0
        across = np.zeros((3, 3))
        grip = np.zeros(3)
        for j in range(n):
            if x[j] <= 0.0 and y[j] <= 0.0:
                continue
            for c in range(3):
                push = free[node, c] * normal[k, j, c]
                v_new[node, c] += x[j] * push
                u_new[node, c] += y[j] * push
                across[pressing, c] = push
            _straighten(across, pressing)
            pressing += 1
            force = m * x[j] / dtm
            normal_force[k, j] = force
            along = total = 0.0
            for c in range(3):
                along += drift_before[c] * normal[k, j, c]
                total += drift_before[c] * drift_before[c]
            speed = sqrt(max(total - along * along, 0.0))
            grip[j] = x[j] * grip_of(mu, laws, face[k, j], node, force, speed)
            limit += grip[j]
            if pressing == 1 and taken[j] >= 0.0:
                lost[node] = 0.5 * m * taken[j] / gram[j, j]
            else:
                lost[node] = BY_PATH
        if pressing == 0:
            continue
        slide = np.empty(3)
        for c in range(3):
            slide[c] = v_new[node, c] - tool[c]
        for i in range(pressing):
            part = 0.0
            for c in range(3):
                part += slide[c] * across[i, c]
            for c in range(3):
                slide[c] -= part * across[i, c]
        sliding = sqrt(slide[0] ** 2 + slide[1] ** 2 + slide[2] ** 2)
        factor = -min(1.0, limit / sliding) if sliding > 0.0 and limit > 0.0 else 0.0
        for j in range(n):
            if x[j] > 0.0:
                status[k, j] = STICK if limit > 0.0 and sliding <= limit else SLIP
                share = factor * grip[j] / limit if limit > 0.0 else 0.0
                for c in range(3):
                    tau[k, j, c] = m * share * slide[c] / dtm
        for c in range(3):
            v_new[node, c] += free[node, c] * factor * slide[c]
            u_new[node, c] += free[node, c] * dt * factor * slide[c]


@njit(forceinline=True)
def _straighten(rows, last):
    """Makes row `last` of rows (3, 3) orthogonal to those before it, of length 1, or 0 where it depends on them."""
    before = sqrt(rows[last, 0] ** 2 + rows[last, 1] ** 2 + rows[last, 2] ** 2)
    for i in range(last):
        part = 0.0
        for c in range(3):
            part += rows[last, c] * rows[i, c]
        for c in range(3):
            rows[last, c] -= part * rows[i, c]
    size = sqrt(rows[last, 0] ** 2 + rows[last, 1] ** 2 + rows[last, 2] ** 2)
    for c in range(3):
        rows[last, c] = rows[last, c] / size if size > 1e-6 * before else 0.0


class Walls:
    """What nodes near tight corners of a tool remember of its walls, in the tool's frame.

    n : nodes
    """

    def __init__(self, surface, n):
        self.surface = surface
        self.memory = Memory(
            count=np.ones(n, dtype=np.int64),
            place=np.full((n, 3), np.nan),
            trust=np.zeros(n),
            distance=np.zeros((n, MOST)),
            normal=np.zeros((n, MOST, 3)),
            bend=np.zeros((n, MOST, 3, 3)),
            face=np.zeros((n, MOST), dtype=np.int64),
        )
        self.found = np.empty(n, dtype=np.int64)

    def look(self, near, now, hit, half_thickness):
        """Which of near nodes (k,) have several walls. now : (n, 3) places in the tool's frame; hit : Hit there"""
        memory = self.memory
        count = outdated(near, now, half_thickness, memory.place, memory.trust, self.found)
        if count:
            nodes = self.found[:count].copy()
            points, first = now[nodes], rows_of(hit, nodes)
            owner, further = self.surface.feet(points, first, (1.0 + ROOM) * half_thickness[nodes])
            order = np.argsort(np.concatenate([np.arange(count), owner]), kind="stable")
            owners = np.concatenate([np.arange(count), owner])[order]
            feet = {
                name: np.concatenate([getattr(first, name), getattr(further, name)])[order]
                for name in ("distance", "normal", "curvature", "direction", "face")
            }
            remember(nodes, points, half_thickness, owners, **feet, walls=memory)
        return near[memory.count[near] > 1]

    def at(self, nodes, now):
        """Distances (k, 3), normals (k, 3, 3), faces (k, 3) and number (k,) of the walls of nodes at now (n, 3)."""
        memory = self.memory
        distance, normal = np.full((len(nodes), MOST), np.inf), np.zeros((len(nodes), MOST, 3))
        walls_now(nodes, now, memory, distance, normal)
        return distance, normal, memory.face[nodes], memory.count[nodes]
