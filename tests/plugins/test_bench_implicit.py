"""Rows of the implicit bench on coarse meshes."""

import pytest

from plugins.bench_implicit import CUP_HEADER, HEADER, YARDSTICK, cup_line, cup_rows, line_of, punch_rows


def test_rows_of_the_punch_add_up():
    rows = punch_rows(sizes=(10.0,), travel=10.0)
    assert [row["element"] for row in rows] == ["membrane", "shell"]
    for row in rows:
        assert row["finished"]
        assert sum(row["shares"].values()) == pytest.approx(1.0)
        assert all(row["shares"][part] > 0.0 for part in ("projection", "elements", "assembly", "solution"))
        assert row["iterations"] == pytest.approx(row["iterations_per_increment"] * row["increments"])
        assert row["increments_per_mm"] == pytest.approx(row["increments"] / 10.0, rel=0.2)
        # 10 mm deep on eight triangles from pole to rim.
        assert 0.0 < row["force_error"] < 0.1 and 0.0 < row["strain_error"] < 0.02
        assert row["yardstick"] == pytest.approx(YARDSTICK / row["seconds"])
        assert len(line_of(row)) == len(HEADER)


def test_rows_of_the_cup_are_compared_with_the_finest_and_with_half_the_increments():
    coarse, fine, halved = cup_rows(sizes=(12.5, 9.0), travel=4.0)
    errors = ["draw_in_error", "force_error", "holder_error", "thickness_error"]
    assert [fine[name] for name in errors] == [0.0] * 4
    assert min(coarse[name] for name in ("draw_in_error", "force_error", "thickness_error")) > 0.0
    assert halved["halved"] and halved["triangles"] == coarse["triangles"]
    assert halved["increments"] > 1.5 * coarse["increments"]
    # The holder's force is given; half the increments change little beside another mesh.
    assert coarse["holder_error"] < 1e-3
    assert halved["force_error"] < coarse["force_error"]
    assert coarse["measured_off"] == {}  # measured at 15 and 40 mm
    assert len(cup_line(coarse)) == len(CUP_HEADER)
