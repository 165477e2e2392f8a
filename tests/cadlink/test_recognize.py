"""Splines that are planes, cylinders, cones, spheres or tori are met in closed form: as the part before conversion."""

from collections import Counter

import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_OffsetSurface, Geom_ToroidalSurface
from OCP.gp import gp_Ax3

from cadlink import TorusSurface, recognize
from cadlink.brep import part_record
from cadlink.records import PATCHES, PLANE, TORUS
from tests.cadlink import shapes
from tests.cadlink.occ_truth import compare, part_of, points_around

# Left out: what is converted already or freeform, and a wall of 1e-4 mm that tells nothing of its radius.
OTHERS = ("rational", "bspline", "tube", "loft", "revolution", "ellipse", "extrusion", "sliver")
CLOSED = [name for name in shapes.SOLIDS if not any(other in name for other in OTHERS)]


def forms(part):
    return Counter(face.form for face in part.record["skin"]["faces"])


@pytest.fixture(scope="module")
def pairs():
    """(part, the same from its NURBS) by name."""

    class Made(dict):
        def __missing__(self, name):
            shape = shapes.SOLIDS[name]()
            self[name] = part_of(shape, name), part_of(shapes.as_nurbs(shape), name, recognize=True)
            return self[name]

    return Made()


@pytest.mark.parametrize("name", CLOSED)
def test_every_form_comes_back(pairs, name):
    before, after = pairs[name]
    assert forms(after) == forms(before) and PATCHES not in forms(after)
    gaps = [face.gap for face in after.record["skin"]["faces"]]
    assert 0.0 <= max(gaps) < 1e-12


@pytest.mark.parametrize("name", CLOSED)
def test_answers_are_those_of_the_part_before(pairs, name):
    """Trims, seams, poles and mirrored frames included: the same distance, side, normal and curvature everywhere."""
    before, after = (part.surface() for part in pairs[name])
    points = points_around(before, pairs[name][0].bounding_box, 2000, seed=2)
    a, b = before.project(points), after.project(points)
    gaps = [part.gap_report() for part in pairs[name]]
    # Where a trim is fitted (the hole across a cylinder) the edge moves by the file's gap.
    bound = 1e-12 + max(max(g.edge, g.vertex) for g in gaps)
    assert np.abs(a.distance - b.distance).max() <= max(bound, 1e-12 * np.abs(points).max())
    same = np.linalg.norm(a.point - b.point, axis=1) < 1e-6
    assert same.mean() > 0.99
    off_edges = same & (np.abs(a.curvature) < 1e11).all(axis=1) & (np.abs(b.curvature) < 1e11).all(axis=1)
    assert np.abs(a.normal - b.normal)[off_edges & (np.abs(a.distance) > 1e-3)].max() < 1e-9
    assert np.abs(a.curvature - b.curvature)[off_edges].max() < 1e-7


@pytest.mark.parametrize("name", ["cross hole", "filleted box", "mirrored torus", "sphere", "apex"])
def test_distance_and_side_agree_with_opencascade(pairs, name):
    """OpenCASCADE is asked on the splines themselves."""
    found = compare(pairs[name][1], 60)
    assert not len(found.unexplained) and not len(found.wrong_side) and found.away_error <= 1e-9


SPANS = 60  # narrower than the 16 steps of the grid that looks first


def flat_spline(bump):
    """A plane of 60 x 60 biquadratic spans as a B-spline, with one control point raised by a bump [mm]."""
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt
    from OCP.TColgp import TColgp_Array2OfPnt
    from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal

    n = SPANS + 2
    poles = TColgp_Array2OfPnt(1, n, 1, n)
    knots, multiplicities = TColStd_Array1OfReal(1, SPANS + 1), TColStd_Array1OfInteger(1, SPANS + 1)
    for k in range(SPANS + 1):
        knots.SetValue(k + 1, k / SPANS)
        multiplicities.SetValue(k + 1, 3 if k in (0, SPANS) else 1)
    flat = [0.5 * sum(min(1.0, max(0.0, (i - 1 + j) / SPANS)) for j in range(2)) for i in range(n)]  # Greville
    for i in range(n):
        for j in range(n):
            # Its basis function lives on 0.5 .. 0.55, between two lines of the grid.
            poles.SetValue(i + 1, j + 1, gp_Pnt(100.0 * flat[i], 80.0 * flat[j], bump if i == j == 32 else 0.0))
    surface = Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 2, 2)
    return BRepBuilderAPI_MakeFace(surface, 1e-7).Face()


def test_a_bump_between_the_points_of_the_grid_is_seen(monkeypatch):
    (face,) = part_record(flat_spline(1e-4))["skin"]["faces"]
    assert face.form == PATCHES and face.gap == 0.0
    monkeypatch.setattr(recognize, "miss_of_spans", lambda *_: 0.0)
    (face,) = part_record(flat_spline(1e-4))["skin"]["faces"]
    assert face.form == PLANE  # the grid alone does not see it


def test_the_gap_is_stated():
    """4e-8 mm in 128: a plane, said to miss by the height of the bump, 9/16 of the control point's."""
    (face,) = part_record(flat_spline(4e-8))["skin"]["faces"]
    assert face.form == PLANE
    assert face.gap == pytest.approx(4e-8 * 9.0 / 16.0, rel=1e-3)


def offset_torus():
    """0.5 mm out of a torus of radii 12 and 3: one of 12 and 3.5."""
    torus = Geom_ToroidalSurface(gp_Ax3(shapes.TILTED), 12.0, 3.0)
    return BRepBuilderAPI_MakeFace(Geom_OffsetSurface(torus, 0.5), 0.1, 2.5, 0.3, 3.0, 1e-7).Face()


def test_an_offset_surface_that_is_a_torus():
    """The file calls it an offset; its distance is the torus' to round-off."""
    shape = offset_torus()
    (face,) = part_record(shape)["skin"]["faces"]
    assert face.form == TORUS and face.kind == "offset" and face.size == pytest.approx([12.0, 3.5], abs=1e-10)
    part = part_of(shape, recognize=True)
    found = compare(part, 100)
    assert not len(found.unexplained) and found.away_error <= 1e-9
    closed = TorusSurface(12.0, 3.5, (1.0, -2.0, 0.5), (1.0, 2.0, 3.0))
    hit = part.surface().project(np.random.default_rng(0).normal(size=(500, 3)) * 12.0)
    inside = (np.abs(hit.curvature) < 1e9).all(axis=1)
    points = hit.point + hit.distance[:, None] * hit.normal
    off = np.abs(np.abs(closed.project(points).distance) - np.abs(hit.distance))
    assert inside.sum() > 100 and np.median(off[inside]) < 1e-12


def test_switched_off_a_spline_stays_a_spline():
    shape = shapes.as_nurbs(shapes.torus())
    (kept,) = part_record(shape, recognize=False)["skin"]["faces"]
    (found,) = part_record(shape)["skin"]["faces"]
    assert kept.form == PATCHES and found.form != PATCHES
    assert kept.kind == found.kind == "bspline"  # what the file calls it
