"""Scene files: what is read, and one line for each mistake."""

import copy
import tomllib
from pathlib import Path

import pytest

from plugins.scene_build import build_tool
from plugins.scene_file import SceneFile, SceneFileError, check, parse
from plugins.scene_keys import SceneKeys
from solver.materials.library import SHEETS

EXAMPLES = Path(__file__).parents[2] / "examples" / "square_cup"
CUP = """
name = "a cup"
cad = "cup.step"
[blank]
part = "BLANK"
size = 2.5
draw_in = {DX = [1, 0, 0]}
[material]
young = "71 GPa"
poisson = 0.33
locus = {hill = {r0 = 0.71, r45 = 0.58, r90 = 0.70}}
hardening = {swift = {K = 576.79, e0 = 0.01658, n = 0.3593}}
[tools.PUNCH]
travel = -40
friction = 0.162
[tools.DIE]
[tools.BLANK_HOLDER]
force = "19.6 kN"
[compare]
source = "a laboratory"
rows = [{quantity = "draw_in_DX", stroke = 15, measured = 5.3}]
"""


def cup(**changes):
    """The scene above with some keys set, or dropped where the value is None: blank__size=3."""
    data = copy.deepcopy(tomllib.loads(CUP))
    for path, value in changes.items():
        *tables, key = path.split("__")
        table = data
        for name in tables:
            table = table.setdefault(name, {})
        if value is None:
            del table[key]
        else:
            table[key] = value
    return data


def mistakes(**changes):
    """The lines that are said about the scene with these changes."""
    with pytest.raises(SceneFileError) as caught:
        check(cup(**changes), "s.toml")
    return str(caught.value).splitlines()


def test_values_arrive_in_mm_newton_megapascal():
    keys = check(cup(), "s.toml")
    assert keys.material.young == 71000.0
    assert keys.tools["BLANK_HOLDER"].force == pytest.approx(19600.0)
    assert keys.tools["PUNCH"].travel == -40.0
    assert keys.material.locus.hill.mean == pytest.approx((0.71 + 2 * 0.58 + 0.70) / 4)
    assert list(keys.tools) == ["PUNCH", "DIE", "BLANK_HOLDER"]  # the first that travels leads


def test_curves_arrive_as_the_solver_takes_them():
    import solver

    def curve(**described):
        return check(cup(material__hardening=described), "s.toml").material.hardening.build()

    voce = {"s0": 100, "Q": "0.2 GPa", "b": 9}
    assert curve(voce=voce) == solver.Voce(100.0, 200.0, 9.0)
    assert curve(ludwik={"s0": 100, "K": 300, "n": 0.4}) == solver.Ludwik(100.0, 300.0, 0.4)
    sherby = {"s0": 100, "s_sat": 300, "a": 5, "p": 0.8}
    assert curve(hockett_sherby=sherby) == solver.HockettSherby(100.0, 300.0, 5.0, 0.8)
    assert curve(table={"strain": [0, 1], "stress": [100, 200]})(0.5) == pytest.approx(150.0)
    swift = {"K": 500, "e0": 0.01, "n": 0.2}
    mixed = curve(sum=[{"weight": 0.25, "swift": swift}, {"weight": 0.75, "voce": voce}])
    expected = 0.25 * solver.Swift(500.0, 0.01, 0.2)(0.3) + 0.75 * solver.Voce(100.0, 200.0, 9.0)(0.3)
    assert mixed(0.3) == pytest.approx(expected, rel=1e-14)


def test_a_stage_changes_a_tool_and_keeps_the_rest():
    stages = [{"tools": {"PUNCH": {}, "DIE": {}}}, {"tools": {"PUNCH": {"force": 100, "friction": 0.05}}}]
    keys = check(cup(stages=stages), "s.toml")
    changed = keys.tools["PUNCH"].changed_by(keys.stages[1].tools["PUNCH"])
    assert (changed.travel, changed.force, changed.friction.coulomb.mu) == (None, 100.0, 0.05)
    same = keys.tools["PUNCH"].changed_by(keys.stages[0].tools["PUNCH"])
    assert (same.travel, same.friction.coulomb.mu) == (-40.0, 0.162)


