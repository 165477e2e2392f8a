"""What a STEP file may hold besides one solid: other units, loose faces, triangles, other files, construction lines."""

import re

import numpy as np
import pytest
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_Transform
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_Writer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Compound, TopoDS_Face, TopoDS_Shell

from cadlink import CadError, read_step
from cadlink.brep import faces_of
from tests.cadlink import shapes
from tests.cadlink.occ_truth import compare, part_of
from tests.cadlink.test_step import SHARED, needs_shared, write_assembly, write_plain


def compound(*items):
    builder, made = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(made)
    for item in items:
        builder.Add(made, item)
    return made


def moved(shape, x, y, z):
    move = gp_Trsf()
    move.SetTranslation(gp_Vec(x, y, z))
    return BRepBuilderAPI_Transform(shape, move, True).Shape()


def refused(path, **options):
    with pytest.raises(CadError) as error:
        read_step(path, **options)
    text = str(error.value)
    assert "\n" not in text and path.name in text
    return text


# --- units

SI = {"mm": ".MILLI.", "m": "$", "cm": ".CENTI.", "um": ".MICRO.", "dm": ".DECI.", "km": ".KILO.", "hm": ".HECTO."}
SI_SIZE = {"mm": 1.0, "m": 1e3, "cm": 10.0, "um": 1e-3, "dm": 100.0, "km": 1e6, "hm": 1e5}
OTHER = {"INCH": 25.4, "FOOT": 304.8, "YARD": 914.4, "MILE": 1609344.0, "MIL": 0.0254, "furlong": 201168.0}
MILLIMETRE = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )"


@pytest.fixture(scope="module")
def box_text(tmp_path_factory):
    path = write_plain(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Solid(), tmp_path_factory.mktemp("u") / "box.step")
    return path.read_text()


def size_of(path):
    (part,) = read_step(path).values()
    return part.unit, np.ptp(part.bounding_box, axis=0)


@pytest.mark.parametrize("unit", SI)
def test_every_si_unit_arrives_in_mm(tmp_path, box_text, unit):
    path = tmp_path / "box.step"
    path.write_text(box_text.replace("SI_UNIT(.MILLI.,.METRE.)", f"SI_UNIT({SI[unit]},.METRE.)"))
    found, size = size_of(path)
    assert found == unit and size == pytest.approx(np.array([10.0, 20.0, 30.0]) * SI_SIZE[unit], rel=1e-9)


@pytest.mark.parametrize("name", OTHER)
def test_every_unit_a_file_defines_arrives_in_mm(tmp_path, box_text, name):
    """A conversion based unit counts by its factor, whatever it is called."""
    number = re.search(r"#(\d+) = \( LENGTH_UNIT\(\)", box_text).group(1)
    new = (
        f"#{number} = ( CONVERSION_BASED_UNIT('{name}',#90001) LENGTH_UNIT() NAMED_UNIT(#90003) );\n"
        f"#90001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({OTHER[name]}),#90002);\n"
        f"#90002 = {MILLIMETRE};\n#90003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);"
    )
    path = tmp_path / "box.step"
    path.write_text(box_text.replace(f"#{number} = {MILLIMETRE};", new))
    found, size = size_of(path)
    assert found == {"FOOT": "ft"}.get(name, name.lower())
    assert size == pytest.approx(np.array([10.0, 20.0, 30.0]) * OTHER[name], rel=1e-9)


def test_a_unit_that_makes_dust_is_one_line(tmp_path, box_text):
    path = tmp_path / "box.step"
    path.write_text(box_text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.NANO.,.METRE.)"))
    assert "is its unit right?" in refused(path)


# --- loose faces


def one_product(path, *faces):
    """Faces without a common shell in one product; OpenCASCADE would make one of each."""
    STEPControl_Writer()  # defines the option
    Interface_Static.SetIVal_s("write.step.assembly", 0)
    try:
        return write_plain(compound(*faces), path)
    finally:
        Interface_Static.SetIVal_s("write.step.assembly", 2)


