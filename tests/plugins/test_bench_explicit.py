"""Rows of the explicit bench on a small sheet."""

import pytest

import solver
from plugins.bench_explicit import HEADER, YARDSTICK, line_of, time_sheet


def test_a_row_is_of_a_flowing_sheet_and_consistent():
    row = time_sheet("membrane", solver.Membrane(), 2000, 1)
    assert row["triangles"] == pytest.approx(2000, rel=0.1)
    assert row["flowing"] > 0.5
    assert row["ns"] * row["updates_per_s"] == pytest.approx(1e9)
    assert row["yardstick"] == pytest.approx(2.0 * row["ns"] / YARDSTICK)
    # State, its past and the look's trial: 17 + 11 + 17 numbers a point, and what nodes and triangles add.
    assert row["bytes"] > 8 * (17 + 11 + 17)
    assert len(line_of(row)) == len(HEADER)
