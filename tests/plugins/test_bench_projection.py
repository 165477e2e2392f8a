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
    assert rows["exact, moved 1 um"]["error"] < 1e-11
    assert rows["OCC DistShapeShape"]["error"] < 1e-9
    facets = rows["facets 0.1 mm, VTK"]
    assert 1e-3 < facets["error"] < 0.2
    for method in ("libigl", "Open3D"):
        row = rows[f"facets 0.1 mm, {method}"]
        assert row["note"] == "not installed" or 1e-3 < row["error"] < 0.2
    assert all(row["ns"] is None or row["ns"] > 0.0 for row in rows.values())


@pytest.mark.parametrize("arguments", [["nothing"], ["die", "--points", "0"]])
def test_wrong_request_is_one_line(arguments, capsys):
    assert main(["bench", "projection", *arguments]) == WRONG_INPUT
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
