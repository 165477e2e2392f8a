"""Free motion of elastic sheets against closed forms: waves, plate frequencies, momentum."""

import numpy as np
import pytest

from solver import Membrane, Shell
from tests.solver.explicit.patch import arch, frequency, motion, swing
from tests.solver.lattice import square

DENSITY, YOUNG = 7.85e-9, 206000.0


def test_a_wave_runs_along_a_bar_at_the_speed_of_sound():
    length, n = 100.0, 40
    mesh = square(n, length)
    mesh.points[:, 1] *= 0.02
    dynamics = motion(mesh, 1.0, poisson=0.0)
    # Fixed at x = 0, free at the other end: omega = pi c / (2 L).
    shape = np.zeros((len(mesh.points), 3))
    shape[:, 0] = 1e-3 * np.sin(0.5 * np.pi * mesh.points[:, 0] / length)
    expected = 0.5 * np.pi * np.sqrt(YOUNG / DENSITY) / length
    steps = int(2.2 * 2.0 * np.pi / expected / dynamics.limit)
    assert frequency(*swing(dynamics, shape, steps)) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("distort", [0.0, 0.2])
def test_frequency_of_a_simply_supported_plate(distort):
    half, n, thickness, nu = 50.0, 10, 1.0, 0.3
    mesh = square(n, half, distort)
    dynamics = motion(mesh, thickness, Shell(3), nu, fixed={"right": "z", "top": "z"})
    shape = np.zeros((len(mesh.points), 3))
    wave = 0.5 * np.pi / half
    shape[:, 2] = 1e-3 * np.cos(wave * mesh.points[:, 0]) * np.cos(wave * mesh.points[:, 1])
    bending = YOUNG * thickness**3 / (12.0 * (1.0 - nu**2))
    expected = 2.0 * wave**2 * np.sqrt(bending / (DENSITY * thickness))
    steps = int(1.2 * 2.0 * np.pi / expected / dynamics.limit)
    assert frequency(*swing(dynamics, shape, steps)) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("bends", [2, 4])
def test_frequency_of_a_ring_that_bends(bends):
    # Without stretch, w = cos k a and v = -sin(k a)/k: omega^2 = E t^2 / (12 rho R^4) k^2 (k^2 - 1)^2 / (k^2 + 1).
    radius, thickness = 50.0, 1.0
    mesh = arch(16 * bends, 2, radius, 4.0)
    dynamics = motion(mesh, thickness, Shell(3), 0.0)
    angle = np.arctan2(mesh.points[:, 0], mesh.points[:, 2])
    out, along = (np.column_stack([f(angle), 0.0 * angle, g(angle)]) for f, g in ((np.sin, np.cos), (np.cos, _down)))
    shape = np.cos(bends * angle)[:, None] * out - (np.sin(bends * angle) / bends)[:, None] * along
    expected = np.sqrt(YOUNG / (12.0 * DENSITY)) * thickness / radius**2
    expected *= bends * (bends**2 - 1.0) / np.sqrt(bends**2 + 1.0)
    steps = int(1.2 * 2.0 * np.pi / expected / dynamics.limit)
    assert frequency(*swing(dynamics, 1e-3 * shape, steps)) == pytest.approx(expected, rel=0.01)


def _down(angle):
    return -np.sin(angle)


def cylinder_mode(radius, length, thickness, nu, around, young=YOUNG):
    """Lowest frequency of a cylinder on shear diaphragms 2 `length` apart that bends `around` times round, and its
    amplitudes along the axis, round it and outwards.

    Love's shell (Leissa 1973): u = U cos n a sin k y, v = V sin n a cos k y, w = W cos n a cos k y, k = pi/(2 length).
    Strains and changes of curvature are linear in the amplitudes; their energy is quadratic.
    """
    n, k, r = around, 0.5 * np.pi / length, radius
    stretch = np.array([[k, 0.0, 0.0], [0.0, n / r, 1.0 / r], [-n / r, -k, 0.0]])
    bend = np.array([[0.0, 0.0, k**2], [0.0, n / r**2, n**2 / r**2], [0.0, -2.0 * k / r, -2.0 * n * k / r]])
    elastic = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]]) * young / (1.0 - nu**2)
    energy = thickness * stretch.T @ elastic @ stretch + thickness**3 / 12.0 * bend.T @ elastic @ bend
    square, modes = np.linalg.eigh(energy / (DENSITY * thickness))
    return np.sqrt(square[0]), modes[:, 0]


