"""The assembled tangent, force-driven tool included, against finite differences of the residuals."""

import numpy as np
import pytest

from solver import Blank, Coulomb, Implicit, Material, Membrane, PlanarHill, Shell, Spring, Stage, Swift, Tool
from solver.contact.drawbead import build_beads
from solver.contact.drive import ToolRun, build_drive, coordinates, move_tools, pivot_of
from solver.contact.search import Neighbourhood
from solver.implicit.equilibrium import Equilibrium
from solver.sheet import build_sheet
from solver.state import State, new_contact, new_sheet
from tests.solver.lattice import Ball, Plane, square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589))


PINS = [(1.0, 2.0, 1.5), (4.0, 3.5, 1.2), (2.5, 5.0, 0.8)]
BORNE = {
    "guided": {"force": 900.0},
    "tilting": {"force": 900.0, "tilts": True, "at": (2.5, 3.2, 1.0)},
    "on springs": {"spring": Spring(4e4, 700.0), "tilts": True, "at": PINS, "stop": 0.005},
}


def pressed_sheet(mu, element, borne="guided", drawbeads=()):
    """A sheet on a ball, under a tilted plate that carries a load; old and new state, new slid and stretched."""
    mesh = square(2, 6.0, distort=0.1)
    mesh.groups.pop("symmetry_x"), mesh.groups.pop("symmetry_y")
    sheet = build_sheet(Blank(mesh, 1.0, STEEL, element))
    friction = Coulomb(mu) if mu else None
    tools = [
        Tool("BALL", Ball((3.0, 3.0, -20.5), 20.0), friction),
        Tool("PLATE", Plane((3.0, 3.0, 0.5), (0.05, 0.02, -1.0)), friction, **BORNE[borne]),
    ]
    stiffness = 2.0e4 * sheet.area
    runs = [
        ToolRun(
            t, t.unit_axis, 0.0, -1.0, build_drive(t, sheet, stiffness, None), stiffness, 0.1 * stiffness,
            Neighbourhood(t.surface, 9), pivot=pivot_of(t, sheet) if t.tilts else None,
        )
        for t in tools
    ]  # fmt: skip
    n_slopes, n_points = sheet.elements.n_slopes, len(sheet.elements.point_volume)

    stage = Stage(tools, pressure=3.0, drawbeads=drawbeads)

    def held():
        return {run.bead.name: run.new_state() for run in build_beads(stage, sheet, Implicit())}

    old, new = (
        State(new_sheet(sheet.points, n_slopes, n_points), {t.name: new_contact(9) for t in tools}, held())
        for _ in range(2)
    )
    equilibrium = Equilibrium(sheet, stage, runs, Implicit(), old)
    equilibrium.begin(old, new)
    equilibrium.evaluate(old, old, 1.0)
    rng = np.random.default_rng(3)
    new.copy_from(old)
    new.sheet.x[:] = 1.01 * old.sheet.x + 0.02 * rng.standard_normal((9, 3)) * [1.0, 1.0, 0.3]
    new.sheet.u[9:, 0] = 0.01 * rng.standard_normal(n_slopes)
    new.tools["PLATE"].travel[0] = -0.02
    if tools[1].tilts:
        old.tools["PLATE"].tilt[:] = -0.01, 0.006, 0.0
        new.tools["PLATE"].tilt[:] = 0.004, 0.011, 0.0
    return equilibrium, old, new


def check_tangent(equilibrium, old, new):
    """The tangent beside central differences of the residuals, relative to its largest entry. Returns it, dense."""
    for _ in range(2):  # which nodes two tools touch is known from the last evaluation
        equilibrium.evaluate(old, new, 1.0)
    touching = {name: int((contact.status > 0).sum()) for name, contact in new.tools.items()}
    assert min(touching.values()) > 0
    tangent = equilibrium.tangent()
    n, k = len(new.sheet.u), len(tangent.corner)
    exact = np.zeros((3 * n + k, 3 * n + k))
    blocks = np.zeros((n, 3, n, 3))
    pattern = equilibrium.sheet.pattern
    for block, row, column in zip(tangent.blocks, pattern.block_row, pattern.block_column):
        blocks[row, :, column, :] = block
    exact[: 3 * n, : 3 * n] = blocks.reshape(3 * n, 3 * n)
    exact[: 3 * n, 3 * n :], exact[3 * n :, : 3 * n] = tangent.column.reshape(3 * n, k), tangent.row.reshape(3 * n, k).T
    exact[3 * n :, 3 * n :] = tangent.corner
    exact[: 3 * n][equilibrium.fixed.ravel()] = 0.0  # held unknowns have no residual
    u, z = new.sheet.u.copy(), coordinates(equilibrium.driven, new)

    def residuals(change):
        new.sheet.u[:] = u + change[: 3 * n].reshape(n, 3)
        move_tools(equilibrium.driven, new, z + change[3 * n :])
        nodes, balance, _ = equilibrium.evaluate(old, new, 1.0)
        return np.append(nodes.ravel(), balance)

    step = 1e-7
    numeric = np.empty_like(exact)
    for row in range(3 * n + k):
        e = np.zeros(3 * n + k)
        e[row] = step
        numeric[:, row] = -(residuals(e) - residuals(-e)) / (2 * step)
    assert exact == pytest.approx(numeric, abs=3e-6 * np.abs(exact).max())
    return exact, k


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
@pytest.mark.parametrize("mu", [0.0, 0.15])
def test_tangent_of_sheet_tools_and_pressure(mu, element):
    exact, _ = check_tangent(*pressed_sheet(mu, element))
    if mu == 0.0:
        # Without friction only the pressure, which follows the sheet, is unsymmetric: the tool's row is its column.
        assert exact[-1] == pytest.approx(exact[:, -1])


@pytest.mark.parametrize("borne", ["tilting", "on springs"])
@pytest.mark.parametrize("mu", [0.0, 0.15])
def test_tangent_of_a_tool_that_tilts(mu, borne):
    exact, k = check_tangent(*pressed_sheet(mu, Membrane(), borne))
    assert k == 3
    if mu == 0.0:
        assert exact[-k:] == pytest.approx(exact[:, -k:].T, abs=1e-9 * np.abs(exact).max())
