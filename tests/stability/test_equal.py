"""What must not matter: the unit of length, the order of nodes and triangles, the place of the scene in space, its
size. The same increments are taken, and the same iterations in them; what is left is round-off.
"""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver import Implicit, Increments, Membrane, Newton, form
from tests.stability.cups import Cup

EQUAL = 1e-8  # of the thickness, and of the largest force
EXACT = Newton(residual=1e-6, correction=1e-6)
STEADY = Implicit(EXACT, Increments(first=0.25, largest=10.0, swift=0, slow=100))
USUAL = Implicit(increments=STEADY.increments)
# Friction holds a whole disc in place. A membrane's rim is held fast enough not to wrinkle.
CUPS = {
    "shell": Cup(quarter=False, travel=2.5),
    "shell, no holder": Cup(quarter=False, travel=2.5, holder_force=0.0),
    "membrane": Cup(quarter=False, travel=2.5, holder_force=1e5, mu=0.3, element=Membrane()),
}
EACH = pytest.mark.parametrize("name", CUPS)
TURN, SHIFT = Rotation.random(random_state=5).as_matrix(), np.array([31.0, -17.0, 12.0])


def formed(cup, mesh=None, method=STEADY):
    """Nodes in mm (n, 3) in the upright cup's place, forces of the punch of all increments [N], thickness in mm."""
    results = form(cup.scene(mesh), method, frames=1)
    frame = results.frames[-1]
    points = (cup.unit * frame.points - cup.shift) @ np.asarray(cup.turn)
    return points, np.array(results.history["force_PUNCH"]), cup.unit * frame.cell_fields["thickness"]


@cache
def reference(name):
    """What `formed` tells of a cup as it stands."""
    return formed(CUPS[name])


def check(name, second, nodes=slice(None), cells=slice(None), scale=1.0):
    """A run equals that of the cup as it stands; those nodes and cells of it, lengths divided by a scale."""
    first, cup = reference(name), CUPS[name]
    assert len(second[1]) == len(first[1])
    small = EQUAL * cup.thickness
    assert second[0][nodes] / scale == pytest.approx(first[0], abs=small)
    assert second[1] / scale**2 == pytest.approx(first[1], abs=EQUAL * np.abs(first[1]).max())
    assert second[2][cells] / scale == pytest.approx(first[2], abs=small)


@EACH
def test_metres_and_millimetres(name):
    check(name, formed(replace(CUPS[name], unit=1000.0)))


@EACH
def test_the_usual_criterion_shows_hardly_more_round_off(name):
    # Iterations end earlier, before the softest movements have been corrected twice.
    cup = CUPS[name]
    first, second = (formed(replace(cup, unit=unit), method=USUAL) for unit in (1.0, 1000.0))
    assert second[0] == pytest.approx(first[0], abs=1e-7 * cup.thickness)
    assert second[1] == pytest.approx(first[1], abs=1e-6 * np.abs(first[1]).max())


@EACH
def test_order_of_nodes_and_triangles(name):
    mesh = CUPS[name].mesh()
    random = np.random.default_rng(2)
    order, rows = random.permutation(len(mesh.points)), random.permutation(len(mesh.cells))
    place = np.argsort(order)
    first_corner = random.integers(0, 3, len(rows))[:, None]
    cells = np.take_along_axis(place[mesh.cells][rows], (np.arange(3) + first_corner) % 3, axis=1)
    groups = {name: place[nodes] for name, nodes in mesh.groups.items()}
    shuffled = SimpleNamespace(points=mesh.points[order], cells=cells, groups=groups)
    check(name, formed(CUPS[name], shuffled), place, np.argsort(rows))


@EACH
def test_rigid_motion_of_the_scene(name):
    check(name, formed(replace(CUPS[name], turn=TURN, shift=SHIFT)))


@EACH
def test_far_from_the_origin(name):
    # As far as a part lies in a car's coordinates: round-off is a hundred times larger there, results are the same.
    check(name, formed(replace(CUPS[name], shift=(4000.0, -900.0, 1200.0))))


@EACH
@pytest.mark.parametrize("scale", [0.01, 10.0])
def test_every_length_scaled(name, scale):
    # From foil to plate: the same strains, forces with the square of the lengths.
    check(name, formed(CUPS[name].scaled(scale)), scale=scale)


def test_a_shell_and_a_quarter_of_it():
    # The structured mesh of the whole disc is its quarter, mirrored. What is out of balance is another sum, so that
    # both need not stop after the same iteration: one more would not change them.
    quarter = replace(CUPS["shell"], quarter=True)
    tight = replace(STEADY, newton=Newton(residual=1e-11, correction=1e-9))
    full, part = formed(CUPS["shell"], method=tight), formed(quarter, method=tight)
    near = np.abs(CUPS["shell"].mesh().points[None] - quarter.mesh().points[:, None]).sum(axis=2)
    assert near.min(axis=1) == pytest.approx(0.0, abs=1e-9)
    assert full[0][near.argmin(axis=1)] == pytest.approx(part[0], abs=EQUAL)
    assert full[1] == pytest.approx(part[1], abs=EQUAL * np.abs(part[1]).max())
