"""The error budget of contact: zero on exact faces, the tilt of an interpolated normal, edges and corners counted."""

import numpy as np
import pytest

from solver.contact.budget import ContactBudget
from solver.state import new_contact
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of


def budget_of(surface, points, touching):
    contact = new_contact(len(points), 3)
    contact.status[:] = touching
    budget = ContactBudget()
    budget.add([(points, surface.project(points), contact)])
    return budget, contact


def test_exact_faces_have_no_error_and_edges_are_counted():
    surface = part_of(shapes.box()).surface()
    points = np.array([[0.0, 0.0, 4.5], [3.0, 2.0, 4.4], [10.3, 0.0, 4.4], [10.3, 7.3, 4.4], [10.4, 0.0, 4.3]])
    budget, _ = budget_of(surface, points, [1, 2, 1, 1, 0])
    assert budget.figures() == {"foot_error": pytest.approx(0.0, abs=1e-12), "sharp_nodes": 2, "several_feet": 0}


def test_a_tilted_normal_is_an_error_of_its_tilt_times_the_distance():
    """Nodal normals 1 mm beside the facets' edge: the foot is exact, the normal is not."""
    surface = part_of(shapes.upright_cylinder()).facets(0.3, normals="nodal")
    exact = part_of(shapes.upright_cylinder()).surface()
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    points = np.column_stack([6.5 * np.cos(angle), 6.5 * np.sin(angle), np.full(200, 6.0)])
    hit = surface.project(points)
    away = points - hit.point
    flat = away / np.linalg.norm(away, axis=1)[:, None]
    tilt = np.linalg.norm(np.cross(flat, hit.normal), axis=1) * hit.distance
    assert budget_of(surface, points, 1)[0].foot_error == pytest.approx(tilt.max(), rel=0.05)
    assert budget_of(surface, points, 1)[0].foot_error > 0.01
    assert budget_of(exact, points, 1)[0].foot_error < 1e-12


def test_the_worst_frame_counts():
    surface = part_of(shapes.l_profile_sharp()).surface()
    points = np.array([[2.5, 3.0, 2.5], [2.5, 4.0, 2.5], [5.0, 3.0, 2.5]])
    budget, contact = budget_of(surface, points, [1, 1, 1])
    assert budget.several_feet == 0
    contact.further[0].status[:] = [1, 2, 0]
    budget.add([(points, surface.project(points), contact)])
    contact.release()
    budget.add([(points, surface.project(points), contact)])
    assert budget.several_feet == 2
