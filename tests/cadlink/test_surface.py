"""ToolSurface as its users call it: seeds, threads, chosen faces, wrong input, degenerate points."""

import os
import subprocess
import sys

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

from cadlink import CadError, ConeSurface, ToolSurface, TorusSurface
from cadlink.closest import REACH
from cadlink.quick import SKIN
from cadlink.rim import ODD
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of


@pytest.fixture(scope="module")
def die():
    return part_of(shapes.filleted_box(), "die")


@pytest.fixture(scope="module")
def freeform():
    return part_of(shapes.bumpy_solid(), "freeform")


@pytest.mark.parametrize("name", ["die", "freeform"])
def test_warm_equals_cold_along_random_paths(request, name):
    """A seed shortens the search and never changes the answer."""
    part = request.getfixturevalue(name)
    surface = ToolSurface(part)
    rng = np.random.default_rng(0)
    box = part.bounding_box
    points = box[0] - 2.0 + rng.random((300, 3)) * (np.ptp(box, axis=0) + 4.0)
    seed = None
    for size in (1e-6, 1e-4, 1e-2, 0.1, 1.0, 5.0):
        for _ in range(4):
            points = points + rng.normal(size=points.shape) * size
            cold, warm = surface.project(points), surface.project(points, seed)
            seed = warm.seed
            assert np.abs(cold.distance - warm.distance).max() < 2e-12
            # Two equally near feet are the only excuse for another one.
            other = np.linalg.norm(cold.point - warm.point, axis=1) > 1e-7
            assert other.mean() < 0.01


PRIMITIVES = {"ring": TorusSurface(12.0, 4.0), "funnel": ConeSurface(30.0, hollow=True)}


@pytest.mark.parametrize("name", ["die", "punch", "freeform", *PRIMITIVES])
def test_following_in_place_is_projecting_with_seeds(request, name):
    """Points that wander over faces, rims and edges: the rows asked for are those of `project`, others untouched.

    Seeds may differ: `follow` searches ahead.
    """
    if name in PRIMITIVES:
        surface, box = PRIMITIVES[name], np.array([[-16.0] * 3, [16.0] * 3])
    else:
        part = part_of(shapes.punch(), name) if name == "punch" else request.getfixturevalue(name)
        surface, box = ToolSurface(part), part.bounding_box
    rng, n = np.random.default_rng(2), 300
    points = box[0] - 1.0 + rng.random((n, 3)) * (np.ptp(box, axis=0) + 2.0)
    found = surface.project(points)
    hit = tuple(getattr(found, name) for name in ("distance", "normal", "curvature", "direction", "face", "seed"))
    place, near, shift = points.copy(), np.empty(n, np.int64), np.array([0.3, -0.2, 0.1])
    ahead = rng.normal(size=points.shape)
    for size in (1e-4, 1e-3, 1e-2, 0.1, 1.0, 1e-3):
        for _ in range(3):
            before = [values.copy() for values in hit]
            asked = rng.random(n) < 0.7
            rows = np.flatnonzero(asked)
            points[rows] += size * ahead[rows]
            carried = points + shift
            wanted = surface.project(carried[rows] - shift, hit[-1][rows])
            count = surface.follow(carried, shift, np.where(asked, np.inf, -np.inf), place, hit, near)
            others = np.setdiff1d(np.arange(n), rows)
            assert np.array_equal(near[:count], rows)
            assert np.array_equal(place[rows], carried[rows] - shift)
            for now, new in zip(hit[:-1], wanted[:1] + wanted[2:-1], strict=True):
                assert now[rows] == pytest.approx(new, rel=1e-12, abs=1e-12)
            for now, old in zip(hit, before, strict=True):
                assert np.array_equal(now[others], old[others])


def test_the_outer_sheet_of_a_torus_across_its_axis_is_met_in_closed_form():
    """A trim on one sheet has one foot; on the inner one, or on both, the careful search decides."""
    kinds = {name: part_of(shapes.SHELLS[name]()).surface().skin.rims["kind"] for name in shapes.SHELLS}
    assert (kinds["outer sheet"] != ODD).all()
    assert (kinds["inner sheet"] == ODD).all() and (kinds["both sheets"] == ODD).all()
    surface = part_of(shapes.punch(4.0, 3.0)).surface()
    # Round the middle of a corner's tube, on its axis and beyond: 5.5, 2.5, -4 is on the ring of radius 1.
    corner, centre = np.array([1.0, 1.0, -1.0]) / np.sqrt(3.0), np.array([6.0, 3.0, -1.0])
    middle = centre + np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    away = np.array([-2.0, -1.0, -0.1, 0.3, 2.0])[:, None]
    hit = surface.project(middle + (3.0 + away) * corner)
    assert hit.distance == pytest.approx(away[:, 0], abs=1e-12)
    assert (hit.seed[:, REACH] > 0.0).all()


def test_seed_of_another_surface_does_no_harm(die, freeform):
    points = np.random.default_rng(1).normal(size=(100, 3)) * 8.0
    seed = freeform.surface().project(points).seed
    a, b = die.surface().project(points), die.surface().project(points, seed)
    assert np.abs(a.distance - b.distance).max() < 1e-12


