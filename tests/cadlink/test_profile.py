"""Plane sections against the solids they are cut from, closed forms, brute force and differences."""

import numpy as np
import pytest

from cadlink import CadError, read_step, section
from cadlink.bezier import points as arc_points
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of
from tests.cadlink.test_step import SHARED, needs_shared

TILT = ((0.5, 0.3, 0.2), (0.3, -0.5, 1.0))
CUTS = [
    ("box", TILT, {"line"}),
    ("cylinder", TILT, {"line", "ellipse"}),
    ("cross hole", ((0, 0, 5.0), (0, 0, 1.0)), {"line", "circle"}),
    ("cross hole", ((0, 0, 5.0), (0.2, 0.1, 1.0)), {"ellipse"}),
    ("sphere", TILT, {"circle"}),
    ("cone", TILT, {"ellipse"}),
    ("torus", TILT, {"spline"}),
    ("torus part", TILT, {"spline", "line"}),
    ("filleted box", "xz", {"line", "circle"}),
    ("filleted box", ((0.5, 0.3, 3.2), (0.1, -0.2, 1.0)), {"line", "ellipse"}),
    ("revolution", ((0, 0, 4.0), (0.3, 0, 1.0)), {"spline"}),
    ("bspline", ((9.0, 6.0, 0.0), (1.0, 0.4, 0.1)), {"spline"}),
    ("rational torus", TILT, {"spline"}),
    ("mirrored fillets", "xz", {"line", "circle"}),
    ("moved fillets", TILT, {"line"}),
    ("L profile", ((0, 3.0, 0), (0, 1.0, 0)), {"line", "circle"}),
    ("notched", TILT, {"line"}),
    ("gap", "xz", {"line"}),
]


