"""What is read off a state: the margin to a forming limit, how far tools squeeze the sheet."""

import numpy as np
import pytest

from solver import (
    Blank,
    Implicit,
    LimitCurve,
    Material,
    Membrane,
    Newton,
    PlanarHill,
    Scene,
    SceneError,
    Stage,
    Swift,
    Tool,
)
from solver import form as run
from tests.solver.lattice import Plane, square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589))
LIMIT = LimitCurve([-0.2, 0.0, 0.2], [0.05, 0.03, 0.06])


def pulled(stretch, limit):
    """A strip held in width and pulled by a stretch: plane strain."""
    mesh = square(4, 20.0)
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    edges = {"left": x == x.min(), "right": x == x.max(), "side": (y == y.min()) | (y == y.max())}
    mesh.groups = {name: np.flatnonzero(where) for name, where in edges.items()}
    stage = Stage(moved={"right": ((stretch - 1.0) * (x.max() - x.min()), None, 0.0)})
    blank = Blank(mesh, 1.0, STEEL, Membrane(), fixed={"left": "xz", "side": "yz"}, forming_limit=limit)
    return run(Scene(blank, [stage]), Implicit(newton=Newton(residual=1e-10, correction=1e-8)), frames=2)


def test_margin_to_the_forming_limit_is_a_field_and_a_figure():
    results = pulled(1.02, LIMIT)
    expected = 1.0 - np.log(1.02) / 0.03  # plane strain: the curve's 0.03
    frame = results.frames[-1]
    assert frame.cell_fields["fld_margin"] == pytest.approx(expected, rel=1e-6)
    assert results.history["fld_margin_min"][-1] == pytest.approx(expected, rel=1e-6)
    summary = results.summary()
    assert summary["fld_margin_min"] == results.history["fld_margin_min"][-1]
    middles = frame.points[square(4, 20.0).cells].mean(axis=1)
    place = [summary[f"fld_margin_{axis}"] for axis in "xyz"]
    assert np.linalg.norm(middles - place, axis=1).min() < 1e-9
    assert not results.remarks()


def test_strains_beyond_the_limit_are_remarked_with_their_place():
    results = pulled(1.04, LIMIT)
    stroke = np.array(results.history["stroke"])
    beyond = stroke[np.array(results.history["fld_margin_min"]) < 0.0][0]
    (remark,) = results.remarks()
    assert remark.startswith(f"from {beyond:.3g} mm on, strains are beyond the forming limit, first near (")


def test_without_a_limit_there_is_no_margin():
    results = pulled(1.02, None)
    assert "fld_margin" not in results.frames[-1].cell_fields
    assert not any(name.startswith("fld_margin") for name in results.history)


def test_what_is_no_curve_is_refused():
    with pytest.raises(SceneError, match="blank forming_limit: found 0.3, expected a curve such as LimitCurve"):
        pulled(1.02, 0.3)


def test_a_sheet_with_less_room_than_its_thickness_is_remarked():
    def pressed(travel):
        mesh = square(2, 10.0)
        mesh.groups = {"all": np.arange(len(mesh.points))}
        tools = [
            Tool("DIE", Plane((0.0, 0.0, -0.5))),
            Tool("PUNCH", Plane((0.0, 0.0, 0.5), (0, 0, -1)), travel=-travel),
        ]
        return run(Scene(Blank(mesh, 1.0, STEEL, Membrane(), fixed={"all": "xy"}), [Stage(tools)]), frames=1)

    results = pressed(0.3)
    assert results.history["squeeze_max"][-1] == pytest.approx(0.3, rel=1e-6)
    (remark,) = results.remarks()
    assert "mm on, the tools leave the sheet less room than its thickness, up to 0.3 mm less" in remark
    assert not pressed(0.05).remarks()
