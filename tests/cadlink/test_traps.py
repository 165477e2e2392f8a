"""The traps that closest points on CAD faces are known for, one test each, against OpenCASCADE or by formula."""

import numpy as np
import pytest

from cadlink import read_step
from tests.cadlink import shapes
from tests.cadlink.occ_truth import compare, distances, part_of
from tests.cadlink.test_step import write_assembly, write_plain


def holds(shape, n=60):
    """Whether distance and side agree with OpenCASCADE round a shape."""
    part = part_of(shape)
    found = compare(part, n)
    return not len(found.unexplained) and not len(found.wrong_side) and found.away_error <= 1e-9


def path_over(surface, start, end, n=400):
    """Distances along a straight path, each search seeded by the one before."""
    found, seed = [], None
    for s in np.linspace(0.0, 1.0, n):
        hit = surface.project((start + s * (end - start))[None], seed)
        found.append(hit.distance[0])
        seed = hit.seed
    return np.array(found)


def test_medial_axis_of_a_cylinder_and_a_torus():
    """On the axis, and on the spine: every direction is as near; on a path across, the foot jumps, d does not."""
    cylinder, torus = part_of(shapes.upright_cylinder()).surface(), part_of(shapes.torus()).surface()
    assert cylinder.project(np.array([[0.0, 0.0, 6.0]])).distance == pytest.approx([-6.0])
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    x = np.cross(axis, [0.0, 0.0, 1.0])
    spine = np.array([1.0, -2.0, 0.5]) + 12.0 * x / np.linalg.norm(x)
    assert torus.project(spine[None]).distance == pytest.approx([-4.0])
    d = path_over(cylinder, np.array([-3.0, 0.1, 6.0]), np.array([3.0, -0.1, 6.0]))
    assert np.abs(np.diff(d)).max() <= np.linalg.norm([6.0, 0.2]) / 399 + 1e-12 and d.min() < -5.99


def test_foot_jumps_over_a_nurbs_valley():
    """A path over a valley of a B-spline: the foot changes sides, the distance stays OpenCASCADE's."""
    shape = shapes.face_on(shapes.bumpy_surface())
    surface = part_of(shape).surface()
    start, end = np.array([1.0, 9.0, 6.0]), np.array([19.0, 11.0, 6.0])
    d = path_over(surface, start, end, 60)
    points = start + np.linspace(0.0, 1.0, 60)[:, None] * (end - start)
    assert np.abs(d) == pytest.approx(distances(shape, points)[0], abs=1e-9)


def test_seam_of_a_full_cylinder_with_a_cross_hole():
    assert holds(shapes.cylinder_with_cross_hole())


@pytest.mark.parametrize("shape", ["sphere", "rational sphere", "apex", "rational cone"])
def test_poles(shape):
    assert holds(shapes.SOLIDS[shape]())


def test_feet_beside_a_pole_of_a_patch():
    """The apex of a NURBS cone is a side of its patches; feet near it lie in a narrow sector, away from any start."""
    spline, closed = part_of(shapes.as_nurbs(shapes.cone_with_apex())), part_of(shapes.cone_with_apex())
    vertices = spline.surface().skin.vertices["point"]
    apex = vertices[np.argmax(vertices[:, 2])]
    rng = np.random.default_rng(0)
    points = apex + rng.normal(size=(20000, 3)) * 10.0 ** rng.uniform(-3.0, 1.0, (20000, 1))
    a, b = spline.surface().project(points), closed.surface().project(points)
    assert np.abs(np.abs(a.distance) - np.abs(b.distance)).max() < 1e-9


OVER_THE_SIDE = [
    (shapes.bent_tube, [0.890576, -3.014136, 2.545854]),
    (shapes.round_to_square, [13.614268, -13.59141, 14.311857]),
    (shapes.round_to_square, [-10.956803, 13.619471, 14.374624]),
    (shapes.round_to_square, [12.5193, 11.888909, 13.290956]),
]


