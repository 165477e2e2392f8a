"""The quick search against the careful one, which asks every leaf that may hold the foot from several starts, and both
against the roots of a polynomial."""

from math import comb
from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numpy.polynomial import Polynomial

from cadlink import read_step
from cadlink.closest import PLACE, careful_search
from cadlink.nurbs import WORK
from cadlink.quick import WAITING
from cadlink.surface import project
from cadlink.track import ANSWER
from tests.cadlink import shapes
from tests.cadlink.occ_truth import distances, part_of, points_around

BODIES = {
    "tube": shapes.bent_tube,
    "narrow tube": lambda: shapes.bent_tube(((0, 0, 0), (7, 0, 3), (16, 0, 4), (30, 0, 10)), 1.0),
    "loft": shapes.round_to_square,
    "wide loft": lambda: shapes.round_to_square(11.5, 8.5, 14.0, 11.0),
    "bumpy": shapes.bumpy_solid,
    "rational": lambda: shapes.bumpy_solid(True, seed=3),
    "punch": lambda: shapes.as_nurbs(shapes.punch()),
    "revolution": shapes.revolution,
}
WALK = (0.0, 0.05, 0.05, 0.3, 1.0, 0.05, 0.002)  # mm


@njit
def careful_distances(skin, points):
    """Signed distances (n,) of points (n, 3) by the careful search alone, without hints."""
    found, entries, bounds = np.empty(len(points)), np.zeros(8 * WAITING, np.int64), np.zeros(8 * WAITING)
    work, out = np.zeros(WORK), np.zeros(ANSWER)
    for i in range(len(points)):
        p = (points[i, 0], points[i, 1], points[i, 2])
        careful_search(skin, p, -1, -1.0, -1.0, entries, bounds, work, out)
        found[i] = out[0]
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_quick_and_tracked_answers_are_the_careful_ones(name):
    """20,000 points and where they have walked, answered with and without seeds: distance and side."""
    part = part_of(BODIES[name](), name)
    surface, rng = part.surface(), np.random.default_rng(1)
    points, hit = points_around(surface, part.bounding_box, 20_000), None
    gaps = part.gap_report()
    room = 1e-9 + max(gaps.edge, gaps.vertex)
    ahead = rng.normal(size=points.shape)
    for size in WALK:
        points = points + size * (ahead + 0.5 * rng.normal(size=points.shape))
        cold, hit = surface.project(points), surface.project(points, None if hit is None else hit.seed)
        careful = careful_distances(surface.skin, points)
        clear = np.abs(careful) > room
        for found in (cold, hit):
            assert np.abs(np.abs(found.distance) - np.abs(careful)).max() < room
            assert (np.sign(found.distance) == np.sign(careful))[clear].all()


@pytest.mark.parametrize("made", [shapes.punch, BODIES["punch"]], ids=["closed forms", "patches"])
def test_a_cell_answers_for_points_in_its_reach_what_a_search_finds(made):
    part = part_of(made(), "punch")
    surface = part.surface()
    points = points_around(surface, part.bounding_box, 20_000)
    found = surface.project(points)
    by_cell = (found.seed[:, PLACE : PLACE + 3] != points).any(axis=1)
    assert by_cell.mean() > 0.1
    blind = surface.hints._replace(seed=surface.hints.seed * [1.0, 1.0, 1.0, 0.0])
    searched = project(surface.skin, blind, surface.stamp, points, np.zeros_like(found.seed))
    assert (searched.seed[:, PLACE : PLACE + 3] == points).all()
    assert np.abs(found.distance - searched.distance).max() < 1e-12
    assert np.abs(found.point - searched.point).max() < 1e-9
    assert np.abs(found.normal - searched.normal).max() < 1e-9


def bezier(poles):
    """A coordinate of a Bezier curve as a polynomial."""
    n, t, u = len(poles) - 1, Polynomial([0, 1]), Polynomial([1, -1])
    return sum(pole * comb(n, i) * t**i * u ** (n - i) for i, pole in enumerate(poles))


@pytest.mark.parametrize("seed", range(4))
def test_over_a_valley_the_nearest_of_several_feet_is_found(seed):
    # Points on both sides of the curve's centre of curvature, where the distance has two minima.
    rng = np.random.default_rng(seed)
    poles = (
        np.array([0, 4, 8, 12, 16, 20]) + rng.uniform(-1, 1, 6),
        np.array([12, 4, -3, -4, 2, 14]) + rng.uniform(-3, 3, 6),
    )
    x, z = (bezier(p) for p in poles)
    t = np.linspace(0.15, 0.85, 400)
    tangent, second = np.array([x.deriv()(t), z.deriv()(t)]), np.array([x.deriv(2)(t), z.deriv(2)(t)])
    bend = (tangent[0] * second[1] - tangent[1] * second[0]) / (tangent**2).sum(axis=0) ** 1.5
    at = np.argmax(bend)
    normal, radius = np.array([-tangent[1, at], tangent[0, at]]) / np.linalg.norm(tangent[:, at]), 1.0 / bend[at]
    above = rng.uniform(0.8, 3.0, 1500)[:, None] * radius * normal + 0.15 * radius * rng.normal(size=(1500, 2))
    points = np.array([x(t[at]), z(t[at])]) + above

    def nearest(px, pz):
        feet = ((x - px) * x.deriv() + (z - pz) * z.deriv()).roots()
        feet = feet[np.abs(feet.imag) < 1e-7].real
        feet = np.concatenate([feet[(feet >= 0.0) & (feet <= 1.0)], [0.0, 1.0]])
        return np.hypot(x(feet) - px, z(feet) - pz).min()

    surface = part_of(shapes.valley(np.transpose(poles)), "valley").surface()
    found = surface.project(np.column_stack([points[:, 0], rng.uniform(3.0, 27.0, 1500), points[:, 1]]))
    assert np.abs(np.abs(found.distance) - [nearest(*point) for point in points]).max() < 2e-13


def test_a_leaf_that_bends_near_its_end_has_a_foot_beyond():
    # Curvature is largest at four fifths of a leaf of the nacelle: two feet, 1.90954 and 1.91040 mm away.
    path = Path(__file__).resolve().parents[3] / "shared" / "step" / "nacelle.stp"
    if not path.exists():
        pytest.skip("shared/step/nacelle.stp is not there")
    part = next(iter(read_step(path).values()))
    point = np.array([[2337.25349, -295.95794064, -335.21428123]])
    found = part.surface().project(point)
    assert abs(found.distance[0]) == pytest.approx(distances(part.shape(), point)[0], abs=1e-9)
