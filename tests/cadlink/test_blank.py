"""Blank meshes against closed forms: areas, counts, angles, edges, planes, plates."""

import subprocess
import sys
from collections import Counter
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cadlink import read_step
from cadlink.blank import Mesh, mesh_blank, run_worker
from cadlink.errors import CadError
from cadlink.outline import Disc, Polygon, Rectangle
from cadlink.plate import blank_outline

PIERCED = Rectangle(120.0, 80.0, holes=[Disc(10.0), Disc(5.0, (40.0, 20.0)), Disc(5.0, (-40.0, 20.0))])
EVERY_KIND = [
    (Disc(50.0), {}),
    (Disc(50.0), {"symmetry": ("x", "y")}),
    (Disc(50.0), {"shape": "quad"}),
    (Disc(50.0), {"arrangement": "structured"}),
    (Disc(50.0), {"arrangement": "structured", "symmetry": ("y",)}),
    (Disc(50.0), {"arrangement": "structured", "symmetry": ("x",), "shape": "quad"}),
    (Disc(50.0, holes=[Disc(20.0)]), {"arrangement": "structured"}),
    (Disc(50.0, holes=[Disc(20.0)]), {"arrangement": "structured", "symmetry": ("x", "y")}),
    (Rectangle(120.0, 80.0), {"arrangement": "structured", "symmetry": ("x", "y")}),
    (Rectangle(120.0, 80.0), {"arrangement": "equilateral"}),
    (Rectangle(120.0, 80.0), {"arrangement": "equilateral", "symmetry": ("x", "y")}),
    (Rectangle(120.0, 80.0), {"shape": "quad", "symmetry": ("x",)}),
    (PIERCED, {}),
    (PIERCED, {"symmetry": ("x",)}),
    (PIERCED, {"symmetry": ("x",), "shape": "quad"}),
]


def corner_angles(mesh):
    """(m, corners) angles inside each cell [degrees]."""
    corner = mesh.points[mesh.cells]
    ahead = np.roll(corner, -1, axis=1) - corner
    behind = np.roll(corner, 1, axis=1) - corner
    length = np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
    return np.degrees(np.arccos((ahead * behind).sum(axis=2) / length))


def edge_counts(mesh):
    """How often each directed edge occurs."""
    start, end = mesh.cells.ravel(), np.roll(mesh.cells, -1, axis=1).ravel()
    return Counter(zip(start.tolist(), end.tolist()))


def boundary_edges(mesh):
    """Directed edges with a cell on their left only."""
    counts = edge_counts(mesh)
    return {edge for edge in counts if edge[::-1] not in counts}


@pytest.mark.parametrize("outline, options", EVERY_KIND)
def test_every_mesh_is_sound(outline, options):
    mesh = mesh_blank(outline, size=5.0, **options)
    assert isinstance(mesh, Mesh)
    n_corners = 4 if options.get("shape") == "quad" else 3
    assert mesh.cells.shape[1] == n_corners and mesh.points.shape[1] == 3
    assert mesh.points.dtype == np.float64 and mesh.points.flags.c_contiguous and mesh.cells.flags.c_contiguous

    # anticlockwise seen from +z, of use to an element, about the size asked for
    corner = mesh.points[mesh.cells]
    normals = np.cross(corner[:, 1] - corner[:, 0], corner[:, -1] - corner[:, 0])
    assert (normals[:, 2] > 0.0).all() and np.array_equal(mesh.normal, [0.0, 0.0, 1.0])
    assert corner_angles(mesh).min() > 25.0 and corner_angles(mesh).max() < 160.0
    edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    assert 0.25 * 5.0 < edge.min() and edge.max() < 1.75 * 5.0

    # no node twice, none unused; each edge between two cells is run both ways, once
    assert len(np.unique(np.round(mesh.points, 9), axis=0)) == len(mesh.points)
    assert np.array_equal(np.unique(mesh.cells), np.arange(len(mesh.points)))
    assert set(edge_counts(mesh).values()) == {1}

    # neighbours are near in memory
    assert np.ptp(mesh.cells, axis=1).mean() < 3.0 * np.sqrt(len(mesh.points))
    assert np.abs(np.diff(mesh.cells[:, 0])).mean() < 0.5 * np.sqrt(len(mesh.points))


