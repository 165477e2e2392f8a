"""Scenes at the ends of what can be asked: each ends in a converged result, or in one clear line with the last good
state saved. No number that is none, no run without end, no force that no sheet can carry."""

from dataclasses import replace

import numpy as np
import pytest

from solver import Explicit, Implicit, Increments, Membrane, Newton, Shell
from tests.stability.cups import Cup
from tests.stability.endings import check_line, ends_well, run

ELEMENTS = pytest.mark.parametrize("element", [Shell(5), Membrane()], ids=["shell", "membrane"])
CUP = Cup()


def drawn(folder, element, method=None, **changes):
    """Results of a cup with changes that has to come to its end."""
    results, failure = ends_well(replace(CUP, element=element, **changes).scene(), folder, method)
    assert failure is None, failure
    return results


@ELEMENTS
@pytest.mark.parametrize("radius", [0.01, 0.2, 0.5])
def test_die_radius_below_the_thickness(radius, element, tmp_path):
    sharp = drawn(tmp_path, element, die_radius=radius, holder_force=1e5)
    assert sharp.history["thickness_min"][-1] < drawn(tmp_path, element, holder_force=1e5).history["thickness_min"][-1]


@pytest.mark.parametrize("radius", [0.01, 3.0])
def test_no_node_overlaps_by_more_than_a_thousandth_of_the_thickness(radius, tmp_path):
    for frame in drawn(tmp_path, Shell(5), die_radius=radius, holder_force=0.0).frames[1:]:
        assert frame.point_fields["contact_gap"].min() > -1e-3 * CUP.thickness
        assert (frame.point_fields["contact_pressure"] > 0.0).any()


def test_friction_from_none_to_half_raises_the_force(tmp_path):
    forces = [drawn(tmp_path, Shell(5), mu=mu).largest_forces()["max_force_PUNCH"] for mu in (0.0, 0.1, 0.2, 0.35, 0.5)]
    assert (np.diff(forces) > 0.0).all()


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_friction_of_a_membrane(mu, tmp_path):
    drawn(tmp_path, Membrane(), mu=mu)


def test_holder_force_from_none_to_tearing(tmp_path):
    # Short increments of one length, and little left out of balance: else either changes the force by more than a
    # newton on the holder does.
    exact = Newton(residual=1e-6, correction=1e-6)
    steady = Implicit(exact, Increments(first=0.1, largest=10.0, swift=0, slow=100))
    forces = (0.0, 1.0, 100.0, 1e4, 1e5, 2e5)
    runs = [drawn(tmp_path, Shell(5), steady, holder_force=force) for force in forces]
    largest = [run.largest_forces()["max_force_PUNCH"] for run in runs]
    assert (np.diff(largest) > 0.0).all()
    # A holder that rests on the sheet with next to nothing changes next to nothing.
    assert largest[1] == pytest.approx(largest[0], rel=1e-3)
    assert not any(run.pace()["dynamic_increments"] for run in runs)


@ELEMENTS
def test_tearing(element, tmp_path):
    # Held fast and drawn to twice the depth of its radius: the force passes its maximum, the wall runs thin.
    torn, _ = ends_well(replace(CUP, element=element, holder_force=1e5, mu=0.5, travel=20.0).scene(), tmp_path)
    force = np.abs(torn.history["force_PUNCH"])[torn.in_equilibrium()]
    assert force[-1] < 0.9 * force.max()
    assert torn.history["thinning_max"][-1] > 0.6


@ELEMENTS
@pytest.mark.parametrize("method", [Implicit(), Explicit()], ids=["implicit", "explicit"])
def test_a_holder_that_presses_the_sheet_flat_is_told(method, element, tmp_path):
    # 1,800 MPa on a sheet that flows at 186.
    _, failure = run(replace(CUP, element=element, holder_force=1e6).scene(), tmp_path, method)
    assert "tools press the sheet flat" in str(failure)
    check_line(str(failure))


@ELEMENTS
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0, 4.0, 8.0])
def test_mesh_size_to_die_radius(ratio, element, tmp_path):
    drawn(tmp_path, element, size=min(ratio * CUP.die_radius, CUP.blank))


@ELEMENTS
@pytest.mark.parametrize("thickness", [0.01, 0.1, 3.0, 10.0])
def test_thickness_with_all_else_as_it_is(thickness, element, tmp_path):
    wide = replace(CUP, blank=30.0, size=4.0, element=element, thickness=thickness)
    cup = replace(wide, opening=max(CUP.opening, CUP.punch + 1.2 * thickness))
    ends_well(cup.scene(), tmp_path)


@pytest.mark.parametrize("force", [0.0, 10.0, 1e3, 1e5])
def test_a_blank_that_is_not_flat(force, tmp_path):
    # The holder meets its hilltops first and presses them down.
    bent = drawn(tmp_path, Shell(5), holder_force=force, flatness=0.1 * CUP.thickness)
    flat = drawn(tmp_path, Shell(5), holder_force=force)
    assert bent.history["thickness_min"][-1] == pytest.approx(flat.history["thickness_min"][-1], rel=1e-2)


@ELEMENTS
def test_a_holder_that_pushes_the_blank_through_the_die(element, tmp_path):
    # The blank's edge lies on the die's round edge, and nothing else holds it.
    wide = replace(CUP, element=element, opening=18.2, holder_force=1e6)
    _, failure = ends_well(wide.scene(), tmp_path)
    check_line(str(failure))


@pytest.mark.slow
@ELEMENTS
@pytest.mark.parametrize("radius", [0.05, 1.0])
@pytest.mark.parametrize("mu", [0.0, 0.1, 0.5])
@pytest.mark.parametrize("force", [0.0, 1.0, 1e3, 1e7])
def test_die_radius_friction_and_force_together(radius, mu, force, element, tmp_path):
    cup = replace(CUP, element=element, die_radius=radius, mu=mu, holder_force=force)
    ends_well(cup.scene(), tmp_path)


@pytest.mark.slow
@ELEMENTS
def test_a_mesh_four_times_finer_than_the_die_radius(element, tmp_path):
    drawn(tmp_path, element, size=0.25 * CUP.die_radius, holder_force=1e5)
