"""Cyclic loading: reference/benchmarks.md O, closed forms, and the limits of the two-surface law (theory.md 4)."""

import numpy as np
import pytest

from solver import (
    ArmstrongFrederick,
    Chaboche,
    Hill48,
    Ludwik,
    Material,
    SceneError,
    Swift,
    TwoSurface,
    VonMises,
    YoshidaUemori,
)
from tests.solver.materials.paths import metric_of, pull, reference

E, NU = 206000.0, 0.3
SPCC = {"Y": 124.0, "B": 168.0, "C": 500.0, "R_sat": 190.0, "m": 12.0, "b": 9.0, "h": 0.5}
LINE = Ludwik(200.0, 500.0, 1.0)


def steel(hardening, locus=None):
    return Material(E, NU, locus or VonMises(), hardening)


def cycle(*turns, n=50):
    """Strains from 0 through turning points."""
    ends = [0.0, *turns]
    return np.concatenate([np.linspace(a, b, n + 1)[1:] for a, b in zip(ends, ends[1:])])


def test_armstrong_frederick_follows_the_closed_path():
    rows = np.genfromtxt(
        reference("armstrong_frederick_closed.csv"), delimiter=",", skip_header=2, usecols=(1, 2, 3, 4)
    )
    x, stress, total = rows[1:, 1], rows[1:, 2], rows[1:, 3]
    got, _, state = pull(steel(ArmstrongFrederick(200.0, 10000.0, 25.0)), total)
    assert got == pytest.approx(stress, abs=5e-4)  # the table's strains end at 5e-9, times E
    assert state.history[0, 0] == pytest.approx(x[-1], abs=5e-4)


@pytest.mark.parametrize("n", [1, 3, 40])
def test_armstrong_frederick_is_exact_for_any_increment(n):
    # benchmarks.md O: sigma(0.05) = 485.3981, and -543.7391 after reversal to a plastic strain of -0.05.
    top, bottom = 0.05 + 485.398081 / E, -0.05 - 543.739099 / E
    stress, _, _ = pull(steel(ArmstrongFrederick(200.0, 10000.0, 25.0)), cycle(top, bottom, n=n))
    assert stress[[n - 1, -1]] == pytest.approx([485.398081, -543.739099], abs=1e-5)


def test_linear_kinematic_hardening():
    # benchmarks.md O: s_y = 200, H = 2000: 300 at a plastic strain of 0.05, and reverse yield at -100.
    material = steel(ArmstrongFrederick(200.0, 2000.0, 0.0))
    stress, _, top = pull(material, cycle(0.05 + 300.0 / E, n=3))
    assert stress[-1] == pytest.approx(300.0, rel=1e-9)
    tangent_modulus = E * 2000.0 / (E + 2000.0)
    for change, expected in [(-399.0 / E, -99.0), (-400.0 / E - 0.001, -100.0 - 0.001 * tangent_modulus)]:
        got, _, _ = pull(material, [0.05 + 300.0 / E + change], old=top)
        assert got[0] == pytest.approx(expected, rel=1e-7)


def test_several_backstresses_add_up():
    terms = ((20000.0, 200.0), (3000.0, 20.0), (500.0, 0.0))
    p = 0.08
    expected = 150.0 + sum(c / g * (1 - np.exp(-g * p)) if g else c * p for c, g in terms)
    stress, equivalent, _ = pull(steel(Chaboche(150.0, terms)), [p + expected / E])
    assert stress[0] == pytest.approx(expected, rel=1e-9)
    assert equivalent[0] == pytest.approx(p, rel=1e-9)


def test_chaboche_without_backstress_is_isotropic():
    curve = Swift(500.0, 0.01, 0.2)
    path = cycle(0.05, -0.02, 0.1, n=10)
    assert pull(steel(Chaboche(curve, ((0.0, 0.0),))), path)[0] == pytest.approx(pull(steel(curve), path)[0], rel=1e-9)


def test_kinematic_von_mises_is_pragers_law():
    # In shear the backstress moves by 2/3 C times the plastic strain tensor: tau = s_y/sqrt 3 + C gamma_p/3.
    c, gamma_p = 3000.0, 0.06
    tau = 200.0 / np.sqrt(3.0) + c * gamma_p / 3.0
    material = steel(ArmstrongFrederick(200.0, c, 0.0))
    new = material.new_state(1)
    material.update(metric_of([[0.0, 0.0, gamma_p + 2 * (1 + NU) * tau / E]]), material.new_state(1), new)
    assert new.stress[0] == pytest.approx([0.0, 0.0, tau], rel=1e-7, abs=1e-7)


