"""Warm projection from the osculating cubic at an earlier foot: against cold searches, formulas and differences."""

import numpy as np
import pytest

from cadlink import read_step
from cadlink.closest import COLUMNS, REACH
from cadlink.osculating import CALM, CUBIC, DIRECTION, FOOT, NORMAL
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of
from tests.cadlink.test_projection_properties import BODIES, points_round
from tests.cadlink.test_real_files import SHARED

STEPS, EVERY = 1000, 50


def walk(part, points, size, rng):
    """Random steps of one length, held against cold searches: d 2e-12 mm, foot 1e-7 mm, normal, faces."""
    surface = part.surface()
    hit = surface.project(points)
    for step in range(1, STEPS + 1):
        way = rng.normal(size=points.shape)
        points = points + size * way / np.linalg.norm(way, axis=1)[:, None]
        hit = surface.project(points, hit.seed)
        if step % EVERY:
            continue
        cold = surface.project(points)
        assert np.abs(np.abs(cold.distance) - np.abs(hit.distance)).max() < 2e-12
        # Two equally near feet excuse another one; next to a centre of curvature a foot is not that well known.
        apart = np.linalg.norm(cold.point - hit.point, axis=1)
        known = (1.0 + cold.curvature * cold.distance[:, None]).min(axis=1) > 0.05
        same = known & (apart < 1e-3)
        assert (known & ~same).mean() < 0.02
        assert apart[same].max(initial=0.0) < 1e-7
        off = same & (np.abs(cold.distance) > 1e-6)
        assert np.abs(cold.normal - hit.normal)[off].max(initial=0.0) < 1e-6
        assert np.abs(np.linalg.norm(hit.normal, axis=1) - 1.0).max() < 1e-9
        assert np.abs(np.linalg.norm(hit.direction, axis=1) - 1.0)[same].max(initial=0.0) < 1e-6
        # Faces may differ on an edge only, where both hold the foot.
        other = same & (cold.face != hit.face)
        assert np.abs(surface.project(hit.point[other]).distance).max(initial=0.0) < 1e-7
        assert other.mean() < 0.02


@pytest.mark.parametrize("nurbs", [False, True], ids=["as drawn", "nurbs"])
@pytest.mark.parametrize("kind", sorted(BODIES))
@pytest.mark.parametrize("size", [1e-3, 2e-2])
def test_long_walks_equal_cold_searches(kind, nurbs, size):
    shape = BODIES[kind](0.5, 0.5)
    part = part_of(shapes.as_nurbs(shape) if nurbs else shape, kind)
    rng = np.random.default_rng(3)
    walk(part, points_round(part, 60, rng), size, rng)


@pytest.mark.parametrize("size", [1e-3, 2e-2])
def test_long_walks_on_a_real_part(size):
    path = SHARED / "nacelle.stp"
    if not path.exists():
        pytest.skip(f"needs {path}")
    part = next(iter(read_step(path).values()))
    rng = np.random.default_rng(4)
    box = part.bounding_box
    points = part.surface().project(box[0] + rng.random((100, 3)) * np.ptp(box, axis=0))
    walk(part, points.point + 2.0 * rng.uniform(-1.0, 1.0, (100, 1)) * points.normal, size, rng)


@pytest.fixture(scope="module")
def torus():
    """Radii 12 and 4 round the z axis, as rational patches."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    return part_of(shapes.as_nurbs(BRepPrimAPI_MakeTorus(12.0, 4.0).Solid()), "torus")


def near_torus(n):
    rng = np.random.default_rng(5)
    u, v = rng.uniform(0.0, 2.0 * np.pi, n), rng.uniform(0.0, 2.0 * np.pi, n)
    m = 4.0 + rng.uniform(-2.0, 2.0, n)
    return np.column_stack([(12.0 + m * np.cos(v)) * np.cos(u), (12.0 + m * np.cos(v)) * np.sin(u), m * np.sin(v)])


def test_within_the_calm_radius_nothing_is_evaluated(torus):
    """The seed comes back as it was, and distance, foot and curvature are those of the torus' formulas."""
    surface, points = torus.surface(), near_torus(2000)
    hit = surface.project(points)
    calm = hit.seed[:, COLUMNS + CALM]
    assert np.median(calm) > 1e-3  # a micrometre at least, on a tube of radius 4
    way = np.random.default_rng(6).normal(size=points.shape)
    way /= np.linalg.norm(way, axis=1)[:, None]
    # Half of it: the foot of a point inside the tube moves up to twice as far as the point.
    points = points + 0.49 * calm[:, None] * way
    hit, before = surface.project(points, hit.seed), hit
    # But for those few of which a search could not tell how far they may go.
    served = (calm > 0.0) & (before.seed[:, REACH] > 0.0)
    assert (hit.seed == before.seed)[served].all() and served.mean() > 0.99 * np.mean(calm > 0.0)
    rho = np.hypot(points[:, 0], points[:, 1])
    m = np.hypot(rho - 12.0, points[:, 2])
    cosine, sine = (rho - 12.0) / m, points[:, 2] / m
    radial = points[:, :2] / rho[:, None]
    foot = np.column_stack([radial * (12.0 + 4.0 * cosine)[:, None], 4.0 * sine])
    assert np.abs(hit.distance - (m - 4.0)).max() < 1e-12
    assert np.abs(hit.point - foot).max() < 1e-7
    normal = np.column_stack([radial * cosine[:, None], sine])
    assert np.abs(hit.normal - normal).max() < 1e-7
    assert np.abs(hit.curvature[:, 0] - 0.25).max() < 1e-5
    assert np.abs(hit.curvature[:, 1] - cosine / (12.0 + 4.0 * cosine)).max() < 1e-5


def test_cubic_form_is_the_derivative_of_the_curvature(torus):
    """C along a direction: central differences of the height of the surface over its tangent plane."""
    surface, points = torus.surface(), near_torus(300)
    hit = surface.project(points)
    model = hit.seed[:, COLUMNS:]
    q, n, e = model[:, FOOT : FOOT + 3], model[:, NORMAL : NORMAL + 3], model[:, DIRECTION : DIRECTION + 3]
    f, c, h = np.cross(n, e), model[:, CUBIC : CUBIC + 4], 0.02
    for angle in (0.0, 0.7, 1.5708, 2.4):
        x, y = np.cos(angle), np.sin(angle)
        way = x * e + y * f
        # Height by sliding down the normal: a few steps of the distance itself.
        height = []
        for side in (-1.0, 1.0):
            at = q + side * h * way
            z = np.zeros(len(q))
            for _ in range(20):
                found = surface.project(at + z[:, None] * n)
                z -= found.distance / np.einsum("ij,ij->i", found.normal, n)
            height.append(z)
        third = -(height[1] - height[0]) / (2.0 * h**3) * 6.0
        expected = c[:, 0] * x**3 + 3.0 * c[:, 1] * x**2 * y + 3.0 * c[:, 2] * x * y**2 + c[:, 3] * y**3
        kept = model[:, CALM] > 0.0
        assert kept.mean() > 0.9
        assert np.abs(third - expected)[kept].max() < 1e-4
