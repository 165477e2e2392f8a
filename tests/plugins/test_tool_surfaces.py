"""What a scene file says of a tool's surface: exact or facets, picked faces, clearance, side, mesh files."""

import numpy as np
import pytest

from plugins.scene_file import SceneFileError, load_scene

SCENE = """
cad = "ball.step"
[blank]
outline = {disc = 50, z = 1.5}
size = 10
symmetry = ["x", "y"]
thickness = "0.8 mm"
[material]
young = "206 GPa"
poisson = 0.3
locus = "von Mises"
hardening = {swift = {K = 565, e0 = 0.007, n = 0.26}}
[tools.BALL]
travel = 5
"""
POINTS = np.array([[0.0, 0.0, 25.0], [12.0, 3.0, 9.0], [0.0, 14.0, -2.0]])
EXACT = np.linalg.norm(POINTS, axis=1) - 10.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """ball.step: a ball of radius 10 with a face called SKIN; ball.stl: fine facets of it."""
    import meshio
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    from cadlink import read_step

    folder = tmp_path_factory.mktemp("ball")
    writer = STEPControl_Writer()
    writer.Transfer(BRepPrimAPI_MakeSphere(10.0).Solid(), STEPControl_AsIs)
    writer.Write(str(folder / "ball.step"))
    text = (folder / "ball.step").read_text()
    (folder / "ball.step").write_text(text.replace("ADVANCED_FACE('',", "ADVANCED_FACE('SKIN',"))
    (part,) = read_step(folder / "ball.step").values()
    name = part.name
    surface = part.facets(0.005)
    meshio.Mesh(surface.points, [("triangle", surface.triangles()[1])]).write(folder / "ball.stl")
    return folder, name


def surface_of(folder, lines, scene=SCENE):
    folder, name = folder
    path = folder / "s.toml"
    path.write_text(scene.replace("travel = 5", "travel = 5\n" + lines.replace("NAME", f'part = "{name}"')))
    (stage,) = load_scene(path).stages
    return stage.tools[0].surface


@pytest.mark.parametrize(
    "lines, error",
    [
        ("", 1e-12),
        ('surface = "exact"', 1e-12),
        ('surface = "element"\nchord = 0.1', 0.11),
        ('surface = "nodal"\nchord = "0.01 mm"', 0.011),
        ('surface = "nagata"\nchord = 0.1', 2e-3),
        ('faces = ["SKIN"]', 1e-12),
        ("faces = [0]", 1e-12),
    ],
)
def test_exact_and_faceted_tools(folder, lines, error):
    hit = surface_of(folder, "NAME\n" + lines).project(POINTS)
    assert np.abs(hit.distance - EXACT).max() <= error
    assert (error < 1e-9) == (np.abs(hit.distance - EXACT).max() < 1e-9)


def test_clearance_and_side(folder):
    assert surface_of(folder, "NAME\noffset = 1.5").project(POINTS).distance == pytest.approx(EXACT - 1.5)
    assert surface_of(folder, "NAME\nflip = true").project(POINTS).distance == pytest.approx(-EXACT)
    both = surface_of(folder, 'NAME\nsurface = "nagata"\nchord = 0.1\nflip = true\noffset = "1 mm"')
    assert both.project(POINTS).distance == pytest.approx(-EXACT - 1.0, abs=2e-3)


@pytest.mark.parametrize("kind", [None, "element", "nagata"])
def test_a_mesh_file_needs_no_cad(folder, kind):
    lines = 'mesh = "ball.stl"' + (f'\nsurface = "{kind}"' if kind else "")
    surface = surface_of(folder, lines, SCENE.replace('cad = "ball.step"\n', ""))
    assert np.abs(surface.project(POINTS).distance - EXACT).max() < 0.01
    points, cells = surface.triangles()
    assert len(points) and len(cells)


def test_a_crease_angle_for_a_mesh_file(folder):
    """Facets that keep all their edges have the normals of elements; others share them at their nodes."""
    flat = surface_of(folder, 'mesh = "ball.stl"\nsurface = "element"').project(POINTS).normal
    apart = []
    for angle in (1e-6, 60):
        surface = surface_of(folder, f'mesh = "ball.stl"\ncrease = {angle}')
        assert surface.crease == angle
        apart.append(np.abs(surface.project(POINTS).normal - flat).max())
    assert apart[0] < 1e-6 and apart[1] > 1e-3


WRONG = [
    ('mesh = "ball.stl"\ncrease = 200', "tools.BALL: .*ball.stl: facets: crease 200.0, expected an angle in degrees"),
    ("NAME\ncrease = 30", "tools.BALL.crease: found without mesh"),
    ('NAME\nsurface = "nagata"', "tools.BALL.chord: missing, expected a length in mm such as 0.1"),
    ("NAME\nchord = 0.1", "tools.BALL.chord: found without facets"),
    (
        'NAME\nsurface = "smooth"',
        "tools.BALL.surface: found \"smooth\", expected 'exact', 'nagata', 'nodal' or 'element'",
    ),
    ('mesh = "none.stl"', "tools.BALL: .*none.stl: no such file"),
    ('mesh = "ball.stl"\nsurface = "exact"', 'tools.BALL.surface: found "exact", expected "nagata"'),
    ('mesh = "ball.stl"\nNAME', "tools.BALL.part: found beside mesh"),
    ('NAME\nfaces = ["TOP"]', "tools.BALL: part .*: no face 'TOP', expected one of: SKIN"),
    ("NAME\nfaces = [true]", r"tools.BALL.faces\[0\]: found true, expected the number, name or colour of a face"),
    ("NAME\nfaces = [3]", "tools.BALL: part .* has faces 0 to 0, found 3"),
]


@pytest.mark.parametrize("lines, line", WRONG)
def test_wrong_surfaces_are_one_line(folder, lines, line):
    with pytest.raises(SceneFileError, match=line) as error:
        surface_of(folder, lines)
    assert "\n" not in str(error.value)


def test_a_stage_cannot_change_a_surface(folder):
    scene = SCENE + "[[stages]]\n[stages.tools.BALL]\noffset = 1\n"
    with pytest.raises(SceneFileError, match=r"stages\[0\].tools.BALL.offset: found in a stage"):
        surface_of(folder, "NAME", scene)
