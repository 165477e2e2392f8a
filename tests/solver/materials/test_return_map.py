"""The general return map: exact tangents, and an answer from any trial state."""

import numpy as np
import pytest

from solver import (
    ArmstrongFrederick,
    Hill48,
    Hill90,
    Material,
    PlanarHill,
    Swift,
    TwoSurface,
    Vegter,
    VonMises,
    Yld2000,
    YoshidaUemori,
)
from solver.materials.isotropic import CurveData
from solver.materials.law import NO_TANGENT
from solver.materials.rate import NO_RATE
from solver.materials.update import update_points
from solver.materials.yield_locus import gradients
from tests.solver.materials.paths import green, metric_of, tangent_errors

E, NU = 206000.0, 0.3
CURVE = Swift(565.32, 0.007117, 0.2589)
LOCI = {
    "Yld2000": Yld2000((0.4865, 1.3783, 0.7536, 1.0246, 1.0363, 0.9036, 1.2321, 1.4858), 8.0),
    "Hill90": Hill90(1.0, 1.03, 0.98, 1.1, 1.5),
    "Vegter": Vegter((1, 1.02, 0.98), (1.79, 1.51, 2.27), (1.25, 1.27, 1.26), (0.57, 0.58, 0.57), 1.2, 0.9),
}
LAWS = {
    "Armstrong-Frederick": ArmstrongFrederick(Swift(300.0, 0.01, 0.2), 10000.0, 25.0),
    "Yoshida-Uemori": YoshidaUemori(Y=124, B=168, C=500, R_sat=190, m=12, b=9, h=0.5),
    "two surfaces": TwoSurface(CURVE, 120.0, 60000.0, 2.0),
}
QUICK = [(locus, CURVE) for locus in LOCI.values()] + [(Hill48(1.79, 1.51, 2.27), law) for law in LAWS.values()]
NAMES = [f"{name} isotropic" for name in LOCI] + [f"Hill48 {name}" for name in LAWS]
SLOW = [(locus, law) for locus in LOCI.values() for law in LAWS.values()]
SLOW_NAMES = [f"{locus} {law}" for locus in LOCI for law in LAWS]


def random_strains(n, seed):
    """Logarithmic strains of up to 1.5: trial stresses up to more than a thousand times the yield stress."""
    rng = np.random.default_rng(seed)
    h = rng.standard_normal((n, 3))
    return h * (10.0 ** rng.uniform(-4, np.log10(1.5), n) / np.linalg.norm(h, axis=1))[:, None]


def check_tangents(locus, law):
    material = Material(E, NU, locus, law)
    for scale, tolerance in ((1e-3, 2e-7), (0.02, 1e-7), (0.2, 1e-6)):
        error, yields = tangent_errors(material, scale)
        assert yields.mean() > 0.5
        assert np.isfinite(error).all()
        assert np.sort(error)[-4] < tolerance  # but for states whose differences straddle a corner of the law
        assert np.median(error) < 1e-8


def check_random_states(locus, law, n):
    """Two random steps: every point ends on its yield surface and obeys the flow rule."""
    material = Material(E, NU, locus, law)
    first, second = material.new_state(n), material.new_state(n)
    material.update(metric_of(random_strains(n, 5)), material.new_state(n), first, tangent=False)
    material.update(metric_of(random_strains(n, 6)), first, second, tangent=False)
    for old, new in ((material.new_state(n), first), (first, second)):
        assert np.isfinite(new.stress).all() and np.isfinite(new.equivalent).all() and np.isfinite(new.history).all()
        flow = new.equivalent > old.equivalent
        assert flow.mean() > 0.5
        alpha, size = centre_and_size(law, new)
        phi, n_, _ = gradients(locus, new.stress - alpha)
        inside = new.equivalent < 3.9  # the curve's table ends at 4
        assert phi[flow & inside] == pytest.approx(size[flow & inside], rel=2e-8)
        assert (phi[~flow] <= size[~flow] * (1 + 1e-8)).all()
        dg = (new.equivalent - old.equivalent)[:, None]
        assert np.abs(new.plastic - old.plastic - dg * n_)[flow].max() < 1e-7


def centre_and_size(law, state):
    """Backstress (p, 3) and size (p,) of the yield surface, read off the history."""
    history, n = state.history, len(state.equivalent)
    if isinstance(law, YoshidaUemori):
        return history[:, :3] + history[:, 3:6], np.full(n, law.Y)
    if isinstance(law, TwoSurface):
        return history[:, :3], np.full(n, law.yield_stress)
    if history.shape[1]:
        return history[:, :3], law.size(state.equivalent)
    return np.zeros((n, 3)), law(state.equivalent)


@pytest.mark.parametrize("locus, law", QUICK, ids=NAMES)
def test_tangent_is_exact(locus, law):
    check_tangents(locus, law)


@pytest.mark.parametrize("locus, law", QUICK, ids=NAMES)
def test_every_random_trial_state_returns_to_the_yield_surface(locus, law):
    check_random_states(locus, law, 10_000)