def test_yoshida_uemori_follows_the_reference_path():
    rows = np.genfromtxt(reference("yoshida_uemori_uniaxial.csv"), delimiter=",", skip_header=2, usecols=(1, 2))
    strain, stress = rows[:, 0], rows[:, 1]
    errors = []
    for n in (1, 4, 16):
        path = np.concatenate([np.linspace(a, b, n + 1)[1:] for a, b in zip(strain[:-1], strain[1:])])
        got, _, _ = pull(steel(YoshidaUemori(**SPCC)), path)
        errors.append(np.abs(got[n - 1 :: n] - stress[1:]).max())
    assert errors[0] < 1.0  # increments of 0.004 right after a reversal, where the law turns within 0.002
    assert errors[1] < 0.3 * errors[0]
    assert errors[2] < 0.2  # the reference's own error


def test_yoshida_uemori_with_quick_bound_only_is_a_closed_form():
    # No theta (a = B + R - Y carries nothing at strain 0 when C is small), beta alone: Y + b (1 - exp(-m p)).
    law = YoshidaUemori(Y=200.0, B=200.0 + 1e-9, C=1e-9, R_sat=0.0, m=20.0, b=80.0, h=0.5)
    p = 0.05
    expected = 200.0 + 80.0 * (1 - np.exp(-20.0 * p))
    assert pull(steel(law), [p + expected / E])[0][0] == pytest.approx(expected, rel=1e-7)


def test_two_surfaces_in_contact_follow_the_tensile_curve():
    # delta_0 = 0: the inner surface starts on the outer one, and monotonic loading is that of isotropic hardening.
    curve = Swift(565.32, 0.007117, 0.2589)
    law = TwoSurface(curve, curve(0.0), 50000.0, 2.0)
    path = cycle(0.2, n=7)
    assert pull(steel(law), path)[0] == pytest.approx(pull(steel(curve), path)[0], rel=1e-9)


def test_two_surfaces_with_a_stiff_gap_are_isotropic_in_cycles_too():
    # h0 -> infinity: the gap closes without plastic strain, whatever the power; what is left is isotropic hardening.
    curve = Swift(565.32, 0.007117, 0.2589)
    path = cycle(0.03, -0.02, 0.06, n=12)
    isotropic = pull(steel(curve), path)[0]
    errors = []
    for h0 in (1e7, 1e8):
        got = pull(steel(TwoSurface(curve, 0.8 * curve(0.0), h0, 0.0)), path)[0]
        errors.append(np.abs(got - isotropic).max())
    assert errors[1] < 0.15 * errors[0]
    assert errors[1] < 2.0


@pytest.mark.parametrize("curve, slope", [(LINE, 500.0), (Swift(300.0, 0.01, 0.2), 60.0 * 0.01**-0.8)])
def test_two_surfaces_approach_for_the_first_time_with_the_slope_of_the_curve(curve, slope):
    # power 1: d delta = -(H + h0 delta/delta_0) dp with H = Y'(0), an exponential from delta_0 = Y(0) - s_y on.
    h0, sy, first = 20000.0, 80.0, float(curve(0.0))
    start = first - sy
    p = 0.9 * start / h0 * np.log(1.0 + h0 / slope)  # they touch at 1
    delta = (start + slope * start / h0) * np.exp(-h0 * p / start) - slope * start / h0
    stress, equivalent, _ = pull(steel(TwoSurface(curve, sy, h0, 1.0)), [p + (first - delta) / E])
    assert stress[0] == pytest.approx(first - delta, rel=1e-7)
    assert equivalent[0] == pytest.approx(p, rel=1e-6)


def two_surface_reversal(power, h0=20000.0, sy=120.0):
    """Stress after reversal from a plastic strain of 0.1, at plastic strains beyond it, in one increment each."""
    law = TwoSurface(LINE, sy, h0, power)
    material = steel(law)
    _, _, top = pull(material, cycle(0.1, n=20))
    outer = 200.0 + 500.0 * top.history[0, 7]
    assert top.stress[0, 0] == pytest.approx(outer, rel=1e-9)  # they touch

    def at(p):
        from scipy.optimize import brentq

        def miss(strain):
            return pull(material, [strain], old=top)[1][0] - top.equivalent[0] - p

        start = top.strain[0, 0] - 2 * sy / E
        return pull(material, [brentq(miss, start - p - 0.01, start, xtol=1e-15)], old=top)[0][0]

    return at, outer, sy


