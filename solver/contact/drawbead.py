"""Drawbeads as line forces: a restraint that resists the sheet's motion across a curve, and an uplift (theory.md 8).

    s, w   points along the curve and the length each stands for [mm];  N_a  shares of a triangle's nodes in a point
    t, n   direction of the curve and normal of the triangle;  m = t x n  across the curve, in the sheet
    du     movement of the sheet at the point over the increment, sum N_a (x_a - x_a_old)
    tau    restraint on the sheet [N/mm], along m;  q  its limit;  k  stiffness before slip [N/mm^2]

    tau = clip(tau_old - k m . du, -q, q),   force of node a = N_a w tau m

An elastic-plastic stick-slip, as friction is, with a limit of its own. Points, shares and directions are those of the
increment's start; the curve stands still and the sheet slides under it. The shares of a point sum to 1, so that the
resultant is exact on any mesh. The bead's uplift pushes the tool that holds it away from the sheet.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from ..errors import SceneError
from ..state import Arrays

PER_ELEMENT = 10  # points of the curve on the length of a triangle's side
EDGE = 1e-9  # of a triangle: so far outside still counts as on it


@dataclass(frozen=True)
class Drawbead:
    """A bead along a curve.

    curve : (k, 3) mm, its corners, as a CAD edge or the scene gives them
    restraint : N/mm, force per length across the curve at which the sheet is drawn through; RoundBead(...).forces()
        bounds it, and the uplift, from the bead's shape
    uplift : N/mm, force per length that opens the tools
    holder : name of the tool borne by a force or spring that the uplift pushes back, or None
    axis : direction in which the curve is projected onto the sheet
    """

    name: str
    curve: Sequence
    restraint: float
    uplift: float = 0.0
    holder: str | None = None
    axis: Sequence[float] = (0.0, 0.0, 1.0)

    def __post_init__(self):
        curve = np.asarray(self.curve, dtype=float)
        if curve.ndim != 2 or curve.shape[1] != 3 or len(curve) < 2 or not np.isfinite(curve).all():
            raise SceneError(
                f"drawbead {self.name!r} curve: found shape {curve.shape}, expected 2 or more points (k, 3)"
            )
        if not np.linalg.norm(np.diff(curve, axis=0), axis=1).min() > 0.0:
            raise SceneError(
                f"drawbead {self.name!r} curve: found two equal points in a row, expected a step between them"
            )
        for key in ("restraint", "uplift"):
            value = getattr(self, key)
            if not (np.isfinite(value) and value >= 0.0):
                raise SceneError(f"drawbead {self.name!r} {key}: found {value!r}, expected N/mm, 0 or more")
        if np.shape(self.axis) != (3,) or not np.linalg.norm(self.axis) > 0.0:
            raise SceneError(f"drawbead {self.name!r} axis: found {self.axis!r}, expected 3 numbers, not all 0")

    @property
    def length(self):
        """Of the curve [mm]."""
        return float(np.linalg.norm(np.diff(np.asarray(self.curve, dtype=float), axis=0), axis=1).sum())


@dataclass
class BeadState(Arrays):
    """One bead at one instant."""

    traction: np.ndarray  # (q,) tau at its points, 0 where there is no sheet [N/mm]
    lift: np.ndarray  # (q,) uplift there [N/mm]


def build_beads(stage, sheet, method):
    """BeadRuns of a stage."""
    stiffness = method.stick * sheet.contact_stiffness * sheet.size
    return [BeadRun(bead, sheet, stiffness) for bead in stage.drawbeads]


def uplifts(beads, x):
    """What lifts the beads' holders: {tool: (points (q, 3), forces (q,) [N])}. x : (n, 3) nodes"""
    found = {}
    for run in beads:
        if run.bead.holder is not None and run.bead.uplift > 0.0:
            found.setdefault(run.bead.holder, []).append(run.uplift(x))
    return {name: tuple(map(np.concatenate, zip(*parts, strict=True))) for name, parts in found.items()}