def test_a_restrike_goes_to_a_place_in_a_stage_of_its_own():
    stages = [{}, {"tools": {}}, {"name": "restrike", "tools": {"PUNCH": {"to": "-4 cm"}, "DIE": {}}}]
    keys = check(cup(stages=stages), "s.toml")
    punch = keys.tools["PUNCH"].changed_by(keys.stages[2].tools["PUNCH"])
    assert (punch.travel, punch.to) == (None, -40.0)
    assert build_tool("PUNCH", punch, None, None).to == -40.0


def test_options_of_the_method_reach_it():
    import solver

    data = cup(implicit={"torsion": 0.005, "newton": {"iterations": 12}})
    method = SceneFile(Path("s.toml"), check(data, "s.toml")).method
    assert (method.torsion, method.newton.iterations) == (0.005, 12)
    assert method.penetration == solver.Implicit().penetration


def test_the_method_and_its_options_are_chosen_in_the_file():
    import solver

    data = cup(method="explicit", explicit={"waves": 20, "contact": "touch"}, implicit={"penalty": 2.0})
    keys = check(data | {"material": data["material"] | {"density": "2700 kg/m^3"}}, "s.toml")
    method = SceneFile(Path("s.toml"), keys).method
    assert isinstance(method, solver.Explicit) and isinstance(method.contact, solver.Touch)
    assert (method.waves, method.springback.penalty, method.safety) == (20.0, 2.0, solver.Explicit().safety)
    assert keys.material.build().density == pytest.approx(2.7e-9)
    assert check(cup(), "s.toml").material.build().density == pytest.approx(7.85e-9)
    with pytest.raises(SceneFileError, match="explicit safety: found 2.0, expected above 0 to 1"):
        _ = SceneFile(Path("s.toml"), check(cup(method="explicit", explicit={"safety": 2.0}), "s.toml")).method