def around(profile, n, seed=0):
    lines = np.vstack(profile.polyline())
    rng = np.random.default_rng(seed)
    low, high = lines.min(axis=0), lines.max(axis=0)
    points = low + (rng.random((n, 2)) * 1.4 - 0.2) * (high - low)
    points[: n // 2] = lines[rng.integers(len(lines), size=n // 2)] + rng.normal(size=(n // 2, 2)) * 0.05 * (high - low)
    return points


@pytest.fixture(scope="module")
def cuts():
    class Made(dict):
        def __missing__(self, key):
            name, plane, _ = CUTS[key]
            part = part_of(shapes.SOLIDS[name](), name)
            self[key] = part, section(part, plane)
            return self[key]

    return Made()


@pytest.mark.parametrize("number", range(len(CUTS)), ids=[f"{n} {k}" for n, (k, *_) in enumerate(CUTS)])
def test_section_of_every_kind(cuts, number):
    """Curves lie on the exact faces, the sides are those of the solid, distances those to dense samples."""
    part, profile = cuts[number]
    gap = max(part.gap_report()[:2])
    assert profile.closed
    assert CUTS[number][2] <= {c.kind for c in profile.curves}
    surface = part.surface()
    for curve in profile.curves:
        s = np.linspace(0.0, 1.0, 23)
        on = surface.project(profile.in_space(np.vstack([arc_points(a, s) for a in curve.arcs])))
        assert np.abs(on.distance).max() < 2e-9 + gap, (curve.kind, np.abs(on.distance).max())
    points = around(profile, 300)
    hit = profile.project(points)
    inside = surface.project(profile.in_space(points)).distance
    clear = np.abs(inside) > 1e-6 + gap
    assert (np.sign(hit.distance) == np.sign(inside))[clear].all()
    assert np.linalg.norm(points - hit.point, axis=1) == pytest.approx(np.abs(hit.distance), abs=1e-12)
    # The plane distance is never below the one in space, and its foot is on the part.
    assert (np.abs(hit.distance) >= np.abs(inside) - 1e-9 - gap).all()
    lines = profile.polyline(400)
    truth = np.min([np.linalg.norm(points[:, None] - line[None], axis=2).min(axis=1) for line in lines], axis=0)
    spacing = max(np.linalg.norm(np.diff(line, axis=0), axis=1).max() for line in lines)
    assert (np.abs(hit.distance) <= truth + 1e-9).all()
    assert (np.abs(hit.distance) >= np.sqrt(np.maximum(truth**2 - spacing**2, 0.0)) - 1e-9).all()


@pytest.mark.parametrize("number", [1, 6, 8, 11, 15])
def test_normal_is_the_gradient_and_curvature_the_hessian(cuts, number):
    _, profile = cuts[number]
    points = around(profile, 300, seed=3)
    hit = profile.project(points)
    step, gradient, turn = 1e-5, np.zeros((300, 2)), np.zeros((300, 2, 2))
    steady = np.abs(hit.distance) > 0.02
    for c in range(2):
        move = step * np.eye(2)[c]
        after, before = profile.project(points + move), profile.project(points - move)
        gradient[:, c] = (after.distance - before.distance) / (2 * step)
        turn[:, :, c] = (after.normal - before.normal) / (2 * step)
        for other in (after, before):
            steady &= (np.abs(other.curvature) > 1e9) == (np.abs(hit.curvature) > 1e9)  # not past the end of a curve
            steady &= (other.face == hit.face) & (np.linalg.norm(other.point - hit.point, axis=1) < 40 * step)
    factor = hit.curvature / (1.0 + hit.curvature * hit.distance)
    steady &= (np.abs(1.0 + hit.curvature * hit.distance) > 0.3) & (np.abs(factor) < 10.0)
    tangent = hit.normal @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    expected = factor[:, None, None] * tangent[:, :, None] * tangent[:, None, :]
    assert steady.sum() > 150
    assert np.abs(gradient - hit.normal)[steady].max() < 1e-6
    assert np.abs(turn - expected)[steady].max() < 1e-4


def test_seed_changes_nothing(cuts):
    _, profile = cuts[8]
    points = around(profile, 200)
    hit = profile.project(points)
    moved = points + 0.05
    assert (profile.project(moved, hit.seed).distance == profile.project(moved).distance).all()


def test_radii_and_coordinates_of_a_rounded_box(cuts):
    """Cut by y = 0: a rectangle 20 x 8 with corners of radius 1.5; coordinates are x and z."""
    _, profile = cuts[8]
    circles = [c for c in profile.curves if c.kind == "circle"]
    assert len(profile.loops) == 1 and len(profile.curves) == 8 and len(circles) == 4
    assert [c.radius for c in circles] == pytest.approx([1.5] * 4)
    assert np.abs([c.center for c in circles]) == pytest.approx(np.array([[8.5, 2.5]] * 4))
    hit = profile.project(np.array([[12.0, 1.0], [8.5 + 3.0, 2.5 + 4.0], [0.0, 0.0]]))
    assert hit.distance == pytest.approx([2.0, 5.0 - 1.5, -4.0])
    assert hit.curvature[:2] == pytest.approx([0.0, 1.0 / 1.5])
    assert hit.normal[1] == pytest.approx([0.6, 0.8])
    assert profile.in_space(np.array([[1.0, 2.0]]))[0] == pytest.approx([1.0, 0.0, 2.0])


def test_corners_are_sharp_and_reentrant_ones_bend_inwards():
    profile = section(part_of(shapes.l_profile_sharp()), ((0, 3.0, 0), (0, 1.0, 0), (1.0, 0, 0)))
    # Axes: x, and n x x = -z.
    hit = profile.project(np.array([[12.0, 1.0], [1.5, -1.4]]))
    assert hit.distance == pytest.approx([np.hypot(2.0, 1.0), -np.hypot(0.5, 0.6)])
    assert hit.curvature == pytest.approx([1e12, -1e12])
    assert hit.normal[0] == pytest.approx(np.array([2.0, 1.0]) / np.sqrt(5.0))


def test_plane_through_a_face_of_a_half_model():
    """A quarter model is cut where it ends: the profile is the outline of the faces around."""
    part = part_of(shapes.box())
    profile = section(part, ((0.0, -7.0, 0.0), (0.0, 1.0, 0.0)))
    assert profile.closed and len(profile.curves) == 4
    hit = profile.project(np.array([[0.0, 0.0], [12.0, 0.0]]))
    assert hit.distance == pytest.approx([-4.0, 2.0])


def test_hole_is_a_loop_of_its_own(cuts):
    part = part_of(shapes.cylinder_with_cross_hole())
    profile = section(part, ((0, 0, 0), (1.0, 0, 0)))
    assert len(profile.loops) == 2 and profile.closed
    assert profile.project(np.array([[0.0, 6.0]])).distance == pytest.approx([3.0])


def test_open_shell_gives_an_open_profile():
    part = part_of(shapes.bezier_face())
    profile = section(part, ((10.0, 0, 0), (1.0, 0, 0)))
    assert not profile.closed and len(profile.loops) == 1
    assert np.abs(part.surface().project(profile.in_space(np.vstack(profile.polyline()))).distance).max() < 1e-9


@needs_shared
@pytest.mark.parametrize("name", ["part.step", "linkrods.step", "NIST_MBE_PMI_3.stp"])
def test_sections_of_files_from_elsewhere(name):
    part = next(iter(read_step(SHARED / name).values()))
    centre = part.bounding_box.mean(axis=0)
    profile = section(part, (centre, (0.1, 1.0, 0.05)))
    gap = max(part.gap_report()[:2])
    surface = part.surface()
    on = surface.project(profile.in_space(np.vstack(profile.polyline())))
    assert np.abs(on.distance).max() < 2e-9 + gap
    points = around(profile, 400)
    inside = surface.project(profile.in_space(points)).distance
    clear = np.abs(inside) > 1e-6 + 2.0 * gap
    assert profile.closed
    assert (np.sign(profile.project(points).distance) == np.sign(inside))[clear].all()


WRONG = [
    ("zx", "plane 'zx', expected one of xy, xz, yz"),
    (((0, 0, 100.0), (0, 0, 1.0)), "section of part 'box': the plane does not cut it"),
    (((0, 0, 0), (0, 0, 0)), "expected a direction"),
    (((0, 0), (0, 1)), "expected (origin, normal)"),
    (((0, 0, 0), (0, 0, 1), (0, 0, 2.0)), "its x is along its normal"),
    (3, "expected (origin, normal)"),
]


@pytest.mark.parametrize("plane, line", WRONG)
def test_wrong_planes_are_one_line(plane, line):
    with pytest.raises(CadError) as error:
        section(part_of(shapes.box(), "box"), plane)
    assert line in str(error.value) and "\n" not in str(error.value)


def test_wrong_points(cuts):
    _, profile = cuts[8]
    with pytest.raises(ValueError, match=r"points must be \(n, 2\)"):
        profile.project(np.zeros((1, 3)))
    assert len(profile.project(np.zeros((0, 2))).distance) == 0