def loose_box(path, gap=0.0):
    """The six faces of a box without a shell, the last one lifted by a gap."""
    faces = faces_of(shapes.box())
    faces[5] = moved(faces[5], 0.0, 0.0, gap)
    return one_product(path, *faces)


@pytest.mark.parametrize("gap", [0.0, 5e-4])
def test_loose_faces_are_sewn_within_the_tolerance(tmp_path, gap):
    (part,) = read_step(loose_box(tmp_path / "box.step", gap)).values()
    assert part.solid and part.n_faces == 6 and part.sewn == (1e-3, 6, 0)
    assert part.gap_report().edge == pytest.approx(gap, abs=1e-9)
    hit = part.surface().project(np.array([[0.0, 0.0, 6.0], [0.0, 0.0, 1.0], [12.0, 0.0, 0.0]]))
    assert hit.distance == pytest.approx([2.0 - gap, -3.0 - gap, 2.0], abs=1e-9)
    found = compare(part, 80)
    assert not len(found.unexplained) and not len(found.wrong_side)


def test_faces_further_apart_stay_open_and_are_reported(tmp_path):
    """The lid 0.01 mm up: five faces make an open shell, the lid is a part of its own; a wider tolerance joins it."""
    path = loose_box(tmp_path / "box.step", 0.01)
    parts = sorted(read_step(path).values(), key=lambda part: -part.n_faces)
    assert [p.n_faces for p in parts] == [5, 1] and not parts[0].solid
    assert parts[0].sewn == (1e-3, 5, 4) and parts[1].sewn is None
    (whole,) = read_step(path, sew=0.02).values()
    assert whole.solid and whole.sewn == (0.02, 6, 0)
    assert len(read_step(path, sew=0.0)) == 6
    with pytest.raises(CadError, match="read_step sew: found -1, expected a length in mm"):
        read_step(path, sew=-1)


def test_sewing_keeps_names_and_colours_of_faces(tmp_path):
    path = loose_box(tmp_path / "box.step")
    text = path.read_text()
    for name in "abcdef":
        text = text.replace("ADVANCED_FACE('',", f"ADVANCED_FACE('{name}',", 1)
    path.write_text(text)
    (part,) = read_step(path).values()
    loose = {p.face_names[0]: p for p in read_step(path, sew=0.0).values()}
    assert sorted(part.face_names) == list("abcdef")
    for name, own in loose.items():
        middle = own.bounding_box.mean(axis=0)[None]
        assert part.surface(faces=name).project(middle).distance == pytest.approx([0.0], abs=1e-9)


def test_shells_of_different_tools_are_left_alone(tmp_path):
    """Two faces that do not touch are two parts."""
    lower = faces_of(shapes.box())[4]
    path = one_product(tmp_path / "two.step", lower, moved(lower, 0.0, 0.0, 3.0))
    assert [p.sewn for p in read_step(path).values()] == [None, None]


# --- tessellated


