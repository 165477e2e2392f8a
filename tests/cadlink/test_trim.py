"""Inside or outside a boundary in (u, v), right to round-off."""

import numpy as np
import pytest

from cadlink.nurbs import WORK
from cadlink.trim import inside
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of


def is_inside(skin, face, u, v):
    return inside(skin.faces[face], skin.pieces, skin.ctrl, u, v, np.zeros(WORK))


@pytest.fixture(scope="module")
def ellipse():
    """Skin of an elliptic disc, half axes 8 and 3, whose (u, v) are its own x and y."""
    return part_of(shapes.extrusion_of_ellipse()).surface(faces=[1]).skin


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-9, 1e-12])
def test_curved_boundary_is_exact(ellipse, off):
    """Points a relative 1e-12 inside and outside an ellipse are told apart."""
    rng = np.random.default_rng(1)
    frame = ellipse.faces[0]["frame"]
    centre = frame[1:3] @ (np.array([1.0, -2.0, 0.5]) - frame[0])
    # Axes of the ellipse in the plane's own coordinates, from the extremes of its boundary.
    axes = shapes.TILTED
    x = np.array([axes.XDirection().X(), axes.XDirection().Y(), axes.XDirection().Z()])
    y = np.array([axes.YDirection().X(), axes.YDirection().Y(), axes.YDirection().Z()])
    x, y = 8.0 * (frame[1:3] @ x), 3.0 * (frame[1:3] @ y)
    for t in rng.random(300) * 2.0 * np.pi:
        way = np.cos(t) * x + np.sin(t) * y
        assert is_inside(ellipse, 0, *(centre + (1.0 - off) * way))
        assert not is_inside(ellipse, 0, *(centre + (1.0 + off) * way))


def test_rays_through_corners_count_once():
    """Points level with the corners of a rectangle and with the ends of a hole."""
    skin = part_of(shapes.plane_face()).surface().skin
    u0, u1, v0, v1 = skin.faces[0]["box"]
    for v in (v0, v1, 0.5 * (v0 + v1)):
        assert not is_inside(skin, 0, u0 - 1.0, v)
        assert not is_inside(skin, 0, u1 + 1.0, v)
    assert is_inside(skin, 0, u0 + 1e-6, v0 + 1e-6)


def test_parameters_are_turned_into_the_face():
    """u and u + 2 pi are one meridian, and the seam belongs to the face."""
    skin = part_of(shapes.cylinder()).surface().skin
    face = int(np.flatnonzero(skin.faces["form"] == 1)[0])
    height = 0.5 * skin.faces[face]["box"][2:].sum()
    for u in (0.0, -0.0, 2.0 * np.pi, -1e-16, 1.0, 1.0 - 2.0 * np.pi, 1.0 + 4.0 * np.pi):
        assert is_inside(skin, face, u, height)
    assert not is_inside(skin, face, 1.0, height + 100.0)
