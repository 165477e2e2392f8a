"""A modulus that falls with plastic strain: benchmarks.md O, SPCC with E_a = 159 GPa and xi = 30.8."""

import numpy as np
import pytest

from solver import DecayingModulus, Hill48, Material, SceneError, Swift, VonMises, Yld2000, YoshidaUemori
from tests.solver.materials.paths import metric_of, pull, tangent_errors

E, NU = 206000.0, 0.3
FALL = DecayingModulus(159000.0, 30.8)
CURVE = Swift(565.32, 0.007117, 0.2589)
SPCC = YoshidaUemori(Y=124.0, B=168.0, C=500.0, R_sat=190.0, m=12.0, b=9.0, h=0.5)


def modulus(p):
    return E - (E - FALL.E_a) * (1.0 - np.exp(-FALL.xi * p))


@pytest.mark.parametrize("p", [0.002, 0.03, 0.2])
def test_unloading_has_the_modulus_of_the_plastic_strain_reached(p):
    material = Material(E, NU, VonMises(), CURVE, modulus=FALL)
    top = CURVE(p) / modulus(p) + p  # the stress of the curve, given back with the modulus that is left
    stress, equivalent, state = pull(material, [top])
    assert stress[0] == pytest.approx(CURVE(p), rel=1e-8)
    assert equivalent[0] == pytest.approx(p, rel=1e-8)
    back, _, _ = pull(material, [top - 1e-4, top - 5e-4], old=state)
    assert stress[0] - back == pytest.approx([1e-4 * modulus(p), 5e-4 * modulus(p)], rel=1e-8)


def test_the_path_of_increments_does_not_matter():
    material = Material(E, NU, VonMises(), CURVE, modulus=FALL)
    one, _, _ = pull(material, [0.05])
    many, _, _ = pull(material, np.linspace(0.0, 0.05, 60)[1:])
    assert many[-1] == pytest.approx(one[0], rel=1e-9)


@pytest.mark.parametrize("law", [CURVE, SPCC], ids=["isotropic", "Yoshida-Uemori"])
def test_tangent_is_exact(law):
    material = Material(E, NU, Hill48(1.79, 1.51, 2.27), law, modulus=FALL)
    for scale in (1e-3, 0.02, 0.2):
        error, yields = tangent_errors(material, scale)
        assert yields.mean() > 0.5
        assert np.isfinite(error).all()
        assert np.sort(error)[-4] < 1e-6
        assert np.median(error) < 1e-8


def test_a_modulus_that_does_not_fall_changes_nothing():
    # The general return map with xi = 0 against the one-equation map.
    strains = metric_of(0.03 * np.random.default_rng(0).standard_normal((100, 3)))
    found = []
    for fall in (None, DecayingModulus(159000.0, 0.0)):
        material = Material(E, NU, Hill48(1.79, 1.51, 2.27), CURVE, modulus=fall)
        new = material.new_state(100)
        material.update(strains, material.new_state(100), new)
        found.append(new)
    assert found[1].second_stress == pytest.approx(found[0].second_stress, rel=1e-8, abs=1e-6)
    assert found[1].tangent == pytest.approx(found[0].tangent, rel=1e-6, abs=1e-2)


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: DecayingModulus(-1.0, 30.0), "modulus E_a: found -1.0, expected MPa above 0"),
        (lambda: DecayingModulus(159000.0, -1.0), "modulus xi: found -1.0, expected a number of 0 or more"),
        (
            lambda: Material(E, NU, VonMises(), CURVE, modulus=DecayingModulus(3e5, 1.0)),
            "E_a: found 300000.0, .*at most",
        ),
        (lambda: Material(E, NU, Yld2000((1.0,) * 8), CURVE, modulus=0.8), "material modulus: found 0.8"),
    ],
)
def test_wrong_values_are_refused(wrong, message):
    with pytest.raises(SceneError, match=message):
        wrong()