@pytest.mark.parametrize("make, p", OVER_THE_SIDE)
def test_a_foot_far_along_a_side_and_a_little_inside_it(make, p):
    """From a corner of a leaf the Newton step points a little over one side and far along it; the foot is inside."""
    shape, points = make(), np.array([p])
    hit = part_of(shape).surface().project(points)
    assert np.abs(hit.distance) == pytest.approx(distances(shape, points)[0], abs=1e-9)


@pytest.mark.parametrize("shape", [shapes.torus_part, shapes.cone, shapes.filleted_box])
def test_orientation_of_mirrored_and_reversed_solids(shape):
    assert holds(shapes.mirrored(shape())) and holds(shape().Reversed(), 30)


def test_sliver_boss():
    """The wall is 1e-4 mm high, and is met."""
    surface = part_of(shapes.boss_sliver()).surface()
    hit = surface.project(np.array([[14.0 + 1e-3, 10.0, 2.00005]]))
    assert hit.distance == pytest.approx([5e-5], rel=1e-6)  # the plate below is nearer than the wall
    assert holds(shapes.boss_sliver())


def test_c0_nurbs():
    assert holds(shapes.creased_face())


def test_gap_between_sewn_planes():
    part = part_of(shapes.box_sewn_with_a_gap())
    hit = part.surface().project(np.array([[0.0, 0.0, 5.0], [12.0, 0.0, 4.0001], [10.0005, 7.0, 4.2]]))
    assert hit.distance[:2] == pytest.approx([1.0 - 5e-4, 2.0], abs=1e-6) and (hit.distance > 0.0).all()


def test_concave_radius_under_half_the_thickness():
    """Sheet 1.0 thick in a corner of radius 0.3: its middle plane touches both legs, and both feet are reachable."""
    part = part_of(shapes.l_profile(0.3))
    assert part.gap_report(thickness=1.0).too_tight
    surface, middle = part.surface(), np.array([[2.5, 3.0, 2.5]])
    left, below = (surface.project(middle - step) for step in ([[0.01, 0, 0]], [[0, 0, 0.01]]))
    feet = [surface.project(middle, hit.seed).normal[0] for hit in (left, below)]
    assert feet == [pytest.approx([1.0, 0, 0]), pytest.approx([0, 0, 1.0])]


@pytest.mark.parametrize("unit", ["MM", "INCH", "M", "FT"])
def test_units(tmp_path, unit):
    (part,) = read_step(write_plain(shapes.box(), tmp_path / "box.step", unit)).values()
    assert np.ptp(part.bounding_box, axis=0) == pytest.approx([20.0, 14.0, 8.0], abs=1e-9)


def test_names_of_nested_products(tmp_path):
    """The instance label is an id: parts are called by their products, and know the products above them."""
    assembly = read_step(write_assembly(tmp_path / "stack.step"))
    assert {name: part.tree for name, part in assembly.items()} == {
        "bolt": ("stack", "pair", "bolt"),
        "bolt-2": ("stack", "pair", "bolt"),
        "plate": ("stack", "plate"),
    }


def test_solids_without_names(tmp_path):
    """Two nameless solids in one product are told apart."""
    from tests.cadlink.test_reading import moved, one_product

    path = one_product(tmp_path / "two.step", shapes.box(), moved(shapes.box(), 30.0, 0.0, 0.0))
    parts = read_step(path)
    assert len(parts) == 2 and len(set(parts)) == 2


def test_weights_of_a_nurbs_circle():
    """Rational in u though the surface says it is not: a torus as NURBS has its radii."""
    hit = (
        part_of(shapes.as_nurbs(shapes.torus())).surface().project(np.random.default_rng(0).normal(size=(40, 3)) * 15.0)
    )
    # The foot is known to about 1e-7 mm, and the curvature of the patch changes by as much.
    assert hit.curvature[:, 0] == pytest.approx(0.25, abs=1e-7)
