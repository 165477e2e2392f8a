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


def test_reading_is_timed_three_ways_and_leaves_the_users_cache_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("CADLINK_READ_CACHE", str(tmp_path))
    rows = bench_projection.read_times(bench_projection.DIE)
    assert [method.split(", ")[-1] for method, _ in rows] == ["first of a session", "OpenCASCADE loaded", "kept"]
    assert all(seconds > 0.0 for _, seconds in rows)
    assert not list(tmp_path.iterdir()) and bench_projection.read_times("memory") == []


def test_too_many_facets_are_left_out_with_the_reason(monkeypatch):
    """The torus has so many facets at 0.1 mm that ten times as many are above what is allowed here."""
    monkeypatch.setattr(bench_projection, "SUBSET", 5)
    monkeypatch.setattr(bench_projection, "CHORDS", (0.1, 0.01))
    monkeypatch.setattr(bench_projection, "MOST", 5000)
    rows = {row["method"]: row for row in bench_projection.measure(["torus-nurbs"], 100)}
    assert rows["facets 0.1 mm, VTK"]["ns"] > 0.0
    assert "left out: about 0." in rows["facets 0.01 mm"]["note"] and rows["facets 0.01 mm"]["ns"] is None


def test_a_sentence_sets_exact_beside_facets():
    """Numbers of the sentence: the quickest time and the least error of the fine facets, whichever query has them."""
    row = {"case": "a", "points": 1, "ratio": 1.0, "build": None, "kilobytes": None, "note": ""}
    found = [
        row | {"method": method, "ns": ns, "error": error}
        for method, ns, error in (
            ("exact, cold", 300.0, 1e-14),
            ("exact, moved 50 um", 50.0, 1e-14),
            ("facets 0.01 mm, libigl", 5000.0, 4e-3),
            ("facets 0.01 mm, VTK", 2000.0, 5e-3),
            ("facets 0.1 mm, VTK", 1000.0, 5e-2),
        )
    ]
    (line,) = bench_projection.sentences(found)
    assert "300 ns cold, 50 ns after 50 um" in line and "takes 2000 ns" in line and "4e-03 mm off" in line
    assert bench_projection.sentences(found[:2]) == []


@pytest.mark.parametrize("arguments", [["nothing"], ["die", "--points", "0"]])
def test_wrong_request_is_one_line(arguments, capsys):
    assert main(["bench", "projection", *arguments]) == WRONG_INPUT
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
