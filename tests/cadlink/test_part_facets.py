"""A part as facets at a chord tolerance against its exact surface."""

import numpy as np
import pytest

from cadlink import CadError, FacetSurface, read_step
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of, points_around
from tests.cadlink.test_step import SHARED, needs_shared

SOLIDS = {
    "fillets": shapes.filleted_box,
    "torus": shapes.torus,
    "bspline": shapes.bumpy_solid,
    "apex": shapes.cone_with_apex,
}


@pytest.fixture(scope="module")
def parts():
    return {name: part_of(make(), name) for name, make in SOLIDS.items()}


@pytest.mark.parametrize("name", SOLIDS)
def test_flat_facets_stay_within_the_chord(parts, name):
    part = parts[name]
    exact, facets = part.surface(), part.facets(0.02, normals="element")
    points = points_around(exact, part.bounding_box, 600)
    a, b = exact.project(points), facets.project(points)
    assert facets.closed and np.abs(a.distance - b.distance).max() <= 1.5 * 0.02  # OpenCASCADE's own measure is loose
    clear = np.abs(a.distance) > 0.05
    assert (np.sign(a.distance) == np.sign(b.distance))[clear].all()


@pytest.mark.parametrize("name", ["fillets", "torus", "bspline"])
def test_nagata_patches_are_nearer_than_facets(parts, name):
    """With the exact corner normals: five times nearer, and normals ten times better near the skin.

    On the B-spline body thin facets between hole and rim would fold over; they stay flat, which costs some of it.
    """
    part = parts[name]
    exact = part.surface()
    flat, curved = part.facets(0.05, normals="element"), part.facets(0.05, normals="nagata")
    points = points_around(exact, part.bounding_box, 800)
    a = exact.project(points)
    near = (np.abs(a.distance) < 0.5) & (np.abs(a.curvature) < 1e6).all(axis=1)
    b, c = flat.project(points), curved.project(points)
    off = [np.abs(hit.distance - a.distance)[near].max() for hit in (b, c)]
    turn = [np.median(np.linalg.norm(hit.normal - a.normal, axis=1)[near]) for hit in (b, c)]
    assert off[1] < (0.5 if name == "bspline" else 0.2) * off[0] and turn[1] <= 0.1 * turn[0] + 1e-9


def test_nodal_normals_do_not_leak_over_sharp_edges(parts):
    """Near the rim of a cone's base normals stay those of base and side."""
    facets = parts["apex"].facets(0.01, normals="nodal")
    exact = parts["apex"].surface()
    points = points_around(exact, parts["apex"].bounding_box, 600)
    a, b = exact.project(points), facets.project(points)
    on_face = (
        (np.abs(a.curvature) < 1.0).all(axis=1) & (np.abs(a.distance) < 0.5) & (np.abs(b.curvature) < 1.0).all(axis=1)
    )
    assert np.median((a.normal * b.normal).sum(axis=1)[on_face]) > np.cos(np.radians(0.5))


def test_face_is_that_of_the_part_and_faces_can_be_picked(parts):
    part = parts["fillets"]
    exact, facets = part.surface(), part.facets(0.02)
    points = points_around(exact, part.bounding_box, 300)
    a, b = exact.project(points), facets.project(points)
    assert (a.face == b.face).mean() > 0.95
    top = max(part.planes, key=lambda plane: plane.normal[2]).face
    one = part.facets(0.02, faces=[top])
    assert not one.closed and set(one.project(points).face) == {top}


@needs_shared
def test_thin_facets_of_a_coarse_mesh_do_not_fold():
    """A rod of 5 mm at a chord of 0.1: long thin triangles between small rounds keep their side."""
    (part,) = read_step(SHARED / "linkrods.step").values()
    exact, facets = part.surface(), part.facets(0.1, normals="nagata")
    points = points_around(exact, part.bounding_box, 3000, seed=1)
    a, b = exact.project(points), facets.project(points)
    assert np.abs(a.distance - b.distance).max() < 0.03


def test_wrong_chords_are_one_line(parts):
    with pytest.raises(CadError, match="part 'torus': chord 0, expected a length in mm above 0"):
        parts["torus"].facets(0)
    with pytest.raises(CadError, match="angle 100, expected degrees"):
        parts["torus"].facets(0.1, angle=100)
    with pytest.raises(CadError, match="normals 'round', expected one of"):
        parts["torus"].facets(0.1, normals="round")


@pytest.mark.parametrize("chord", [0.2, 0.05])
def test_how_far_facets_miss_the_faces(chord):
    """A ball of radius 8: flat triangles of a chord miss it by that, as its formula says of all their points."""
    part = part_of(shapes.sphere())
    centre = part.bounding_box.mean(axis=0)
    radius = 0.5 * np.ptp(part.bounding_box[:, 0])
    facets = part.facets(chord, normals="element")
    points, cells = facets.triangles()
    weights = np.random.default_rng(1).dirichlet(np.ones(3), 400)
    inside = np.einsum("wk,tkc->twc", weights, points[cells]).reshape(-1, 3)
    sag = radius - np.linalg.norm(inside - centre, axis=1).min()
    assert facets.misfit() == pytest.approx(sag, rel=0.1) and facets.misfit() < 1.5 * chord
    assert part.facets(chord, normals="nagata").misfit() < 0.1 * facets.misfit()
    assert part.surface(offset=0.1).misfit() == 0.0


def test_facets_of_no_part_miss_nothing():
    assert FacetSurface([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).misfit() == 0.0
