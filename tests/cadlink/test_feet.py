"""All feet of a point against the extrema OpenCASCADE finds on faces, edges and vertices; and when to look for them."""

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon, BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_ExtPC, BRepExtrema_ExtPF
from OCP.BRepLProp import BRepLProp_SLProps
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_VERTEX
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

from cadlink import CylinderSurface, FacetSurface
from cadlink.feet import ALIKE
from cadlink.shifted import shifted
from tests.cadlink import shapes
from tests.cadlink.occ_truth import distances, part_of


def prism(corners, length=10.0):
    """A polygon in the x-z plane drawn along y."""
    polygon = BRepBuilderAPI_MakePolygon()
    for x, z in corners:
        polygon.Add(gp_Pnt(x, 0.0, z))
    polygon.Close()
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(polygon.Wire()).Face(), gp_Vec(0.0, length, 0.0)).Shape()


def v_groove(opening=60.0):
    """A groove 3 mm deep, its bottom at the origin."""
    x = 3.0 * np.tan(np.radians(0.5 * opening))
    return prism([(-8, 3), (-x, 3), (0, 0), (x, 3), (8, 3), (8, -3), (-8, -3)])


def inner_corner():
    """A box with a box cut out of its corner: three planes meet at the origin."""
    block = BRepPrimAPI_MakeBox(gp_Pnt(-4, -4, -4), 10.0, 10.0, 10.0).Solid()
    return BRepAlgoAPI_Cut(block, BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 20.0, 20.0, 20.0).Solid()).Shape()


def step_up():
    """A floor, and a block on it whose upper edge is convex."""
    return prism([(-8, 0), (0, 0), (0, 0.4), (8, 0.4), (8, -3), (-8, -3)])


def valley():
    """A parabola of radius 1.4 at its bottom, z = -4.75, as a B-spline cut along y into a block."""
    curve = shapes.spline_curve([(-6, 0, 8), (-2, 0, -9), (2, 0, -9), (6, 0, 8)])
    tool = BRepPrimAPI_MakePrism(shapes.closed_profile(curve), gp_Vec(0.0, 30.0, 0.0)).Shape()
    block = BRepPrimAPI_MakeBox(gp_Pnt(-9, 1, -9), 18.0, 10.0, 15.0).Solid()
    return BRepAlgoAPI_Cut(block, tool).Shape()


def pin():
    """A pin of radius 5 on a plate: its foot is a re-entrant circle."""
    plate = BRepPrimAPI_MakeBox(gp_Pnt(-9, -9, -3), 18.0, 18.0, 3.0).Solid()
    return BRepAlgoAPI_Fuse(plate, BRepPrimAPI_MakeCylinder(5.0, 6.0).Solid()).Shape()


def each(shape, kind, cast):
    walk, found = TopExp_Explorer(shape, kind), []
    while walk.More():
        found.append(cast(walk.Current()))
        walk.Next()
    return found


def extrema(shape, p):
    """Every extremum of the distance from p, and every vertex: (q, least curvature seen from p, -inf for a maximum)."""
    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, p))).Vertex()
    array = lambda q: np.array([q.X(), q.Y(), q.Z()])  # noqa: E731
    found = []
    for face in each(shape, TopAbs_FACE, TopoDS.Face_s):
        search = BRepExtrema_ExtPF(vertex, face)
        for k in range(1, search.NbExt() + 1 if search.IsDone() else 1):
            q, (u, v) = array(search.Point(k)), search.Parameter(k)
            props = BRepLProp_SLProps(BRepAdaptor_Surface(face), u, v, 2, 1e-9)
            n = array(props.Normal())
            # OpenCASCADE's curvatures are + where the surface bends towards its normal.
            lean = 1.0 if (p - q) @ n > 0.0 else -1.0
            bends = [-lean * props.MaxCurvature(), -lean * props.MinCurvature()]
            found.append((q, min(bends)))
    for edge in each(shape, TopAbs_EDGE, TopoDS.Edge_s):
        if not BRep_Tool.Degenerated_s(edge):
            search = BRepExtrema_ExtPC(vertex, edge)
            n = search.NbExt() if search.IsDone() else 0
            found += [(array(search.Point(k)), 0.0) for k in range(1, n + 1) if search.IsMin(k)]
    return found + [(array(BRep_Tool.Pnt_s(v)), 0.0) for v in each(shape, TopAbs_VERTEX, TopoDS.Vertex_s)]


def true_feet(shape, p, reach):
    """(h, q) of the local minima within reach, by OpenCASCADE alone; of those that look alike the nearest."""
    found = []
    for q, bend in extrema(shape, p):
        h = np.linalg.norm(p - q)
        if not 1e-6 < h <= reach or 1.0 + bend * h < 1e-3:
            continue
        step = 0.01 * h
        if abs(distances(shape, (q + step * (p - q) / h)[None])[0][0] - step) < 1e-6 * step + 1e-9:
            found.append((h, q))
    found.sort(key=lambda foot: foot[0])
    kept = []
    for h, q in found:
        if all((p - q) @ (p - r) < np.cos(ALIKE) * h * g for g, r in kept):
            kept.append((h, q))
    return kept[:3]


