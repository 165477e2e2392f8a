"""The committed STEP files of the square cup have the stated dimensions, and their script writes them."""

import re
import subprocess
import sys
from collections import Counter
from math import pi
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "square_cup"
FILES = {"square_cup.step": 0.81, "square_cup_steel.step": 0.78}
NAMES = ["PUNCH", "DIE", "BLANK_HOLDER", "BLANK"]


def shapes(solid, kind):
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(solid, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


@pytest.fixture(scope="module", params=FILES)
def parts(request):
    """name -> solid of one file, and the sheet thickness it is made for."""
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum

    path = FOLDER / request.param
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    assert re.findall(r"PRODUCT\('(\w+)'", path.read_text()) == ["SQUARE_CUP", *NAMES]
    solids = list(shapes(reader.OneShape(), TopAbs_ShapeEnum.TopAbs_SOLID))
    assert len(solids) == len(NAMES)
    return dict(zip(NAMES, solids)), FILES[request.param]


def kinds(solid):
    """How many faces of each kind and radii (torus: centre line, tube)."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_SurfaceType as Kind
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    found = Counter()
    for face in shapes(solid, TopAbs_ShapeEnum.TopAbs_FACE):
        surface = BRepAdaptor_Surface(TopoDS.Face(face))
        kind = surface.GetType()
        if kind == Kind.GeomAbs_Plane:
            found["plane"] += 1
        elif kind == Kind.GeomAbs_Cylinder:
            found["cylinder", round(surface.Cylinder().Radius(), 9)] += 1
        elif kind == Kind.GeomAbs_Torus:
            torus = surface.Torus()
            found["torus", round(torus.MajorRadius(), 9), round(torus.MinorRadius(), 9)] += 1
        else:
            found[str(kind)] += 1
    return dict(found)


def volume(solid):
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, properties, 1e-12)
    return properties.Mass()


def bounds(solid):
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(solid, box, False, False)
    return box.Get()


def rounded_prism(width, corner, height, edge, sign):
    """Volume of a square prism with rounded corners, one end rounded off (sign -1) or flared (sign +1).

    At a depth h from that end the outline has moved by d(h) = R - sqrt(R^2 - (R - h)^2), and its area has
    changed by sign P d + pi d^2 (Steiner). Over h = 0 ... R the integral of d is R^2 (1 - pi/4), and that of
    d^2 is R^3 (5/3 - pi/2).
    """
    area = width**2 - (4 - pi) * corner**2
    perimeter = 4 * (width - 2 * corner) + 2 * pi * corner
    return area * height + sign * perimeter * edge**2 * (1 - pi / 4) + pi * edge**3 * (5 / 3 - pi / 2)


def test_faces_are_planes_cylinders_and_tori(parts):
    solids, _ = parts
    assert kinds(solids["PUNCH"]) == {"plane": 6, ("cylinder", 10): 4, ("cylinder", 8): 4, ("torus", 2, 8): 4}
    assert kinds(solids["DIE"]) == {"plane": 10, ("cylinder", 12): 4, ("cylinder", 5): 4, ("torus", 17, 5): 4}
    assert kinds(solids["BLANK_HOLDER"]) == {
        "plane": 10,
        ("cylinder", 12): 4,
        ("cylinder", 2): 4,
        ("torus", 14, 2): 4,
    }
    assert kinds(solids["BLANK"]) == {"plane": 6}


def test_volumes(parts):
    solids, t = parts
    assert volume(solids["PUNCH"]) == pytest.approx(rounded_prism(70, 10, 70, 8, -1), rel=1e-9)
    assert volume(solids["DIE"]) == pytest.approx(180**2 * 60 - rounded_prism(74, 12, 60, 5, +1), rel=1e-9)
    assert volume(solids["BLANK_HOLDER"]) == pytest.approx(180**2 * 20 - rounded_prism(74, 12, 20, 2, +1), rel=1e-9)
    assert volume(solids["BLANK"]) == pytest.approx(150**2 * t, rel=1e-12)


def test_places(parts):
    """The sheet lies on the die; punch and blank-holder touch it from above."""
    solids, t = parts
    assert bounds(solids["PUNCH"]) == pytest.approx((-35, -35, t, 35, 35, t + 70), abs=1e-6)
    assert bounds(solids["DIE"]) == pytest.approx((-90, -90, -60, 90, 90, 0), abs=1e-6)
    assert bounds(solids["BLANK_HOLDER"]) == pytest.approx((-90, -90, t, 90, 90, t + 20), abs=1e-6)
    assert bounds(solids["BLANK"]) == pytest.approx((-75, -75, 0, 75, 75, t), abs=1e-6)


def test_solids_are_valid(parts):
    from OCP.BRepCheck import BRepCheck_Analyzer

    for solid in parts[0].values():
        assert BRepCheck_Analyzer(solid).IsValid()


def test_blank_is_a_plate_for_the_mesher(parts):
    from cadlink.blank import mesh_blank

    solids, t = parts
    mesh = mesh_blank(solids["BLANK"], size=5.0, arrangement="structured", symmetry=("x", "y"))
    assert mesh.thickness == pytest.approx(t) and mesh.points[:, 2] == pytest.approx(0.5 * t)
    assert mesh.areas.sum() == pytest.approx(75.0**2)


def test_the_script_writes_the_committed_files(tmp_path):
    """Byte for byte, under the Open CASCADE they were written with."""
    pytest.importorskip("cadquery", reason="the script needs the extra 'cad'")
    script = FOLDER / "make_tools.py"
    subprocess.run([sys.executable, str(script), str(tmp_path)], check=True, timeout=120)
    processor = r"'Open CASCADE STEP processor [\d.]+'"
    for name in FILES:
        committed, written = (FOLDER / name).read_text(), (tmp_path / name).read_text()
        if re.search(processor, committed)[0] != re.search(processor, written)[0]:
            pytest.skip("the committed files were written by another Open CASCADE")
        assert written == committed