@pytest.mark.parametrize("outline, options", EVERY_KIND)
def test_edge_groups_are_the_boundary(outline, options):
    mesh = mesh_blank(outline, size=5.0, **options)
    symmetry = options.get("symmetry", ())
    for name in symmetry:
        axis = "xyz".index(name)
        nodes = mesh.groups[f"symmetry_{name}"]
        assert (mesh.points[nodes, axis] == 0.0).all()
        assert np.array_equal(np.flatnonzero(mesh.points[:, axis] == 0.0), np.sort(nodes))
        assert (np.diff(mesh.points[nodes, 1 - axis]) > 0.0).all()
        assert mesh.points[:, axis].min() == 0.0

    # every boundary edge belongs to one group, and a group's nodes follow each other along such edges
    edges = boundary_edges(mesh)
    left = set(edges)
    for name, nodes in mesh.groups.items():
        if name != "center":
            assert len(np.unique(nodes)) == len(nodes)
            run = zip(nodes.tolist(), np.roll(nodes, -1).tolist())
            if name.startswith("symmetry"):
                left = {edge for edge in left if not set(edge) <= set(nodes.tolist())}
            else:
                left -= set(run)
    assert not left
    assert set(mesh.groups) >= {"rim", *(f"symmetry_{name}" for name in symmetry)}


@pytest.mark.parametrize("options", [{}, {"symmetry": ("x", "y")}, {"arrangement": "structured"}, {"shape": "quad"}])
def test_disc_area_converges_at_second_order(options):
    """Rim nodes are evenly spread, so the mesh is the regular polygon: n/2 R^2 sin(2 pi / n)."""
    quarter = 4 if options.get("symmetry") else 1
    errors = []
    for size in (8.0, 4.0, 2.0):
        mesh = mesh_blank(Disc(50.0), size=size, **options)
        n = len(mesh.groups["rim"]) if quarter == 1 else 4 * (len(mesh.groups["rim"]) - 1)
        area = quarter * mesh.areas.sum()
        assert area == pytest.approx(0.5 * n * 50.0**2 * sin(2 * pi / n), rel=1e-9)
        assert np.hypot(*mesh.points[mesh.groups["rim"], :2].T) == pytest.approx(50.0, rel=1e-9)
        errors.append(pi * 50.0**2 - area)
    order = np.log2(errors[0] / errors[2]) / 2
    assert order == pytest.approx(2.0, abs=0.15)


def test_pierced_areas_and_names():
    mesh = mesh_blank(PIERCED, size=1.0)
    assert mesh.areas.sum() == pytest.approx(PIERCED.area, rel=1e-3)
    assert PIERCED.area == pytest.approx(120 * 80 - 150 * pi, rel=1e-14)
    centres = {name: mesh.points[nodes].mean(axis=0)[:2] for name, nodes in mesh.groups.items() if "hole" in name}
    assert list(centres) == ["hole-1", "hole-2", "hole-3"]
    assert np.array(list(centres.values())) == pytest.approx(np.array([(-40, 20), (0, 0), (40, 20)]), abs=1e-9)

    half = mesh_blank(PIERCED, size=1.0, symmetry=("x",))
    assert sorted(half.groups) == ["hole-1", "hole-2", "rim", "symmetry_x"]
    assert np.hypot(*half.points[half.groups["hole-1"], :2].T) == pytest.approx(10.0)
    assert half.points[half.groups["hole-1"], 0].min() == 0.0
    assert half.areas.sum() == pytest.approx(0.5 * PIERCED.area, rel=1e-3)