CORNERS = {
    "sharp L": (shapes.l_profile_sharp(), (2.0, 3.0, 2.0), 0.7),
    "fillet under half the sheet": (shapes.l_profile(0.3), (2.4, 3.0, 2.4), 0.7),
    "V groove": (v_groove(), (0.0, 5.0, 0.8), 0.7),
    "blunt groove": (v_groove(150.0), (0.0, 5.0, 0.4), 0.7),
    "three planes": (inner_corner(), (0.4, 0.4, 0.4), 0.9),
    "step": (step_up(), (-0.4, 5.0, 0.4), 0.9),
    "notch and spike": (shapes.star_vertex(), (-5.0, 3.2, 4.7), 1.5),
    "B-spline valley": (valley(), (0.0, 5.0, -2.0), 3.5),
    "pin on a plate": (pin(), (5.5, 0.0, 0.5), 0.9),
    "mirrored L": (shapes.mirrored(shapes.l_profile(0.3)), (3.6, 3.0, 2.4), 0.7),
}


@pytest.mark.parametrize("name", CORNERS)
def test_feet_are_the_local_minima(name):
    shape, middle, reach = CORNERS[name]
    surface = part_of(shape).surface()
    points = np.array(middle) + np.random.default_rng(6).uniform(-0.6, 0.6, (30, 3)) * min(1.0, reach)
    hit = surface.project(points)
    points, hit = points[hit.distance > 0.1], surface.project(points[hit.distance > 0.1])
    owner, feet = surface.feet(points, hit, reach)
    several = 0
    for i, p in enumerate(points):
        mine = np.flatnonzero(owner == i)
        expected = true_feet(shape, p, reach)
        if hit.distance[i] > reach:
            assert not len(mine) and not expected
            continue
        found = [hit.distance[i], *feet.distance[mine]]
        assert found == pytest.approx([h for h, _ in expected], abs=1e-7)
        assert np.vstack([hit.point[i], feet.point[mine]]) == pytest.approx(
            np.array([q for _, q in expected]), abs=1e-5
        )
        assert points[i] - feet.point[mine] == pytest.approx(feet.distance[mine, None] * feet.normal[mine], abs=1e-7)
        several += len(mine) > 0
    assert several >= 5, several


def test_distance_and_normal_of_a_further_foot_are_derivatives_of_each_other():
    surface, reach = part_of(valley()).surface(), 5.0
    points = np.array([0.0, 6.0, -1.5]) + np.random.default_rng(1).uniform(-1.0, 1.0, (40, 3))
    owner, feet = surface.feet(points, surface.project(points), reach)
    first = np.unique(owner, return_index=True)[1]
    owner, at = owner[first], points[owner[first]]
    n, k, e1 = feet.normal[first], feet.curvature[first], feet.direction[first]
    smooth = (np.abs(k) < 1e3).all(axis=1)
    assert smooth.sum() >= 10
    d, e2 = feet.distance[first], np.cross(n, e1)
    c = k / (1.0 + k * d[:, None])
    hessian = c[:, 0, None, None] * e1[:, :, None] * e1[:, None] + c[:, 1, None, None] * e2[:, :, None] * e2[:, None]
    step, tested = 1e-6, 0
    for axis in range(3):
        move = step * np.eye(3)[axis]
        ends = []
        for sign in (1.0, -1.0):
            other, moved = surface.feet(at + sign * move, surface.project(at + sign * move), reach)
            rows = [np.flatnonzero((other == i) & (np.abs(moved.distance - d[i]) < 2 * step)) for i in range(len(at))]
            ends.append([(moved.distance[r[0]], moved.normal[r[0]]) if len(r) else None for r in rows])
        for i in np.flatnonzero(smooth):
            up, down = ends[0][i], ends[1][i]
            if up and down:
                assert (up[0] - down[0]) / (2 * step) == pytest.approx(n[i, axis], abs=1e-6)
                scale = max(1.0, np.abs(hessian[i]).max())
                assert (up[1] - down[1]) / (2 * step) == pytest.approx(hessian[i, axis], abs=1e-4 * scale)
                tested += 1
    assert tested >= 30


def test_both_feet_stay_where_the_nearer_one_changes():
    """A path over the bisector of an L: the pair of walls is the same on either side, whichever is nearer."""
    surface = part_of(shapes.l_profile(0.3)).surface()
    s = np.linspace(-0.15, 0.15, 31)
    points = np.column_stack([2.5 + s, np.full(31, 3.0), 2.5 - s])
    seed, walls = None, []
    for p in points:
        hit = surface.project(p[None], seed)
        owner, feet = surface.feet(p[None], hit, 0.7)
        assert len(owner) == 1
        both = np.vstack([hit.normal, feet.normal])
        walls.append(dict(zip(both[:, 0].round().astype(int), [hit.distance[0], feet.distance[0]])))
        seed = hit.seed
    assert [w[1] for w in walls] == pytest.approx(0.5 + s)
    assert [w[0] for w in walls] == pytest.approx(0.5 - s)


