"""Parameters found again from tests made with them."""

import numpy as np
import pytest

from solver import HockettSherby, SceneError, Swift, Voce
from solver.materials.fit import fit_curve, flow_curve, r_value

YOUNG, R = 206000.0, 1.77


def tensile_test(curve, n=600, top=0.4):
    """Engineering strain, stress and width strain of a pull past uniform elongation, elastic part included."""
    plastic = np.concatenate([np.zeros(40), np.geomspace(1e-6, top, n)])
    stress = curve(plastic)
    stress[:40] *= np.linspace(0.0, 0.999, 40)
    strain = plastic + stress / YOUNG
    width = -R / (1 + R) * plastic - 0.3 * stress / YOUNG
    return np.expm1(strain), stress * np.exp(-strain), np.expm1(width)


CASES = [
    ("swift", Swift(565.32, 0.007117, 0.2589), ("K", "e0", "n")),
    ("voce", Voce(150.0, 200.0, 12.0), ("s0", "Q", "b")),
    ("hockett_sherby", HockettSherby(150.0, 420.0, 6.0, 0.8), ("s0", "s_sat", "a", "p")),
]


@pytest.mark.parametrize("kind, curve, names", CASES, ids=[case[0] for case in CASES])
def test_a_curve_is_found_again(kind, curve, names):
    strain, stress, _ = tensile_test(curve)
    flow = flow_curve(strain, stress)
    assert flow.young == pytest.approx(YOUNG, rel=1e-6)
    fit = fit_curve(kind, flow)
    assert fit.error < 1e-7
    assert [getattr(fit.curve, name) for name in names] == pytest.approx([getattr(curve, n) for n in names], rel=1e-4)


def test_the_curve_ends_at_uniform_elongation():
    # Considere for Swift: plastic strain n - e0; the elastic strain shifts it by less than 1 %.
    strain, stress, _ = tensile_test(CASES[0][1], n=4000)
    assert flow_curve(strain, stress).plastic[-1] == pytest.approx(0.2589 - 0.007117, rel=0.01)


def test_noise_and_true_columns():
    rng = np.random.default_rng(0)
    strain, stress, _ = tensile_test(CASES[0][1])
    stress = stress * (1 + 0.002 * rng.standard_normal(len(stress)))
    true_strain, true_stress = np.log1p(strain), stress * (1 + strain)
    for flow in (flow_curve(strain, stress, young=YOUNG), flow_curve(true_strain, true_stress, true=True, young=YOUNG)):
        fit = fit_curve("swift", flow)
        assert fit.error == pytest.approx(0.002, rel=0.15)
        assert fit.curve(0.1) == pytest.approx(CASES[0][1](0.1), rel=2e-3)


def test_r_value_is_found_again():
    strain, stress, width = tensile_test(CASES[0][1])
    true_stress = stress * (1 + strain)
    assert r_value(np.log1p(strain), np.log1p(width), true_stress, YOUNG) == pytest.approx(R, rel=1e-9)
    assert r_value(np.log1p(strain), np.log1p(width)) == pytest.approx(R, rel=0.01)


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: flow_curve([0.1], [100.0]), "at least ten rows"),
        (lambda: flow_curve(np.linspace(0, 20, 50), np.full(50, 100.0)), "found a strain of 20, expected a ratio"),
        (lambda: flow_curve(-np.ones(20), np.ones(20)), "found no tension"),
        (lambda: flow_curve(np.full(20, np.nan), np.ones(20)), "no numbers"),
        (lambda: flow_curve(np.linspace(0.02, 0.2, 50), np.linspace(200, 300, 50)), "give Young's modulus"),
        (lambda: fit_curve("ludwig", flow_curve(*tensile_test(CASES[0][1])[:2])), "expected one of swift, voce"),
        (lambda: r_value([0.0, 0.01], [0.0, -0.004]), "found 0 points at strains from 0.05 to 0.15"),
        (lambda: r_value(np.linspace(0, 0.2, 50), np.linspace(0, 0.1, 50)), "expected between -1 and 0"),
    ],
)
def test_what_is_no_tensile_test_is_refused(wrong, message):
    with pytest.raises(SceneError, match=message):
        wrong()
