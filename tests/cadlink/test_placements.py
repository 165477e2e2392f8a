"""Where parts and copies of shapes are placed, against ISO 10303-42 and -43 by hand."""

import re

import numpy as np
import pytest
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

from cadlink import read_step
from tests.cadlink.test_reading import refused
from tests.cadlink.test_step import write_assembly, write_plain

# TURNED: at (10, 20, 30), x along y and y along -x. BACK: at (-10, 0, 0), axes of the space.
SYSTEMS = """#90001 = AXIS2_PLACEMENT_3D('',#90002,#90003,#90004);
#90002 = CARTESIAN_POINT('',(10.,20.,30.));
#90003 = DIRECTION('',(0.,0.,1.));
#90004 = DIRECTION('',(0.,1.,0.));
#90011 = AXIS2_PLACEMENT_3D('',#90012,#90003,#90014);
#90012 = CARTESIAN_POINT('',(-10.,0.,0.));
#90014 = DIRECTION('',(1.,0.,0.));
"""
TURNED, BACK = "#90001", "#90011"


def operator(x="(0.,1.,0.)", y="(-1.,0.,0.)", z="(0.,0.,1.)", scale="1."):
    """The same move as TURNED, unless told otherwise; None leaves a direction out."""
    names = ["$" if v is None else name for name, v in (("#90004", x), ("#90005", y), ("#90006", z))]
    lines = [f"{name} = DIRECTION('',{v});\n" for name, v in zip(names, (x, y, z), strict=True) if v]
    return (
        f"#90001 = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,{names[0]},{names[1]},#90002,{scale},{names[2]});\n"
        "#90002 = CARTESIAN_POINT('',(10.,20.,30.));\n" + "".join(lines)
    )


def write(path, text, *lines):
    path.write_text(text.replace("ENDSEC;\nEND-ISO", "".join(lines) + "ENDSEC;\nEND-ISO"))
    return path


def boxes(path):
    """Bounding boxes of the parts, sorted."""
    return sorted(np.round(part.bounding_box, 9).tolist() for part in read_step(path).values())


@pytest.fixture
def box(tmp_path):
    """Text of a file with a box 1 x 2 x 4: #10 its representation, #11 the space's system, #15 the solid."""
    text = write_plain(BRepPrimAPI_MakeBox(1.0, 2.0, 4.0).Solid(), tmp_path / "box.step").read_text()
    assert "#10 = ADVANCED_BREP_SHAPE_REPRESENTATION('',(#11,#15),#345)" in text
    return text


HERE = [[0.0, 0.0, 0.0], [1.0, 2.0, 4.0]]
THERE = [[8.0, 20.0, 30.0], [10.0, 21.0, 34.0]]  # HERE by TURNED: (10 - y, 20 + x, 30 + z)
BEHIND = [[-10.0, 0.0, 0.0], [-9.0, 2.0, 4.0]]


@pytest.mark.parametrize("items", ["#11,#15,#90001", "#90001,#15", "#90001,#90011,#11,#15"])
def test_a_coordinate_system_in_a_part_moves_nothing(tmp_path, box, items):
    path = write(tmp_path / "datum.step", box.replace("(#11,#15),#345", f"({items}),#345"), SYSTEMS)
    assert boxes(path) == [HERE]


# --- copies of a shape within a part


def copied(box, items, unit="#345"):
    """The part holds `items` in place of its solid."""
    own = box.replace("SHAPE_DEFINITION_REPRESENTATION(#4,#10)", "SHAPE_DEFINITION_REPRESENTATION(#4,#91000)")
    assert own != box
    return own, f"#91000 = SHAPE_REPRESENTATION('',({items}),{unit});\n"


def copy(target=TURNED, origin="#11", shape="#10", first=91001):
    return f"#{first} = MAPPED_ITEM('',#{first + 1},{target});\n#{first + 1} = REPRESENTATION_MAP({origin},{shape});\n"


@pytest.mark.parametrize("items", ["#91001", "#11,#91001", "#11,#90001,#91001"])
def test_a_copy_is_where_its_target_is(tmp_path, box, items):
    path = write(tmp_path / "copy.step", *copied(box, items), SYSTEMS, copy())
    assert boxes(path) == [THERE]


def test_two_copies(tmp_path, box):
    text, part = copied(box, "#11,#90001,#90011,#91001,#91011")
    path = write(tmp_path / "copies.step", text, part, SYSTEMS, copy(), copy(BACK, first=91011))
    assert boxes(path) == [BEHIND, THERE]


@pytest.mark.parametrize("move", [SYSTEMS, operator()])
def test_a_solid_and_a_copy_of_it(tmp_path, box, move):
    text = box.replace("(#11,#15),#345", "(#11,#15,#91001),#345")
    inner = "#91010 = SHAPE_REPRESENTATION('',(#11,#15),#345);\n"
    path = write(tmp_path / "copy.step", text, inner, move, copy(shape="#91010"))
    assert boxes(path) == [HERE, THERE]


def test_a_copy_of_a_copy(tmp_path, box):
    text, part = copied(box, "#11,#91011")
    inner = "#91020 = SHAPE_REPRESENTATION('',(#11,#91001),#345);\n"
    path = write(tmp_path / "copy.step", text, part, inner, SYSTEMS, copy(), copy(BACK, shape="#91020", first=91011))
    assert boxes(path) == [[[-2.0, 20.0, 30.0], [0.0, 21.0, 34.0]]]