@pytest.mark.parametrize("around", [2, 4])
def test_frequency_of_a_cylinder_on_diaphragms(around):
    """Stretch and bending of a curved shell together: twice round the one rules, four times the other."""
    radius, length, thickness, nu = 50.0, 50.0, 1.0, 0.3
    mesh = arch(24, 14, radius, length)
    y = mesh.points[:, 1]
    mesh.groups |= {"symmetry_y": np.flatnonzero(y == 0.0), "end": np.flatnonzero(y == length)}
    dynamics = motion(mesh, thickness, Shell(3), nu, fixed={"end": "xz"})
    expected, (along, round_, out) = cylinder_mode(radius, length, thickness, nu, around)
    angle = np.arctan2(mesh.points[:, 0], mesh.points[:, 2])
    far, near = np.cos(0.5 * np.pi * y / length), np.sin(0.5 * np.pi * y / length)
    shape = out * (np.cos(around * angle) * far)[:, None] * np.column_stack([np.sin(angle), 0 * y, np.cos(angle)])
    shape += round_ * (np.sin(around * angle) * far)[:, None] * np.column_stack([np.cos(angle), 0 * y, -np.sin(angle)])
    shape[:, 1] = along * np.cos(around * angle) * near
    steps = int(1.2 * 2.0 * np.pi / expected / dynamics.limit)
    assert frequency(*swing(dynamics, 1e-3 * shape, steps)) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
def test_frequency_of_a_ring_that_breathes(element):
    # omega = sqrt(E / rho) / R
    radius, n = 50.0, 48
    mesh = arch(n, 2, radius, 4.0)
    dynamics = motion(mesh, 1.0, element, 0.0)
    shape = mesh.points * [1e-3 / radius, 0.0, 1e-3 / radius]
    expected = np.sqrt(YOUNG / DENSITY) / radius
    steps = int(2.2 * 2.0 * np.pi / expected / dynamics.limit)
    assert frequency(*swing(dynamics, shape, steps)) == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
def test_momentum_and_energy_of_a_free_sheet_stay(element):
    mesh = square(5, 10.0, 0.2)
    mesh.groups = {}
    dynamics = motion(mesh, 0.5, element)
    n = len(mesh.points)
    velocity = np.random.default_rng(1).standard_normal((n, 3))
    dynamics.v[:n] = velocity
    mass = dynamics.mass[:n, None]
    start = np.sum(mass * velocity, axis=0)
    spin = np.sum(np.cross(mesh.points, mass * velocity), axis=0)
    kinetic = 0.5 * np.sum(mass * velocity**2)
    dt = 0.5 * dynamics.limit
    for _ in range(400):
        internal = dynamics.work["internal"]
        dynamics.step(0.0, dt, dt)
    size = np.abs(mass * velocity).sum()
    assert np.sum(mass * dynamics.v[:n], axis=0) == pytest.approx(start, abs=1e-11 * size)
    # v is half a step behind x: their spin is known to the force over half a step.
    x = dynamics.state.sheet.x - 0.5 * dt * dynamics.v[:n]
    assert np.sum(np.cross(x, mass * dynamics.v[:n]), axis=0) == pytest.approx(spin, abs=1e-3 * 10.0 * size)
    # Central differences keep the sum of internal energy and v- M v+ / 2 of a linear system.
    both = 0.5 * np.sum(dynamics.mass[:, None] * dynamics.v * dynamics.v_new)
    total = both + internal
    assert total == pytest.approx(kinetic, rel=1e-6)
    assert internal > 0.2 * kinetic
