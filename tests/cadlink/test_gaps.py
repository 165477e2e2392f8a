"""What gap_report says of shapes built with a known gap, kink, sliver or radius."""

import numpy as np
import pytest

from cadlink import CadError, read_step
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of
from tests.cadlink.test_step import SHARED, needs_shared


def test_a_clean_part_has_nothing_to_say():
    gaps = part_of(shapes.filleted_box()).gap_report(thickness=1.0)
    assert max(gaps.edge, gaps.vertex, gaps.jump) < 1e-9 and gaps.kinks == 0 and gaps.slivers == ()
    # Each of the 12 rounds has 2 smooth edges along it and 2 across its ends: 12 * 4.
    assert gaps.smooth_edges == 48 and gaps.concave_radius == np.inf and not gaps.too_tight
    assert gaps.remarks() == []


def test_gap_of_two_planes_sewn():
    gaps = part_of(shapes.box_sewn_with_a_gap(5e-4)).gap_report()
    assert gaps.edge == pytest.approx(5e-4, rel=0.6) and gaps.smooth_edges == 0


def test_gap_above_a_micrometre_is_remarked():
    gaps = part_of(shapes.box_sewn_with_a_gap(9e-4)).gap_report()
    assert gaps._replace(edge=2e-3).remarks() == ["faces meet only within 0.002 mm"]


def test_sliver_of_a_low_boss():
    """A boss 1e-4 mm high on a plate 20 mm wide: its wall is a sliver, for any sheet too."""
    part = part_of(shapes.boss_sliver())
    gaps = part.gap_report()
    (sliver,) = gaps.slivers
    assert part.record["kind_of_face"][sliver] == "cylinder"
    assert part.gap_report(thickness=1.0).slivers == (sliver,)
    assert gaps.remarks() == [f"1 slivers (faces {sliver})"]


def test_concave_radius_below_half_the_sheet():
    part = part_of(shapes.l_profile(0.3))
    tight, loose = part.gap_report(thickness=1.0), part.gap_report(thickness=0.5)
    assert tight.concave_radius == pytest.approx(0.3) and tight.too_tight and not loose.too_tight
    assert "concave radius 0.3 mm is below half the sheet, 0.5 mm" in tight.remarks()
    with pytest.raises(CadError, match="thickness 0, expected a length"):
        part.gap_report(thickness=0)


@pytest.mark.parametrize("degrees, kinks", [(0.02, 0), (0.3, 1), (2.0, 0)])
def test_normal_jump_across_an_edge_drawn_smooth(degrees, kinks):
    """Two planes at a small angle: at 0.3 degrees drawn smooth but taken as sharp, at 2 degrees sharp on purpose."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Pnt, gp_Vec

    polygon, top = BRepBuilderAPI_MakePolygon(), 5.0 + 10.0 * np.tan(np.radians(degrees))
    for x, z in ((0, 0), (20, 0), (20, 5), (10, top), (0, top)):
        polygon.Add(gp_Pnt(x, 0.0, float(z)))
    polygon.Close()
    part = part_of(BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(polygon.Wire()).Face(), gp_Vec(0, 10, 0)).Shape())
    gaps = part.gap_report()
    assert gaps.kinks == kinks and gaps.smooth_edges == (degrees < 0.57)
    assert gaps.jump == pytest.approx(degrees if degrees < 0.57 else 0.0, rel=1e-6)


@needs_shared
def test_files_from_elsewhere():
    """frame.step leaves gaps of hundredths of a millimetre, which is said; part.step none, but kinks of 0.15 deg."""
    frame = next(iter(read_step(SHARED / "frame.step").values())).gap_report()
    assert 0.01 < frame.edge < 0.03 and "faces meet only within 0.02 mm" in frame.remarks()
    part = next(iter(read_step(SHARED / "part.step").values())).gap_report()
    assert part.edge < 1e-9 and part.jump == pytest.approx(0.151, abs=1e-3) and part.kinks > 0


def test_inspect_says_it_in_short(tmp_path):
    from plugins.inspect_step import describe, remarks_on
    from tests.cadlink.test_step import write_plain

    path = write_plain(shapes.l_profile(0.3), tmp_path / "l.step")
    described = describe(path, thickness=1.0)
    lines = remarks_on(described)
    assert len(lines) == 2 and lines[0].startswith("Faces meet within")
    assert "concave radius 0.3 mm is below half the sheet" in lines[1]
    assert len(remarks_on(describe(path))) == 1
