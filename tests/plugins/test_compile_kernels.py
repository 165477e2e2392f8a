from pathlib import Path

from plugins import compile_kernels
from plugins.scene_file import SceneFile

SCENE = Path(__file__).resolve().parents[2] / "examples" / "square_cup" / "aluminium.toml"


def test_one_small_step_of_the_scene_is_taken(monkeypatch):
    taken = []
    monkeypatch.setattr("solver.form", lambda scene, frames: taken.append((scene, frames)))
    compile_kernels.compile_kernels(SCENE)
    (scene, frames) = taken[0]
    punch = next(tool for tool in scene.stages[0].tools if tool.name == "PUNCH")
    assert frames == 1
    assert abs(punch.travel) == 0.01 * scene.blank.thickness
    assert punch.travel < 0.0
    assert SceneFile.read(SCENE).build().stages[0].tools[0].travel == -40.0


def test_facets_are_compiled_for_whatever_normals():
    from cadlink import FacetSurface
    from cadlink.facet_closest import project_on_facets

    compile_kernels.compile_facets()
    known = list(project_on_facets.signatures)
    assert known
    corners, cells = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2, 3]]
    for normals in ("element", "nodal", "nagata"):
        FacetSurface(corners, cells, normals).project([[0.5, 0.5, 1.0]])
    assert list(project_on_facets.signatures) == known