def triangles_only(shape):
    """A shell whose faces have triangles and no surface."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    BRepMesh_IncrementalMesh(shape, 0.1, False, 0.5, False)
    builder, shell = BRep_Builder(), TopoDS_Shell()
    builder.MakeShell(shell)
    for face in faces_of(shape):
        bare = TopoDS_Face()
        builder.MakeFace(bare, BRep_Tool.Triangulation_s(face, TopLoc_Location()))
        builder.Add(shell, bare)
    return shell


def test_tessellated_ap242_is_refused_in_one_line(tmp_path):
    STEPControl_Writer()  # defines the options
    Interface_Static.SetCVal_s("write.step.schema", "AP242DIS")
    Interface_Static.SetIVal_s("write.step.tessellated", 1)
    path = write_plain(triangles_only(shapes.box()), tmp_path / "die.step")
    Interface_Static.SetIVal_s("write.step.tessellated", 0)
    Interface_Static.SetCVal_s("write.step.schema", "AP214IS")
    assert "TESSELLATED" in path.read_text()
    line = refused(path)
    assert "is tessellated: 6 of its faces are triangles, expected exact faces; export it as B-rep" in line


# --- files that refer to others


def write_split(path, monkeypatch, **parts):
    """An assembly whose parts, name = (shape, place), are files of their own beside it, part_<name>.stp."""
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_AsIs
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("test"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())

    def named(label, name):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        return label

    whole = named(tool.NewShape(), path.stem)
    for name, (shape, place) in parts.items():
        move = gp_Trsf()
        move.SetTranslation(gp_Vec(*place))
        tool.AddComponent(whole, named(tool.AddShape(shape, False), name), TopLoc_Location(move))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.SetNameMode(True)
    monkeypatch.chdir(path.parent)
    writer.Transfer(document, STEPControl_AsIs, "part_")
    writer.Write(path.name)
    monkeypatch.chdir("/")
    return path


def bolt():
    return BRepPrimAPI_MakeBox(1.0, 1.0, 4.0).Solid()


def plate():
    return BRepPrimAPI_MakeBox(20.0, 10.0, 2.0).Solid()


@pytest.fixture
def stack(tmp_path, monkeypatch):
    """stack.step with the products bolt and plate in files of their own."""
    return write_split(
        tmp_path / "stack.step", monkeypatch, bolt=(bolt(), (5.0, 0.0, 2.0)), plate=(plate(), (0.0, 0.0, 0.0))
    )


@pytest.fixture
def nested(tmp_path, monkeypatch):
    """top.step that refers to sub/pair.step, which refers to part_bolt.stp and part_nut.stp beside it."""
    folder = tmp_path / "sub"
    folder.mkdir()
    nut = BRepPrimAPI_MakeBox(2.0, 2.0, 1.0).Solid()
    write_split(folder / "pair.step", monkeypatch, bolt=(bolt(), (5.0, 0.0, 2.0)), nut=(nut, (0.0, 0.0, 1.0)))
    top = write_split(
        tmp_path / "top.step", monkeypatch, pair=(bolt(), (0.0, 100.0, 0.0)), plate=(plate(), (0.0, 0.0, 0.0))
    )
    (tmp_path / "part_pair.stp").unlink()
    top.write_text(top.read_text().replace("part_pair.stp", "sub/pair.step"))
    return top


def test_parts_in_files_beside_it(stack):
    assembly = read_step(stack)
    assert list(assembly) == ["bolt", "plate"] and assembly["bolt"].tree == ("stack", "bolt")
    assert assembly["bolt"].bounding_box == pytest.approx(np.array([[5.0, 0, 2], [6, 1, 6]]), abs=1e-9)


def test_parts_in_files_named_absolutely(stack, tmp_path):
    elsewhere = tmp_path / "library"
    elsewhere.mkdir()
    (tmp_path / "part_bolt.stp").rename(elsewhere / "part_bolt.stp")
    text = stack.read_text().replace("part_bolt.stp", str(elsewhere / "part_bolt.stp"))
    stack.write_text(text)
    assembly = read_step(stack)
    assert list(assembly) == ["bolt", "plate"]
    assert assembly["bolt"].bounding_box == pytest.approx(np.array([[5.0, 0, 2], [6, 1, 6]]), abs=1e-9)


def test_a_missing_file_is_named_in_one_line(stack, tmp_path):
    (tmp_path / "part_bolt.stp").unlink()
    assert "stack.step: it refers to part_bolt.stp, not found" in refused(stack)


def test_parts_of_a_file_that_is_referred_to(nested):
    assembly = read_step(nested)
    assert [part.tree for part in assembly.values()] == [
        ("top", "pair", "bolt"),
        ("top", "pair", "nut"),
        ("top", "plate"),
    ]
    assert assembly["bolt"].bounding_box == pytest.approx(np.array([[5.0, 100, 2], [6, 101, 6]]), abs=1e-9)


def test_a_file_missing_further_down_is_named_in_one_line(nested, tmp_path):
    """OpenCASCADE would leave its part out in silence."""
    (tmp_path / "sub" / "part_bolt.stp").unlink()
    assert "top.step: it refers to part_bolt.stp, not found" in refused(nested)


def test_a_file_that_is_no_step_further_down_is_named_in_one_line(nested, tmp_path):
    (tmp_path / "sub" / "part_bolt.stp").write_text("a note\n")
    assert "top.step: it refers to part_bolt.stp, which OpenCASCADE cannot parse" in refused(nested)


def test_a_file_that_refers_to_itself_is_one_line(nested, tmp_path):
    """OpenCASCADE would follow it until its stack is full."""
    pair = tmp_path / "sub" / "pair.step"
    pair.write_text(pair.read_text().replace("part_bolt.stp", "../top.step"))
    assert "top.step: it refers to ../top.step, which refers back to it" in refused(nested)


# --- what is no part


def test_construction_geometry_is_no_part(tmp_path):
    """Lines and points beside a solid."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex

    axis = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, -50), gp_Pnt(0, 0, 50)).Edge()
    point = BRepBuilderAPI_MakeVertex(gp_Pnt(99, 0, 0)).Vertex()
    (part,) = read_step(write_plain(compound(shapes.box(), axis, point), tmp_path / "box.step")).values()
    assert part.solid and np.ptp(part.bounding_box, axis=0) == pytest.approx([20.0, 14.0, 8.0])


