"""Primitives without a file against OpenCASCADE's own shapes, closed forms, and differences."""

import numpy as np
import pytest
from numba.np.numpy_support import from_dtype
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

from cadlink import CadError, ConeSurface, CylinderSurface, PlaneSurface, SphereSurface, TorusSurface
from cadlink.primitive_surfaces import FORM
from cadlink.skin import FACE
from tests.cadlink.occ_truth import distances, sides

AT, AXIS = (1.0, -2.0, 0.5), (1.0, 2.0, 3.0)
UNIT = np.array(AXIS) / np.sqrt(14.0)
LOW = gp_Ax2(gp_Pnt(*(np.array(AT) - 100.0 * UNIT)), gp_Dir(*AXIS))
HERE = gp_Ax2(gp_Pnt(*AT), gp_Dir(*AXIS))
SURFACES = {
    "cylinder": (CylinderSurface(8.0, AT, AXIS), lambda: BRepPrimAPI_MakeCylinder(LOW, 8.0, 200.0).Solid()),
    "sphere": (SphereSurface(7.0, AT), lambda: BRepPrimAPI_MakeSphere(HERE, 7.0).Solid()),
    "cone": (
        ConeSurface(30.0, AT, AXIS),
        lambda: BRepPrimAPI_MakeCone(HERE, 0.0, 100.0 * np.tan(np.pi / 6.0), 100.0).Solid(),
    ),
    "torus": (TorusSurface(12.0, 4.0, AT, AXIS), lambda: BRepPrimAPI_MakeTorus(HERE, 12.0, 4.0).Solid()),
}
POINTS = np.array(AT) + np.random.default_rng(0).normal(size=(300, 3)) * 8.0


@pytest.mark.parametrize("name", SURFACES)
def test_distance_and_side_agree_with_opencascade(name):
    surface, shape = SURFACES[name]
    solid = shape()
    hit = surface.project(POINTS)
    assert np.abs(hit.distance) == pytest.approx(distances(solid, POINTS)[0], abs=1e-9)
    assert (np.sign(hit.distance) == sides(solid, POINTS)).all()
    assert np.linalg.norm(hit.point - POINTS, axis=1) == pytest.approx(np.abs(hit.distance), abs=1e-12)


def test_plane():
    hit = PlaneSurface(AT, AXIS).project(POINTS)
    assert hit.distance == pytest.approx((POINTS - AT) @ UNIT, abs=1e-12)
    assert hit.normal == pytest.approx(np.tile(UNIT, (300, 1))) and (hit.curvature == 0.0).all()


@pytest.mark.parametrize("name", SURFACES)
def test_normal_is_the_gradient_and_curvature_the_hessian(name):
    surface = SURFACES[name][0]
    hit = surface.project(POINTS)
    step, gradient, hessian = 1e-4, np.zeros((300, 3)), np.zeros((300, 3, 3))
    for c in range(3):
        move = step * np.eye(3)[c]
        after, before = surface.project(POINTS + move), surface.project(POINTS - move)
        gradient[:, c] = (after.distance - before.distance) / (2.0 * step)
        hessian[:, :, c] = (after.normal - before.normal) / (2.0 * step)
    expected, across = 0.0, np.cross(hit.normal, hit.direction)
    steady = np.ones(300, bool)
    for i, e in enumerate((hit.direction, across)):
        k = hit.curvature[:, i]
        factor = k / (1.0 + k * hit.distance)
        steady &= (np.abs(1.0 + k * hit.distance) > 0.3) & (np.abs(factor) < 1.0)
        expected = expected + factor[:, None, None] * e[:, :, None] * e[:, None, :]
    assert steady.sum() > 150
    assert np.abs(gradient - hit.normal)[steady].max() < 1e-6
    assert np.abs(hessian - expected)[steady].max() < 1e-5


@pytest.mark.parametrize(
    "solid, hollow",
    [
        (CylinderSurface(8.0, AT, AXIS), CylinderSurface(8.0, AT, AXIS, hollow=True)),
        (SphereSurface(7.0, AT), SphereSurface(7.0, AT, hollow=True)),
        (ConeSurface(30.0, AT, AXIS), ConeSurface(30.0, AT, AXIS, hollow=True)),
        (TorusSurface(12.0, 4.0, AT, AXIS), TorusSurface(12.0, 4.0, AT, AXIS, hollow=True)),
    ],
)
def test_hollow_has_its_material_outside(solid, hollow):
    a, b = solid.project(POINTS), hollow.project(POINTS)
    assert b.distance == pytest.approx(-a.distance) and b.normal == pytest.approx(-a.normal)
    assert b.curvature == pytest.approx(-a.curvature[:, ::-1])


def test_points_without_a_single_foot():
    """On the axis, at the centre, at the apex and beyond it."""
    axis = np.array(AT) + np.array([[-3.0], [0.0], [5.0]]) * UNIT
    assert CylinderSurface(8.0, AT, AXIS).project(axis).distance == pytest.approx([-8.0] * 3)
    assert SphereSurface(7.0, AT).project(axis).distance == pytest.approx([-4.0, -7.0, -2.0])
    hit = ConeSurface(30.0, AT, AXIS).project(axis)
    assert hit.distance == pytest.approx([3.0, 0.0, -2.5]) and hit.curvature[0] == pytest.approx([1e12, 1e12])
    assert hit.normal[0] == pytest.approx(-UNIT)
    assert TorusSurface(12.0, 4.0, AT, AXIS).project(axis).distance[1] == pytest.approx(8.0)
    for surface, _ in SURFACES.values():
        assert np.linalg.norm(surface.project(axis).normal, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "make, line",
    [
        (lambda: CylinderSurface(0.0), "CylinderSurface radius: found 0.0, expected a length in mm above 0"),
        (lambda: SphereSurface(np.nan), "SphereSurface radius: found nan"),
        (lambda: ConeSurface(90.0), "ConeSurface half_angle: found 90.0, expected degrees between 0 and 90"),
        (lambda: TorusSurface(4.0, 5.0), "TorusSurface tube: found 5.0, expected less than the radius 4.0"),
        (lambda: PlaneSurface(normal=(0, 0, 0)), "PlaneSurface: found a direction of length 0"),
        (lambda: PlaneSurface((0, 0)), "PlaneSurface: found (0, 0), expected a point (x, y, z)"),
    ],
)
def test_wrong_sizes_are_one_line(make, line):
    with pytest.raises(CadError) as error:
        make()
    assert line in str(error.value) and "\n" not in str(error.value)


def test_wrong_points():
    with pytest.raises(ValueError, match=r"points must be \(n, 3\)"):
        PlaneSurface().project(np.zeros(3))
    with pytest.raises(ValueError, match="finite"):
        PlaneSurface().project(np.full((1, 3), np.inf))
    assert len(PlaneSurface().project(np.zeros((0, 3))).distance) == 0


def test_its_record_is_none_of_a_faces_for_numba():
    """Of a record that begins like a face's numba says at length that it takes one for the other."""
    assert from_dtype(FACE).can_convert_to(None, from_dtype(FORM)) is None
