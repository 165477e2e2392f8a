"""The quick search against the careful one, which asks every leaf that may hold the foot from several starts."""

import numpy as np
import pytest
from numba import njit

from cadlink.closest import PLACE, careful_search
from cadlink.nurbs import WORK
from cadlink.quick import WAITING
from cadlink.surface import project
from cadlink.track import ANSWER
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of, points_around

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