def test_rim_runs_counter_clockwise():
    whole = mesh_blank(Disc(30.0), size=4.0).groups["rim"]
    mesh = mesh_blank(Disc(30.0), size=4.0)
    angle = np.unwrap(np.arctan2(*mesh.points[whole, 1::-1].T))
    assert angle[0] == pytest.approx(0.0, abs=1e-9) and (np.diff(angle) > 0.0).all()
    quarter = mesh_blank(Rectangle(60.0, 40.0), size=4.0, symmetry=("x", "y"))
    ends = quarter.points[quarter.groups["rim"][[0, -1]], :2]
    assert ends == pytest.approx(np.array([(30.0, 0.0), (0.0, 20.0)]))
    assert quarter.points[quarter.groups["center"]] == pytest.approx(np.zeros((1, 3)))


def test_structured_rectangle_is_the_lattice():
    mesh = mesh_blank(Rectangle(150.0, 150.0), size=2.5, arrangement="structured", symmetry=("x", "y"))
    assert len(mesh.points) == 31 * 31 and len(mesh.cells) == 2 * 30 * 30
    grid = mesh.points.reshape(31, 31, 3)
    assert grid[..., 0] == pytest.approx(np.broadcast_to(np.arange(31) * 2.5, (31, 31)), abs=1e-12)
    assert grid[..., 1].T == pytest.approx(grid[..., 0], abs=1e-12)
    assert mesh.areas == pytest.approx(3.125, rel=1e-12)
    # one diagonal: each cell is halved from its corner nearest the origin
    assert mesh.cells[:2].tolist() == [[0, 1, 32], [0, 32, 31]]
    assert (np.sort(mesh.cells, axis=1)[:, 2] - np.sort(mesh.cells, axis=1)[:, 0] == 32).all()
    quads = mesh_blank(
        Rectangle(20.0, 10.0, center=(3.0, 4.0)), size=2.0, arrangement="structured", shape="quad", z=7.0
    )
    assert quads.cells.shape == (50, 4) and len(quads.groups["rim"]) == 30
    assert quads.points.min(axis=0) == pytest.approx([-7.0, -1.0, 7.0])
    assert "center" not in quads.groups  # ten columns, but five rows


@pytest.mark.parametrize("arrangement", ["structured", "unstructured"])
def test_a_blank_drawn_as_a_quarter_stays_whole(arrangement):
    mesh = mesh_blank(
        Rectangle(75.0, 50.0, center=(37.5, 25.0)), size=5.0, arrangement=arrangement, symmetry=("x", "y")
    )
    assert mesh.areas.sum() == pytest.approx(75.0 * 50.0)
    assert len(mesh.groups["symmetry_x"]) == 11 and len(mesh.groups["rim"]) == 26


def test_equilateral_triangles_have_equal_sides():
    mesh = mesh_blank(Rectangle(60.0, 17.5 * np.sqrt(3.0)), size=5.0, arrangement="equilateral")
    side = np.linalg.norm(mesh.points[mesh.cells] - mesh.points[np.roll(mesh.cells, 1, axis=1)], axis=2)
    inner = np.abs(mesh.points[mesh.cells].mean(axis=1)[:, 0]) < 27.0
    assert side[inner] == pytest.approx(5.0)
    assert mesh.areas.sum() == pytest.approx(60.0 * 17.5 * np.sqrt(3.0))
    assert mesh.areas.min() > 0.0
    with pytest.raises(CadError, match="only rectangles can be 'equilateral'"):
        mesh_blank(Disc(20.0), size=5.0, arrangement="equilateral")
    with pytest.raises(CadError, match="an equilateral lattice is of triangles"):
        mesh_blank(Rectangle(20.0, 20.0), size=5.0, arrangement="equilateral", shape="quad")


