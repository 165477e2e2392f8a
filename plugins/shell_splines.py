"""Problems of `shell_problems.py` on a tube, solved once more with nothing in common with the triangles: a smooth
Kirchhoff-Love shell, displacements in tensor-product B-splines of any degree (J. Kiendl, K.-U. Bletzinger, J. Linhard,
R. Wuechner, Computer Methods in Applied Mechanics and Engineering 198 (2009) 3902-3914).

The energy per area is h/2 e.D.e + h^3/24 k.D.k, e = (a - A)/2 and k = b - B the changes of the first and the second
fundamental form (St. Venant-Kirchhoff, plane stress), in the arc lengths s round the tube and t along it, where A is
the unit matrix. Symbols: q = (x_s, x_t, x_ss, x_tt, x_st), 5 x 3 numbers at a point of integration, of which the energy
is a function; n unit normal; a^1, a^2 dual vectors; forms e, k, D as [ss, tt, 2 st].
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numba import njit, prange
from scipy.interpolate import BSpline
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from solver.errors import StepFailed
from solver.implicit.sparse import SuperLU

TOLERANCE, FAR = 1e-9, 1e3  # unbalanced force relative to the load: of equilibrium, and where it is out of sight
N_ITERATIONS, FEW = 25, 6  # of Newton's method in a step
SMALLEST = 1e-4  # step, relative to the largest


@njit(cache=True)
def energy_derivatives(q, curvature, stiffness, h, gradient, hessian):
    """Fills the first (5, 3) and second (5, 3, 5, 3) derivatives of the energy per area with respect to q and returns
    the energy. curvature : (3,) initial b [ss, tt, 2 st]; stiffness : (3, 3) D; h : thickness"""
    a1, a2 = q[0], q[1]
    normal = np.cross(a1, a2)
    n = normal / sqrt(np.dot(normal, normal))
    a11, a22, a12 = np.dot(a1, a1), np.dot(a2, a2), np.dot(a1, a2)
    det = a11 * a22 - a12 * a12
    inverse = np.array([[a22 / det, -a12 / det], [-a12 / det, a11 / det]])
    dual = np.empty((2, 3))
    dual[0], dual[1] = inverse[0, 0] * a1 + inverse[0, 1] * a2, inverse[1, 0] * a1 + inverse[1, 1] * a2

    # Strains and their first derivatives: de_v = B_e[v].dq, dk_v = B_k[v].dq with dn = -a^c (n.da_c).
    e = np.array([0.5 * (a11 - 1.0), 0.5 * (a22 - 1.0), a12])
    k = np.array([np.dot(q[2], n), np.dot(q[3], n), 2.0 * np.dot(q[4], n)]) - curvature
    be, bk = np.zeros((3, 5, 3)), np.zeros((3, 5, 3))
    be[0, 0], be[1, 1], be[2, 0], be[2, 1] = a1, a2, a2, a1
    for v in range(3):
        w = 2.0 if v == 2 else 1.0
        bk[v, 2 + v] = w * n
        for c in range(2):
            bk[v, c] = -w * np.dot(q[2 + v], dual[c]) * n
    force, moment = h * (stiffness @ e), h**3 / 12.0 * (stiffness @ k)
    gradient[:] = 0.0
    for v in range(3):
        gradient += force[v] * be[v] + moment[v] * bk[v]

    hessian[:] = 0.0
    for v in range(3):
        for u in range(3):
            for i in range(5):
                for c in range(3):
                    left = stiffness[v, u] * h * be[v, i, c], stiffness[v, u] * h**3 / 12.0 * bk[v, i, c]
                    for j in range(5):
                        for d in range(3):
                            hessian[i, c, j, d] += left[0] * be[u, j, d] + left[1] * bk[u, j, d]
    for c in range(3):
        hessian[0, c, 0, c] += force[0]
        hessian[1, c, 1, c] += force[1]
        hessian[0, c, 1, c] += force[2]
        hessian[1, c, 0, c] += force[2]
    # m_v dx_v.dn, and M.d2n with M = m_v x_v:
    # d2n = a^b (a^c.Da_b)(n.da_c) + a^c (a^b.da_c)(n.Da_b) - A^bc n (n.Da_b)(n.da_c).
    total = moment[0] * q[2] + moment[1] * q[3] + 2.0 * moment[2] * q[4]
    for c in range(3):
        for d in range(3):
            for b in range(2):
                for v in range(3):
                    w = moment[v] * (2.0 if v == 2 else 1.0)
                    hessian[2 + v, c, b, d] -= w * dual[b, c] * n[d]
                    hessian[b, d, 2 + v, c] -= w * dual[b, c] * n[d]
                for g in range(2):
                    hessian[g, c, b, d] += np.dot(total, dual[b]) * n[c] * dual[g, d]
                    hessian[g, c, b, d] += np.dot(total, dual[g]) * dual[b, c] * n[d]
                    hessian[g, c, b, d] -= inverse[b, g] * np.dot(total, n) * n[c] * n[d]
    return 0.5 * (np.dot(force, e) + np.dot(moment, k))


@njit(parallel=True, cache=True)
def element_stiffness(u, along, across, span_s, span_t, weight, q0, curvature, stiffness, h, force, tangent):
    """Fills force (m, n, 3) and tangent (m, 3 n, 3 n) of every element, its n control points numbered t fastest.

    u : (n_s, n_t, 3); along, across : (m_s, g, p + 1, 3) values and two derivatives of the splines at the points of
    integration of a span, the first of which are span_s, span_t; weight : (m_s, m_t, g, g); q0 : (m_s, g, 5, 3)
    """
    m_s, n_g, order = along.shape[0], along.shape[1], along.shape[2]
    m_t, n = across.shape[0], order * order
    for element in prange(m_s * m_t):
        es, et = element // m_t, element % m_t
        force[element], tangent[element] = 0.0, 0.0
        shape = np.empty((n, 5))
        gradient, hessian = np.empty((5, 3)), np.empty((5, 3, 5, 3))
        part = np.empty((5, 3, 3))
        for gs in range(n_g):
            for gt in range(n_g):
                q = q0[es, gs].copy()
                for i in range(order):
                    for j in range(order):
                        s, t, a = along[es, gs, i], across[et, gt, j], i * order + j
                        shape[a, 0], shape[a, 1] = s[1] * t[0], s[0] * t[1]
                        shape[a, 2], shape[a, 3], shape[a, 4] = s[2] * t[0], s[0] * t[2], s[1] * t[1]
                        for f in range(5):
                            for c in range(3):
                                q[f, c] += shape[a, f] * u[span_s[es] + i, span_t[et] + j, c]
                energy_derivatives(q, curvature, stiffness, h, gradient, hessian)
                w = weight[es, et, gs, gt]
                for b in range(n):
                    part[:] = 0.0
                    for f in range(5):
                        for c in range(3):
                            for d in range(3):
                                for g in range(5):
                                    part[f, c, d] += w * hessian[f, c, g, d] * shape[b, g]
                    for f in range(5):
                        for c in range(3):
                            force[element, b, c] += w * gradient[f, c] * shape[b, f]
                    for a in range(b, n):
                        for c in range(3):
                            for d in range(3):
                                sum = 0.0
                                for f in range(5):
                                    sum += shape[a, f] * part[f, c, d]
                                tangent[element, 3 * a + c, 3 * b + d] += sum
        for a in range(3 * n):
            for b in range(a + 1, 3 * n):
                tangent[element, a, b] = tangent[element, b, a]


def spline_values(knots, degree, order):
    """Values and two derivatives (m, g, p + 1, 3) of the splines of every span of an open knot vector at Gauss points,
    the weights (m, g), the places (m, g) and the first spline (m,) of each span."""
    point, weight = np.polynomial.legendre.leggauss(order)
    spans = np.flatnonzero(np.diff(knots) > 0.0)
    low, high = knots[spans], knots[spans + 1]
    places = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * point
    n = len(knots) - degree - 1
    values = np.stack([BSpline(knots, np.eye(n), degree)(places, nu) for nu in range(3)], axis=-1)
    chosen = (spans - degree)[:, None] + np.arange(degree + 1)
    values = np.take_along_axis(values, chosen[:, None, :, None], axis=2)
    return values, 0.5 * (high - low)[:, None] * weight, places, spans - degree


@dataclass
class SplineShell:
    """A case of `shell_problems.py` on a tube. cells : spans along s and t; degree : of the splines; points : of
    integration, a span and direction: one less than the degree, so smooth are splines across the knots."""

    case: object
    cells: tuple
    degree: int = 3
    points: int = 2

    def __post_init__(self):
        case, p = self.case, self.degree
        angle, length = case.size
        radius = case.shape(np.zeros(1), np.zeros(1))[0, 2]
        sizes = radius * angle, length
        knots = [
            size * np.concatenate([np.zeros(p), np.linspace(0.0, 1.0, n + 1), np.ones(p)])
            for size, n in zip(sizes, self.cells, strict=True)
        ]
        along, weight_s, s, self.span_s = spline_values(knots[0], p, self.points)
        across, weight_t, _, self.span_t = spline_values(knots[1], p, self.points)
        self.along, self.across = np.ascontiguousarray(along), np.ascontiguousarray(across)
        self.weight = weight_s[:, None, :, None] * weight_t[None, :, None, :]
        sin, cos, zero = np.sin(s / radius), np.cos(s / radius), np.zeros_like(s)
        outward = np.stack([sin, zero, cos], axis=-1)
        rows = [np.stack([cos, zero, -sin], axis=-1), np.broadcast_to([0.0, 1.0, 0.0], outward.shape)]
        self.q0 = np.stack([*rows, -outward / radius, 0.0 * outward, 0.0 * outward], axis=2)
        # The normal x_s x x_t points outward (x, y, z right-handed: (cos, 0, -sin) x (0, 1, 0) = (sin, 0, cos)).
        self.curvature = np.array([-1.0 / radius, 0.0, 0.0])
        nu = case.poisson
        self.stiffness = (
            case.young / (1.0 - nu**2) * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 - 0.5 * nu]])
        )
        self.shape = len(knots[0]) - p - 1, len(knots[1]) - p - 1
        self._unknowns(knots, sizes)
        self._pattern()

    def _unknowns(self, knots, sizes):
        """unknown (n_s, n_t, 3): number of the unknown of every component, -1 where it is fixed."""
        case, p = self.case, self.degree
        greville = [
            np.array([k[i + 1 : i + p + 1].mean() for i in range(n)]) / size
            for k, n, size in zip(knots, self.shape, sizes, strict=True)
        ]
        s, t = (values.ravel() for values in np.meshgrid(*greville, indexing="ij"))
        self.group = {name: true(s, t).reshape(self.shape) for name, true in case.groups.items()}
        owner = np.arange(3 * s.size).reshape(*self.shape, 3)
        fixed = np.zeros(owner.shape, dtype=bool)
        for name, on in self.group.items():
            edge = next((edge for edge in EDGES if on[edge[0]].all()), None)
            if name.startswith("symmetry"):
                axis = "xyz".index(name[-1])
                fixed[..., axis] |= on
                for other in set(range(3)) - {axis}:
                    owner[(*edge[0], other)] = owner[(*edge[1], other)]
            if name in case.clamped:
                fixed[edge[0]], fixed[edge[1]] = True, True
            for axis in case.fixed.get(name, ""):
                fixed[..., "xyz".index(axis)] |= on
        owner = owner.ravel()
        owner = owner[owner]  # a corner of two symmetry planes follows its neighbour's neighbour
        free = ~fixed.ravel()[owner] & ~fixed.ravel()
        number = np.full(owner.size, -1)
        used = np.unique(owner[free])
        number[used] = np.arange(len(used))
        self.unknown = np.where(free, number[owner], -1)
        self.n = len(used)

    def _pattern(self):
        """Places of the elements' entries in the sparse tangent."""
        p1 = self.degree + 1
        i = self.span_s[:, None] + np.arange(p1)
        j = self.span_t[:, None] + np.arange(p1)
        point = (i[:, None, :, None] * self.shape[1] + j[None, :, None, :]).reshape(-1, p1 * p1)
        self.dof = self.unknown[(3 * point[:, :, None] + np.arange(3)).reshape(len(point), -1)]
        rows = np.repeat(self.dof[:, :, None], self.dof.shape[1], axis=2).ravel()
        columns = np.repeat(self.dof[:, None, :], self.dof.shape[1], axis=1).ravel()
        self.kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        key, self.entry = np.unique(rows[self.kept].astype(np.int64) * self.n + columns[self.kept], return_inverse=True)
        row, column = key // self.n, key % self.n
        self.order = SuperLU.order(row, column, self.n)
        place = np.empty(self.n, dtype=np.int64)
        place[self.order] = np.arange(self.n)
        pattern = csc_matrix((np.arange(1.0, len(key) + 1.0), (place[row], place[column])), shape=(self.n, self.n))
        self.of_entry = pattern.data.astype(np.int64) - 1
        self.indices, self.indptr = pattern.indices, pattern.indptr
        m, n = len(self.dof), self.dof.shape[1]
        self.force, self.tangent = np.empty((m, n // 3, 3)), np.empty((m, n, n))

    def full(self, unknowns):
        """Displacements of the control points (n_s, n_t, 3)."""
        return np.append(unknowns, 0.0)[self.unknown].reshape(*self.shape, 3)

    def evaluate(self, unknowns):
        """Internal forces (n,) and a solver of the tangent at some unknowns (n,)."""
        element_stiffness(
            self.full(unknowns), self.along, self.across, self.span_s, self.span_t, self.weight, self.q0,
            self.curvature, self.stiffness, self.case.thickness, self.force, self.tangent,
        )  # fmt: skip
        on = self.dof.ravel() >= 0
        internal = np.bincount(self.dof.ravel()[on], self.force.ravel()[on], minlength=self.n)
        values = np.bincount(self.entry, self.tangent.ravel()[self.kept])[self.of_entry]
        matrix = csc_matrix((values, self.indices, self.indptr), shape=(self.n, self.n))
        return internal, matrix

    def solver(self, matrix):
        """Function that solves with a tangent."""
        factor = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.01, options={"SymmetricMode": True})

        def solve(right):
            answer = np.empty_like(right)
            answer[self.order] = factor.solve(right[self.order])
            return answer

        return solve

    def load(self):
        """The case's forces on corners of the sheet (n,)."""
        load = np.zeros(self.n)
        for group, force in self.case.loads["forces"].items():
            corner = int(np.flatnonzero(self.group[group].ravel())[0])
            for axis in range(3):
                if self.unknown[3 * corner + axis] >= 0:
                    load[self.unknown[3 * corner + axis]] += force[axis]
        return load

    def probes(self, unknowns):
        """Displacements of the case's probes."""
        u = self.full(unknowns)
        return [sign * float(u[self.group[group]][0][axis]) for group, axis, sign in self.case.probes.values()]


EDGES = (
    ((0, slice(None)), (1, slice(None))),
    ((-1, slice(None)), (-2, slice(None))),
    ((slice(None), 0), (slice(None), 1)),
    ((slice(None), -1), (slice(None), -2)),
)  # rows of control points on an edge, and next to it


def spline_path(shell, farthest):
    """Points of the path (load, *probes) from no load up to the first beyond the full load, by the movement of the
    loaded point, which only goes on. farthest : that movement in a step. Raises StepFailed."""
    load = shell.load()
    along = load / np.linalg.norm(load)
    u, factor = np.zeros(shell.n), 0.0
    solve = shell.solver(shell.evaluate(u)[1])
    onward, size = solve(load), 0.1 * farthest
    yield 0.0, *shell.probes(u)
    while factor < 1.0:
        found = correct(shell, load, along, u, factor, size / (along @ onward) * onward, size)
        if found is None:
            size *= 0.5
            if size < SMALLEST * farthest:
                raise StepFailed(f"splines: no equilibrium beyond {factor:.4f} of the load; take more cells")
            continue
        reached, factor, iterations = found
        onward, u = reached - u, reached
        yield factor, *shell.probes(u)
        size = min(farthest, size * (1.5 if iterations <= FEW else 0.8))


def correct(shell, load, along, u, factor, step, size):
    """Equilibrium where the loaded point has moved by `size` beyond u, sought from u + step by Newton's method: the
    unknowns, the load factor and the iterations, or None."""
    trial = u + step
    for iteration in range(N_ITERATIONS):
        internal, matrix = shell.evaluate(trial)
        error = np.linalg.norm(factor * load - internal) / np.linalg.norm(load)
        if not np.isfinite(error) or (iteration > FEW and error > FAR):
            return None
        if iteration and error < TOLERANCE:
            return trial, factor, iteration
        solve = shell.solver(matrix)
        r, v = solve(factor * load - internal), solve(load)
        change = (size - along @ (trial - u + r)) / (along @ v)
        trial, factor = trial + r + change * v, factor + change
    return None