class BeadRun:
    """A bead in its stage.

    stiffness : k; points (q, 3), lengths (q,), tangents (q, 3); triangle (q,) that lies there, -1 for none,
    nodes (q, 3), shares (q, 3), across (q, 3): of the increment
    """

    def __init__(self, bead, sheet, stiffness):
        self.bead, self.sheet, self.stiffness = bead, sheet, stiffness
        self.axis = np.asarray(bead.axis, dtype=float) / np.linalg.norm(bead.axis)
        self.points, self.tangents, self.lengths = sample(np.asarray(bead.curve, dtype=float), sheet.size / PER_ELEMENT)

    def new_state(self):
        """A bead that holds nothing yet."""
        return BeadState(np.zeros(len(self.points)), np.zeros(len(self.points)))

    def begin(self, x):
        """Find the sheet under the curve. x : (n, 3) nodes"""
        cells = self.sheet.triangles.cells
        self.triangle, self.shares = locate(self.points, self.axis, x, cells)
        self.nodes = cells[self.triangle]
        corner = x[self.nodes]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        across = np.cross(self.tangents, normal)
        self.across = across / np.linalg.norm(across, axis=1)[:, None]

    def pull(self, before, after, x_old, x, force, stiffness):
        """Adds the forces to force (n, 3), their tangent to the triangles' stiffness (m, d, d); fills after."""
        bead_forces(
            self.triangle, self.nodes, self.shares, self.across, self.lengths, self.bead.restraint, self.stiffness,
            before.traction, x_old, x, force, stiffness, after.traction,
        )  # fmt: skip
        after.lift[:] = np.where(self.triangle >= 0, self.bead.uplift, 0.0)

    def uplift(self, x):
        """Where the bead lifts its holder, (q, 3), and how much there, (q,) [N]. x : (n, 3) nodes"""
        on = self.triangle >= 0
        places = np.einsum("qa,qac->qc", self.shares[on], x[self.nodes[on]])
        return places, self.bead.uplift * self.lengths[on]

    def work(self, before, after, x_old, x):
        """Lost in the bead over an increment [mJ]."""
        slid = np.einsum("qa,qac,qc->q", self.shares, x[self.nodes] - x_old[self.nodes], self.across)
        return -0.5 * float(np.sum((before.traction + after.traction) * self.lengths * slid * (self.triangle >= 0)))

    def held(self, state):
        """Restraint it holds now [N], and uplift [N], of the modelled share."""
        return float(np.abs(state.traction) @ self.lengths), float(state.lift @ self.lengths)


def sample(curve, spacing):
    """Middles (q, 3), directions (q, 3) and lengths (q,) of equal pieces of a polyline's sides, no longer than
    spacing."""
    points, tangents, lengths = [], [], []
    for start, end in zip(curve[:-1], curve[1:], strict=True):
        length = np.linalg.norm(end - start)
        n = max(1, int(np.ceil(length / spacing)))
        points.append(start + (np.arange(n) + 0.5)[:, None] / n * (end - start))
        tangents.append(np.tile((end - start) / length, (n, 1)))
        lengths.append(np.full(n, length / n))
    return np.concatenate(points), np.concatenate(tangents), np.concatenate(lengths)


def locate(points, axis, x, cells):
    """Triangle (q,) that each point falls on along an axis, -1 for none, and the shares (q, 3) of its nodes.

    Where several lie on top of each other it is the nearest one. points : (q, 3); x : (n, 3); cells : (m, 3)
    """
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    plane = np.stack([first, np.cross(axis, first)], axis=1)
    flat, corner = points @ plane, (x @ plane)[cells]
    middle = corner.mean(axis=1)
    # A triangle that holds a point has its middle no farther than its own farthest corner.
    reach = np.linalg.norm(corner - middle[:, None], axis=2).max()
    lists = cKDTree(middle).query_ball_point(flat, reach * (1.0 + EDGE), return_sorted=True)
    owner = np.repeat(np.arange(len(points)), [len(found) for found in lists])
    candidate = np.concatenate([*(np.asarray(found, dtype=np.int64) for found in lists), np.zeros(0, np.int64)])
    a, b, c = (corner[candidate, i] for i in range(3))
    p = flat[owner]
    double = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([_cross(b - p, c - p), _cross(c - p, a - p), _cross(a - p, b - p)], axis=1) / double[:, None]
    inside = (shares >= -EDGE).all(axis=1)  # one that stands on edge has no shares
    height = np.abs(np.sum(shares * (x @ axis)[cells[candidate]], axis=1) - (points @ axis)[owner])
    order = np.lexsort((candidate, height, owner))
    order = order[inside[order]]
    chosen, where = np.unique(owner[order], return_index=True)
    triangle, found = np.full(len(points), -1), np.tile([1.0, 0.0, 0.0], (len(points), 1))
    triangle[chosen], found[chosen] = candidate[order][where], shares[order][where]
    return triangle, found


def _cross(u, v):
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


@njit(cache=True)
def bead_forces(
    triangle, nodes, shares, across, lengths, limit, k, traction_old, x_old, x, force, stiffness, traction
):  # fmt: skip
    """Adds nodal forces (n, 3) and triangles' stiffness (m, d, d), whose first nine unknowns are the nodes' (left out
    where that is empty); fills traction (q,), which may be traction_old itself."""
    wanted = stiffness.shape[0] > 0
    for q in range(len(triangle)):
        before = traction_old[q]
        traction[q] = 0.0
        if triangle[q] < 0:
            continue
        slid = 0.0
        for a in range(3):
            for c in range(3):
                slid += shares[q, a] * (x[nodes[q, a], c] - x_old[nodes[q, a], c]) * across[q, c]
        trial = before - k * slid
        sticks = abs(trial) <= limit
        traction[q] = min(max(trial, -limit), limit)
        for a in range(3):
            for c in range(3):
                force[nodes[q, a], c] += shares[q, a] * lengths[q] * traction[q] * across[q, c]
        if not (sticks and wanted):
            continue
        for a in range(3):
            for b in range(3):
                weight = shares[q, a] * shares[q, b] * lengths[q] * k
                for c in range(3):
                    for d in range(3):
                        stiffness[triangle[q], 3 * a + c, 3 * b + d] += weight * across[q, c] * across[q, d]