@pytest.mark.parametrize("move", [SYSTEMS, operator()])
def test_a_copy_into_another_unit(tmp_path, box, move):
    """The target is in cm, the box in mm."""
    text, part = copied(box, "#11,#91001", unit="#92000")
    unit = (
        "#92000 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#92001,#347,#348)) "
        "REPRESENTATION_CONTEXT('','') );\n#92001 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.CENTI.,.METRE.) );\n"
    )
    path = write(tmp_path / "copy.step", text, part, unit, move, copy())
    assert boxes(path) == [[[98.0, 200.0, 300.0], [100.0, 201.0, 304.0]]]


def test_a_copy_from_one_system_onto_another(tmp_path, box):
    """BACK comes to lie on TURNED: (10 - y, 30 + x, 30 + z). OpenCASCADE alone: (20 - y, 20 + x, 30 + z)."""
    text, part = copied(box, "#11,#91001")
    path = write(tmp_path / "copy.step", text, part, SYSTEMS, copy(origin=BACK))
    assert boxes(path) == [[[8.0, 30.0, 30.0], [10.0, 31.0, 34.0]]]


@pytest.mark.parametrize("left_out", ["z", "none"])
def test_a_copy_by_an_operator(tmp_path, box, left_out):
    text, part = copied(box, "#11,#91001")
    move = operator(z=None) if left_out == "z" else operator()
    assert boxes(write(tmp_path / "copy.step", text, part, move, copy())) == [THERE]


OPERATORS = [
    ("it scales a part by 2", {"scale": "2."}),
    ("it places a part as its mirror image", {"z": "(0.,0.,-1.)"}),
    ("it places a part as its mirror image", {"y": "(1.,0.,0.)", "z": None}),
    ("by an operator that leaves out directions", {"y": None}),
    ("by an operator that leaves out directions", {"y": "(0.,0.,1.)", "z": None}),
]


@pytest.mark.parametrize("line, how", OPERATORS)
def test_an_operator_that_would_be_misread_is_one_line(tmp_path, box, line, how):
    text, part = copied(box, "#11,#91001")
    assert line in refused(write(tmp_path / "copy.step", text, part, operator(**how), copy()))


def test_copies_that_would_be_left_out_or_unmoved_are_one_line(tmp_path, box):
    path = tmp_path / "copy.step"
    text, part = copied(box, "#11,#91001")
    plain = "#91010 = REPRESENTATION('',(#11,#15),#345);\n"
    assert "which OpenCASCADE would leave out" in refused(write(path, text, part, plain, SYSTEMS, copy(shape="#91010")))
    assert "by something else than a coordinate system" in refused(write(path, text, part, SYSTEMS, copy("#90002")))
    assert "from something else than a coordinate system" in refused(
        write(path, text, part, SYSTEMS, copy(origin="#90002"))
    )
    back = "".join(line + "\n" for line in SYSTEMS.splitlines() if line.startswith(("#90003", "#9001")))
    text, part = copied(box, "#11,#91001")
    lines = operator(z=None), back, copy(origin=BACK)
    assert "by an operator from a place other than the origin" in refused(write(path, text, part, *lines))


# --- parts of an assembly: the plate, [0, 20] x [0, 10] x [0, 2]


@pytest.fixture
def stack(tmp_path):
    """Text of an assembly whose plate (#417) is placed in it (#10) by #754 with #755, the system #11 onto #19."""
    text = write_assembly(tmp_path / "stack.step").read_text()
    assert "#755 = ITEM_DEFINED_TRANSFORMATION('','',#11,#19)" in text
    text = text.replace("(#11,#418),#748", "(#11,#418,#90011),#748")
    return text.replace("(#11,#15,#19),#23", "(#11,#15,#19,#90001),#23")


def by_systems(stack, first, second):
    return stack.replace("TRANSFORMATION('','',#11,#19)", f"TRANSFORMATION('','',{first},{second})")


def by_operator(stack):
    new = re.sub(r"WITH_TRANSFORMATION\(#755\)", "WITH_TRANSFORMATION(#90001)", stack)
    return new.replace("(#11,#418,#90011),#748", "(#11,#418),#748").replace("#19,#90001),#23", "#19),#23")


MOVES = {
    ("#11", TURNED): [[0.0, 20.0, 30.0], [10.0, 40.0, 32.0]],
    (BACK, "#11"): [[10.0, 0.0, 0.0], [30.0, 10.0, 2.0]],
    (BACK, TURNED): [[0.0, 30.0, 30.0], [10.0, 50.0, 32.0]],  # OpenCASCADE alone: [10, 20] x [20, 40]
    (TURNED, BACK): [[0.0, 30.0, 30.0], [10.0, 50.0, 32.0]],  # each listed where the other belongs: swapped
}


@pytest.mark.parametrize("systems", MOVES)
def test_a_part_placed_by_two_systems(tmp_path, stack, systems):
    plate = read_step(write(tmp_path / "moved.step", by_systems(stack, *systems), SYSTEMS))["plate"]
    assert plate.bounding_box == pytest.approx(np.array(MOVES[systems]), abs=1e-9)


def test_a_part_placed_by_an_operator(tmp_path, stack):
    plate = read_step(write(tmp_path / "moved.step", by_operator(stack), operator()))["plate"]
    assert plate.bounding_box == pytest.approx(np.array(MOVES["#11", TURNED]), abs=1e-9)


@pytest.mark.parametrize("line, how", OPERATORS)
def test_a_part_whose_operator_would_be_misread_is_one_line(tmp_path, stack, line, how):
    assert line in refused(write(tmp_path / "moved.step", by_operator(stack), operator(**how)))


def test_an_operator_in_place_of_a_system_is_one_line(tmp_path, stack):
    """OpenCASCADE would leave the part where it is."""
    text = by_systems(stack, "#11", "#90001").replace("(#11,#418,#90011),#748", "(#11,#418),#748")
    assert "it places a part by something else than two coordinate systems" in refused(
        write(tmp_path / "moved.step", text, operator())
    )