@pytest.mark.parametrize(
    "changes, line",
    [
        ({"tools__PUNCH__travle": -40}, "tools.PUNCH.travle: unknown key; did you mean 'travel'?"),
        ({"blank__size": None, "blank__sise": 2}, "blank.sise: unknown key; did you mean 'size'?"),
        ({"tool": {}}, "tool: unknown key; did you mean 'tools'?"),
        ({"blank__thickness": -0.81}, "blank.thickness: found -0.81, expected a length above 0 in mm"),
        ({"blank__size": "2.5 kN"}, 'blank.size: found "2.5 kN", not a length, expected a length above 0'),
        ({"blank__arrangement": "tidy"}, "blank.arrangement: found \"tidy\", expected 'structured', "),
        ({"blank__symmetry": ["x", "x"]}, "blank.symmetry: found ['x', 'x'], expected each axis once"),
        ({"blank__outline": {"disc": 50}}, "blank: found part and outline, expected one of them"),
        ({"blank__part": None}, "blank: found neither part nor outline, expected one of them"),
        ({"blank__fixed": {"rim": "xw"}}, 'blank.fixed.rim: found "xw", expected the axes held'),
        ({"material": None}, "material: missing, expected a table [material]"),
        ({"material": 3}, "material: found 3, expected a table"),
        ({"material__poisson": 0.5}, "material.poisson: found 0.5, expected a number of at least 0"),
        ({"material__locus": "mises"}, 'material.locus: found "mises", expected "von Mises" or {hill'),
        ({"material__locus": {"hill": {"r0": 1}}}, "material.locus.hill: found a table with the keys r0,"),
        ({"material__hardening": {"swft": {}}}, "material.hardening.swft: unknown key; did you mean 'swi"),
        ({"material__hardening": {"voce": {"s0": 1, "Q": 1}}}, "material.hardening.voce.b: missing, exp"),
        ({"material__hardening": {"voce": {}, "swift": {}}}, "material.hardening: found swift and voce, ex"),
        ({"tools": {}}, "tools: missing, expected a table such as [tools.PUNCH]: nothing forms the blank"),
        ({"tools__PUNCH__force": 3}, "tools.PUNCH: found travel and force, expected at most one of"),
        ({"tools__PUNCH__travel": 0}, "tools.PUNCH.travel: found 0, expected a length in mm other than 0"),
        ({"tools__DIE__friction": -0.1}, "tools.DIE.friction: found -0.1, expected a number of at least 0"),
        ({"stages": [{"tools": {"PNCH": {}}}]}, "stages[0].tools.PNCH: unknown tool; did you mean 'PUNCH'?"),
        ({"stages": [{"moved": {"rim": [1]}}]}, "stages[0].moved.rim: found [1], expected three lengths"),
        ({"compare__rows": [{"quantity": "draw_in_DZ", "stroke": 1, "measured": 1}]},
         "compare.rows[0].quantity: unknown column 'draw_in_DZ'; did you mean 'draw_in_DX'?"),
        ({"cad": None}, "cad: missing, expected the STEP file"),
        ({"output": {"frames": 0}}, "output.frames: found 0, expected a whole number of at least 1"),
        ({"implicit": {"newton": {"iteration": 3}}}, "implicit.newton.iteration: unknown key; did you mean"),
    ],
)  # fmt: skip
def test_one_mistake_is_one_line(changes, line):
    changes = dict(changes)
    if changes.get("tools") == {}:
        changes["compare"] = {"source": "none", "rows": []}
    said = mistakes(**changes)
    assert len(said) == 1, said
    assert said[0].startswith(f"s.toml: {line}")


def test_several_mistakes_are_all_named():
    said = mistakes(blank__size="x", tools__DIE__friction="slippery", nam="cup")
    assert [line.split(":")[1].strip() for line in said] == ["blank.size", "tools.DIE.friction", "nam"]


def test_file_that_is_missing_or_not_toml(tmp_path):
    with pytest.raises(SceneFileError, match=r"none.toml: no such file, expected a scene file"):
        parse(tmp_path / "none.toml")
    with pytest.raises(SceneFileError, match="expected a scene file"):
        parse(tmp_path)
    (tmp_path / "bad.toml").write_text("name = 'cup'\nsize = = 3\n")
    with pytest.raises(SceneFileError, match=r"bad.toml: line 2, column \d+: .*expected TOML"):
        parse(tmp_path / "bad.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneFileError, match="not a text file"):
        parse(tmp_path / "binary.toml")


@pytest.mark.parametrize("name", ["aluminium.toml", "steel.toml"])
def test_examples_are_right(name):
    keys = SceneFile.read(EXAMPLES / name).keys
    assert keys.tools["PUNCH"].travel == -40.0
    assert (EXAMPLES / keys.cad).exists()


def test_every_key_that_must_be_there_says_what_is_expected():
    def walk(table):
        from plugins.scene_file import tables_in

        for name, field in table.model_fields.items():
            assert not field.is_required() or field.description, f"{table.__name__}.{name}"
            for inner in tables_in(field.annotation):
                walk(inner)

    walk(SceneKeys)
    assert SceneKeys.model_json_schema()["properties"]["blank"]


def test_the_schema_takes_what_the_reader_takes_in_place_of_a_table():
    schema = SceneKeys.model_json_schema()
    material = schema["properties"]["material"]
    assert {"enum": list(SHEETS)} in material["anyOf"]
    assert {"$ref": "#/$defs/Material"} in material["anyOf"]
    locus = schema["$defs"]["Material"]["properties"]["locus"]
    assert {"enum": ["von Mises"]} in locus["anyOf"] and {"$ref": "#/$defs/Locus"} in locus["anyOf"]
