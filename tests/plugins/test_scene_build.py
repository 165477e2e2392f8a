"""From a scene file to a solver.Scene."""

import numpy as np
import pytest

import solver
from plugins.scene_file import SceneFileError, load_scene

BULGE = """
[blank]
outline = {disc = 50, z = 1.5}
size = 10
symmetry = ["x", "y"]
thickness = "0.8 mm"
fixed = {rim = "xyz"}
[material]
young = "206 GPa"
poisson = 0.3
locus = "von Mises"
hardening = {swift = {K = 565, e0 = 0.007, n = 0.26}}
[[stages]]
name = "bulge"
pressure = "5 MPa"
moved = {center = ["free", "free", 2]}
"""


def scene_of(tmp_path, text):
    path = tmp_path / "s.toml"
    path.write_text(text)
    return load_scene(path)


def test_a_bulge_needs_neither_cad_nor_tools(tmp_path):
    scene = scene_of(tmp_path, BULGE)
    points = scene.blank.mesh.points
    assert scene.blank.symmetry_planes == ("x", "y")
    assert np.abs(points[:, 2] - 1.5).max() < 1e-12
    assert np.linalg.norm(points[scene.blank.nodes_of("rim"), :2], axis=1) == pytest.approx(50.0)
    (stage,) = scene.stages
    assert (stage.name, stage.pressure, stage.moved["center"]) == ("bulge", 5.0, (None, None, 2.0))
    assert scene.blank.material.locus.r == 1.0


def test_a_rectangle_and_a_polygon(tmp_path):
    for shape in ("{rectangle = [100, 60]}", "{polygon = [[-50, -30], [50, -30], [50, 30], [-50, 30]]}"):
        mesh = scene_of(
            tmp_path,
            BULGE.replace("{disc = 50, z = 1.5}", shape).replace(
                "size = 10", 'size = 10\narrangement = "unstructured"'
            ),
        ).blank.mesh
        assert mesh.points.max(axis=0) == pytest.approx([50.0, 30.0, 0.0])


def test_a_group_that_does_not_exist(tmp_path):
    with pytest.raises(SceneFileError, match=r"s.toml: blank: blank group 'edge' does not exist; there are .*rim"):
        scene_of(tmp_path, BULGE.replace("{rim =", "{edge ="))
    with pytest.raises(SceneFileError, match=r"s.toml: stages: blank group 'tip' does not exist"):
        scene_of(tmp_path, BULGE.replace("{center =", "{tip ="))


def test_a_shell_with_layers_or_a_membrane(tmp_path):
    assert scene_of(tmp_path, BULGE).blank.element == solver.Shell(7)
    assert scene_of(tmp_path, BULGE.replace("size = 10", "size = 10\nlayers = 9")).blank.element == solver.Shell(9)
    membrane = BULGE.replace("size = 10", 'size = 10\nelement = "membrane"')
    assert scene_of(tmp_path, membrane).blank.element == solver.Membrane()
    with pytest.raises(SceneFileError, match="blank.layers: found 5, expected none: a membrane has no layers"):
        scene_of(tmp_path, membrane.replace("size = 10", "size = 10\nlayers = 5"))
    with pytest.raises(SceneFileError, match="blank.layers: found 1, expected a number of layers from 2 to 51"):
        scene_of(tmp_path, BULGE.replace("size = 10", "size = 10\nlayers = 1"))


def test_loads_and_springback(tmp_path):
    text = (
        BULGE
        + """
    forces = {center = [0, 0, "1 kN"]}
    line_loads = {rim = [0, "2 kN/m", 0.5]}
    [[stages]]
    name = "release"
    tools = {}
    """
    )
    first, second = scene_of(tmp_path, text).stages
    assert first.forces == {"center": (0.0, 0.0, 1000.0)}
    assert first.line_loads == {"rim": (0.0, 2.0, 0.5)}
    assert second.is_springback and not first.is_springback
    with pytest.raises(SceneFileError, match=r'line_loads.rim.*found "2 kN", not a line load'):
        scene_of(tmp_path, text.replace("2 kN/m", "2 kN"))


@pytest.mark.parametrize(
    "text, expected",
    [
        ("{table = {minor = [-0.1, 0.2], major = [0.3, 0.4]}}", solver.LimitCurve([-0.1, 0.2], [0.3, 0.4])),
        (
            "{table = {minor = [0.0, 0.2], major = [0.3, 0.4], engineering = true}}",
            solver.LimitCurve(np.log([1.0, 1.2]), np.log([1.3, 1.4])),
        ),
        ("{keeler_brazier = {n = 0.18}}", solver.KeelerBrazier(0.8, 0.18)),
    ],
)
def test_a_forming_limit_is_given_in_the_scene(tmp_path, text, expected):
    scene = scene_of(tmp_path, f"forming_limit = {text}\n" + BULGE)
    minor = np.linspace(-0.2, 0.3, 11)
    assert scene.blank.forming_limit(minor) == pytest.approx(expected(minor), rel=1e-14)


def test_a_forming_limit_is_computed_from_the_material(tmp_path):
    scene = scene_of(tmp_path, "forming_limit = {marciniak = {f0 = 0.9}}\n" + BULGE)
    limit = scene.blank.forming_limit
    assert limit.name == "Marciniak-Kuczynski, f0 = 0.9"
    # An imperfection of a tenth: far below the uniform strain n - e0 of a sheet without one.
    assert 0.0 < limit(0.0) < 0.26 - 0.007


@pytest.mark.parametrize(
    "text, message",
    [
        ("{table = {minor = [0.2, 0.1], major = [0.3, 0.4]}}", "forming_limit: .*expected minor strains that rise"),
        ("{marciniak = {f0 = 1.5}}", "forming_limit.marciniak.f0: found 1.5, expected a ratio of thicknesses"),
        ("{hill = 1}", "forming_limit"),
    ],
)
def test_a_wrong_forming_limit_is_one_line(tmp_path, text, message):
    with pytest.raises(SceneFileError, match=message) as caught:
        scene_of(tmp_path, f"forming_limit = {text}\n" + BULGE)
    assert "\n" not in str(caught.value)