@needs_shared
def test_product_manufacturing_information_is_no_part():
    """NIST CTC 01 has semantic PMI and annotations: one solid of 117 faces, 800 x 450 x 150 mm."""
    (part,) = read_step(SHARED / "nist_ctc_01_asme1_ap242-e1.stp").values()
    assert part.solid and part.n_faces == 117
    assert np.ptp(part.bounding_box, axis=0) == pytest.approx([800.0, 450.0, 150.0], abs=1e-6)


# --- places


def test_mirrored_part_in_a_file(tmp_path):
    """A mirrored solid arrives with its outside outside."""
    path = write_plain(shapes.mirrored(shapes.filleted_box()), tmp_path / "m.step")
    (part,) = read_step(path).values()
    found = compare(part, 100)
    assert found.away_error < 1e-9 and not len(found.wrong_side)


@pytest.mark.parametrize("how", ["mirrored", "scaled"])
def test_a_place_that_mirrors_or_scales(how):
    """Such a placement becomes a shape of its own: normals still leave the material."""
    from cadlink.assembly_tree import placed

    move = gp_Trsf()
    if how == "mirrored":
        move.SetMirror(gp_Ax1(gp_Pnt(3.0, 0.0, 0.0), gp_Dir(1.0, 0.0, 0.0)))
        turn = gp_Trsf()
        turn.SetMirror(gp_Pnt(0.0, 0.0, 0.0))
        move = turn
    else:
        move.SetScale(gp_Pnt(0.0, 0.0, 0.0), 2.0)
    part = part_of(placed(shapes.filleted_box(), TopLoc_Location(move)))
    found = compare(part, 100)
    assert found.away_error < 1e-9 and not len(found.wrong_side)
    assert part.surface().project(np.zeros((1, 3))).distance < 0.0


def test_a_place_that_mirrors_in_a_file_is_refused_in_one_line(tmp_path):
    """Axes -x, y, z: OpenCASCADE would turn the part by half a turn about z instead."""
    path = write_assembly(tmp_path / "stack.step")
    text = path.read_text()
    for sign in ("1.", "-1."):
        operator = (
            "#90001 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,#90002,#90003,#90004,1.,#90005);\n"
            f"#90002 = DIRECTION('',({sign},0.,0.));\n#90003 = DIRECTION('',(0.,1.,0.));\n"
            "#90004 = CARTESIAN_POINT('',(7.,0.,0.));\n#90005 = DIRECTION('',(0.,0.,1.));\n"
        )
        of_pair = re.search(r"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION\(#\d+\)", text).group()
        moved_pair = text.replace(of_pair, "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#90001)", 1)
        path.write_text(moved_pair.replace("ENDSEC;\nEND-ISO", operator + "ENDSEC;\nEND-ISO"))
        if sign == "1.":
            assert read_step(path)["bolt"].bounding_box == pytest.approx(np.array([[7.0, 0, 0], [8, 1, 4]]), abs=1e-9)
    assert "it places a part as its mirror image" in refused(path)