def test_unstructured_is_deterministic_in_another_process():
    script = (
        "import hashlib, sys; from cadlink import mesh_blank; from cadlink.outline import Disc;"
        "m = mesh_blank(Disc(50.0), size=6.0);"
        "assert 'gmsh' not in sys.modules and 'OCP' not in sys.modules;"
        "print(hashlib.sha256(m.points.tobytes() + m.cells.tobytes()).hexdigest())"
    )
    once, again = (
        subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    )
    assert once == again and len(once) == 65


def test_polygon_with_arcs():
    """A stadium: two straight sides of 40 and two half circles of radius 15."""
    stadium = Polygon(
        [(-20.0, -15.0), (20.0, -15.0), (20.0, 15.0), (-20.0, 15.0)], arcs={1: (35.0, 0.0), 3: (-35.0, 0.0)}
    )
    assert stadium.area == pytest.approx(40 * 30 + pi * 15**2, rel=1e-14)
    mesh = mesh_blank(stadium, size=1.0, symmetry=("y",))
    assert mesh.areas.sum() == pytest.approx(0.5 * stadium.area, rel=1e-3)
    assert mesh.points[:, 0].max() == pytest.approx(35.0)
    clockwise = Polygon([(0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0)])
    assert mesh_blank(clockwise, size=2.0).areas.min() > 0.0


@settings(max_examples=8, deadline=None, derandomize=True)
@given(radii=st.lists(st.floats(15.0, 50.0), min_size=5, max_size=12), size=st.floats(2.0, 8.0))
def test_star_shaped_polygons(radii, size):
    angle = np.arange(len(radii)) * 2 * pi / len(radii)
    polygon = Polygon(np.array(radii)[:, None] * np.column_stack((np.cos(angle), np.sin(angle))))
    mesh = mesh_blank(polygon, size=size)
    assert mesh.areas.min() > 0.0
    assert mesh.areas.sum() == pytest.approx(polygon.area, rel=1e-9)
    assert mesh.points[mesh.groups["center"][0]] == pytest.approx(np.zeros(3), abs=1e-9)


# ---- plates and faces from CAD


def box(low, high):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Shape()


def pierced(shape, radius, x, y):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, y, -50.0), gp_Dir(0.0, 0.0, 1.0)), radius, 100.0)
    return BRepAlgoAPI_Cut(shape, drill.Shape()).Shape()


