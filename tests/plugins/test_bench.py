"""The benchmarks of `cadlink bench` that need no CAD file."""

import numpy as np
import pytest

from plugins import bench_elements, bench_materials, bench_shell, shell_limits


def test_shell_rows_carry_errors_against_the_published_answers(tmp_path):
    done = list(bench_shell.rows(["cantilever"], range(2)))
    for kind in ("lattice", "unstructured"):
        assert [row["error"] < 0.01 for row in done if row["mesh"] == kind][-1]
    coarse, fine = (row for row in done if row["mesh"] == "lattice")
    assert fine["error"] < coarse["error"]
    assert bench_shell.line_of(fine)[0] == "cantilever"
    bench_shell.plot(done, tmp_path / "shell.png")
    assert (tmp_path / "shell.png").stat().st_size > 10_000


def test_roll_up_by_an_edge_moment():
    coarse, fine = (bench_shell.measure("roll-up", "lattice", k) for k in range(2))
    assert fine["error"] < 0.006
    assert fine["error"] == pytest.approx(0.25 * coarse["error"], rel=0.1)  # second order


def test_a_coarse_curved_shell_does_not_lock():
    # 81 nodes, 11 degrees a triangle; the metric of mean gradients was 20 % too stiff.
    row = bench_shell.measure("hemisphere", "lattice", 0)
    assert row["error"] < 0.05


def test_no_corner_of_a_mesh_is_one_triangle():
    cells = np.array([[0, 1, 2], [3, 2, 1]])
    assert bench_shell.open_corners(cells).tolist() == [[0, 1, 3], [0, 3, 2]]
    case = bench_shell.PROBLEMS["open cylinder"]
    s, t, cells = bench_shell.unstructured(case, 0)
    assert np.bincount(cells.ravel()).min() > 1
    a, b, c = (np.stack([s, t], axis=1)[cells[:, k]] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert area.min() > 0.0 and area.sum() == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", bench_shell.MESHES)
@pytest.mark.parametrize("problem", [name for name in bench_shell.PROBLEMS if name != "pinched cylinder"])
def test_finest_meshes_are_within_a_per_cent(problem, kind):
    row = bench_shell.measure(problem, kind, 2)
    assert row["error"] < 0.01


@pytest.mark.slow
def test_the_pinched_cylinder_is_within_a_per_cent_of_its_limit():
    # The published rows are a mesh's of 40 x 40; docs/shell.md has how far they are from where these meshes tend to.
    done = [bench_shell.measure("pinched cylinder", kind, k) for kind in bench_shell.MESHES for k in (1, 2)]
    for row in shell_limits.limit_rows(done):
        for errors in row["errors"].values():
            assert abs(errors[-1]) < 0.01
        assert np.mean(list(row["limit"].values())) == pytest.approx(row["published"], rel=0.06)


def test_limits_and_orders_are_those_of_what_converges():
    # Two displacements that tend to 2 and 3 at second order, from either side.
    def run(kind, k, sign):
        values = {"u": (2.0 + sign * 0.1 / 4**k, 2.01, 0.0), "w": (3.0 - sign * 0.01 / 4**k, 3.0, 0.0)}
        return {"problem": "p", "mesh": kind, "cells": 8 * 2**k, "values": values}

    done = [run(kind, k, sign) for kind, sign in (("a", 1), ("b", -1)) for k in range(3)]
    u, w = shell_limits.limit_rows([*done, {"problem": "p", "mesh": "a", "failed": "no"}])
    assert u["limit"] == pytest.approx({"a": 2.0, "b": 2.0}) and w["limit"]["a"] == pytest.approx(3.0)
    assert u["errors"]["a"] == pytest.approx([0.05, 0.0125, 0.003125])
    assert u["order"] == pytest.approx({"a": 2.0, "b": 2.0}) == w["order"]
    assert shell_limits.line_of(u)[2:6] == ["2.01", "2", "0.00", "-0.50"]
    # One mesh of a kind has no limit.
    assert list(shell_limits.limit_rows(done[:1])) == []


def test_an_unknown_problem_is_one_line():
    with pytest.raises(bench_shell.BenchError, match="found problem 'nothing', expected some of cantilever"):
        bench_shell.checked(["nothing"])


def test_times_per_element():
    rows = bench_elements.rows(n_side=6, repeats=1)
    assert [row["element"] for row in rows] == list(bench_elements.ELEMENTS)
    assert all(row["explicit"] > 0.0 and row["flowing"] > 0.5 for row in rows)
    assert rows[2]["material"] > rows[0]["material"]


def test_each_law_is_timed_on_every_element():
    names = ["planar Hill", "Hill48"]  # of one kernel, quick to compile
    rows = bench_elements.law_rows(names, n_side=6, repeats=1)
    assert [row["law"] for row in rows] == names
    for row in rows:
        assert row["ratio, membrane"] == 1.0
        assert row["flowing, shell, 7 layers"] > 0.5
        assert row["shell, 9 layers"] > 0.0
        assert len(bench_elements.law_line(row)) == len(bench_elements.LAW_HEADER)


def test_every_locus_and_law_of_the_materials_bench_is_there():
    pairs = list(bench_elements.LAWS.values())
    assert all(any(locus is of for of, _ in pairs) for locus in bench_materials.LOCI.values())
    for name in ("isotropic", "Yoshida-Uemori", "two surfaces"):
        assert any(law is bench_materials.LAWS[name] for _, law in pairs)
