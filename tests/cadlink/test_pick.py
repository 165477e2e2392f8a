"""Tool surfaces by pick: faces by number, name or colour; moved by a clearance; material on the other side."""

import numpy as np
import pytest

from cadlink import CadError, read_step
from tests.cadlink import shapes
from tests.cadlink.occ_truth import distances, part_of
from tests.cadlink.test_step import SHARED, needs_shared, write_plain


@pytest.fixture
def named(tmp_path):
    """A box whose faces are called -x, +x, .. in the file; +z is red, -z blue, the rest have the part's grey."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool

    from cadlink.brep import faces_of

    document = TDocStd_Document(TCollection_ExtendedString("test"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    body = BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Solid()
    label = tool.AddShape(body, False)
    colors.SetColor(label, Quantity_Color(0.5, 0.5, 0.5, Quantity_TOC_sRGB), XCAFDoc_ColorSurf)
    for number, rgb in ((5, (1.0, 0.0, 0.0)), (4, (0.0, 0.2, 0.8))):
        face = tool.AddSubShape(label, faces_of(body)[number])
        colors.SetColor(face, Quantity_Color(*rgb, Quantity_TOC_sRGB), XCAFDoc_ColorSurf)
    writer = STEPCAFControl_Writer()
    writer.SetColorMode(True)
    writer.Transfer(document)
    path = tmp_path / "box.step"
    writer.Write(str(path))
    text = path.read_text()
    for name in ("-x", "+x", "-y", "+y", "sides", "sides"):
        text = text.replace("ADVANCED_FACE('',", f"ADVANCED_FACE('{name}',", 1)
    path.write_text(text)
    (part,) = read_step(path).values()
    return part


def test_names_and_colours_of_faces(named):
    assert named.face_names == ["-x", "+x", "-y", "+y", "sides", "sides"]
    assert named.face_colors[5] == pytest.approx((1.0, 0.0, 0.0), abs=2e-3)
    assert named.face_colors[4] == pytest.approx((0.0, 0.2, 0.8), abs=2e-3)
    assert named.face_colors[0] == pytest.approx((0.5, 0.5, 0.5), abs=2e-3)


PICKS = [
    (["+x"], [1]),
    ("sides", [4, 5]),
    (["#ff0000"], [5]),
    ((0.0, 0.2, 0.8), [4]),
    (["#808080"], [0, 1, 2, 3]),
    ([3, "#ff0000", "-x"], [0, 3, 5]),
    (np.array([2, 2]), [2]),
]


@pytest.mark.parametrize("faces, expected", PICKS)
def test_a_surface_of_picked_faces(named, faces, expected):
    """Its distance is that of the faces picked, as OpenCASCADE measures it."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    from cadlink.brep import faces_of

    surface = named.surface(faces=faces)
    builder, kept = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(kept)
    all_faces = faces_of(named.shape())
    for k in expected:
        builder.Add(kept, all_faces[k])
    points = np.random.default_rng(0).random((60, 3)) * 20.0 - 5.0
    hit = surface.project(points)
    assert np.abs(hit.distance) == pytest.approx(distances(kept, points)[0], abs=1e-9)
    assert set(hit.face) <= set(expected)


WRONG = [
    ("TOP", "no face 'TOP', expected one of: -x, +x, -y, +y, sides"),
    ("#00ff00", "no face of colour #00ff00, expected one of: #808080, #0033cc, #ff0000"),
    ([6], "has faces 0 to 5, found 6"),
    ([-1], "has faces 0 to 5, found -1"),
    ([], "an empty list of faces"),
    ([None], "expected a number, a name or a colour"),
]


@pytest.mark.parametrize("faces, line", WRONG)
def test_faces_that_are_not_there_are_one_line(named, faces, line):
    with pytest.raises(CadError) as error:
        named.surface(faces=faces)
    assert line in str(error.value) and "\n" not in str(error.value)


def test_a_part_without_names_says_so(tmp_path):
    (part,) = read_step(write_plain(shapes.box(), tmp_path / "box.step")).values()
    with pytest.raises(CadError, match="no face 'TOP', expected numbers or colours: its faces have no names"):
        part.surface(faces=["TOP"])
    with pytest.raises(CadError, match="no face of colour #ff0000, expected names: its faces have no colours"):
        part.surface(faces=["#ff0000"])