def test_same_bits_at_any_thread_count(tmp_path):
    script = tmp_path / "hash.py"
    script.write_text(
        "import hashlib, numpy as np\n"
        "from tests.cadlink import shapes\n"
        "from tests.cadlink.occ_truth import part_of\n"
        "points = np.random.default_rng(0).normal(size=(3000, 3)) * 10.0\n"
        "surface = part_of(shapes.bumpy_solid()).surface()\n"
        "hits = [surface.project(points)]\n"
        "for step in (1e-4, 1e-3, 2e-2):\n"
        "    hits.append(surface.project(points + step, hits[-1].seed))\n"
        "print(hashlib.sha256(b''.join(a.tobytes() for hit in hits for a in hit)).hexdigest())\n"
    )
    found = set()
    for threads in ("1", "2"):
        env = {**os.environ, "NUMBA_NUM_THREADS": threads, "PYTHONPATH": os.getcwd()}
        done = subprocess.run([sys.executable, script], env=env, capture_output=True, text=True, check=True)
        found.add(done.stdout)
    assert len(found) == 1


def test_chosen_faces_only(die):
    """The top of a box alone: points below it are inside, whatever the other faces are."""
    top = max(die.planes, key=lambda plane: plane.normal[2])
    surface = die.surface(faces=[top.face])
    hit = surface.project(np.array([[0.0, 0.0, 9.0], [0.0, 0.0, -50.0]]))
    assert hit.distance == pytest.approx([5.0, -54.0])
    assert (hit.face == top.face).all()
    assert hit.normal == pytest.approx(np.array([[0, 0, 1.0], [0, 0, 1.0]]))


def test_face_number_out_of_range_is_named(die):
    with pytest.raises(CadError, match="faces 0 to 25"):
        die.surface(faces=[26])


@pytest.mark.parametrize(
    "points, message",
    [
        (np.zeros(3), "must be"),
        (np.zeros((4, 2)), "must be"),
        (np.full((2, 3), np.nan), "finite"),
    ],
)
def test_wrong_points_are_refused(die, points, message):
    with pytest.raises(ValueError, match=message):
        die.surface().project(points)


def test_no_points_give_no_hits(die):
    hit = die.surface().project(np.zeros((0, 3)))
    assert hit.distance.shape == (0,) and hit.point.shape == (0, 3)


def test_smooth_edges_leave_no_trace(die):
    """Along a line over flat, fillet and corner the normal and the curvature follow the faces."""
    surface = die.surface()
    x = np.linspace(0.0, 12.0, 2001)
    points = np.column_stack([x, np.zeros_like(x), np.full_like(x, 5.0)])
    hit = surface.project(points)
    assert np.abs(hit.curvature).max() < 1.0
    # On the flat up to x = 8.5 the normal is z; over the fillet of radius 1.5 it turns with d.
    assert np.abs(np.diff(hit.normal, axis=0)).max() < 1.1 * (x[1] - x[0]) / 2.5
    edge = surface.project(np.array([[8.5, 0.0, 5.0]]))
    assert edge.distance == pytest.approx([1.0])
    assert edge.normal[0] == pytest.approx([0.0, 0.0, 1.0])
    assert edge.curvature[0].max() <= 1.0 / 1.5 + 1e-12


def test_sharp_convex_edge_and_vertex():
    """Over an edge of a box hess d = 1/d across it and 0 along it; over a corner 1/d both ways."""
    surface = part_of(shapes.box()).surface()
    hit = surface.project(np.array([[11.0, 0.0, 5.0], [11.0, 8.0, 5.0], [10.0, 0.0, 4.0]]))
    assert hit.distance[:2] == pytest.approx([np.sqrt(2.0), np.sqrt(3.0)])
    assert hit.curvature[0] == pytest.approx([1e12, 0.0])
    assert hit.direction[0] @ [0.0, 1.0, 0.0] == pytest.approx(0.0)
    assert hit.curvature[1] == pytest.approx([1e12, 1e12])
    # On the edge itself the normal is the mean of the two faces, or one of them.
    assert hit.distance[2] == pytest.approx(0.0, abs=1e-12)
    assert hit.normal[2] @ [1.0, 0.0, 1.0] >= 1.0 - 1e-9


def test_reentrant_edge_is_met_from_inside():
    """Inside an L the nearest point may be the re-entrant edge: distance negative, bend too."""
    surface = part_of(shapes.l_profile_sharp()).surface()
    hit = surface.project(np.array([[1.5, 3.0, 1.4]]))
    away = np.hypot(0.5, 0.6)
    assert hit.distance == pytest.approx([-away])
    assert hit.normal[0] == pytest.approx(np.array([0.5, 0.0, 0.6]) / away)
    assert hit.curvature[0] == pytest.approx([0.0, -1e12])


