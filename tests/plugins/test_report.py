"""History, summary, comparison and plots of a run."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from plugins import report


def row(quantity, stroke, measured):
    return SimpleNamespace(quantity=quantity, stroke=stroke, measured=measured, scatter=None)


def test_computed_values_are_interpolated_and_never_extrapolated():
    history = {"stroke": [10.0, 20.0], "draw_in_DX": [2.0, 6.0]}
    rows = [row("draw_in_DX", 15.0, 5.0), row("draw_in_DX", 20.0, 5.0), row("draw_in_DX", 20.5, 5.0)]
    half, end, beyond = report.compare(rows, history, {"draw_in_DX": "mm"})
    assert half["computed"] == pytest.approx(4.0)
    assert half["percent_off"] == pytest.approx(-20.0)
    assert end["computed"] == pytest.approx(6.0)
    assert beyond["computed"] is None and beyond["percent_off"] is None


def test_nothing_computed_yet():
    (only,) = report.compare([row("draw_in_DX", 15.0, 5.0)], {}, {})
    assert only["computed"] is None


def test_history_comes_back(tmp_path):
    history = {"stage": ["draw", "draw"], "stroke": [0.1, 1.0 / 3.0], "force_PUNCH": [np.float64(1.5), 2]}
    report.write_history(tmp_path, history)
    assert report.read_history(tmp_path) == history


def test_summary_is_plain_json(tmp_path):
    report.write_summary(tmp_path, {"a": np.float64(1.5), "b": np.arange(2), "c": float("nan"), "d": np.bool_(True)})
    text = (tmp_path / "summary.json").read_text()
    assert json.loads(text) == {"a": 1.5, "b": [0, 1], "c": None, "d": True}
    assert report.read_summary(tmp_path)["a"] == 1.5


def test_a_folder_without_a_run(tmp_path):
    with pytest.raises(report.RunFolderError, match=r"summary.json: no such file, expected the folder of a run"):
        report.read_summary(tmp_path)
    with pytest.raises(report.RunFolderError, match=r"history.csv: cannot be read"):
        report.read_history(tmp_path)


def test_plot_is_a_picture(run_folder):
    report.plot(run_folder, run_folder / "plot.png")
    assert (run_folder / "plot.png").read_bytes().startswith(b"\x89PNG")


def test_contact_is_reported_in_words():
    figures = {"contact_foot_error": 2.5e-6, "contact_sharp_nodes": 3, "contact_several_feet": 12, "cad_gap": 1.2e-5}
    rows = {words: (number, unit) for words, number, unit in report.figure_rows(figures)}
    assert rows["largest error of a contact point on its tool"] == ("0.0025", "µm")
    assert rows["largest gap between faces of the CAD tools"] == ("0.0120", "µm")
    assert rows["nodes on sharp edges of tools, at most"] == ("3", "")
    assert rows["nodes held by several walls of one tool, at most"] == ("12", "")
