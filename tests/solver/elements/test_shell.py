"""The shell triangle: exact derivatives, rigid motion, patch tests on distorted meshes, no spurious modes."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver import SceneError
from solver.elements.assembly import build_pattern, gather_blocks, gather_forces
from solver.elements.formulation import SheetMesh, ShellElements
from solver.elements.patches import OWN, neighbours
from tests.solver.lattice import square

YOUNG, POISSON, THICKNESS = 1000.0, 0.3, 0.5
ELASTIC = YOUNG / (1 - POISSON**2) * np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, (1 - POISSON) / 2]])


class ElasticShell:
    """A patch with a linear law between Green strain and second Piola-Kirchhoff stress."""

    def __init__(self, points, cells, planes=None, clamped=(), n_layers=3, size=1.0):
        nodes = np.asarray(clamped, dtype=np.int64)
        mesh = SheetMesh(points, cells, THICKNESS, (1.0, 0.0, 0.0), planes or {}, nodes, size)
        self.elements = ShellElements(mesh, n_layers)
        self.n_nodes, self.n_rows = len(points), len(points) + self.elements.n_slopes
        self.start = np.vstack([points, np.zeros((self.elements.n_slopes, 3))])
        self.pattern = build_pattern(self.elements.slots, self.n_rows, self.elements.n_translations)
        self.free = np.ones((self.n_rows, 3), dtype=bool)
        self.free[self.n_nodes :, 1:] = False

    def evaluate(self, u):
        """Energy, forces (n + k, 3) and stiffness (3 (n + k), 3 (n + k)) at u."""
        e = self.elements
        n_points, n_tris = len(e.point_volume), len(e.slots)
        sheet = SimpleNamespace(
            u=u,
            x=u[: self.n_nodes],
            metric=np.empty((n_points, 3)),
            second_stress=np.empty((n_points, 3)),
            tangent=np.tile(ELASTIC, (n_points, 1, 1)),
        )
        e.strain(sheet)
        green = np.column_stack([0.5 * (sheet.metric[:, 0] - 1), 0.5 * (sheet.metric[:, 1] - 1), sheet.metric[:, 2]])
        sheet.second_stress[:] = green @ ELASTIC
        energy = 0.5 * np.sum(e.point_volume * np.sum(green * sheet.second_stress, axis=1))
        slots, stiffness = np.empty((n_tris, 9, 3)), np.empty((n_tris, 21, 21))
        force, blocks = np.empty((self.n_rows, 3)), np.empty((len(self.pattern.block_row), 3, 3))
        e.forces(sheet, slots)
        e.stiffness(sheet, stiffness)
        gather_forces(slots, *self.pattern.rows, force)
        gather_blocks(stiffness, 9, 6, self.pattern.block_first, self.pattern.block_slot, blocks)
        full = np.zeros((self.n_rows, 3, self.n_rows, 3))
        full[self.pattern.block_row, :, self.pattern.block_column] = blocks
        return energy, force, full.reshape(3 * self.n_rows, -1)

    def solve(self, held, values):
        """Displacement from u by linear theory with some unknowns (n + k, 3) bool held at values."""
        _, _, stiffness = self.evaluate(self.start)
        known = (held | ~self.free).ravel()
        answer = np.where(held, values, 0.0).ravel()
        right = -(stiffness @ answer)[~known]
        answer[~known] = np.linalg.solve(stiffness[np.ix_(~known, ~known)], right)
        return answer.reshape(-1, 3), (stiffness @ answer).reshape(-1, 3)


def curved(mesh, seed=1, scale=0.0):
    points = mesh.points.copy()
    points[:, 2] = 0.05 * points[:, 0] ** 2 + 0.03 * points[:, 0] * points[:, 1]
    return points + scale * np.random.default_rng(seed).standard_normal(points.shape)


@pytest.mark.parametrize("edges", ["free", "symmetric and clamped"])
def test_forces_and_stiffness_are_derivatives_of_the_energy(edges):
    mesh = square(3, 3.0, distort=0.3)
    supports = {"planes": {0: mesh.groups["symmetry_x"]}, "clamped": mesh.groups["top"]} if edges != "free" else {}
    shell = ElasticShell(curved(mesh), mesh.cells, **supports)
    rng = np.random.default_rng(2)
    shell.elements.stretch[:] = 1.0 + 0.1 * rng.uniform(size=len(mesh.cells))
    u = shell.start + 0.1 * rng.standard_normal(shell.start.shape) * shell.free
    _, force, stiffness = shell.evaluate(u)
    numeric_force, numeric = np.zeros(u.size), np.zeros_like(stiffness)
    for k in np.flatnonzero(shell.free):
        e = np.zeros(u.size)
        e[k] = 1e-6
        (w1, f1, _), (w2, f2, _) = (shell.evaluate(u + s * e.reshape(u.shape)) for s in (1, -1))
        numeric_force[k] = (w1 - w2) / 2e-6
        numeric[:, k] = (f1 - f2).ravel() / 2e-6
    assert force.ravel() == pytest.approx(numeric_force, abs=1e-8 * np.abs(force).max())
    assert stiffness == pytest.approx(numeric, abs=1e-8 * np.abs(stiffness).max())
    assert stiffness == pytest.approx(stiffness.T, abs=1e-13 * np.abs(stiffness).max())


def test_a_rigid_motion_makes_no_strain_and_turns_the_forces():
    mesh = square(3, 3.0, distort=0.3)
    shell = ElasticShell(curved(mesh), mesh.cells)
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    u = shell.start.copy()
    u[: shell.n_nodes] = u[: shell.n_nodes] @ turn.T + [3.0, -2.0, 7.0]
    energy, force, _ = shell.evaluate(u)
    assert energy < 1e-24 * YOUNG
    assert np.abs(force).max() < 1e-11 * YOUNG
    rng = np.random.default_rng(3)
    bent = shell.start + 0.05 * rng.standard_normal(shell.start.shape) * shell.free
    turned = bent.copy()
    turned[: shell.n_nodes] = bent[: shell.n_nodes] @ turn.T
    (e1, f1, _), (e2, f2, _) = shell.evaluate(bent), shell.evaluate(turned)
    n = shell.n_nodes
    assert e2 == pytest.approx(e1, rel=1e-11)
    assert f2[:n] == pytest.approx(f1[:n] @ turn.T, abs=1e-10 * np.abs(f1).max())
    assert f2[n:] == pytest.approx(f1[n:], abs=1e-10 * np.abs(f1).max())
    assert f1[:n].sum(axis=0) == pytest.approx(0.0, abs=1e-10 * np.abs(f1).max())
    assert np.cross(bent[:n], f1[:n]).sum(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(f1).max())


@pytest.mark.parametrize(("distort", "wider"), [(0.0, 1.0), (0.3, 1.0), (0.3, 1.8), (0.0, 0.4)])
def test_folding_strains_no_triangle(distort, wider):
    # A sheet folded about a line of sides keeps all lengths: no membrane strain, and the slope across is tan(theta/2)
    # between equal triangles. wider : those beyond the fold, relative to the others
    mesh, angle = square(4, 4.0, distort=0.0), np.radians(70.0)
    # Inner nodes move along y only: the fold x = 2 stays straight.
    inner = ((mesh.points[:, :2] > 0.0) & (mesh.points[:, :2] < 4.0)).all(axis=1)
    mesh.points[inner, 1] += distort * np.random.default_rng(5).uniform(-1.0, 1.0, inner.sum())
    mesh.points[:, 0] += (wider - 1.0) * np.maximum(mesh.points[:, 0] - 2.0, 0.0)
    elements = ElasticShell(mesh.points, mesh.cells).elements
    u = np.vstack([mesh.points, np.zeros((elements.n_slopes, 3))])
    beyond = np.maximum(mesh.points[:, 0] - 2.0, 0.0)
    u[: len(mesh.points), 0] += (np.cos(angle) - 1.0) * beyond
    u[: len(mesh.points), 2] += np.sin(angle) * beyond
    elements._kinematics(u)
    assert elements.metric == pytest.approx(np.tile([1.0, 1.0, 0.0], (len(mesh.cells), 1)), abs=1e-13)
    if not distort and wider == 1.0:
        away = np.abs(mesh.points[mesh.cells][:, :, 0] - 2.0)
        at_fold = (away < 1e-9).sum(axis=1) == 2  # triangles of altitude 1 on the fold
        turn = np.linalg.norm(elements.curvature, axis=1)
        assert turn[at_fold] == pytest.approx(2.0 * np.tan(0.5 * angle), rel=1e-12)
        assert turn[~at_fold] == pytest.approx(0.0, abs=1e-12)


def test_in_the_plane_the_metric_is_that_of_mean_gradients():
    mesh = square(3, 3.0, distort=0.3)
    elements = ElasticShell(mesh.points, mesh.cells).elements
    u = np.vstack([mesh.points, np.zeros((elements.n_slopes, 3))])
    u[: len(mesh.points), :2] += 0.3 * np.random.default_rng(6).standard_normal((len(mesh.points), 2))
    elements._kinematics(u)
    own = np.einsum("mic,mia->mac", u[mesh.cells], elements.triangles.gradients)
    across, _ = neighbours(mesh.cells)
    area = elements.triangles.area[:, None, None]
    expected = OWN * np.einsum("mac,mbc->mab", own, own)
    for i in range(3):
        there = (across[:, i] >= 0)[:, None, None]
        share = np.where(there, area[across[:, i]] / (area + area[across[:, i]]), 0.0)
        mean = (1.0 - share) * own + share * own[across[:, i]]
        expected += (1.0 - OWN) / 3.0 * np.einsum("mac,mbc->mab", mean, mean)
    found = elements.metric
    assert found == pytest.approx(expected[:, [0, 1, 0], [0, 1, 1]], abs=1e-13)


def test_compression_finds_no_softer_mode_than_the_material():
    # A plate pressed to 0.65 of its length along x, free to widen: with the law of this file the material still resists
    # every wave in its plane, and so must every movement of the nodes. With a mean of the triangles' metrics rows of
    # them zigzag before.
    n, pressed = 6, 0.65
    mesh = square(n, float(n))
    shell = ElasticShell(mesh.points, mesh.cells)
    green = 0.5 * (pressed**2 - 1.0)
    stretch, stress = np.array([pressed, np.sqrt(1.0 - 2.0 * POISSON * green)]), YOUNG * green
    for angle in np.radians(np.arange(0.0, 180.0, 5.0)):
        wave = np.array([np.cos(angle), np.sin(angle)])
        strain = np.array([
            [stretch[0] * wave[0], 0.0], [0.0, stretch[1] * wave[1]], [stretch[0] * wave[1], stretch[1] * wave[0]],
        ])  # fmt: skip
        acoustic = strain.T @ ELASTIC @ strain + stress * wave[0] ** 2 * np.eye(2)
        assert np.linalg.eigvalsh(acoustic)[0] > 0.0
    u = shell.start.copy()
    u[: shell.n_nodes, :2] *= stretch
    _, _, stiffness = shell.evaluate(u)
    x, y = mesh.points[:, :2].T
    free = np.zeros(u.shape, dtype=bool)
    free[: shell.n_nodes, 0], free[: shell.n_nodes, 1] = (x > 0.0) & (x < n), y > 0.0
    assert np.linalg.eigvalsh(stiffness[np.ix_(free.ravel(), free.ravel())])[0] > 0.0


def test_the_energy_of_bending_in_the_plane():
    # Nodes of a lattice at the exact places of pure bending along its sides, L = n h: the energy is within (h/L)^2 of
    # the exact one. Linear triangles without a part of their neighbours' metrics store 3.45 (h/L)^2 too much.
    n, curvature = 24, 1e-5
    mesh = square(n, float(n))
    shell = ElasticShell(mesh.points, mesh.cells)
    x, y = mesh.points[:, 0], mesh.points[:, 1] - 0.5 * n
    u = shell.start.copy()
    u[: shell.n_nodes, 0] += curvature * x * y
    u[: shell.n_nodes, 1] -= 0.5 * curvature * (x**2 + POISSON * y**2)
    energy, _, _ = shell.evaluate(u)
    exact = 0.5 * YOUNG * THICKNESS * curvature**2 * n * n**3 / 12
    assert energy == pytest.approx(exact, rel=1.0 / n**2)


@pytest.mark.parametrize("distort", [0.0, 0.35])
def test_no_spurious_mode(distort):
    # Six rigid ones and no other: theory_shell.md 12.8.
    mesh = square(3, 3.0, distort=distort)
    shell = ElasticShell(mesh.points, mesh.cells)
    _, _, stiffness = shell.evaluate(shell.start)
    free = shell.free.ravel()
    values = np.linalg.eigvalsh(stiffness[np.ix_(free, free)])
    assert (np.abs(values) < 1e-10 * values[-1]).sum() == 6
    assert values.min() > -1e-10 * values[-1]


STATES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "twist": [0.0, 0.0, 1.0], "all": [0.7, -0.4, 0.5]}


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("distort", [0.0, 0.35])
def test_bending_patch(state, distort):
    # Edge nodes on a quadratic surface, edge slopes free under its edge moment: inner nodes follow it exactly.
    mesh = square(4, 4.0, distort=distort)
    shell = ElasticShell(mesh.points, mesh.cells)
    k11, k22, k12 = STATES[state]
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    w = 1e-3 * (0.5 * k11 * x**2 + 0.5 * k22 * y**2 + k12 * x * y)
    held, values = np.zeros(shell.start.shape, dtype=bool), np.zeros(shell.start.shape)
    rim = (x == 0.0) | (x == 4.0) | (y == 0.0) | (y == 4.0)
    held[: shell.n_nodes][rim] = True
    held[: shell.n_nodes, :2] = True
    values[: shell.n_nodes, 2] = w
    # The rim carries the exact normal moments M_nn.
    moment = THICKNESS**3 / 12 * ELASTIC @ (-1e-3 * np.array([k11, k22, 2 * k12]))
    _, _, stiffness = shell.evaluate(shell.start)
    load = np.zeros(shell.start.size)
    tri_across, _ = neighbours(mesh.cells)
    for tri, i in zip(*np.nonzero(tri_across < 0)):
        a, b = mesh.points[mesh.cells[tri, (i + 1) % 3]], mesh.points[mesh.cells[tri, (i + 2) % 3]]
        t = (b - a) / np.linalg.norm(b - a)
        nu = np.array([t[1], -t[0]])
        normal_moment = moment[0] * nu[0] ** 2 + moment[1] * nu[1] ** 2 + 2 * moment[2] * nu[0] * nu[1]
        # The side's outward slope, dw/dnu of the triangle plus the edge slope, is conjugate to -M_nn times the side.
        load[3 * shell.elements.slots[tri, 6 + i]] -= normal_moment * np.linalg.norm(b - a)
        slope = shell.elements.triangles.gradients[tri] @ nu
        load[3 * mesh.cells[tri] + 2] -= normal_moment * np.linalg.norm(b - a) * slope
    known = (held | ~shell.free).ravel()
    answer = values.ravel().copy()
    right = load[~known] - stiffness[np.ix_(~known, known)] @ np.where(held.ravel(), values.ravel(), 0.0)[known]
    answer[~known] = np.linalg.solve(stiffness[np.ix_(~known, ~known)], right)
    assert answer.reshape(-1, 3)[: shell.n_nodes, 2] == pytest.approx(w, abs=1e-9 * np.abs(w).max())


def test_membrane_patch():
    # Rim nodes on a linear map: so are the inner ones, on any mesh.
    mesh = square(4, 4.0, distort=0.35)
    shell = ElasticShell(mesh.points, mesh.cells)
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    held, values = np.zeros(shell.start.shape, dtype=bool), np.zeros(shell.start.shape)
    rim = (x == 0.0) | (x == 4.0) | (y == 0.0) | (y == 4.0)
    held[: shell.n_nodes][rim] = True
    values[: shell.n_nodes] = 1e-3 * mesh.points @ [[1.0, 0.3, 0.0], [-0.2, 0.5, 0.0], [0.0, 0.0, 0.0]]
    answer, _ = shell.solve(held, values)
    assert answer[: shell.n_nodes] == pytest.approx(values[: shell.n_nodes], abs=1e-12)


def test_slopes_are_unknowns_only_where_four_nodes_do_not_do():
    # theory_shell.md 2: free sides always, inner sides of a one-diagonal lattice never, of a distorted mesh mostly.
    mesh = square(4, 4.0)
    assert ElasticShell(mesh.points, mesh.cells).elements.n_slopes == 16
    planes = {0: mesh.groups["symmetry_x"], 1: mesh.groups["symmetry_y"]}
    assert ElasticShell(mesh.points, mesh.cells, planes).elements.n_slopes == 8
    clamped = np.concatenate([mesh.groups["top"], mesh.groups["right"]])
    assert ElasticShell(mesh.points, mesh.cells, planes, clamped).elements.n_slopes == 0
    distorted = square(4, 4.0, distort=0.3)
    assert ElasticShell(distorted.points, distorted.cells).elements.n_slopes > 48


@pytest.mark.parametrize("fold", [5.0, 60.0, 120.0, 150.0])
def test_a_fold_bends_more_the_more_it_closes(fold):
    # Two equal triangles, altitude 0.5 on the shared side: the slope there is tan(fold/2), seen from either of them.
    points = np.array([[0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [-0.5, 1.0, 0.0]])
    cells = np.array([[0, 1, 2], [3, 2, 1]])
    shell = ElasticShell(points, cells)
    assert shell.elements.n_slopes == 4  # on the free sides only
    u = shell.start.copy()
    turn = Rotation.from_rotvec([0.0, np.radians(fold), 0.0]).as_matrix()
    u[3] = turn @ points[3]
    shell.elements._kinematics(u)
    tip_up = np.sign(u[3, 2])
    expected = [-2.0 / 0.5 * tip_up * np.tan(np.radians(fold) / 2), 0.0, 0.0]
    assert shell.elements.curvature == pytest.approx(np.array([expected, expected]), abs=1e-12)
    # And its derivatives are exact there, too.
    rng = np.random.default_rng(7)
    u += 0.02 * rng.standard_normal(u.shape) * shell.free
    _, force, stiffness = shell.evaluate(u)
    step = 1e-6 * rng.standard_normal(u.shape) * shell.free
    (w1, f1, _), (w2, f2, _) = shell.evaluate(u + step), shell.evaluate(u - step)
    assert w1 - w2 == pytest.approx(2.0 * np.sum(force * step), rel=1e-6)
    change = (stiffness @ (2.0 * step.ravel())).reshape(u.shape)
    assert f1 - f2 == pytest.approx(change, abs=1e-6 * np.abs(change).max())


def test_a_symmetry_plane_is_half_of_the_whole():
    # The half model bends as the whole sheet does.
    whole = square(4, 4.0)
    shift = whole.points - [2.0, 0.0, 0.0]
    w = 0.01 * shift[:, 0] ** 2 + 0.02 * shift[:, 1] ** 2
    shell = ElasticShell(shift, whole.cells)
    right = shift[:, 0] >= 0.0
    place = np.cumsum(right) - 1
    cells = place[whole.cells[right[whole.cells].all(axis=1)]]
    half = ElasticShell(shift[right], cells, {0: np.flatnonzero(shift[right][:, 0] == 0.0)})
    full_u, half_u = shell.start.copy(), half.start.copy()
    full_u[: shell.n_nodes, 2], half_u[: half.n_nodes, 2] = w, w[right]
    # Compare the sections' curvature where neither free edge is near.
    shell.elements._kinematics(full_u), half.elements._kinematics(half_u)
    ours = half.elements.curvature
    theirs = shell.elements.curvature[right[whole.cells].all(axis=1)]
    assert ours == pytest.approx(theirs, abs=1e-12)


def test_meshes_that_are_no_surface_are_refused():
    with pytest.raises(SceneError, match="three triangles share"):
        neighbours(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))
    with pytest.raises(SceneError, match="face opposite ways"):
        neighbours(np.array([[0, 1, 2], [0, 1, 3]]))
