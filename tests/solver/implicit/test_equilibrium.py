"""The assembled tangent, force-driven tool included, against finite differences of the residuals."""

import numpy as np
import pytest

from solver import Blank, Coulomb, Implicit, Material, Membrane, PlanarHill, Shell, Stage, Swift, Tool
from solver.contact.search import Neighbourhood
from solver.implicit.equilibrium import Equilibrium, ToolRun
from solver.sheet import build_sheet
from solver.state import State, new_contact, new_sheet
from tests.solver.lattice import Ball, Plane, square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589))


def pressed_sheet(mu, element):
    """A sheet on a ball, under a tilted plate driven by a force; old and new state, new slid and stretched."""
    mesh = square(2, 6.0, distort=0.1)
    mesh.groups.pop("symmetry_x"), mesh.groups.pop("symmetry_y")
    sheet = build_sheet(Blank(mesh, 1.0, STEEL, element))
    friction = Coulomb(mu) if mu else None
    tools = [
        Tool("BALL", Ball((3.0, 3.0, -20.5), 20.0), friction),
        Tool("PLATE", Plane((3.0, 3.0, 0.5), (0.05, 0.02, -1.0)), friction, force=900.0),
    ]
    stiffness = 2.0e4 * sheet.area
    runs = [
        ToolRun(t, t.unit_axis, 0.0, -1.0, t.force or 0.0, stiffness, 0.1 * stiffness, Neighbourhood(t.surface, 9))
        for t in tools
    ]
    n_slopes, n_points = sheet.elements.n_slopes, len(sheet.elements.point_volume)
    old, new = (
        State(new_sheet(sheet.points, n_slopes, n_points), {t.name: new_contact(9) for t in tools}) for _ in range(2)
    )
    equilibrium = Equilibrium(sheet, Stage(tools, pressure=3.0), runs, Implicit(), old)
    equilibrium.begin(old, new)
    equilibrium.evaluate(old, old, 1.0)
    rng = np.random.default_rng(3)
    new.copy_from(old)
    new.sheet.x[:] = 1.01 * old.sheet.x + 0.02 * rng.standard_normal((9, 3)) * [1.0, 1.0, 0.3]
    new.sheet.u[9:, 0] = 0.01 * rng.standard_normal(n_slopes)
    new.tools["PLATE"].travel[0] = -0.02
    return equilibrium, old, new


@pytest.mark.parametrize("element", [Membrane(), Shell(3)])
@pytest.mark.parametrize("mu", [0.0, 0.15])
def test_tangent_of_sheet_tools_and_pressure(mu, element):
    equilibrium, old, new = pressed_sheet(mu, element)
    equilibrium.evaluate(old, new, 1.0)
    touching = {name: int((contact.status > 0).sum()) for name, contact in new.tools.items()}
    assert min(touching.values()) > 0
    tangent = equilibrium.tangent()
    n = len(new.sheet.u)
    exact = np.zeros((3 * n + 1, 3 * n + 1))
    blocks = exact[: 3 * n, : 3 * n].reshape(n, 3, n, 3)
    pattern = equilibrium.sheet.pattern
    for block, row, column in zip(tangent.blocks, pattern.block_row, pattern.block_column):
        blocks[row, :, column, :] = block
    exact[: 3 * n, -1], exact[-1, : 3 * n] = tangent.column.ravel(), tangent.row.ravel()
    exact[-1, -1] = tangent.corner[0]
    exact = exact.copy()
    exact[:-1][equilibrium.fixed.ravel()] = 0.0  # held unknowns have no residual

    u, travel = new.sheet.u.copy(), new.tools["PLATE"].travel.copy()

    def residuals(change):
        new.sheet.u[:] = u + change[:-1].reshape(n, 3)
        new.tools["PLATE"].travel[:] = travel + change[-1]
        nodes, balance, _ = equilibrium.evaluate(old, new, 1.0)
        return np.append(nodes.ravel(), balance)

    step = 1e-7
    numeric = np.empty_like(exact)
    for k in range(3 * n + 1):
        e = np.zeros(3 * n + 1)
        e[k] = step
        numeric[:, k] = -(residuals(e) - residuals(-e)) / (2 * step)
    assert exact == pytest.approx(numeric, abs=3e-6 * np.abs(exact).max())
    if mu == 0.0:
        # Without friction only the pressure, which follows the sheet, is unsymmetric: the tool's row is its column.
        assert exact[-1] == pytest.approx(exact[:, -1])