def test_two_surfaces_after_reversal_with_power_1_is_an_exponential():
    # d delta = -(H + h0 delta/delta_0) dp with H = 500, delta_0 = 2 (Y - s_y): solved by an exponential.
    at, outer, sy = two_surface_reversal(1.0)
    start, h0, h = 2 * (outer - sy), 20000.0, 500.0
    for p in (1e-3, 5e-3, 0.02):
        delta = (start + h * start / h0) * np.exp(-h0 * p / start) - h * start / h0
        assert delta > 0.0
        # Compression: stress = outer's opposite side, less what is left of the distance.
        assert at(p) == pytest.approx(-(outer - delta), rel=1e-7)


def test_two_surfaces_after_reversal_with_power_0_is_linear_until_they_touch():
    at, outer, sy = two_surface_reversal(0.0)
    start, slope = 2 * (outer - sy), 20500.0
    touch = start / slope
    for p in (0.3 * touch, 0.9 * touch):
        assert at(p) == pytest.approx(-(outer - start + slope * p), rel=1e-8)
    assert at(touch + 0.03) == pytest.approx(-(outer + 500.0 * 0.03), rel=1e-8)


def test_two_surfaces_show_the_bauschinger_effect_and_a_smooth_transient():
    curve = Swift(565.32, 0.007117, 0.2589)
    law = TwoSurface(curve, 120.0, 30000.0, 2.0)
    path = cycle(0.05, -0.02, n=400)
    stress, equivalent, state = pull(steel(law), path)
    top = stress[399]
    reverse = stress[400:][np.argmax(equivalent[400:] > equivalent[399])]
    assert reverse > top - 2 * 120.0 - 5.0  # yields 240 MPa below the top, long before -top
    assert state.history[0, 6] == 0.0 and stress[-1] < -top  # and is back on the curve of the other side at the end
    slope = np.diff(stress[420:]) / np.diff(path[420:])
    assert (np.diff(slope) < 1e-6 * E).all()  # the modulus falls without a jump
    assert state.history[0, 7] < equivalent[-1]  # the outer surface rested meanwhile


def test_reloading_the_same_way_leaves_no_trace():
    curve = Swift(565.32, 0.007117, 0.2589)
    law = TwoSurface(curve, 120.0, 30000.0, 2.0)
    _, _, midway = pull(steel(law), cycle(0.05, 0.047, n=100))
    straight, _, _ = pull(steel(law), [0.045], old=midway)
    _, _, relaxed = pull(steel(law), [0.0474], old=midway)
    again, _, _ = pull(steel(law), [0.045], old=relaxed)
    assert again[0] == pytest.approx(straight[0], rel=1e-9)


@pytest.mark.parametrize("law", [ArmstrongFrederick(200.0, 8000.0, 30.0), TwoSurface(LINE, 150.0, 2e4, 2.0)])
def test_kinematic_laws_flow_by_the_locus(law):
    # In tension along the rolling direction the r-value is that of the locus, whatever moves its centre.
    material = steel(law, Hill48(1.79, 1.51, 2.27))
    _, _, state = pull(material, cycle(0.05, -0.02, 0.08, n=5))
    plastic = state.plastic[0]
    assert plastic[1] / -(plastic[0] + plastic[1]) == pytest.approx(1.79, rel=1e-9)


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: Chaboche(-1.0, ((1.0, 1.0),)), "Chaboche size: found -1.0, expected MPa above 0 or a hardening curve"),
        (lambda: Chaboche(100.0, ((1.0,),)), r"Chaboche terms: found \(\(1.0,\),\), expected pairs"),
        (lambda: Chaboche(100.0, ((1.0, -1.0),)), "expected C in MPa and gamma of 0 or more"),
        (lambda: YoshidaUemori(**{**SPCC, "B": 100.0}), "Yoshida-Uemori B: found 100.0, expected MPa above Y"),
        (lambda: YoshidaUemori(**{**SPCC, "C": 0.0}), "Yoshida-Uemori C: found 0.0, expected a number above 0"),
        (lambda: YoshidaUemori(**{**SPCC, "h": 2.0}), "Yoshida-Uemori h: found 2.0, expected 0 up to 1"),
        (lambda: TwoSurface(LINE, 300.0, 1e4, 1.0), "two-surface yield_stress: found 300 MPa, and a curve that starts"),
        (lambda: TwoSurface(LINE, 100.0, 0.0, 1.0), "two-surface h0: found 0.0, expected MPa above 0"),
        (lambda: TwoSurface(LINE, 100.0, 1e4, -1.0), "two-surface power: found -1.0"),
        (lambda: steel(TwoSurface(lambda e: 300.0 - 10 * e, 100.0, 1e4, 1.0)).prepare(), "expected a curve that rises"),
    ],
)
def test_wrong_parameters_are_refused_in_one_line(wrong, message):
    with pytest.raises(SceneError, match=message):
        wrong()