def turned(shape, angle):
    """Turned about the x axis."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf

    turn = gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(1.0, 0.0, 0.0)), angle)
    return BRepBuilderAPI_Transform(shape, turn, True).Shape()


def faces_of(shape):
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def test_plate_is_meshed_on_its_mid_plane():
    plate = box((-75.0, -75.0, 0.0), (75.0, 75.0, 0.81))
    outline = blank_outline(plate)
    assert outline.thickness == pytest.approx(0.81, rel=1e-12) and outline.area == pytest.approx(22500.0)
    assert outline.simple == Rectangle(150.0, 150.0)
    for options in ({}, {"arrangement": "structured"}):
        mesh = mesh_blank(plate, size=5.0, symmetry=("x", "y"), **options)
        assert (mesh.points[:, 2] == pytest.approx(0.405)) and mesh.thickness == outline.thickness
        assert mesh.areas.sum() == pytest.approx(5625.0)
        assert mesh.points[mesh.groups["rim"][0], :2] == pytest.approx([75.0, 0.0])
    assert mesh_blank(outline, size=9.0, z=-3.0).points[:, 2] == pytest.approx(-3.0)


def test_pierced_plate_keeps_its_holes():
    plate = pierced(pierced(box((-60.0, -40.0, 1.0), (60.0, 40.0, 3.0)), 10.0, 0.0, 0.0), 5.0, 40.0, 20.0)
    mesh = mesh_blank(plate, size=2.0)
    assert blank_outline(plate).area == pytest.approx(9600 - 125 * pi)
    assert mesh.areas.sum() == pytest.approx(9600 - 125 * pi, rel=2e-3) and mesh.points[:, 2] == pytest.approx(2.0)
    assert np.hypot(*mesh.points[mesh.groups["hole-1"], :2].T) == pytest.approx(10.0, rel=1e-6)
    assert len(mesh.groups["rim"]) == 200 and "hole-2" in mesh.groups
    with pytest.raises(CadError, match="does not halve the outline: 49.57 %"):
        mesh_blank(plate, size=5.0, symmetry=("x",))


def test_plate_on_another_plane():
    upright = mesh_blank(box((3.0, -30.0, -20.0), (5.0, 30.0, 20.0)), size=5.0, symmetry=("y", "z"))
    assert np.array_equal(upright.normal, [1.0, 0.0, 0.0]) and upright.points[:, 0] == pytest.approx(4.0)
    assert (upright.points[upright.groups["symmetry_z"], 2] == 0.0).all() and upright.areas.min() > 0.0
    assert upright.points.max(axis=0)[1:] == pytest.approx([30.0, 20.0])

    tilted = mesh_blank(turned(box((-30.0, -20.0, 0.0), (30.0, 20.0, 2.0)), 0.3), size=5.0, symmetry=("x",))
    assert tilted.normal == pytest.approx([0.0, -sin(0.3), cos(0.3)])
    assert tilted.points @ tilted.normal == pytest.approx(1.0)
    assert (tilted.points[tilted.groups["symmetry_x"], 0] == 0.0).all()
    assert tilted.areas.sum() == pytest.approx(1200.0)
    with pytest.raises(CadError, match="not perpendicular"):
        mesh_blank(turned(box((-30.0, -20.0, 0.0), (30.0, 20.0, 2.0)), 0.3), size=5.0, symmetry=("y",))


def test_a_face_with_an_elliptic_edge():
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.gp import gp_Ax2, gp_Dir, gp_Elips, gp_Pnt

    ellipse = gp_Elips(gp_Ax2(gp_Pnt(0.0, 0.0, 5.0), gp_Dir(0.0, 0.0, -1.0)), 40.0, 25.0)
    edge = BRepBuilderAPI_MakeEdge(ellipse).Edge()
    face = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(edge).Wire()).Face()
    mesh = mesh_blank(face, size=1.0, symmetry=("x", "y"))
    assert mesh.areas.sum() == pytest.approx(0.25 * pi * 40 * 25, rel=1e-3) and mesh.points[:, 2] == pytest.approx(5.0)
    x, y, _ = mesh.points[mesh.groups["rim"]].T
    assert (x / 40) ** 2 + (y / 25) ** 2 == pytest.approx(1.0, rel=1e-9)
    with pytest.raises(CadError, match="only rectangles, discs and rings"):
        mesh_blank(face, size=1.0, arrangement="structured")


def test_sheet_face_has_no_thickness():
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    tool = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(1.0, 2.0, 3.0), gp_Dir(0.0, 0.0, 1.0)), 20.0, 5.0).Shape()
    side, *ends = faces_of(tool)
    for end, z in zip(ends, (8.0, 3.0)):
        outline = blank_outline(end)
        assert outline.thickness is None and outline.simple == Disc(20.0, (1.0, 2.0))
        mesh = mesh_blank(outline, size=3.0, arrangement="structured")
        assert np.array_equal(mesh.normal, [0.0, 0.0, 1.0]) and mesh.points[:, 2] == pytest.approx(z)
        assert mesh.points[mesh.groups["center"][0]] == pytest.approx([1.0, 2.0, z])
    with pytest.raises(CadError, match="no planar face"):
        blank_outline(side)
    plate = blank_outline(tool)
    assert plate.thickness == pytest.approx(5.0) and plate.simple == Disc(20.0, (1.0, 2.0))


def test_plate_from_a_step_file(tmp_path):
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    writer = STEPControl_Writer()
    writer.Transfer(box((-50.0, -30.0, 2.0), (50.0, 30.0, 3.2)), STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(tmp_path / "plate.step"))
    (part,) = read_step(tmp_path / "plate.step").values()
    mesh = mesh_blank(part, size=4.0, symmetry=("x",))
    assert mesh.thickness == pytest.approx(1.2) and mesh.points[:, 2] == pytest.approx(2.6)
    assert mesh.areas.sum() == pytest.approx(3000.0)


# ---- wrong input


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: mesh_blank(Disc(50.0), size=0.0), "size: expected a number > 0"),
        (lambda: mesh_blank(Disc(50.0), size=-2.0), "size: expected a number > 0"),
        (lambda: mesh_blank(Disc(50.0), size=float("nan")), "size: expected a number > 0"),
        (lambda: mesh_blank(Disc(50.0), size="2"), "size: expected a number > 0"),
        (lambda: mesh_blank(Disc(50.0), size=1e-3), "expected at most"),
        (
            lambda: mesh_blank(Disc(50.0), size=5.0, arrangement="mapped"),
            "'unstructured' or 'structured' or 'equilateral'",
        ),
        (lambda: mesh_blank(Disc(50.0), size=5.0, shape="tri"), "'triangle' or 'quad'"),
        (lambda: mesh_blank(Disc(50.0), size=5.0, symmetry=("w",)), "some of 'x', 'y', 'z'"),
        (lambda: mesh_blank(Disc(50.0), size=5.0, symmetry=("x", "x")), "each once"),
        (lambda: mesh_blank(Disc(50.0), size=5.0, symmetry=("z",)), "z = 0 is not perpendicular"),
        (lambda: mesh_blank(Disc(50.0), size=5.0, z="high"), "expected a height"),
        (lambda: mesh_blank(Disc(5.0, (20.0, 0.0)), size=1.0, symmetry=("x",)), "does not reach across"),
        (lambda: mesh_blank(Disc(5.0, (-20.0, 0.0)), size=1.0, symmetry=("x",)), "does not reach across"),
        (lambda: mesh_blank(Rectangle(10, 10, (30, 0)), 1.0, symmetry=("x",)), "does not reach across"),
        (
            lambda: mesh_blank(Rectangle(10, 10, (1, 0)), 1.0, symmetry=("x",)),
            "does not halve the outline: 60 %",
        ),
        (
            lambda: mesh_blank(Rectangle(10, 10, (1, 0)), 1.0, symmetry="x", arrangement="structured"),
            "does not halve the outline: 60 %",
        ),
        (
            lambda: mesh_blank(Disc(5.0, (0.5, 0.0)), 1.0, symmetry="x", arrangement="structured"),
            "the disc's centre is not on the plane",
        ),
        (lambda: mesh_blank(PIERCED, size=5.0, arrangement="structured"), "rectangle with holes"),
        (
            lambda: mesh_blank(Polygon([(0, 0), (9, 0), (4, 7)]), 1.0, arrangement="structured"),
            "only rectangles, discs",
        ),
        (lambda: mesh_blank("disc", size=5.0), "expected an outline, a Part or a shape, got str"),
        (lambda: Disc(0.0), "Disc radius: expected a length > 0"),
        (lambda: Rectangle(10.0, -1.0), "Rectangle height: expected a length > 0"),
        (lambda: Rectangle(10.0, 1.0, center=(1.0,)), "Rectangle center"),
        (lambda: Polygon([(0, 0), (1, 1)]), "expected at least 3"),
        (lambda: Polygon([(0, 0), (1, 1), (2, 2)]), "encloses no area|crosses itself"),
        (lambda: Polygon([(0, 0), (10, 10), (10, 0), (0, 10)]), "no area|crosses itself"),
        (lambda: Polygon([(0, 0), (10, 10), (10, 0), (0, 12)]), "crosses itself"),
        (lambda: Polygon([(0, 0), (9, 0), (9, 0), (9, 5)]), r"point \(9, 0\) is repeated"),
        (lambda: Polygon([(0, 0), (20, 0), (20, 10), (0, 10)], arcs={0: (10, 11)}), "crosses itself"),
        (lambda: mesh_blank(Polygon([(0, 0), (20, 0), (20, 1e-8), (9, 9)]), 2.0), "gmsh failed: Could not create line"),
        (lambda: Polygon([(0, 0), (10, 0), (10, 0), (0, 12)]), "is repeated"),
        (lambda: Polygon([(0, 0), (10, 0), (0, float("inf"))]), "finite"),
        (lambda: Polygon([(0, 0), (10, 0), (5, 8)], arcs={0: (5, 0)}), "is on its chord"),
        (lambda: Polygon([(0, 0), (10, 0), (5, 8)], arcs={3: (5, 1)}), "edge 3 does not exist"),
        (lambda: Disc(10.0, holes=[Disc(2.0, (30.0, 0.0))]), "hole 1: lies outside"),
        (lambda: Disc(10.0, holes=[Disc(2.0, (9.0, 0.0))]), "outline: touches hole 1"),
        (lambda: Disc(10.0, holes=[Disc(5.0), Disc(1.0)]), "lies inside hole"),
        (lambda: Disc(10.0, holes=[3.0]), "hole: expected"),
    ],
)
def test_wrong_input_is_one_clear_line(make, message):
    with pytest.raises(CadError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_plate_is_needed():
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    with pytest.raises(CadError, match="no planar face"):
        mesh_blank(BRepPrimAPI_MakeSphere(10.0).Shape(), size=2.0)
    with pytest.raises(CadError, match="60 mm apart; expected a thin, flat plate"):
        mesh_blank(box((0.0, 0.0, 0.0), (90.0, 80.0, 60.0)), size=5.0)


@pytest.mark.parametrize(
    "script, message",
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", r"gmsh crashed \(signal 11\)"),
        ("import os; os.abort()", r"gmsh crashed \(signal 6\)"),
        ("import sys; sys.stderr.write('noise\\nInvalid loop\\n'); sys.exit(1)", "gmsh failed: Invalid loop"),
        ("import sys; sys.exit(7)", "gmsh failed: exit status 7"),
        ("", "gmsh failed: exit status 0"),
        ("import time; time.sleep(60)", "gmsh did not finish in 0.5 s"),
    ],
)
def test_a_dying_worker_is_one_clear_line(tmp_path, script, message):
    (tmp_path / "worker.py").write_text(script)
    with pytest.raises(CadError, match=message) as caught:
        run_worker(tmp_path, 0.5 if "sleep" in script else 30.0, worker=tmp_path / "worker.py")
    assert "\n" not in str(caught.value)


def test_quadrilaterals_where_one_way_to_them_fails():
    """The first way leaves triangles beside this hole."""
    outline = Rectangle(20.0, 10.0, holes=(Disc(2.0),))
    mesh = mesh_blank(outline, size=2.0, shape="quad")
    assert mesh.cells.shape[1] == 4 and mesh.areas.min() > 0.0
    assert mesh.areas.sum() == pytest.approx(outline.area, rel=0.01)


def test_a_blank_too_coarse_for_quadrilaterals_is_one_clear_line():
    with pytest.raises(CadError, match="mesh_blank: gmsh failed: .*; try a smaller size, or triangles") as caught:
        mesh_blank(Rectangle(20.0, 10.0), size=30.0, shape="quad")
    assert "\n" not in str(caught.value)


def test_a_quality_floor_for_fine_and_coarse_meshes():
    for size in (2.0, 20.0, 60.0):
        mesh = mesh_blank(Disc(50.0), size=size)
        assert corner_angles(mesh).min() > 30.0
    quads = mesh_blank(Disc(50.0), size=3.0, shape="quad")
    assert corner_angles(quads).min() > 40.0 and corner_angles(quads).max() < 140.0
    structured = mesh_blank(Disc(50.0), size=1.0, arrangement="structured", shape="quad")
    assert corner_angles(structured).min() > 50.0 and corner_angles(structured).max() < 130.0
