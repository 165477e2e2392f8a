"""Every kind of face and every trap against OpenCASCADE, and derivatives against differences."""

import numpy as np
import pytest
from OCP.Geom import Geom_OffsetSurface
from OCP.gp import gp_Pnt

from cadlink import faces
from cadlink.gaps import MISSED
from tests.cadlink import shapes
from tests.cadlink.occ_truth import compare, part_of

SHAPES = {**shapes.SOLIDS, **shapes.SHELLS}
KIND_IN = {
    "box": "plane",
    "cylinder": "cylinder",
    "cone": "cone",
    "sphere": "sphere",
    "torus": "torus",
    "revolution": "revolution",
    "extrusion": "extrusion",
    "bspline": "bspline",
    "bezier": "bezier",
    "offset": "offset",
}


@pytest.fixture(scope="module")
def parts():
    """Parts by name, each made once."""

    class Made(dict):
        def __missing__(self, name):
            self[name] = part_of(SHAPES[name](), name)
            return self[name]

    return Made()


@pytest.mark.parametrize("name", SHAPES)
def test_distance_and_side_agree_with_opencascade(parts, name):
    found = compare(parts[name], 120)
    assert not len(found.unexplained), found
    assert not len(found.wrong_side), found
    assert found.away_error <= 1e-9


@pytest.mark.parametrize("name", KIND_IN)
def test_kinds_are_counted_as_the_file_has_them(parts, name):
    assert parts[name].kinds[KIND_IN[name]] >= 1
    assert sum(parts[name].kinds.values()) == parts[name].n_faces


@pytest.mark.parametrize("name", SHAPES)
def test_normal_is_the_gradient_and_curvature_the_hessian(parts, name):
    """grad d = n; hess d = sum k_i / (1 + k_i d) e_i e_i^T, on faces, edges and vertices."""
    part = parts[name]
    surface = part.surface()
    rng = np.random.default_rng(5)
    box = part.bounding_box
    size = np.ptp(box, axis=0)
    points = box[0] - 3.0 + rng.random((300, 3)) * (size + 6.0)
    hit = surface.project(points)
    step = 1e-4
    gradient, hessian = np.zeros((300, 3)), np.zeros((300, 3, 3))
    steady = np.abs(hit.distance) > 0.05
    kind = surface.skin.items["kind"]
    for c in range(3):
        move = np.zeros(3)
        move[c] = step
        after, before = surface.project(points + move), surface.project(points - move)
        gradient[:, c] = (after.distance - before.distance) / (2.0 * step)
        hessian[:, :, c] = (after.normal - before.normal) / (2.0 * step)
        for other in (after, before):
            # Leave out points where the foot passes to another face, edge or sheet between steps.
            steady &= kind[other.seed[:, 0].astype(int)] == kind[hit.seed[:, 0].astype(int)]
            steady &= other.face == hit.face
            # Beyond the free edge of a shell the side, and so the sign, is a matter of taste.
            steady &= np.sign(other.distance) == np.sign(hit.distance)
            steady &= np.linalg.norm(other.point - hit.point, axis=1) < 40.0 * step
    k, d = hit.curvature, hit.distance[:, None]
    across = np.cross(hit.normal, hit.direction)
    expected = np.zeros((300, 3, 3))
    for i, e in enumerate((hit.direction, across)):
        factor = k[:, i] / (1.0 + k[:, i] * d[:, 0])
        expected += factor[:, None, None] * e[:, :, None] * e[:, None, :]
        # Third derivatives grow near the centres of curvature and near edges.
        steady &= (np.abs(1.0 + k[:, i] * d[:, 0]) > 0.3) & (np.abs(factor) < 10.0)
    assert steady.sum() > 100
    assert np.abs(gradient - hit.normal)[steady].max() < 1e-6
    wrong = np.abs(hessian - expected).max(axis=(1, 2))[steady]
    assert wrong.max() < 3e-5
    assert np.allclose(np.linalg.norm(hit.direction, axis=1), 1.0)
    assert np.abs(np.einsum("ij,ij->i", hit.direction, hit.normal)).max() < 1e-9
    assert (k[:, 0] >= k[:, 1]).all()


