import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver import Blank, Implicit, Material, Membrane, Newton, PlanarHill, Scene, Shell, Stage, Swift, form
from solver.elements.membrane import build_membranes, internal_forces, metrics, stiffnesses, unit_normals
from solver.elements.pressure import pressure_forces
from tests.solver.lattice import square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589), "mild steel")
TIGHT = Implicit(newton=Newton(residual=1e-11, correction=1e-9))


class Patch:
    """A few membranes with material, evaluated at any positions."""

    def __init__(self, mesh, rolling=(1.0, 0.0, 0.0)):
        self.start = mesh.points.copy()
        self.m = build_membranes(mesh.points, mesh.cells, 0.8, rolling)
        n = len(mesh.cells)
        self.state = STEEL.new_state(n)
        self.normal, self.torsion = self.m.axes[:, 2].copy(), 0.0

    def stress(self, x):
        n = len(self.m.cells)
        metric, new = np.empty((n, 3)), STEEL.new_state(n)
        metrics(x, self.m.cells, self.m.gradients, metric)
        STEEL.update(metric, self.state, new)
        return new.second_stress, new.tangent

    def forces(self, x):
        s, _ = self.stress(x)
        force = np.empty((len(self.m.cells), 3, 3))
        internal_forces(x, self.m.cells, self.m.gradients, self.m.volume, s, self.normal, self.torsion, force)
        return force

    def stiffness(self, x):
        s, ds = self.stress(x)
        k = np.empty((len(self.m.cells), 9, 9))
        stiffnesses(x, self.m.cells, self.m.gradients, self.m.volume, s, ds, self.normal, self.torsion, k)
        return k.reshape(-1, 3, 3, 3, 3)


def bent(mesh, scale, seed=1):
    x = mesh.points.copy()
    rng = np.random.default_rng(seed)
    x[:, 2] = 0.05 * x[:, 0] ** 2 - 0.03 * x[:, 0] * x[:, 1]
    return x + scale * rng.standard_normal(x.shape)


@pytest.mark.parametrize("scale", [1e-4, 0.1])
def test_stiffness_is_the_derivative_of_the_forces(scale):
    mesh = square(2, 3.0, distort=0.2)
    patch = Patch(mesh, rolling=(0.6, 0.8, 0.0))
    x = bent(mesh, scale)
    patch.torsion = 500.0
    unit_normals(bent(mesh, scale, seed=2), mesh.cells, patch.normal)
    k = patch.stiffness(x)
    step = 1e-6
    for node in range(len(x)):
        for c in range(3):
            e = np.zeros_like(x)
            e[node, c] = step
            numeric = (patch.forces(x + e) - patch.forces(x - e)) / (2 * step)
            exact = np.zeros_like(numeric)
            for i in range(3):
                here = patch.m.cells[:, i] == node
                exact[here] += k[here][:, :, :, i, c]
            assert exact == pytest.approx(numeric, abs=2e-6 * np.abs(k).max())
    assert k == pytest.approx(k.transpose(0, 3, 4, 1, 2), abs=1e-9 * np.abs(k).max())


def test_pressure_tangent_is_the_derivative_of_the_forces():
    mesh = square(1, 2.0)
    x = bent(mesh, 0.2)

    def forces(x):
        f, k = np.empty((2, 3, 3)), np.zeros((2, 9, 9))
        pressure_forces(x, mesh.cells, 1.7, f, k)
        return f, k.reshape(2, 3, 3, 3, 3)

    f, k = forces(x)
    corner = x[mesh.cells]
    area = 0.5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]).sum(axis=0)
    assert f.sum(axis=(0, 1)) == pytest.approx(-1.7 * area)
    for i in range(2):
        for j in range(3):
            for c in range(3):
                e = np.zeros_like(x)
                e[mesh.cells[i, j], c] = 1e-6
                numeric = (forces(x + e)[0][i] - forces(x - e)[0][i]) / 2e-6
                assert -k[i, :, :, j, c] == pytest.approx(numeric, abs=1e-8)


def test_a_rigid_turn_makes_no_stress_and_turns_the_forces():
    mesh = square(3, 5.0, distort=0.2)
    patch = Patch(mesh)
    stretched = bent(mesh, 0.05)
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    moved = mesh.points @ turn.T + [3.0, -2.0, 7.0]
    assert np.abs(patch.stress(moved)[0]).max() < 1e-9 * STEEL.young
    assert patch.stress(stretched @ turn.T)[0] == pytest.approx(patch.stress(stretched)[0], abs=1e-8)
    assert patch.forces(stretched @ turn.T) == pytest.approx(patch.forces(stretched) @ turn.T, abs=1e-8)


