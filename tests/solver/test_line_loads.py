"""Forces along edges and along rows of nodes, against closed forms of beams, strips and tubes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from solver import Blank, Explicit, Material, Membrane, Scene, SceneError, Shell, Stage, Swift, VonMises, form
from solver.loads import Loads
from solver.sheet import build_sheet
from tests.solver.lattice import square

STEEL = Material(200000.0, 0.0, VonMises(), Swift(1000.0, 0.01, 0.2), "steel")  # nu = 0: a strip is a beam
LENGTH, WIDTH, THICKNESS = 40.0, 10.0, 1.0
BENDING = 200000.0 * THICKNESS**3 / 12.0  # D [N mm]
SMALL = 1e-3 * LENGTH  # deflection


def strip(n=16, distort=0.0, spread=1.0):
    """Strip on [0, length] x [0, width] of 2n triangles along it; groups root, end, middle (a row of nodes inside)."""
    mesh = square(n, 1.0, distort)
    x, y = mesh.points[:, 0].copy(), mesh.points[:, 1] ** spread
    points = np.column_stack([LENGTH * x, WIDTH * y, 0.0 * x])
    groups = {"root": mesh.groups["symmetry_x"], "end": mesh.groups["right"], "long": mesh.groups["top"]}
    groups["middle"] = np.flatnonzero(np.abs(x - 0.5) < 1e-12)
    return SimpleNamespace(points=points, cells=mesh.cells, groups=groups | {"all": mesh.groups["all"]})


def deflection(mesh, load, group, at="end", **supports):
    """Mean rise of a group under a line load on another one [mm]."""
    blank = Blank(mesh, THICKNESS, STEEL, Shell(2), **supports)
    results = form(Scene(blank, [Stage(line_loads={group: (0.0, 0.0, load)})]), frames=1)
    return results.frames[-1].points[mesh.groups[at], 2].mean()


@pytest.mark.parametrize("spread", [1.0, 1.7])
def test_a_cantilever_with_a_load_along_its_end(spread):
    load = SMALL * 3.0 * BENDING / LENGTH**3  # w = f L^3/(3 D)
    found = deflection(strip(spread=spread), load, "end", clamped=("root",))
    assert found == pytest.approx(SMALL, rel=0.01)
    assert deflection(strip(32, spread=spread), load, "end", clamped=("root",)) == pytest.approx(SMALL, rel=0.003)


def test_a_strip_on_two_supports_with_a_load_across_its_middle():
    load = SMALL * 48.0 * BENDING / LENGTH**3  # w = f L^3/(48 D)
    supports = {"fixed": {"root": "xyz", "end": "z"}}
    assert deflection(strip(), load, "middle", "middle", **supports) == pytest.approx(SMALL, rel=0.01)


def test_a_tube_under_an_axial_pull_along_its_end():
    # Quarter of a tube, ends free to move radially: u = f L/(E h), and 2 pi R f in all.
    mesh = square(12, 1.0)
    radius, angle = 20.0, 0.5 * np.pi * mesh.points[:, 0]
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), LENGTH * mesh.points[:, 1]])
    # The sides lie on the planes y = 0 (x side) and x = 0; z = 0 at the bottom.
    groups = {"symmetry_y": mesh.groups["symmetry_x"], "symmetry_x": mesh.groups["right"]}
    groups |= {"symmetry_z": mesh.groups["symmetry_y"], "end": mesh.groups["top"]}
    blank = Blank(SimpleNamespace(points=points, cells=mesh.cells, groups=groups), THICKNESS, STEEL, Shell(2))
    load = SMALL * 200000.0 * THICKNESS / LENGTH
    results = form(Scene(blank, [Stage(line_loads={"end": (0.0, 0.0, load)})]), frames=1)
    rise = results.frames[-1].points[groups["end"], 2] - LENGTH
    assert rise == pytest.approx(SMALL, rel=2e-3)  # logarithmic strain of 0.1 %


def nodal(mesh, group, load, **keys):
    """Forces on the nodes of a sheet (n, 3)."""
    sheet = build_sheet(Blank(mesh, THICKNESS, STEEL, Membrane()))
    return Loads(sheet, Stage(line_loads={group: load}, **keys)).nodal


@pytest.mark.parametrize("group, axis", [("end", 1), ("middle", 1), ("long", 0)])
def test_the_forces_are_those_of_the_line_whatever_its_nodes(group, axis):
    mesh, load = strip(8, spread=1.7), np.array([1.0, -2.0, 0.5])
    forces = nodal(mesh, group, load)
    size = (LENGTH, WIDTH)[axis]
    assert forces.sum(axis=0) == pytest.approx(load * size, rel=1e-12)
    # The first moment along the line: an even load acts at its middle.
    assert mesh.points[:, axis] @ forces == pytest.approx(0.5 * load * size**2, rel=1e-12)
    away = np.setdiff1d(mesh.groups["all"], mesh.groups[group])
    assert not forces[away].any()


def test_a_force_on_a_row_of_nodes_is_shared_by_length_too():
    mesh = strip(8, spread=1.7)
    sheet = build_sheet(Blank(mesh, THICKNESS, STEEL, Membrane()))
    force = Loads(sheet, Stage(forces={"middle": (0.0, 0.0, 7.0 * WIDTH)})).nodal
    assert force == pytest.approx(nodal(mesh, "middle", (0.0, 0.0, 7.0)), rel=1e-12)


def test_explicit_carries_line_loads():
    mesh = strip(8)
    load = SMALL * 200000.0 * THICKNESS / LENGTH
    blank = Blank(mesh, THICKNESS, replace(STEEL, density=7.8e-9), Membrane(), fixed={"root": "x", "all": "yz"})
    results = form(Scene(blank, [Stage(line_loads={"end": (load, 0.0, 0.0)})]), Explicit(), frames=1)
    assert results.frames[-1].points[mesh.groups["end"], 0].mean() - LENGTH == pytest.approx(SMALL, rel=0.02)


@pytest.mark.parametrize(
    "group, load, message",
    [
        ("end", (1.0, 0.0), r"stage 'draw' line_loads 'end': found \(1.0, 0.0\), expected 3 numbers in N/mm"),
        ("end", (1.0, np.nan, 0.0), "line_loads 'end': found .* expected 3 numbers in N/mm"),
        ("all", (0.0, 0.0, 1.0), None),
        ("corner", (0.0, 0.0, 1.0), "line_loads 'corner': found no line there, expected an edge or a row of nodes"),
        ("elsewhere", (0.0, 0.0, 1.0), "blank group 'elsewhere' does not exist; there are"),
    ],
)
def test_what_is_no_line_load_is_refused_in_one_line(group, load, message):
    mesh = strip(4)
    mesh.groups["corner"] = mesh.groups["root"][:1]
    if message is None:  # the edge of the whole sheet
        assert nodal(mesh, group, load).sum(axis=0) == pytest.approx([0.0, 0.0, 2.0 * (LENGTH + WIDTH)])
        return
    with pytest.raises(SceneError, match=message):
        nodal(mesh, group, load)