@needs_shared
def test_face_names_of_a_file_from_elsewhere():
    """NIST CTC 01: 117 faces with 105 names; the surface of one name is the faces that have it."""
    (part,) = read_step(SHARED / "nist_ctc_01_asme1_ap242-e1.stp").values()
    assert len(part.face_names) == 117 and len(set(part.face_names)) == 105
    name = part.face_names[0]
    faces = [i for i, n in enumerate(part.face_names) if n == name]
    hit = part.surface(faces=name).project(np.random.default_rng(0).normal(size=(50, 3)) * 300.0)
    assert set(hit.face) <= set(faces)


@pytest.mark.parametrize("offset", [0.3, 2.0, -0.3])
@pytest.mark.parametrize("name", ["torus part", "filleted box", "bspline"])
def test_offset_moves_feet_along_normals(name, offset):
    """d falls by the clearance, the foot moves by it, and hess d stays what it was."""
    part = part_of(shapes.SOLIDS[name](), name)
    exact, moved = part.surface(), part.surface(offset=offset)
    points = np.random.default_rng(1).normal(size=(200, 3)) * 12.0
    a, b = exact.project(points), moved.project(points)
    assert b.distance == pytest.approx(a.distance - offset, abs=1e-14)
    assert b.point == pytest.approx(a.point + offset * a.normal, abs=1e-12)
    assert np.abs(points - b.point - b.distance[:, None] * b.normal).max() < 1e-6
    steady = (np.abs(1.0 + a.curvature * a.distance[:, None]) > 1e-3).all(axis=1)
    hess_a, hess_b = (hessian(hit)[steady] for hit in (a, b))
    assert hess_b == pytest.approx(hess_a, rel=1e-4, abs=1e-6)
    assert (b.curvature[:, 0] >= b.curvature[:, 1]).all()


def hessian(hit):
    across = np.cross(hit.normal, hit.direction)
    total = 0.0
    for i, e in enumerate((hit.direction, across)):
        k = hit.curvature[:, i] / (1.0 + hit.curvature[:, i] * hit.distance)
        total = total + k[:, None, None] * e[:, :, None] * e[:, None, :]
    return total


def test_offset_of_closed_forms():
    """A sphere grows, its curvature falls; a box edge becomes a round of the clearance."""
    sphere = part_of(shapes.sphere()).surface(offset=3.0)
    hit = sphere.project(np.array([[1.0, -2.0, 20.5]]))
    assert hit.distance == pytest.approx([10.0]) and hit.curvature[0] == pytest.approx([0.1, 0.1])
    box = part_of(shapes.box()).surface(offset=2.0)
    hit = box.project(np.array([[13.0, 11.0, 0.0]]))
    assert hit.distance == pytest.approx([3.0]) and hit.curvature[0] == pytest.approx([0.5, 0.0], abs=1e-9)
    assert hit.point[0] == pytest.approx([11.2, 8.6, 0.0])


def test_material_on_the_other_side():
    """Turned inside out a sphere is a bowl: all signs change, and clearance goes inwards."""
    part = part_of(shapes.sphere())
    points = np.array([[1.0, -2.0, 20.5], [1.0, -2.0, 3.5]])
    hit = part.surface(flip=True).project(points)
    assert hit.distance == pytest.approx([-13.0, 4.0]) and hit.curvature == pytest.approx(-1.0 / 7.0)
    assert hit.normal[1] == pytest.approx([0.0, 0.0, -1.0])
    hit = part.surface(flip=True, offset=2.0).project(points)
    assert hit.distance == pytest.approx([-15.0, 2.0]) and hit.curvature == pytest.approx(-1.0 / 5.0)
    torus = part_of(shapes.torus_part())
    points = np.random.default_rng(2).normal(size=(50, 3)) * 10.0
    a, b = torus.surface().project(points), torus.surface(flip=True).project(points)
    steady = (np.abs(1.0 + a.curvature * a.distance[:, None]) > 1e-3).all(axis=1)
    assert hessian(b)[steady] == pytest.approx(-hessian(a)[steady], abs=1e-9, rel=1e-9)
    with pytest.raises(CadError, match="offset nan"):
        part.surface(offset=np.nan)