@pytest.mark.parametrize("locus, law", QUICK, ids=NAMES)
def test_a_release_is_elastic_and_so_is_its_tangent(locus, law):
    # From flowing states 2 % back into the yield surface: the answer of a sheet that never yields, with the same
    # plastic strain.
    material, n = Material(E, NU, locus, law), 50
    endless = Material(E, NU, VonMises(), lambda p: 1e9 * (1.0 + p))
    flowed, back, elastic = material.new_state(n), material.new_state(n), endless.new_state(n)
    material.update(metric_of(random_strains(n, 8)), material.new_state(n), flowed)
    flows = flowed.equivalent > 0.0
    assert flows.mean() > 0.5
    alpha, _ = centre_and_size(law, flowed)
    t = alpha + 0.98 * (flowed.stress - alpha)
    compliance = np.array([[1.0, -NU, 0.0], [-NU, 1.0, 0.0], [0.0, 0.0, 2.0 * (1.0 + NU)]]) / E
    metric = metric_of(flowed.plastic + t @ compliance)
    material.update(metric, flowed, back)
    before = endless.new_state(n)
    before.plastic[:] = flowed.plastic
    endless.update(metric, before, elastic)
    assert (back.equivalent == flowed.equivalent).all()
    assert back.stress == pytest.approx(t, rel=1e-8, abs=1e-6 * np.abs(t).max())
    assert back.tangent == pytest.approx(elastic.tangent, rel=1e-9, abs=1e-9 * E)


@pytest.mark.slow
@pytest.mark.parametrize("locus, law", SLOW, ids=SLOW_NAMES)
def test_every_locus_goes_with_every_law(locus, law):
    check_tangents(locus, law)
    check_random_states(locus, law, 10_000)


@pytest.mark.slow
@pytest.mark.parametrize(
    "locus",
    [VonMises(), Hill48(1.79, 1.51, 2.27), Hill48(0.2115, 1.5769, 0.6923), *LOCI.values()],
    ids=["von Mises", "Hill48 steel", "Hill48 aluminium", *LOCI],
)
def test_a_million_random_trial_states(locus):
    check_random_states(locus, CURVE, 1_000_000)


@pytest.mark.parametrize("scale", [1e-3, 0.02, 0.3])
def test_both_return_maps_agree_where_both_apply(scale):
    # Quadratic loci with isotropic hardening: one scalar equation, or the general Newton.
    material = Material(E, NU, Hill48(1.79, 1.51, 2.27), CURVE)
    n = 200
    y = scale * np.random.default_rng(1).uniform(-1, 1, (n, 3))
    old, scalar, general = (material.new_state(n) for _ in range(3))
    material.update(green(y), old, scalar)
    g, locus, law = general, material.locus.data(), CurveData(material.law.table)
    update_points(
        locus, law, NO_RATE, material.elastic, green(y), old.plastic, old.equivalent, old.history, g.second_stress,
        g.tangent, g.strain, g.plastic, g.equivalent, g.history, g.stress, g.thickness_strain,
    )  # fmt: skip
    assert g.second_stress == pytest.approx(scalar.second_stress, rel=1e-9, abs=1e-7)
    assert g.tangent == pytest.approx(scalar.tangent, rel=1e-7, abs=1e-2)
    assert g.equivalent == pytest.approx(scalar.equivalent, rel=1e-9, abs=1e-15)
    assert g.thickness_strain == pytest.approx(scalar.thickness_strain, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("beyond", [1e-9, 1e-6, 1e-5, 1e-4])
def test_a_point_that_hardly_flows_meets_its_curve(beyond):
    # Its first plastic strain is so small that the table's slope there is none yet.
    locus, directions = VonMises(), np.random.default_rng(3).normal(size=(500, 3))
    material = Material(E, NU, locus, CURVE)
    trial = E / (1.0 - NU**2) * directions @ np.array([[1.0, NU, 0.0], [NU, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - NU)]])
    yields = CURVE(0.0) / gradients(locus, trial)[0]
    state = material.new_state(len(directions))
    material.update(green((1.0 + beyond) * yields[:, None] * directions), material.new_state(len(directions)), state)
    flow = state.equivalent > 0.0
    assert flow.sum() > 100
    _, size = centre_and_size(CURVE, state)
    assert gradients(locus, state.stress)[0][flow] == pytest.approx(size[flow], rel=1e-10)


def test_planar_hill_as_yld2000_of_exponent_2():
    # a = 2 and alphas of 1 make von Mises: the same answer by the scalar equation and by the general Newton.
    y = 0.05 * np.random.default_rng(2).uniform(-1, 1, (100, 3))
    states = []
    for locus in (PlanarHill(1.0), Yld2000((1.0,) * 8, 2.0)):
        material = Material(E, NU, locus, CURVE)
        state = material.new_state(100)
        material.update(green(y), material.new_state(100), state, tangent=False)
        states.append(state)
    assert states[1].stress == pytest.approx(states[0].stress, rel=1e-9, abs=1e-7)


def test_an_empty_tangent_costs_no_array():
    assert NO_TANGENT.size == 0
