"""Strain-rate factors: closed forms in tension."""

import numpy as np
import pytest

from solver import ArmstrongFrederick, CowperSymonds, Material, PowerLawRate, SceneError, Swift, VonMises, Yld2000
from tests.solver.materials.paths import pull, tangent_errors

E, CURVE = 206000.0, Swift(500.0, 0.01, 0.2)


def steel(rate, locus=None, hardening=CURVE):
    return Material(E, 0.3, locus or VonMises(), hardening, rate=rate)


@pytest.mark.parametrize("locus", [VonMises(), Yld2000((1.0,) * 8, 8.0)], ids=["scalar", "general"])
@pytest.mark.parametrize(
    "rate, factor",
    [
        (CowperSymonds(40.0, 5.0), lambda rate: 1 + (rate / 40.0) ** 0.2),
        (PowerLawRate(0.001, 0.02), lambda rate: (1 + rate / 0.001) ** 0.02),
    ],
    ids=["Cowper-Symonds", "power law"],
)
def test_tension_at_a_rate(locus, rate, factor):
    p, dt = 0.1, 0.004
    expected = CURVE(p) * factor(p / dt)
    stress, equivalent, _ = pull(steel(rate, locus), [p + expected / E], dt=dt)
    assert stress[0] == pytest.approx(expected, rel=1e-8)
    assert equivalent[0] == pytest.approx(p, rel=1e-8)


def test_the_rate_scales_the_surface_that_moves():
    p, dt = 0.05, 0.01
    rate = PowerLawRate(0.1, 0.05)
    expected = 200.0 * (1 + p / dt / 0.1) ** 0.05 + 10000.0 / 25.0 * (1 - np.exp(-25.0 * p))
    material = steel(rate, hardening=ArmstrongFrederick(200.0, 10000.0, 25.0))
    assert pull(material, [p + expected / E], dt=dt)[0][0] == pytest.approx(expected, rel=1e-8)


def test_without_time_the_rate_does_not_count():
    path = np.linspace(0.0, 0.1, 6)[1:]
    assert (pull(steel(CowperSymonds(40.0, 5.0)), path)[0] == pull(steel(None), path)[0]).all()


@pytest.mark.parametrize("rate", [CowperSymonds(40.0, 5.0), PowerLawRate(0.001, 0.02)], ids=["Cowper-Symonds", "power"])
@pytest.mark.parametrize("locus", [VonMises(), Yld2000((1.0,) * 8, 8.0)], ids=["scalar", "general"])
def test_tangent_is_exact(rate, locus):
    error, yields = tangent_errors(steel(rate, locus), 0.02, dt=0.01)
    assert yields.mean() > 0.9
    assert error.max() < 1e-6


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: CowperSymonds(0.0, 5.0), "Cowper-Symonds D: found 0.0, expected a number above 0"),
        (lambda: CowperSymonds(40.0, 0.5), "Cowper-Symonds P: found 0.5, expected a number of 1 or more"),
        (lambda: PowerLawRate(1.0, 2.0), "power-law rate m: found 2.0, expected 0 up to 1"),
        (lambda: pull(steel(CowperSymonds(40.0, 5.0)), [0.1], dt=0.0), "increment of time: found 0.0"),
        (lambda: steel("fast"), "material rate: found 'fast'"),
    ],
)
def test_wrong_parameters_are_refused(wrong, message):
    with pytest.raises(SceneError, match=message):
        wrong()
