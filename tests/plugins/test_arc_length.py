"""The arc length: its constraint, and a path with two limit loads and a snap-back."""

from dataclasses import replace

import numpy as np
import pytest

from plugins import bench_shell
from plugins.arc_length import LoadedNodes, WholeSheet, follow
from plugins.shell_problems import PROBLEMS
from solver import Implicit, StepFailed


def test_the_change_of_the_load_keeps_the_length_of_the_step():
    rng = np.random.default_rng(4)
    moved, v = rng.standard_normal((2, 7, 3))
    r, size = 0.01 * rng.standard_normal((7, 3)), np.linalg.norm(moved)
    root = WholeSheet().change
    change = root(moved, r, v, size)
    ahead = moved + r + change * v
    assert np.linalg.norm(ahead) == pytest.approx(size, rel=1e-12)
    assert np.sum(moved * ahead) > 0.0  # the root that does not turn back
    assert root(moved, 100.0 * np.cross(moved, [1.0, 2.0, 3.0]), 1e-3 * moved, size) is None
    length = LoadedNodes(v / np.linalg.norm(v))
    assert length.size(moved + r + length.change(moved, r, v, size) * v) == pytest.approx(size, rel=1e-12)


def test_the_loaded_nodes_alone_lead_along_the_same_path():
    # Through both limit loads of the thicker roof, whose loaded node never comes back.
    case = PROBLEMS["hinged roof"]
    path, _ = bench_shell.path_of(replace(case, wrinkles=True), bench_shell.build(case, "lattice", 0))
    whole, _ = bench_shell.path_of(case, bench_shell.build(case, "lattice", 0))
    assert (np.diff(path[:, 1]) > 0.0).all() and (np.diff(path[:, 0]) < 0.0).any()
    assert bench_shell.distances(whole, path)[0] < 1e-3


def test_a_snap_back_is_followed():
    case = PROBLEMS["thin hinged roof"]
    path, _ = bench_shell.path_of(case, bench_shell.build(case, "lattice", 0))
    load, place = path.T
    assert load[-1] == case.curve[-1, 0]  # ends at the last published load, not beyond
    assert (np.diff(place) < 0.0).any() and load.min() < -0.1  # the loaded point comes back, pulled up
    assert bench_shell.distances(path, case.curve)[0] < 0.05  # 81 nodes


def test_too_few_steps_are_told():
    case = PROBLEMS["hinged roof"]
    with pytest.raises(StepFailed, match="of the load after 2 steps"):
        list(follow(bench_shell.build(case, "lattice", 0), Implicit(), 1.0, n_steps=2))


def test_the_distance_of_curves_is_that_of_load_or_displacement():
    # A straight path against rows that lie 0.02 of the full load above it: 0.02 cos 45 in the plane of both scales.
    load = np.linspace(0.0, 1.0, 11)
    rows = np.column_stack([load[1:-1] + 0.02, 3.0 * load[1:-1]])
    rows = np.vstack([rows, [1.0, 3.0]])
    assert bench_shell.distances(np.column_stack([load, 3.0 * load]), rows)[0] == pytest.approx(
        0.02 / np.sqrt(2.0), rel=1e-3
    )
