"""Reading STEP: names, places, units, colours, and one clear line for whatever is wrong."""

from pathlib import Path

import numpy as np
import pytest
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.gp import gp_Pnt, gp_Trsf, gp_Vec
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool

from cadlink import CadError, read_step
from tests.cadlink import shapes

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "step"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="needs the CAD files in ../shared/step")


def write_plain(shape, path, unit="MM"):
    Interface_Static.SetCVal_s("write.step.unit", unit)
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_AsIs)
    assert writer.Write(str(path)) == IFSelect_RetDone
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    return path


def write_assembly(path):
    """stack -> (pair -> bolt, bolt), plate: nested places, names and colours."""
    document = TDocStd_Document(TCollection_ExtendedString("test"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def named(label, name):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        return label

    def place(x, y, z):
        move = gp_Trsf()
        move.SetTranslation(gp_Vec(x, y, z))
        return TopLoc_Location(move)

    bolt = named(tool.AddShape(BRepPrimAPI_MakeBox(1.0, 1.0, 4.0).Solid(), False), "bolt")
    plate = named(tool.AddShape(BRepPrimAPI_MakeBox(20.0, 10.0, 2.0).Solid(), False), "plate")
    colors.SetColor(plate, Quantity_Color(0.2, 0.4, 0.8, Quantity_TOC_sRGB), XCAFDoc_ColorSurf)
    pair = named(tool.NewShape(), "pair")
    tool.AddComponent(pair, bolt, place(0.0, 0.0, 0.0))
    tool.AddComponent(pair, bolt, place(5.0, 0.0, 0.0))
    stack = named(tool.NewShape(), "stack")
    tool.AddComponent(stack, pair, place(0.0, 0.0, 100.0))
    tool.AddComponent(stack, plate, place(0.0, -3.0, 0.0))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.SetColorMode(True)
    writer.SetNameMode(True)
    writer.Transfer(document)
    assert writer.Write(str(path)) == IFSelect_RetDone
    return path


def test_nested_assembly_has_names_places_and_colours(tmp_path):
    assembly = read_step(write_assembly(tmp_path / "stack.step"))
    assert list(assembly) == ["bolt", "bolt-2", "plate"]
    assert len(assembly) == 3 and assembly.unit == "mm"
    second = assembly["bolt-2"]
    assert second.bounding_box == pytest.approx(np.array([[5, 0, 100], [6, 1, 104]]), abs=1e-9)
    assert assembly["plate"].bounding_box == pytest.approx(np.array([[0, -3, 0], [20, 7, 2]]), abs=1e-9)
    assert assembly["plate"].color == pytest.approx((0.2, 0.4, 0.8), abs=2e-3)
    assert second.color is None
    hit = second.surface().project(np.array([[5.5, 0.5, 110.0]]))
    assert hit.distance == pytest.approx([6.0])


@pytest.mark.parametrize("unit, name", [("MM", "mm"), ("INCH", "inch"), ("M", "m"), ("FT", "ft")])
def test_every_unit_arrives_in_mm(tmp_path, unit, name):
    """The same 30 x 20 x 10 mm box, written in four units."""
    shape = BRepPrimAPI_MakeBox(gp_Pnt(1.0, 2.0, 3.0), 30.0, 20.0, 10.0).Solid()
    assembly = read_step(write_plain(shape, tmp_path / "box.step", unit))
    (part,) = assembly.values()
    assert assembly.unit == part.unit == name
    assert np.ptp(part.bounding_box, axis=0) == pytest.approx([30.0, 20.0, 10.0], abs=1e-9)
    assert part.surface().project(np.array([[15.0, 10.0, 23.0]])).distance == pytest.approx([10.0])


def test_part_describes_itself(tmp_path):
    (part,) = read_step(write_plain(shapes.box(), tmp_path / "box.step")).values()
    assert part.kinds == {"plane": 6} and part.n_faces == 6 and part.solid
    areas = sorted(plane.area for plane in part.planes)
    assert areas == pytest.approx([112, 112, 160, 160, 280, 280])
    centre = part.bounding_box.mean(axis=0)
    for plane in part.planes:
        assert (plane.origin - centre) @ plane.normal > 0.0
    points, cells = part.triangles()
    assert points.shape[1] == 3 and cells.shape[1] == 3
    a, b, c = (points[cells[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(2240.0)
    assert part.gap_report().edge < 1e-12
    copy = tmp_path / "copy.brep"
    part.write_brep(copy)
    assert b"CASCADE Topology" in copy.read_bytes()[:40]  # text: gmsh cannot read the binary form
    assert not part.shape().IsNull()
    assert "6 faces" in repr(part)


def test_parts_can_be_pickled(tmp_path):
    import pickle

    (part,) = read_step(write_plain(shapes.filleted_box(), tmp_path / "box.step")).values()
    again = pickle.loads(pickle.dumps(part))
    points = np.random.default_rng(0).normal(size=(20, 3)) * 9.0
    assert (again.surface().project(points).distance == part.surface().project(points).distance).all()


# --- wrong input ---------------------------------------------------------------------------------


def one_line(error):
    text = str(error.value)
    assert "\n" not in text
    return text


def test_missing_file(tmp_path):
    with pytest.raises(CadError) as error:
        read_step(tmp_path / "none.step")
    assert "none.step: no such file" in one_line(error)


def test_folder_instead_of_file(tmp_path):
    with pytest.raises(CadError) as error:
        read_step(tmp_path)
    assert "folder" in one_line(error)


def test_file_that_is_not_step(tmp_path):
    path = tmp_path / "die.stp"
    path.write_text("solid ascii\nfacet normal 0 0 1\n")
    with pytest.raises(CadError) as error:
        read_step(path)
    assert "not a STEP file: starts with 'solid ascii" in one_line(error)


def test_empty_file(tmp_path):
    path = tmp_path / "die.stp"
    path.write_bytes(b"")
    with pytest.raises(CadError) as error:
        read_step(path)
    assert "empty" in one_line(error)


def test_step_without_faces(tmp_path):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

    edge = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0)).Edge()
    with pytest.raises(CadError) as error:
        read_step(write_plain(edge, tmp_path / "wire.step"))
    assert "no face" in one_line(error)


@pytest.mark.parametrize("keep", [0.1, 0.5, 0.95])
def test_truncated_step(tmp_path, keep):
    whole = write_plain(shapes.cylinder_with_cross_hole(), tmp_path / "whole.step").read_bytes()
    path = tmp_path / "half.step"
    path.write_bytes(whole[: int(keep * len(whole))])
    with pytest.raises(CadError) as error:
        read_step(path)
    assert "half.step" in one_line(error)


def test_header_without_data(tmp_path):
    path = tmp_path / "none.step"
    path.write_text("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    with pytest.raises(CadError) as error:
        read_step(path)
    assert "none.step" in one_line(error)


def test_unknown_part_lists_those_that_exist(tmp_path):
    assembly = read_step(write_assembly(tmp_path / "stack.step"))
    with pytest.raises(CadError) as error:
        assembly["PUNCH"]
    assert "no part 'PUNCH', expected one of: bolt, bolt-2, plate" in one_line(error)
    assert "PUNCH" not in assembly
    assert assembly.get("PUNCH") is None


def test_crash_of_the_reading_process_is_one_line(tmp_path, monkeypatch):
    import cadlink.step as step

    path = write_plain(shapes.box(), tmp_path / "box.step")
    monkeypatch.setattr(step, "READER", "cadlink.nothing_here")
    with pytest.raises(CadError) as error:
        read_step(path)
    assert "box.step" in one_line(error) and "crashed" in str(error.value)


def test_a_file_that_hangs_is_given_up(tmp_path):
    path = write_plain(shapes.box(), tmp_path / "box.step")
    with pytest.raises(CadError) as error:
        read_step(path, timeout=0.01)
    assert "did not finish within 0.01 s" in one_line(error)


def test_reading_leaves_opencascade_out_of_this_process(tmp_path):
    import subprocess
    import sys

    path = write_plain(shapes.box(), tmp_path / "box.step")
    code = f"import sys; from cadlink import read_step; read_step({str(path)!r}); print('OCP' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


# --- files from elsewhere ------------------------------------------------------------------------


@needs_shared
@pytest.mark.parametrize("name, unit", [("cube-in", "inch"), ("cube-m", "m"), ("cube-mm", "mm")])
def test_the_three_cubes_are_all_1000_mm(name, unit):
    (part,) = read_step(SHARED / f"{name}.step").values()
    assert np.ptp(part.bounding_box, axis=0) == pytest.approx([1000.0] * 3, abs=1e-6)
    assert part.unit == unit


@needs_shared
def test_cax_if_assembly_has_18_parts_of_5_products():
    assembly = read_step(SHARED / "as1-oc-214.stp")
    assert len(assembly) == 18
    products = {name.rsplit("-", 1)[0] if name[-1].isdigit() else name for name in assembly}
    assert products == {"nut", "bolt", "rod", "plate", "l-bracket"}
    assert sum(part.n_faces for part in assembly.values()) == 160
    assert all(part.color is not None for part in assembly.values())
