"""The stable step against the largest eigenvalue of the assembled, elastic sheet."""

import numpy as np
import pytest
from scipy.linalg import eigh

from cadlink import Rectangle, mesh_blank
from solver import Membrane, Shell
from solver.explicit.dynamics import APART, BEGIN, NARROWED
from solver.explicit.mass import lumped_masses, scaled_density, wave_steps
from tests.solver.explicit.patch import arch, motion
from tests.solver.lattice import square


def true_limit(dynamics):
    """2/omega_max of K x = omega^2 M x, from the elements' assembled tangents."""
    sheet, state, elements = dynamics.sheet, dynamics.state.sheet, dynamics.sheet.elements
    elements.begin(state, sheet.blank.material, dynamics.method)
    elements.strain(state)
    sheet.blank.material.update(state.metric, sheet.blank.material.new_state(len(state.metric)), state)
    m, k = elements.slots.shape
    size = k + 2 * elements.n_translations
    force, stiffness = np.empty((m, k, 3)), np.empty((m, size, size))
    elements.forces(state, force)
    elements.stiffness(state, stiffness)
    whole = np.zeros((3 * len(dynamics.mass),) * 2)
    for tri in range(m):
        place = []
        for slot, row in enumerate(elements.slots[tri]):
            width = 3 if slot < elements.n_translations else 1
            place += [3 * row + c if row >= 0 else -1 for c in range(width)]
        place = np.array(place)
        there = np.flatnonzero(place >= 0)
        np.add.at(whole, np.ix_(place[there], place[there]), stiffness[tri][np.ix_(there, there)])
    free = np.flatnonzero(~dynamics.fixed.ravel())
    mass = np.repeat(dynamics.mass, 3)[free]
    largest = eigh(whole[np.ix_(free, free)], np.diag(mass), eigvals_only=True)[-1]
    return 2.0 / np.sqrt(largest)


MESHES = {
    "lattice": lambda: square(6, 6.0),
    "distorted": lambda: square(6, 6.0, 0.3),
    "unstructured": lambda: mesh_blank(Rectangle(6.0, 6.0), 1.0, arrangement="unstructured"),
    "one small triangle": lambda: pinched(),
    "curved": lambda: arch(12, 4, 8.0, 4.0),
}


def pinched():
    mesh = square(6, 6.0)
    mesh.points[3 * 7 + 3, :2] += [0.55, 0.0]
    return mesh


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(
    "element, thickness", [(Membrane(), 0.1), (Shell(3), 0.1), (Shell(3), 0.5), (Shell(3), 1.0), (Shell(3), 2.0)]
)
def test_step_is_below_the_limit_and_close_to_it(mesh, element, thickness):
    dynamics = motion(MESHES[mesh](), thickness, element)
    found, limit = dynamics.limit / dynamics.method.safety, true_limit(dynamics)
    assert 0.85 * limit <= found <= limit * (1.0 + 1e-6)


def test_a_second_look_at_a_stretched_sheet():
    dynamics = motion(square(6, 6.0), 0.1)
    dynamics.state.sheet.x[:, 0] *= 0.5
    dynamics.sheet.elements.strain(dynamics.state.sheet)
    for _ in range(3):
        dynamics.look()
    assert 0.85 * true_limit(dynamics) <= dynamics.limit / dynamics.method.safety <= true_limit(dynamics) * (1 + 1e-6)


@pytest.mark.parametrize("element, thickness", [(Membrane(), 0.1), (Shell(3), 0.01)])
def test_supports_in_the_plane_do_not_make_the_step_longer(element, thickness):
    mesh = square(6, 6.0)
    held = motion(mesh, thickness, element, fixed={"all": "xy"})
    # The free sheet's step stays a bound however far the held one deflects. A shell's slopes see to it by themselves.
    mesh.groups = {"all": mesh.groups["all"]}
    limit = true_limit(motion(mesh, thickness, element))
    assert 0.85 * held.method.safety * limit <= held.limit <= limit


