"""`cadlink materials`, and the material tables of scene files."""

import json
import tomllib

import numpy as np
import pytest

import solver
from plugins.command_line import main
from plugins.scene_file import SceneFileError, check

SCENE = """
[blank]
outline = {rectangle = [10, 10]}
size = 5
thickness = 1
[[stages]]
moved = {symmetry_x = [0, 0, 0]}
"""
TABLE = """
[material]
young = "206 GPa"
poisson = 0.3
locus = %s
hardening = %s
"""
SWIFT = "{swift = {K = 565, e0 = 0.007, n = 0.26}}"


def material(text):
    return check(tomllib.loads(text + SCENE), "s.toml").material.build()


@pytest.mark.parametrize(
    "locus, expected",
    [
        ('"von Mises"', solver.VonMises()),
        ("{hill = {r0 = 1, r45 = 2, r90 = 3}}", solver.PlanarHill(2.0)),
        ("{hill48 = {r0 = 1.79, r45 = 1.51, r90 = 2.27}}", solver.Hill48(1.79, 1.51, 2.27)),
        ("{hill90 = {s0 = 1, s45 = 1.03, s90 = 0.98, sb = 1.1, r45 = 1.5}}", solver.Hill90(1, 1.03, 0.98, 1.1, 1.5)),
        (
            "{vegter = {uniaxial = [1, 1], r = [1, 2], plane_strain = [1.1, 1.1], shear = [0.6, 0.6],"
            " biaxial = 1, rb = 1}}",
            solver.Vegter((1, 1), (1, 2), (1.1, 1.1), (0.6, 0.6), 1, 1),
        ),
        ("{yld2000 = {alphas = [1, 1, 1, 1, 1, 1, 1, 1], a = 6}}", solver.Yld2000((1.0,) * 8, 6.0)),
    ],
)
def test_every_locus_has_a_table(locus, expected):
    assert material(TABLE % (locus, SWIFT)).locus == expected


def test_yld2000_from_its_tests():
    tests = "s0 = 1, s45 = 0.8114, s90 = 0.9102, sb = 1.035, r0 = 0.2115, r45 = 1.5769, r90 = 0.6923, rb = 0.67"
    got = material(TABLE % (f"{{yld2000 = {{{tests}}}}}", SWIFT)).locus
    assert got == solver.Yld2000.fit(1, 0.8114, 0.9102, 1.035, 0.2115, 1.5769, 0.6923, 0.67)


@pytest.mark.parametrize(
    "hardening, expected",
    [
        ('{chaboche = {size = "200 MPa", terms = [[10000, 25]]}}', solver.ArmstrongFrederick(200.0, 10000.0, 25.0)),
        (
            f"{{chaboche = {{curve = {SWIFT}, terms = [[8000, 50], [500, 0]]}}}}",
            solver.Chaboche(solver.Swift(565, 0.007, 0.26), ((8000, 50), (500, 0))),
        ),
        (
            "{yoshida_uemori = {Y = 124, B = 168, C = 500, R_sat = 190, m = 12, b = 9, h = 0.5}}",
            solver.YoshidaUemori(124, 168, 500, 190, 12, 9, 0.5),
        ),
        (
            f"{{two_surface = {{curve = {SWIFT}, yield_stress = 120, h0 = 60000, power = 2}}}}",
            solver.TwoSurface(solver.Swift(565, 0.007, 0.26), 120, 60000, 2),
        ),
    ],
)
def test_every_hardening_law_has_a_table(hardening, expected):
    assert material(TABLE % ('"von Mises"', hardening)).hardening == expected


def test_rates_moduli_and_published_sheets():
    table = TABLE % ('"von Mises"', SWIFT)
    assert material(table + "rate = {cowper_symonds = {D = 40, P = 5}}").rate == solver.CowperSymonds(40, 5)
    assert material(table + "rate = {power_law = {reference = 0.001, m = 0.02}}").rate == solver.PowerLawRate(
        0.001, 0.02
    )
    fall = material(table + 'modulus = {E_a = "159 GPa", xi = 30.8}').modulus
    assert fall == solver.DecayingModulus(159000.0, 30.8)
    got = material('material = "numisheet93-steel"')
    assert got.locus == solver.Hill48(1.79, 1.51, 2.27)
    assert got.name == "numisheet93-steel"


