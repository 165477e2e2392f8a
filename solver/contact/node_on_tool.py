"""A node on a rigid tool: normal force, stick-slip friction and their exact tangent (theory.md 6 and 7;
seed Eq. 7-13).

Forces and stiffnesses are per node (pressure times tributary area). Symbols: d signed distance of the node
to the tool, n the tool's normal, h its Hessian hess d = sum kappa/(1 + kappa d) e e^T; g = d - t/2 gap;
kn, kt normal and tangential stiffness [N/mm]; lam multiplier of the augmented Lagrangian [N];
N = <lam - kn g> normal force, with <> rounded over a skin of a small part of the thickness (one quadratic
piece) so that its slope is continuous, and hardly more than metal between two tools bears (normal_law.py); tau
friction force on the sheet, du displacement of the node relative to the tool over the increment. tau is carried from
the old normal to the new one by the smallest rotation that takes one to the other, then trial = R tau_old -
kt (1 - n n^T) du, kept inside the circle mu N. Where mu follows pressure and sliding speed v = |(1 - n n^T) du| / lapse
(friction.py), the circle's radius has slopes by both.
"""

from math import sqrt

import numpy as np
from numba import njit, prange

from .friction import friction_limit, law_at
from .normal_law import normal_law

OPEN, STICK, SLIP = 0, 1, 2


@njit(forceinline=True)
def hessian_of_distance(d, n, curvature, e1, h):
    """Fills h (3, 3) = hess d. curvature (2,), e1 (3,) direction of curvature[0]."""
    e2 = (n[1] * e1[2] - n[2] * e1[1], n[2] * e1[0] - n[0] * e1[2], n[0] * e1[1] - n[1] * e1[0])
    c1 = curvature[0] / (1.0 + curvature[0] * d)
    c2 = curvature[1] / (1.0 + curvature[1] * d)
    for i in range(3):
        for j in range(3):
            h[i, j] = c1 * e1[i] * e1[j] + c2 * e2[i] * e2[j]


@njit(forceinline=True)
def dot(a, b):
    """Scalar product of two 3-vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(forceinline=True)
def node_force(gap, n, h, lam, kn, kt, flow, mu, laws, face, node, skin, tau_old, n_old, du, held, tau, stiffness):
    """Force of one touching node. Fills tau (3,) and stiffness (3, 3) = - d(N n + tau)/dx; returns N and
    the state. held : the node may pull at its tool. laws : in place of mu, or None; compiled apart for each."""
    normal_force, slope = normal_law(lam - kn * gap, kn * skin, kn, held, flow, node)
    kn = slope * kn
    for i in range(3):
        for j in range(3):
            stiffness[i, j] = kn * n[i] * n[j] - normal_force * h[i, j]
        tau[i] = 0.0
    if laws is None:
        if mu == 0.0:
            return normal_force, SLIP
    # Trial: the old friction force turned onto the new tangent plane, and the elastic response.
    cos, lever = 1.0 + dot(n_old, n), dot(n, tau_old)
    lift = dot(n, du)
    trial = np.empty(3)
    for i in range(3):
        trial[i] = tau_old[i] - lever / cos * (n_old[i] + n[i]) - kt * (du[i] - lift * n[i])
    size = sqrt(dot(trial, trial))
    limit, grip, drag, speed = mu * max(normal_force, 0.0), mu, 0.0, 0.0
    if laws is not None:
        speed = sqrt(max(dot(du, du) - lift * lift, 0.0)) / laws.lapse[0]
        row = laws.rows[law_at(laws.law_of_face, face)]
        limit, grip, drag = friction_limit(row, max(normal_force, 0.0), laws.area[node], speed)
        if row[1] == 0.0 and limit == 0.0:
            return normal_force, SLIP
    sticks = size <= limit
    factor = 1.0 if sticks else limit / size
    state = STICK if sticks else SLIP
    # Derivative of the trial through the node's own movement and through the turning normal, dn = h dx.
    dtrial = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            turned = 0.0
            for k in range(3):
                w = n_old[i] + n[i]
                part = -w * tau_old[k] / cos + lever * w * n_old[k] / (cos * cos) + kt * n[i] * du[k]
                if i == k:
                    part += kt * lift - lever / cos
                turned += part * h[k, j]
            dtrial[i, j] = turned + kt * n[i] * n[j]
        dtrial[i, i] -= kt
    for i in range(3):
        tau[i] = factor * trial[i]
    if sticks:
        for i in range(3):
            for j in range(3):
                stiffness[i, j] -= dtrial[i, j]
    elif size > 0.0:
        for j in range(3):
            along = (trial[0] * dtrial[0, j] + trial[1] * dtrial[1, j] + trial[2] * dtrial[2, j]) / (size * size)
            dn = -grip * kn * n[j] / size if limit > 0.0 else 0.0
            if laws is not None:
                if drag != 0.0 and speed > 0.0:
                    # Slope of the sliding speed, whose direction s = du - (n du) n turns with the normal.
                    turned, lapse = 0.0, laws.lapse[0]
                    for k in range(3):
                        turned += h[j, k] * (du[k] - lift * n[k])
                    dn += drag * (du[j] - lift * n[j] - lift * turned) / (speed * lapse * lapse * size)
            for i in range(3):
                stiffness[i, j] -= factor * (dtrial[i, j] - trial[i] * along) + trial[i] * dn
    return normal_force, state


@njit(parallel=True, cache=True)
def contact_forces(
    near, distance, normal, curvature, direction, face, half_thickness, skin, first, lam, kn, kt, flow, mu, laws,
    tau_old, n_old, state_old, x, x_old, force, stiffness, normal_force, tau, n_new, gap, state,
):  # fmt: skip
    """Adds the contact forces of one tool.

    near : (k,) node ids; distance (k,), normal (k, 3), curvature (k, 2), direction (k, 3), face (k,) of their feet
    mu : coefficient of friction; laws : Laws in its place where it is more than a number, or None
    half_thickness (n,), lam (n,), kn (n,), kt (n,), tau_old (n, 3), n_old (n, 3), state_old (n,) by node;
    flow : Flow, of metal that two tools press flat
    skin : half the width of the gap over which the force sets in [mm]
    first : at an increment's first evaluation the nodes that touched before still do, so that the tangent
    knows them; x (n, 3); x_old (n, 3) at the increment's start, carried along with the tool
    adds to force (n, 3) [N]; fills stiffness (n, 3, 3) [N/mm], normal_force (n,), tau (n, 3), n_new (n, 3), gap (n,),
    state (n,) of the near nodes
    """
    for k in prange(near.shape[0]):
        node = near[k]
        gap[node] = distance[k] - half_thickness[node]
        held = first and state_old[node] != OPEN
        if not held and lam[node] - kn[node] * gap[node] <= -kn[node] * skin:
            continue
        h = np.empty((3, 3))
        du = np.empty(3)
        n_start = np.empty(3)
        hessian_of_distance(distance[k], normal[k], curvature[k], direction[k], h)
        for c in range(3):
            du[c] = x[node, c] - x_old[node, c]
            # A new contact has no old normal, and no friction force to carry.
            n_start[c] = normal[k, c] if state_old[node] == OPEN else n_old[node, c]
        normal_force[node], state[node] = node_force(
            gap[node], normal[k], h, lam[node], kn[node], kt[node], flow, mu, laws, face[k], node, skin,
            tau_old[node], n_start, du, held, tau[node], stiffness[node],
        )  # fmt: skip
        for c in range(3):
            n_new[node, c] = normal[k, c]
            force[node, c] += normal_force[node] * normal[k, c] + tau[node, c]