@pytest.mark.parametrize(
    ("shape", "outside", "inside"),
    [
        (shapes.box(), np.inf, 0.0),
        (shapes.sphere(), np.inf, 7.0),
        (shapes.l_profile(0.3), 0.3, 0.0),
        (shapes.l_profile_sharp(), 0.0, 0.0),
        (v_groove(), 0.0, 0.0),
        (shapes.filleted_box(1.5), np.inf, 1.5),
        (shapes.as_nurbs(shapes.filleted_box(1.5)), np.inf, 1.5),
        (shapes.upright_cylinder(), np.inf, 0.0),
    ],
)
def test_tightest_hollow(shape, outside, inside):
    surface = part_of(shape).surface()
    assert surface.tightest() == pytest.approx(outside, rel=0.1)
    assert surface.tightest(-1.0) == pytest.approx(inside, rel=0.1)
    turned = shifted(surface, flip=True)
    assert turned.tightest() == pytest.approx(inside, rel=0.1)


def test_feet_of_a_moved_and_of_a_turned_surface():
    """A clearance of 0.1 moves both walls; seen from within, the edges of a box are its hollows."""
    surface = part_of(shapes.l_profile_sharp()).surface()
    p = np.array([[2.5, 3.0, 2.6]])
    moved = shifted(surface, 0.1)
    _, feet = moved.feet(p, moved.project(p), 0.55)
    assert feet.distance == pytest.approx([0.5]) and feet.point[0] == pytest.approx([2.5, 3.0, 2.1])
    assert not len(moved.feet(p, moved.project(p), 0.45).owner)
    inside = shifted(part_of(shapes.box()).surface(), flip=True)
    p = np.array([[9.6, 6.5, 3.4]])
    owner, feet = inside.feet(p, inside.project(p), 0.7)
    assert list(owner) == [0, 0] and feet.distance == pytest.approx([0.5, 0.6])
    assert feet.normal == pytest.approx(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]))


@pytest.mark.parametrize("normals", ["element", "nodal", "nagata"])
def test_feet_on_facets(normals):
    """The walls of a coarse L, and of one with a fillet of 0.3 in facets; a fine convex bar has none."""
    for radius in (0.0, 0.3):
        part = part_of(shapes.l_profile(radius) if radius else shapes.l_profile_sharp())
        surface = part.facets(0.002, normals=normals)
        assert surface.tightest() < 0.5
        p = np.array([[2.5, 3.0, 2.52], [2.6, 3.0, 2.45], [5.0, 3.0, 2.5]])
        owner, feet = surface.feet(p, surface.project(p), np.array([0.58, 0.61, 0.58]))
        assert list(owner) == [0, 1]
        assert feet.distance == pytest.approx([0.52, 0.6], abs=1e-9)
        assert feet.point == pytest.approx(np.array([[2.5, 3.0, 2.0], [2.0, 3.0, 2.45]]), abs=1e-9)
    bar = part_of(shapes.upright_cylinder()).facets(0.01, normals=normals)
    p = bar.project(np.random.default_rng(0).uniform(-8.0, 8.0, (200, 3)) + [0.0, 0.0, 6.0])
    points = p.point + 0.5 * p.normal
    assert bar.tightest() == np.inf and not len(bar.feet(points, bar.project(points), 0.7).owner)


def test_a_facetted_hollow_wider_than_the_sheet_has_one_foot():
    """A trough of radius 5 in facets that turn by 6 degrees: kinks between facets are not walls of their own."""
    t = np.linspace(-1.0, 1.0, 20)
    ring = 5.0 * np.column_stack([np.sin(t), -np.cos(t)])
    points = np.array([[x, y, z] for y in (0.0, 4.0) for x, z in ring])
    cells = np.array([[k, k + 1, k + 21, k + 20] for k in range(19)])
    surface = FacetSurface(points, cells, "element")
    surface = (
        surface
        if surface.project(np.array([[0.0, 2.0, -4.5]])).distance > 0
        else FacetSurface(points, cells, "element", flip=True)
    )
    assert surface.tightest() == pytest.approx(5.0, rel=0.02)
    p = np.column_stack([np.linspace(-3.0, 3.0, 50), np.full(50, 2.0), np.zeros(50)])
    p[:, 2] = -np.sqrt(4.5**2 - p[:, 0] ** 2)
    assert not len(surface.feet(p, surface.project(p), 0.7).owner)


def test_a_whole_surface_has_one_foot():
    bore = CylinderSurface(0.3, hollow=True)
    p = np.array([[0.1, 0.0, 1.0]])
    assert bore.tightest() == np.inf and not len(bore.feet(p, bore.project(p), 1.0).owner)
