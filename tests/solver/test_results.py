"""Figures read off a history by hand."""

import pytest

from solver.results import Results


def history(**columns):
    results = Results(None, travelled=("draw",))
    results.history = columns
    return results


def test_pace_counts_what_a_stroke_took():
    results = history(
        stage=["draw", "draw", "draw", "draw", "bulge"],
        stroke=[0.0, 1.0, 1.0, 2.0, 3.0],
        iterations=[7, 4, 6, 4, 4],
        dynamic=[0.0, 1.0, 0.0, 0.0, 0.0],
    )
    pace = results.pace()
    assert pace["iterations_per_increment"] == pytest.approx(5.0)
    # Two increments led over 2 mm; closing the tools and a load stage have no stroke in mm.
    assert pace["increments_per_mm"] == pytest.approx(1.0)
    assert pace["dynamic_increments"] == 1


def test_a_dynamic_increment_counts_but_its_force_is_no_equilibrium():
    results = history(
        stage=["draw"] * 3,
        stroke=[1.0, 1.0, 2.0],
        iterations=[4, 4, 4],
        dynamic=[1.0, 1.0, 0.0],
        force_PUNCH=[900.0, -500.0, -40.0],
    )
    assert results.pace()["increments_per_mm"] == pytest.approx(1.5)
    assert results.largest_forces() == {"max_force_PUNCH": 40.0}


def test_a_run_without_increments_has_no_pace():
    assert history().pace() == {}
