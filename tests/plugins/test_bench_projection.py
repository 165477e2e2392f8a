"""cadlink bench projection: rows with time and error for every method, or one line."""

import json

import pytest

from plugins import bench_projection
from plugins.command_line import WRONG_INPUT, main


def test_exact_is_nearer_than_facets(monkeypatch, capsys):
    monkeypatch.setattr(bench_projection, "CHORDS", (0.1,))
    monkeypatch.setattr(bench_projection, "SUBSET", 20)
    assert main(["bench", "projection", "torus-nurbs", "--points", "300", "--json"]) == 0
    rows = {row["method"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["exact, cold"]["error"] < 1e-12
    for method in ("moved 1 um", "moved 50 um", "walk of 20 x 1 um", "walk of 20 x 50 um"):
        assert rows[f"exact, {method}"]["error"] < 1e-11
    assert rows["OCC DistShapeShape"]["error"] < 1e-9
    assert 0.0 < rows["exact, cold"]["build"] < 10.0 and rows["exact, cold"]["kilobytes"] > 10.0
    facets = rows["facets 0.1 mm, VTK"]
    assert 1e-3 < facets["error"] < 0.2
    for method in ("libigl", "Open3D"):
        row = rows[f"facets 0.1 mm, {method}"]
        assert row["note"] == "not installed" or 1e-3 < row["error"] < 0.2
    assert all(row["ns"] is None or row["ns"] > 0.0 for row in rows.values())


def test_reading_again_is_quicker_and_leaves_the_users_cache_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("CADLINK_READ_CACHE", str(tmp_path))
    (first, slow), (again, quick) = bench_projection.read_times(bench_projection.DIE)
    assert (first, again) == ("read, first time", "read again") and 0.0 < quick < 0.5 * slow
    assert not list(tmp_path.iterdir()) and bench_projection.read_times("memory") == []


@pytest.mark.parametrize("arguments", [["nothing"], ["die", "--points", "0"]])
def test_wrong_request_is_one_line(arguments, capsys):
    assert main(["bench", "projection", *arguments]) == WRONG_INPUT
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
