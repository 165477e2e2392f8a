"""A blank delivered not quite flat: how high it stands, and that neither mesh nor symmetry matter."""

import numpy as np
import pytest

from cadlink import CadError, Disc, Rectangle, mesh_blank
from cadlink.flatness import bow, edge_wave

HEIGHT = 0.05


def test_heights_lie_between_the_plane_and_the_flatness():
    xy = np.random.default_rng(1).uniform([-30.0, 5.0], [90.0, 45.0], (20_000, 2))
    xy[:4] = [[-30.0, 5.0], [90.0, 5.0], [-30.0, 45.0], [90.0, 45.0]]
    height = bow(xy, HEIGHT)
    assert height.min() >= -1e-3 * HEIGHT and height.max() <= 1.001 * HEIGHT
    assert height.min() < 0.02 * HEIGHT and height.max() > 0.98 * HEIGHT
    assert bow(xy, -HEIGHT) == pytest.approx(-height)
    # Moved and scaled it is the same shape.
    assert bow(7.0 * xy + [3.0, -2.0], HEIGHT) == pytest.approx(height, abs=1e-12)


def test_no_slope_across_the_sides():
    along = np.linspace(0.0, 1.0, 50)
    step = 1e-5
    corners = np.array([[0.0, 0.0], [1.0, 1.0]])
    for side in (0.0, 1.0):
        inside = side + (step if side == 0.0 else -step)
        for swap in (False, True):
            edge = np.column_stack([np.full(50, side), along])
            near = np.column_stack([np.full(50, inside), along])
            if swap:
                edge, near = edge[:, ::-1], near[:, ::-1]
            slope = (bow(np.vstack([near, corners]), 1.0) - bow(np.vstack([edge, corners]), 1.0))[:50] / step
            assert np.abs(slope).max() < 1e-2  # a wave of eight half waves has a slope of order 10 inside


@pytest.mark.parametrize("symmetry", [(), ("x",), ("x", "y")])
def test_meshes_of_a_blank_have_one_shape(symmetry):
    coarse, fine = (mesh_blank(Rectangle(80, 60), s, arrangement="structured", symmetry=symmetry, flatness=HEIGHT)
                    for s in (5.0, 2.5))  # fmt: skip
    at = {tuple(np.round(p[:2], 9)): p[2] for p in fine.points}
    shared = [(p[2], at[tuple(np.round(p[:2], 9))]) for p in coarse.points if tuple(np.round(p[:2], 9)) in at]
    assert len(shared) == len(coarse.points)
    assert np.ptp(coarse.points[:, 2]) > 0.5 * HEIGHT
    assert np.array(shared)[:, 0] == pytest.approx(np.array(shared)[:, 1], abs=1e-12)


def test_a_flat_blank_stays_flat_and_nodes_on_planes_on_them():
    flat = mesh_blank(Disc(50), 5.0, arrangement="structured", symmetry=("x", "y"))
    bent = mesh_blank(Disc(50), 5.0, arrangement="structured", symmetry=("x", "y"), flatness=HEIGHT)
    assert np.ptp(flat.points[:, 2]) == 0.0
    assert bent.points[:, :2] == pytest.approx(flat.points[:, :2], abs=0.0)
    assert (bent.points[bent.groups["symmetry_x"], 0] == 0.0).all()


def test_a_wavy_edge_has_its_waves_and_fades_towards_the_middle():
    angle = np.linspace(0.0, 2.0 * np.pi, 4801)
    ring = 40.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    height = edge_wave(np.vstack([ring, 0.5 * ring, [[0.0, 0.0]]]), HEIGHT, 12)
    edge, halfway, middle = height[:4801], height[4801:-1], height[-1]
    assert edge.min() == pytest.approx(0.0, abs=1e-12) and edge.max() == pytest.approx(HEIGHT)
    assert np.sum((edge[1:-1] < edge[:-2]) & (edge[1:-1] <= edge[2:])) == 12
    assert np.ptp(halfway) == pytest.approx(0.25 * HEIGHT) and middle == pytest.approx(0.5 * HEIGHT)


def test_a_wavy_quarter_is_a_quarter_of_the_wavy_blank():
    quarter = mesh_blank(Disc(50), 5.0, arrangement="structured", symmetry=("x", "y"), flatness=HEIGHT, edge_waves=6)
    whole = mesh_blank(Disc(50), 5.0, arrangement="structured", flatness=HEIGHT, edge_waves=6)
    at = {tuple(np.round(np.abs(p[:2]), 9)): p[2] for p in whole.points}
    assert [at[tuple(np.round(p[:2], 9))] for p in quarter.points] == pytest.approx(quarter.points[:, 2], abs=1e-12)
    # Away from the origin the waves go round the blank's own middle.
    aside = mesh_blank(Disc(50, center=(70.0, 0.0)), 5.0, flatness=HEIGHT, edge_waves=6)
    assert aside.points[:, 2] == pytest.approx(edge_wave(aside.points[:, :2] - [70.0, 0.0], HEIGHT, 6))


@pytest.mark.parametrize("wrong, line", [
    ({"edge_waves": 0}, "edge_waves: expected a whole number of waves > 0, got 0"),
    ({"edge_waves": 7}, "edge_waves: expected an even number beside symmetry, got 7"),
    ({"edge_waves": 6, "flatness": 0.0}, "edge_waves: expected a flatness other than 0"),
])  # fmt: skip
def test_waves_are_counted_and_have_a_height(wrong, line):
    with pytest.raises(CadError, match=line):
        mesh_blank(Disc(50), 5.0, symmetry=("x",), **{"flatness": HEIGHT, **wrong})


def test_flatness_is_a_length():
    with pytest.raises(CadError, match="mesh_blank flatness: expected a height in mm, got 'much'"):
        mesh_blank(Disc(50), 5.0, flatness="much")