def test_concave_fillet_smaller_than_the_sheet():
    """Two equal feet: the seed decides, the distance does not."""
    surface = part_of(shapes.l_profile(0.3)).surface()
    middle = np.array([[3.0, 3.0, 3.0]])
    left = surface.project(middle - [0.01, 0.0, 0.0])
    below = surface.project(middle - [0.0, 0.0, 0.01])
    a, b = surface.project(middle, left.seed), surface.project(middle, below.seed)
    assert a.distance == pytest.approx([1.0]) and b.distance == pytest.approx([1.0])
    assert a.normal[0] == pytest.approx([1.0, 0.0, 0.0])
    assert b.normal[0] == pytest.approx([0.0, 0.0, 1.0])


def test_points_without_a_single_foot():
    """Axis of a cylinder, centre of a sphere, spine and axis of a torus: distance as it should be."""
    on_axis = np.array([[0.0, 0.0, 6.0]])
    assert part_of(shapes.upright_cylinder()).surface().project(on_axis).distance == pytest.approx([-6.0])
    centre = np.array([[1.0, -2.0, 0.5]])
    for shape in (shapes.sphere(), shapes.as_nurbs(shapes.sphere())):
        assert part_of(shape).surface().project(centre).distance == pytest.approx([-7.0])
    for shape in (shapes.torus(), shapes.as_nurbs(shapes.torus())):
        assert part_of(shape).surface().project(centre).distance == pytest.approx([8.0])


def test_poles_have_a_normal():
    """On the axis over the pole of a sphere: the pole, a finite normal and curvature 1/R."""
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    points = np.array([1.0, -2.0, 0.5]) + np.array([[9.0], [-9.0], [5.0]]) * axis
    for shape in (shapes.sphere(), shapes.as_nurbs(shapes.sphere())):
        hit = part_of(shape).surface().project(points)
        assert hit.distance == pytest.approx([2.0, 2.0, -2.0])
        assert hit.normal == pytest.approx(np.array([axis, -axis, axis]), abs=1e-4)
        assert hit.curvature == pytest.approx(1.0 / 7.0, abs=1e-6)


def test_seam_with_a_hole_through_it():
    """Feet on the seam of a cylinder, beside the hole and in it."""
    surface = part_of(shapes.cylinder_with_cross_hole()).surface()
    hit = surface.project(np.array([[10.0, 0.0, 1.0], [10.0, 1e-13, 1.0], [10.0, 0.0, 6.0], [10.0, -1e-13, 11.0]]))
    assert hit.distance[[0, 1, 3]] == pytest.approx(2.0)
    assert hit.normal[[0, 1, 3]] == pytest.approx(np.array([[1.0, 0.0, 0.0]] * 3), abs=1e-9)
    # Over the middle of the hole the rim is nearest: (8 cos t, 8 sin t, 6 +- sqrt(9 - y^2)).
    t = np.linspace(0.0, np.arcsin(3.0 / 8.0), 200001)
    y = 8.0 * np.sin(t)
    rim = np.sqrt((10.0 - 8.0 * np.cos(t)) ** 2 + y**2 + (9.0 - y**2)).min()
    assert abs(hit.distance[2]) == pytest.approx(rim, abs=1e-6)


def test_crease_inside_a_bspline_is_an_edge():
    """C0 knot: over the ridge normals fan out, and face numbers stay those of the file."""
    part = part_of(shapes.creased_face(), "crease")
    assert part.n_faces == 1
    surface = part.surface()
    hit = surface.project(np.array([[9.9, 10.0, -3.0], [8.0, 10.0, 8.0], [12.0, 10.0, 8.0]]))
    assert (hit.face == 0).all()
    assert hit.curvature[0].max() >= 1e9 or hit.curvature[0].min() <= -1e9


def test_a_foot_on_a_sharp_edge_stays_the_nearest_until_a_face_is_below_the_point():
    """A plate with a hole: at a outside and b above its edge the point may move by the smaller of the two.

    Beyond SKIN the search need not tell all of it.
    """
    hole = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(50.0, 40.0, -1.0), gp_Dir(0, 0, 1)), 10.0, 22.0).Shape()
    surface = part_of(BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(100.0, 80.0, 20.0).Shape(), hole).Shape()).surface()
    a, b = (x.ravel() for x in np.meshgrid([0.01, 0.05, 0.3, 1.0], [0.02, 0.08, 0.5, 1.5]))
    x = np.linspace(5.0, 95.0, len(a))
    beside = np.column_stack([x, -a, 20.0 + b])
    angle = np.linspace(0.3, 6.0, len(a))
    inside = np.column_stack([50.0 + (10.0 - a) * np.cos(angle), 40.0 + (10.0 - a) * np.sin(angle), 20.0 + b])
    hit = surface.project(beside)
    assert hit.distance == pytest.approx(np.hypot(a, b), abs=1e-12)
    reach, room = hit.seed[:, REACH], np.minimum(a, b)
    assert (reach <= room + 1e-6).all()
    assert (reach >= np.minimum(SKIN, room) - 1e-6).all()
    # The same over the rim of the hole.
    hit = surface.project(inside)
    assert hit.distance == pytest.approx(np.hypot(a, b), abs=1e-12)
    assert (hit.seed[:, REACH] > 0.5 * np.minimum(SKIN, room)).all()
    assert (hit.seed[:, REACH] <= room + 1e-9).all()