@pytest.mark.parametrize("name", ["torus part", "cone", "filleted box", "bspline"])
def test_mirrored_part_gives_mirrored_answers(parts, name):
    """Left-handed frames: the mirror image of a point has the same distance and curvatures."""
    twin = part_of(shapes.mirrored(SHAPES[name]()), name).surface()
    surface = parts[name].surface()
    rng = np.random.default_rng(2)
    box = parts[name].bounding_box
    points = box[0] - 2.0 + rng.random((200, 3)) * (np.ptp(box, axis=0) + 4.0)
    image = points * [-1.0, 1.0, 1.0] + [6.0, 0.0, 0.0]
    here, there = surface.project(points), twin.project(image)
    assert np.abs(here.distance - there.distance).max() < 1e-9
    # Feet are unique off the medial axis only.
    same = np.linalg.norm(here.point * [-1, 1, 1] + [6, 0, 0] - there.point, axis=1) < 1e-6
    assert same.mean() > 0.95
    assert np.abs(here.normal * [-1, 1, 1] - there.normal)[same].max() < 1e-6


@pytest.mark.parametrize("name", ["box", "filleted box", "torus part", "bspline", "revolution"])
def test_reversed_solid_still_points_out_of_the_material(parts, name):
    """A solid written inside out is turned round: outside stays positive."""
    inside_out = part_of(SHAPES[name]().Reversed(), name).surface()
    points = np.random.default_rng(4).normal(size=(100, 3)) * 10.0
    a, b = parts[name].surface().project(points), inside_out.project(points)
    assert np.abs(a.distance - b.distance).max() < 1e-12


def test_radii_of_a_torus_and_a_fillet(parts):
    """Smallest convex radius of a torus is its tube; a concave fillet has its own radius."""
    concave, convex = parts["torus"].radii
    assert convex == pytest.approx(4.0)
    assert concave == pytest.approx(8.0)  # inside the ring: 12 - 4
    assert parts["L profile"].smallest_concave_radius == pytest.approx(0.3)
    assert parts["L profile"].smallest_convex_radius == np.inf
    assert parts["filleted box"].smallest_convex_radius == pytest.approx(1.5)
    assert parts["rational torus"].smallest_convex_radius == pytest.approx(4.0, rel=1e-3)


def test_curvatures_of_known_surfaces(parts):
    """Cylinder 1/R and 0, sphere 1/R twice, torus 1/r and cos v/(R + r cos v)."""
    rng = np.random.default_rng(9)
    for name in ("sphere", "rational sphere"):
        hit = parts[name].surface().project(rng.normal(size=(50, 3)) * 9.0)
        assert hit.curvature == pytest.approx(1.0 / 7.0, abs=1e-6)
    for name in ("torus", "rational torus"):
        hit = parts[name].surface().project(rng.normal(size=(50, 3)) * 20.0)
        assert hit.curvature[:, 0] == pytest.approx(1.0 / 4.0, abs=1e-8)
        assert (hit.curvature[:, 1] >= -1.0 / 8.0 - 1e-8).all()
        assert (hit.curvature[:, 1] <= 1.0 / 16.0 + 1e-8).all()


def steep_offset(height, distance=0.5):
    """The offset of a spline one of whose control points stands out: it turns sharply there."""
    surface = shapes.bumpy_surface()
    surface.SetPole(4, 4, gp_Pnt(9.9, 10.8, height))
    return Geom_OffsetSurface(surface, distance)


def furthest(part, surface, n=4000):
    """Largest distance of a part from points of the surface it was made of, as OpenCASCADE evaluates them [mm]."""
    uv = np.random.default_rng(2).random((n, 2))
    points = np.array([[p.X(), p.Y(), p.Z()] for p in (surface.Value(*row) for row in uv)])
    return np.abs(part.surface().project(points).distance).max()


@pytest.mark.parametrize("height", [20.0, 60.0])
def test_an_offset_surface_that_turns_sharply(height):
    """Fitted to 1e-11 of its size, 28 mm, where four halvings all over would not do."""
    surface = steep_offset(height)
    part = part_of(shapes.face_on(surface))
    gaps = part.gap_report()
    assert furthest(part, surface) < 5e-10 and gaps.form < 5e-10 and gaps.remarks() == []


def test_how_far_a_fit_misses_is_told(monkeypatch):
    """Stopped at 64 patches; points of the surface are as far from the part as it says, and no further."""
    monkeypatch.setattr(faces, "MOST_PATCHES", 64)
    surface = steep_offset(20.0)
    part = part_of(shapes.face_on(surface))
    gaps = part.gap_report()
    found = furthest(part, surface)
    assert gaps.form > MISSED and 0.1 * gaps.form < found < 1.5 * gaps.form
    assert gaps.remarks() == [f"a face is met up to {gaps.form:.2g} mm from where it is drawn"]


def test_exact_forms_miss_nothing():
    """Splines are taken as they are; what is swept from conics and splines is rational too."""
    for name in ("bspline", "rational", "extrusion", "revolution", "torus", "filleted box"):
        assert part_of(SHAPES[name]()).gap_report().form < 1e-12, name
