"""Friction laws, springs, drawbeads, gravity and pilots of a scene file."""

import numpy as np
import pytest

import solver
from plugins.check_scene import check_scene
from plugins.scene_file import SceneFileError, check, load_scene
from plugins.scene_keys import SceneKeys
from tests.plugins.test_scene_file import cup, mistakes

CAD = "examples/square_cup/square_cup_steel.step"
SCENE = """
cad = "{cad}"
[blank]
part = "BLANK"
size = 10
[material]
young = "206 GPa"
poisson = 0.3
locus = "von Mises"
hardening = {{swift = {{K = 565, e0 = 0.007, n = 0.26}}}}
[tools.PUNCH]
travel = -40
friction = {{velocity = {{mu = 0.15, fast = 0.05, velocity = "0.1 m/s"}}}}
[tools.DIE]
friction = {{pressure = {{mu = 0.14, pressure = "8 MPa", exponent = 0.9}}}}
friction_faces = [{{faces = [0, 3], friction = 0.02}}]
[tools.BLANK_HOLDER]
spring = {{stiffness = "2 kN/mm", preload = "10 kN"}}
stop = "3 mm"
tilts = true
at = [[60, 60, 0], [-60, 60, 0], [-60, -60, 0], [60, -60, 0]]
[drawbeads.RIGHT]
curve = [[60, -40, 0], [60, 40, 0]]
restraint = "80 N/mm"
uplift = 50
holder = "BLANK_HOLDER"
[drawbeads.MOUTH]
part = "DIE"
through = [0, -42, 0]
shape = {{radius = 5, shoulder = 2, width = 14, depth = 5, friction = 0.1}}
[[stages]]
name = "draw"
speed = "50 mm/s"
gravity = [0, 0, "-9.81 m/s^2"]
pilots = ["rim"]
[[stages]]
name = "release"
tools = {{}}
"""


@pytest.fixture
def file(tmp_path):
    from pathlib import Path

    path = tmp_path / "s.toml"
    path.write_text(SCENE.format(cad=Path(CAD).resolve().as_posix()))
    return path


def test_all_of_it_arrives_in_the_scene(file):
    scene = load_scene(file)
    draw, release = scene.stages
    punch, die, holder = draw.tools
    assert (punch.friction.mu, punch.friction.fast) == (0.15, 0.05)
    assert punch.friction.velocity == pytest.approx(100.0)
    assert die.friction.elsewhere == solver.CoulombPressure(0.14, 8.0, 0.9)
    assert die.friction.faces == {0: solver.Coulomb(0.02), 3: solver.Coulomb(0.02)}
    assert holder.spring == solver.Spring(2000.0, 10000.0)
    assert (holder.stop, holder.tilts, np.shape(holder.at)) == (3.0, True, (4, 3))
    assert (draw.speed, draw.gravity) == (50.0, (0.0, 0.0, pytest.approx(-9810.0)))
    assert draw.movements["rim"] == (0.0, 0.0, None)
    right, mouth = draw.drawbeads
    assert (right.restraint, right.uplift, right.holder, right.length) == (80.0, 50.0, "BLANK_HOLDER", 80.0)
    shape = solver.RoundBead(5.0, 2.0, 14.0, 5.0).forces(scene.blank.material, scene.blank.thickness, 0.1)
    assert (mouth.restraint, mouth.uplift) == shape
    assert len(mouth.curve) >= 2
    assert release.is_springback and not release.drawbeads


def test_check_says_what_is_on(file):
    plan = check_scene(file)["plan"]
    for text in (
        "pressed by a spring of 2000 N/mm, preload 10000 N, free to tilt along (0.0, 0.0, 1.0), stop after 3 mm",
        "friction 0.14 (p / 8 MPa)^-0.1; friction 0.02 on face(s) 0, 3",
        "drawbead RIGHT: 80 mm, restraint 80 N/mm, uplift 50 N/mm on BLANK_HOLDER",
        "group rim keeps its place across the tools' axis",
        "50 mm/s: it lasts 0.8 s",
        "gravity: (0.0, 0.0, -9810",
    ):
        assert text in plan


