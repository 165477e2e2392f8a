"""A million points round ten CAD files, none with a wrong distance or on a wrong side.

OpenCASCADE takes 0.1 to 20 ms for a point. So all points are held against the triangles of the part, which miss its
faces by their chord: a farther foot, or a wrong side, shows there. OpenCASCADE decides every point that the triangles
cannot: those nearer to the skin than they are, and those where the two differ by more.
"""

import numpy as np
import pytest

from tests.cadlink.occ_truth import compare_at, points_around
from tests.cadlink.test_real_files import NAMES, assemblies  # noqa: F401  a fixture

FILES = [name for name in NAMES if name != "cube-m.step"]  # ten; the three cubes differ in their unit only
POINTS = 1_000_000
CHORD = 2e-4  # of a part's diagonal


def doubted(part, n):
    """Indices of the points that OpenCASCADE must decide, of n points round a part, and the points."""
    surface = part.surface()
    points = points_around(surface, part.bounding_box, n, seed=5)
    hit = surface.project(points)
    # The foot lies as far away as it says.
    assert np.abs(np.linalg.norm(points - hit.point, axis=1) - np.abs(hit.distance)).max() < 1e-9
    chord = CHORD * np.linalg.norm(np.ptp(part.bounding_box, axis=0))
    flat = part.facets(chord, normals="element").project(points).distance
    exact = hit.distance
    if not part.solid:
        flat, exact = np.abs(flat), np.abs(exact)
    return np.flatnonzero((np.abs(exact - flat) > 2.0 * chord) | (np.abs(exact) <= 2.0 * chord)), points


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_no_wrong_distance_and_no_wrong_side(assemblies, name):  # noqa: F811
    parts = list(assemblies[name].values())
    n = -(-POINTS // (len(FILES) * len(parts)))
    asked = missed = 0
    for part in parts:
        doubts, points = doubted(part, n)
        assert len(doubts) < 0.1 * n, f"{part.name}: {len(doubts)} of {n} points differ from the triangles"
        found = compare_at(part, points[doubts])
        asked, missed = asked + len(doubts), missed + found.occ_missed + found.occ_wrong_side
        gaps = part.gap_report()
        assert not len(found.unexplained) and not len(found.wrong_side), found
        assert found.away_error <= 1e-9 and found.near_error <= 1e-9 + max(gaps.edge, gaps.vertex)
    print(f"{name}: {n * len(parts)} points, {asked} asked of OpenCASCADE, which erred at {missed}")
