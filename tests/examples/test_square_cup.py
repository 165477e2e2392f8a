"""The example's figures against the laboratories' means (benchmarks.md A: 5.3, 3.3 mm at 15 mm; 28.5, 15.0 at 40)."""

from dataclasses import replace
from pathlib import Path

import pytest

from plugins.scene_file import SceneFile
from solver import Implicit, Scene, Stage, form

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "square_cup"


def cup(tmp_path, size, travel, scene_file="aluminium.toml"):
    """The example's scene with another mesh and stroke."""
    text = (FOLDER / scene_file).read_text().replace("size = 2.5", f"size = {size}")
    text = text.replace('cad = "', f'cad = "{FOLDER}/')
    path = tmp_path / "scene.toml"
    path.write_text(text)
    scene = SceneFile.read(path).build()
    stage = scene.stages[0]
    tools = [replace(t, travel=-travel) if t.travel else t for t in stage.tools]
    return replace(scene, stages=[replace(stage, tools=tools)])


def test_draw_in_at_15_mm(tmp_path):
    results = form(cup(tmp_path, 3.75, 15.0), frames=15)
    assert results.history["draw_in_DX"][-1] == pytest.approx(5.3, rel=0.12)
    assert results.history["draw_in_DD"][-1] == pytest.approx(3.3, rel=0.12)
    assert results.history["draw_in_DY"][-1] == pytest.approx(results.history["draw_in_DX"][-1], rel=0.02)
    assert results.history["force_BLANK_HOLDER"][-1] == pytest.approx(19600.0, rel=1e-5)
    assert abs(results.energy["imbalance"]) < 0.01 * results.energy["external"]
    assert not results.remarks()


@pytest.mark.slow
@pytest.mark.parametrize("option", ["penalty", "stick", "skin"])
def test_numerical_parameters_of_contact_move_nothing_a_user_reads(tmp_path, option):
    scene, method = cup(tmp_path, 3.75, 15.0), Implicit()
    changed = replace(method, **{option: 0.5 * getattr(method, option)})
    first, second = (form(scene, m, frames=1) for m in (method, changed))
    for column in ("force_PUNCH", "thickness_min", "thickness_max", "draw_in_DX", "draw_in_DD"):
        assert second.history[column][-1] == pytest.approx(first.history[column][-1], rel=1e-2), column


@pytest.mark.slow
@pytest.mark.parametrize("scene_file", ["aluminium.toml", "steel.toml"])
def test_whole_cup(tmp_path, scene_file):
    results = form(cup(tmp_path, 2.5, 40.0, scene_file), frames=40)
    assert results.finished
    measured = {"aluminium.toml": (5.3, 3.3, 28.5, 15.0), "steel.toml": (6.2, 3.2, 27.95, 15.4)}[scene_file]
    found = [results.at(f"draw_in_{name}", stroke) for stroke in (15.0, 40.0) for name in ("DX", "DD")]
    assert found == pytest.approx(measured, rel=0.15)


def test_stages_follow_each_other(tmp_path):
    scene = cup(tmp_path, 7.5, 4.0)
    first = scene.stages[0]
    again = replace(first, name="second")
    results = form(Scene(scene.blank, [first, Stage(again.tools, name="second")]), frames=2)
    assert results.history["stage"][-1] == "second"
    # The second stage's punch starts where it touches the drawn sheet: 4 mm further in all.
    assert results.history["travel_PUNCH"][-1] == pytest.approx(-8.0, abs=0.2)
    assert results.history["stroke"][-1] == pytest.approx(8.0)