def test_forces_of_a_triangle_balance():
    mesh = square(2, 3.0, distort=0.2)
    patch = Patch(mesh)
    x = bent(mesh, 0.1)
    f = patch.forces(x)
    corner = x[mesh.cells]
    assert f.sum(axis=1) == pytest.approx(0.0, abs=1e-9)
    assert np.cross(corner, f).sum(axis=1) == pytest.approx(0.0, abs=1e-8)


def test_energy_of_the_forces_is_that_of_the_stress():
    # f . dx = V S : dE for any movement, here along a straight path inside one elastic increment.
    mesh = square(2, 3.0, distort=0.2)
    patch = Patch(mesh)
    rng = np.random.default_rng(5)
    x, dx = bent(mesh, 1e-5), 1e-6 * rng.standard_normal(mesh.points.shape)
    metric = [np.empty((len(mesh.cells), 3)) for _ in range(2)]
    for sign, out in zip((-1, 1), metric):
        metrics(x + sign * dx, patch.m.cells, patch.m.gradients, out)
    de = 0.5 * (metric[1] - metric[0]) * [1, 1, 2]
    work = np.sum(patch.m.volume[:, None] * patch.stress(x)[0] * de)
    f = np.zeros_like(x)
    np.add.at(f, mesh.cells.ravel(), patch.forces(x).reshape(-1, 3))
    assert np.sum(f * 2 * dx) == pytest.approx(work, rel=1e-8)


def test_torsion_resists_the_rotation_out_of_the_plane_of_the_start():
    # Energy T* t A (g1^2 + g2^2)/2 with g the slopes of a flat patch that tilts (theory.md 2).
    mesh = square(2, 3.0, distort=0.2)
    patch = Patch(mesh)
    patch.torsion = 7.0
    x = mesh.points.copy()
    x[:, 2] = 1e-4 * (0.3 * x[:, 0] - 0.4 * x[:, 1])
    f = np.zeros_like(x)
    np.add.at(f, mesh.cells.ravel(), patch.forces(x).reshape(-1, 3))
    assert np.sum(f[:, 2] * x[:, 2]) == pytest.approx(7.0 * 0.8 * 9.0 * (0.5e-4) ** 2, rel=1e-3)


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
@pytest.mark.parametrize("rolling", [(1.0, 0.0, 0.0), (0.3, 0.9, 0.0)])
def test_patch_uniaxial_tension_of_a_distorted_mesh(rolling, element):
    # Force and thickness in closed form: s(ep) with h1 = s/E + ep; benchmarks.md L.
    mesh = square(4, 10.0, distort=0.3)
    ep, r = 0.18, 1.77
    s = STEEL.hardening(ep)
    h1 = s / STEEL.young + ep
    h2 = -0.3 * s / STEEL.young - r / (1 + r) * ep
    h3 = -0.3 * s / STEEL.young - ep / (1 + r)
    blank = Blank(mesh, 0.8, STEEL, element, rolling=rolling, fixed={"all": "z"})
    results = form(Scene(blank, [Stage(moved={"right": (10 * np.expm1(h1), None, None)})]), TIGHT, frames=1)
    frame = results.frames[-1]
    assert frame.cell_fields["thickness"] == pytest.approx(0.8 * np.exp(h3), rel=1e-8)
    assert frame.cell_fields["plastic_strain"] == pytest.approx(ep, rel=1e-8)
    assert frame.points[mesh.groups["top"], 1] == pytest.approx(10 * np.exp(h2), rel=1e-8)
    inner = 5.0 * mesh.points / 5.0 * [np.exp(h1), np.exp(h2), 1.0]
    assert frame.points == pytest.approx(inner, abs=1e-7)
    stress = frame.cell_fields["stress"]
    # True stress: T lives on the initial volume, so it is divided by the volume ratio.
    assert stress[:, 0] == pytest.approx(s / np.exp(h1 + h2 + h3), rel=1e-7)
    assert np.abs(stress[:, 1:]).max() < 1e-5 * s


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
def test_patch_equibiaxial_tension(element):
    mesh = square(3, 10.0, distort=0.3)
    ep, r = 0.3, 1.77
    s = np.sqrt((1 + r) / 2) * STEEL.hardening(ep)
    h = 0.7 * s / STEEL.young + ep * STEEL.hardening(ep) / (2 * s)
    pull = 10 * np.expm1(h)
    blank = Blank(mesh, 0.8, STEEL, element, fixed={"all": "z"})
    moved = {"right": (pull, None, None), "top": (None, pull, None)}
    frame = form(Scene(blank, [Stage(moved=moved)]), TIGHT, frames=1).frames[-1]
    assert frame.cell_fields["plastic_strain"] == pytest.approx(ep, rel=1e-8)
    assert frame.cell_fields["strain_minor"] == pytest.approx(h, rel=1e-8)
