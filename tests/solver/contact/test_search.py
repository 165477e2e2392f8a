import numpy as np
import pytest

from solver.contact.search import Neighbourhood
from tests.solver.lattice import Ball


def test_skipping_far_nodes_never_loses_a_contact():
    ball = Ball((0.0, 0.0, 0.0), 5.0)
    rng = np.random.default_rng(0)
    points = rng.uniform(-20.0, 20.0, (500, 3))
    search = Neighbourhood(ball, len(points))
    reach = np.full(len(points), 0.5)
    for _ in range(60):
        points += rng.normal(0.0, 0.3, points.shape)
        near, hit = search.project(points, reach)
        distance = np.linalg.norm(points, axis=1) - 5.0
        assert set(np.flatnonzero(distance <= 0.5)) <= set(near)
        assert hit.distance == pytest.approx(distance[near])
        assert (search.distance - np.linalg.norm(points - search.place, axis=1) <= distance + 1e-12).all()
    assert search.n_projected < 0.5 * search.n_asked
