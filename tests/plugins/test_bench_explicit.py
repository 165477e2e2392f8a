"""Rows of the explicit bench on a small sheet."""

import pytest

import solver
from plugins import bench_explicit
from plugins.bench_explicit import HEADER, YARDSTICK, line_of, rows, time_sheets


def test_a_row_is_of_a_flowing_sheet_and_consistent():
    (row,) = time_sheets("membrane", solver.Membrane(), [2000], 1)
    assert row["triangles"] == pytest.approx(2000, rel=0.1)
    assert row["flowing"] > 0.5
    assert row["ns"] * row["updates_per_s"] == pytest.approx(1e9)
    assert row["yardstick"] == pytest.approx(2.0 * row["ns"] / YARDSTICK)
    # State, its past and the look's trial: 17 + 11 + 17 numbers a point, and what nodes and triangles add.
    assert row["bytes"] > 8 * (17 + 11 + 17)


def test_rows_stand_beside_the_limits_of_the_machine(monkeypatch):
    monkeypatch.setattr(bench_explicit, "SIZES", (1000, 2000))
    monkeypatch.setattr(bench_explicit, "ELEMENTS", {"membrane": solver.Membrane()})
    small, large = [row for row in rows() if row["threads"] == 1]
    assert small["to_smallest"] == 1.0 and large["to_smallest"] == pytest.approx(large["ns"] / small["ns"])
    # No step does more than a core can.
    assert 0.0 < large["arithmetic_ns"] < large["ns"]
    assert large["arithmetic_ns"] * large["operations_per_s"] == pytest.approx(1e9 * large["operations"])
    assert len(line_of(large)) == len(HEADER)