def test_a_membrane_without_stiffness_across_it_is_stepped_through_large_deflections():
    # Pushed across its plane by velocities that stretch it by some per cent: its energy stays what it was.
    mesh = square(6, 6.0)
    dynamics = motion(mesh, 0.1, fixed={"all": "xy"})
    x, y = mesh.points[:, 0] / 6.0, mesh.points[:, 1] / 6.0
    dynamics.v[: len(x), 2] = 2e5 * np.cos(0.5 * np.pi * x) * np.cos(0.5 * np.pi * y)
    start = 0.5 * float(np.sum(dynamics.mass[:, None] * dynamics.v**2))
    dt, deflection = dynamics.limit, 0.0
    for _ in range(400):
        dynamics.step(0.0, dt, dt)
        deflection = max(deflection, np.abs(dynamics.state.sheet.x[:, 2]).max())
        assert dynamics.kinetic + dynamics.work["internal"] == pytest.approx(start, rel=0.1)
    assert deflection > 0.3


def test_a_triangle_that_narrows_does_not_hold_up_the_sheet_for_long():
    # A corner that only one triangle has moves towards its neighbour: a soft triangle at a rim, squeezed.
    dynamics = motion(square(6, 6.0), 0.5, Shell(3))
    start = dynamics.limit
    sheet, x = dynamics.sheet, dynamics.state.sheet.x
    alone = np.flatnonzero(np.bincount(sheet.triangles.cells.ravel()) == 1)[0]
    cell = sheet.triangles.cells[(sheet.triangles.cells == alone).any(axis=1)][0]
    x[alone] += 0.8 * (x[cell].mean(axis=0) - x[alone])
    dynamics.count = BEGIN
    waves = dynamics.fastest() / dynamics.wave
    assert waves < NARROWED and dynamics.shortest() == pytest.approx(waves * start)
    assert not dynamics.overdue()
    dynamics.count = APART
    assert dynamics.overdue()
    for _ in range(3):
        dynamics.look()
    assert not dynamics.overdue() and dynamics.shortest() == dynamics.limit
    limit = true_limit(dynamics)
    assert 0.85 * limit <= dynamics.limit / dynamics.method.safety <= limit * (1.0 + 1e-6)


def test_masses_add_up_and_slopes_weigh_nothing_in_rigid_motion():
    dynamics = motion(square(4, 8.0, 0.2), 0.7, Shell(3))
    sheet = dynamics.sheet
    n = len(sheet.points)
    assert dynamics.mass[:n].sum() == pytest.approx(7.85e-9 * 64.0 * 0.7)
    assert (dynamics.mass[n:] > 0.0).all()


def test_added_mass_goes_to_the_slowest_triangles_and_no_further():
    sheet = motion(pinched(), 0.1).sheet
    plain = np.full(len(sheet.triangles.cells), 7.85e-9)
    thickness = np.full(len(plain), 0.1)
    volume = sheet.triangles.volume
    before = wave_steps(sheet, sheet.points, plain, thickness)
    for share in (0.0, 1e-3, 1e-2, 1.0):
        density = scaled_density(sheet, plain, share)
        added = volume @ (density - plain) / (volume @ plain)
        steps = wave_steps(sheet, sheet.points, density, thickness)
        assert added <= share * (1.0 + 1e-9)
        assert steps.min() == pytest.approx(np.maximum(before, steps.min()).min())
        raised = density > plain * (1.0 + 1e-12)
        assert steps[raised] == pytest.approx(steps.min())
        if share < 1.0:
            assert added == pytest.approx(share)
        else:
            assert steps.min() == pytest.approx(np.median(before))
        assert lumped_masses(sheet, density)[: len(sheet.points)].sum() == pytest.approx(volume @ density)


def test_mass_is_added_for_a_target_step_and_told():
    mesh, thickness = pinched(), 0.1
    plain = motion(mesh, thickness, Shell(3))
    count = plain.pacing.duration / plain.limit
    for share in (0.8, 0.3):
        dynamics = motion(mesh, thickness, Shell(3), steps=share * count)
        taken = dynamics.pacing.duration / dynamics.limit
        # The fastest mode changes as mass is added, and its frequency is known to the 15 % of a look.
        assert 0.97 * share * count <= taken <= 1.1 * share * count
        assert f"{100.0 * dynamics.added_mass:.2g} % of mass added" in dynamics.notes(dynamics.pacing.duration)[0]
        heavier = dynamics.density > 7.85e-9 * (1.0 + 1e-12)
        assert 0 < heavier.sum() and dynamics.added_mass > 0.0
        if share == 0.8:
            # Of a pinched mesh, only the triangles that are pinched.
            assert heavier.sum() < 0.2 * len(heavier) and dynamics.added_mass < 0.02
    assert motion(mesh, thickness, Shell(3), steps=2.0 * count).added_mass == 0.0