@pytest.mark.parametrize(
    "text, message",
    [
        (
            'material = "steel"',
            'material: found "steel", expected a table .material., or a published sheet: numisheet93',
        ),
        (TABLE % ("{hill48 = {r0 = 1}}", SWIFT), "material.locus.hill48.r45: missing"),
        (TABLE % ("{yld2000 = {s0 = 1}}", SWIFT), "material.locus.yld2000: .* expected alphas, or all of s0, s45"),
        (TABLE % ("{hill = {r = 1}, hill48 = {}}", SWIFT), "material.locus: found hill and hill48, expected"),
        (TABLE % ('"von Mises"', "{chaboche = {terms = [[1, 1]]}}"), "chaboche: .* expected size in MPa, or a curve"),
        (TABLE % ('"von Mises"', "{yoshida_uemori = {Y = 1}}"), "material.hardening.yoshida_uemori.B: missing"),
        (TABLE % ('"von Mises"', SWIFT) + "rate = {}", "material.rate: .* expected a rate factor"),
    ],
)
def test_wrong_tables_are_refused_by_key(text, message):
    with pytest.raises(SceneFileError, match=message):
        material(text)


def test_list_and_show(capsys):
    assert main(["materials", "list", "--json"]) == 0
    names = [row["name"] for row in json.loads(capsys.readouterr().out)]
    assert "aa2090-t3" in names
    assert main(["materials", "show", "aa2090-t3", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["r_value"][0] == pytest.approx(0.2115)
    assert shown["yield_stress"][-1] == pytest.approx(0.9102)
    assert "P" in shown["grade"]
    assert main(["materials", "show", "numisheet93-steel"]) == 0
    assert "Taylor et al." in capsys.readouterr().out
    assert main(["materials", "list"]) == 0
    assert main(["materials", "show", "steel"]) == 2
    assert "there are numisheet93-steel" in capsys.readouterr().err


def write_test(path, header="strain,stress,width_strain"):
    plastic = np.concatenate([np.zeros(40), np.geomspace(1e-6, 0.4, 600)])
    stress = 565.32 * (0.007117 + plastic) ** 0.2589
    stress[:40] *= np.linspace(0.0, 0.999, 40)
    strain, width = plastic + stress / 206000.0, -1.77 / 2.77 * plastic - 0.3 * stress / 206000.0
    rows = np.column_stack([np.expm1(strain), stress * np.exp(-strain), np.expm1(width)])
    np.savetxt(path, rows, delimiter=",", header=header, comments="")


def test_fit_a_tensile_test_with_a_plot(tmp_path, capsys):
    write_test(tmp_path / "test.csv")
    assert main(["materials", "fit", str(tmp_path / "test.csv"), "--json", "--plot", str(tmp_path / "fit.png")]) == 0
    result = json.loads(capsys.readouterr().out)
    swift = result["curves"]["swift"]
    assert [swift["K"], swift["e0"], swift["n"]] == pytest.approx([565.32, 0.007117, 0.2589], rel=1e-4)
    assert result["r_value"] == pytest.approx(1.77, rel=1e-6)
    assert (tmp_path / "fit.png").read_bytes()[:4] == b"\x89PNG"
    assert main(["materials", "fit", str(tmp_path / "test.csv")]) == 0
    assert "r-value 1.77" in capsys.readouterr().out


def test_a_plot_of_a_sheet(tmp_path):
    assert main(["materials", "show", "numisheet93-steel", "--plot", str(tmp_path / "sheet.png")]) == 0
    assert (tmp_path / "sheet.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    "text, message",
    [
        ("a,b\n1,2\n", "found columns a, b, expected one called strain"),
        ("strain,stress\n1,x\n", "column 'stress' holds what is no number"),
        ("", "found no rows"),
        ("strain,stress\n0,0\n0.1,100\n", "at least ten rows"),
    ],
)
def test_a_file_that_is_no_test_gives_one_line(tmp_path, capsys, text, message):
    (tmp_path / "bad.csv").write_text(text)
    assert main(["materials", "fit", str(tmp_path / "bad.csv")]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1