@pytest.mark.parametrize(
    "changes, line",
    [
        ({"tools__DIE__friction": "oil"}, 'tools.DIE.friction: found "oil", expected a number of at least 0, or {pres'),
        ({"tools__DIE__friction": {"presure": {}}}, "tools.DIE.friction.presure: unknown key; did you mean 'pressure'"),
        (
            {"tools__DIE__friction": {"velocity": {"mu": 0.1, "fast": 0.1}}},
            "tools.DIE.friction.velocity.velocity: missing, expected the velocity at which it fades",
        ),
        (
            {"tools__DIE__friction_faces": [{"faces": [True], "friction": 0.1}]},
            "tools.DIE.friction_faces[0].faces[0]: found true, expected the number, name or colour",
        ),
        ({"tools__DIE__tilts": True}, "tools.DIE.tilts: found beside no force or spring, expected one of them"),
        ({"tools__DIE__spring": {"stiffness": 0}}, "tools.DIE.spring.stiffness: found 0, expected a force per length"),
        (
            {"tools__BLANK_HOLDER__spring": {"stiffness": 10}},
            "tools.BLANK_HOLDER: found force and spring, expected at most one of travel, to, force, gap, spring",
        ),
        (
            {"drawbeads__B": {"curve": [[0, 0, 0], [1, 0, 0]]}},
            'drawbeads.B.restraint: missing, expected a force per length such as "80 N/mm", or shape',
        ),
        ({"drawbeads__B": {"restraint": 80}}, "drawbeads.B: found no curve, expected one of edges, through, curve"),
        (
            {"drawbeads__B": {"restraint": 80, "edges": [1]}},
            "drawbeads.B.part: missing, expected the part whose edges the bead follows",
        ),
        (
            {"drawbeads__B": {"restraint": 80, "part": "DIE", "edges": [1], "holder": "HOLDER"}},
            "drawbeads.B.holder: unknown tool 'HOLDER', expected one of PUNCH, DIE, BLANK_HOLDER",
        ),
        ({"stages": [{"drawbeads": ["B"]}]}, "stages[0].drawbeads: unknown drawbead 'B'; expected none here"),
        ({"stages": [{"speed": "3 mm"}]}, 'stages[0].speed: found "3 mm", not a speed, expected a speed above 0'),
        ({"stages": [{"gravity": [0, 0]}]}, "stages[0].gravity: found [0, 0], expected 3 values or more"),
    ],
)
def test_a_mistake_is_one_line(changes, line):
    (said,) = mistakes(**changes)
    assert said.startswith("s.toml: " + line)


def test_a_law_that_needs_speed_asks_for_it(file):
    file.write_text(file.read_text().replace('speed = "50 mm/s"', ""))
    with pytest.raises(SceneFileError, match="stages: stage 'draw' speed: missing, expected mm/s: .*'PUNCH'"):
        load_scene(file)


def test_a_stage_changes_how_a_tool_is_borne():
    stages = [{"tools": {"BLANK_HOLDER": {"force": 100}}}, {"tools": {"BLANK_HOLDER": {"gap": 1}}}]
    holder = {"spring": {"stiffness": 10}, "tilts": True, "at": [0, 0, 0], "friction": 0.1}
    keys = check(cup(tools__BLANK_HOLDER=holder, stages=stages), "s.toml")
    base = keys.tools["BLANK_HOLDER"]
    pressed, kept = (base.changed_by(stage.tools["BLANK_HOLDER"]) for stage in keys.stages)
    assert (pressed.force, pressed.spring, pressed.tilts, pressed.at) == (100.0, None, True, [(0.0, 0.0, 0.0)])
    assert (kept.gap, kept.tilts, kept.friction.coulomb.mu) == (1.0, None, 0.1)


def test_the_schema_knows_them():
    schema = SceneKeys.model_json_schema()
    assert {"stribeck", "pressure"} <= set(schema["$defs"]["Friction"]["properties"])
    assert "drawbeads" in schema["properties"]
