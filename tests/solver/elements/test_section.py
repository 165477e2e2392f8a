"""The layered section driven through bending and unbending under tension (benchmarks.md K)."""

import numpy as np
import pytest
from scipy.optimize import brentq

from solver import Chaboche, Material, PlanarHill, Swift
from solver.elements.section import layer_metrics, resultants

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589), "mild steel")
THICKNESS, N_LAYERS = 0.78, 25
PLACE, WEIGHT = np.polynomial.legendre.leggauss(N_LAYERS)
HEIGHT, WEIGHT = 0.5 * PLACE * THICKNESS, 0.5 * WEIGHT


def shell_section(strain, turn, old):
    """Tension [N/mm], moment [N] and the new state of the shell at a mid-surface strain ln(stretch) and a turn
    per initial length [1/mm]. Its own curvature is stretch times turn, so the moment that works on the turn is stretch
    times M; a fibre's stretch is stretch + z turn.
    """
    new, layers, result = STEEL.new_state(N_LAYERS), np.empty((N_LAYERS, 3)), np.empty((1, 6))
    stretch = np.exp(strain)
    flat, zero = np.array([[1.0, 1.0, 0.0]]), np.zeros((1, 3))
    metric, kappa = np.array([[stretch**2, 1.0, 0.0]]), np.array([[stretch * turn, 0.0, 0.0]])
    inverse = np.array([[1.0 / stretch**2, 1.0, 0.0]])
    layer_metrics(metric, kappa, flat, zero, zero, inverse, HEIGHT, np.ones(1), layers)
    assert layers[:, 0] == pytest.approx((stretch + HEIGHT * turn) ** 2, rel=1e-12)  # a circle's fibres, exactly
    STEEL.update(layers, old, new)
    resultants(new.second_stress, kappa, inverse, HEIGHT, WEIGHT, np.ones(1), THICKNESS, result)
    tension = np.sum(THICKNESS * WEIGHT * new.second_stress[:, 0] * (stretch + HEIGHT * turn))
    return tension, stretch * result[0, 3], new


def linear_section(strain, turn, old, material=STEEL):
    """The same with the reference's strain, linear over the thickness: eps = strain + turn z."""
    new = material.new_state(N_LAYERS)
    metric = np.column_stack([np.exp(2.0 * (strain + turn * HEIGHT)), np.ones(N_LAYERS), np.zeros(N_LAYERS)])
    material.update(metric, old, new)
    force = THICKNESS * WEIGHT * new.stress[:, 0]
    return force.sum(), force @ HEIGHT, new


def under_tension(section, tension, curvature, old, near):
    """Section at a curvature whose mid-surface strain carries the tension: strain, moment, state."""
    strain = brentq(lambda e: section(e, curvature, old)[0] - tension, near - 0.02, near + 0.05, xtol=1e-12)
    _, moment, new = section(strain, curvature, old)
    return strain, moment, new


# Strains at the skins are 7 %: the shell's ln(1 + turn z) differs from the reference's turn z by half their square.
@pytest.mark.parametrize("section, tolerance", [(linear_section, 5e-3), (shell_section, 0.05)])
@pytest.mark.parametrize(
    "share, strain, bent, unbent, radius",
    [
        (0.02, 0.00128, 54.894, -64.259, 139.31),
        (0.1, 0.00800, 54.782, -64.061, 139.74),
        (0.4, 0.03129, 53.027, -61.594, 145.24),
    ],
)
def test_bend_and_unbend_under_tension(share, strain, bent, unbent, radius, section, tolerance):
    flow = 2.77 / np.sqrt(4.54) * STEEL.initial_yield_stress
    tension, top = share * flow * THICKNESS, 1.0 / (5.0 + 0.5 * THICKNESS)
    state, e = STEEL.new_state(N_LAYERS), 0.0
    for curvature in np.linspace(0.0, top, 40)[1:]:
        e, moment, state = under_tension(section, tension, curvature, state, e)
    assert moment == pytest.approx(bent, rel=tolerance)
    for curvature in np.linspace(top, 0.0, 40)[1:]:
        e, moment, state = under_tension(section, tension, curvature, state, e)
    assert moment == pytest.approx(unbent, rel=tolerance)
    if section is linear_section:
        assert e == pytest.approx(strain, rel=0.03, abs=1.2e-3)
    curl = 12.0 * (1.0 - 0.3**2) * -moment / (206000.0 * THICKNESS**3)
    assert 1.0 / curl == pytest.approx(radius, rel=tolerance)


def moments_of_fibres(size, terms, path, n=4000):
    """Moment at the end of each leg of a path of curvatures, from fibres in plane strain with one unknown each.

    Sheet of normal anisotropy r in plane strain, the lateral stress at its plastic value: s = q (X + R), dp = q |de_p|,
    q = (1 + r)/sqrt(1 + 2 r), s = E/(1 - nu^2) (e - e_p), dX_i = (C_i sign - gamma_i X_i) dp, in small steps.
    """
    q, stiff = 2.77 / np.sqrt(4.54), 206000.0 / (1.0 - 0.3**2)
    plastic, p, x = np.zeros(N_LAYERS), np.zeros(N_LAYERS), np.zeros((len(terms), N_LAYERS))
    c, gamma = np.array(terms).T[:, :, None]
    moments = []
    for start, end in zip(path[:-1], path[1:], strict=True):
        for curvature in np.linspace(start, end, n + 1)[1:]:
            stress = stiff * (curvature * HEIGHT - plastic)
            beyond = stress / q - x.sum(axis=0)
            sign = np.sign(beyond)
            over, slope = np.abs(beyond) - size(p), (size(p + 1e-6) - size(p)) / 1e-6
            dp = np.maximum(over, 0.0) / (stiff / q**2 + slope + np.sum(c - gamma * x * sign, axis=0))
            plastic, p, x = plastic + sign * dp / q, p + dp, x + (c * sign - gamma * x) * dp
        stress = stiff * (end * HEIGHT - plastic)
        moments.append(THICKNESS * WEIGHT * stress @ HEIGHT)
    return moments


@pytest.mark.parametrize(
    "terms",
    [[(0.0, 0.0)], [(2000.0, 0.0)], [(8000.0, 50.0)], [(8000.0, 50.0), (1000.0, 0.0)]],
    ids=["isotropic", "Prager", "Armstrong-Frederick", "Chaboche"],
)
def test_bend_and_unbend_with_a_surface_that_moves(terms):
    size, top = Swift(300.0, 0.01, 0.2), 1.0 / (5.0 + 0.5 * THICKNESS)
    material = Material(206000.0, 0.3, PlanarHill(1.77), Chaboche(size, terms))
    state, moments = material.new_state(N_LAYERS), []
    for leg in (np.linspace(0.0, top, 60), np.linspace(top, 0.0, 60)):
        for curvature in leg[1:]:
            _, moment, state = linear_section(0.0, curvature, state, material)
        moments.append(moment)
    # The lateral stress is elastic at first, and its backstress does not forget that at once: 0.04 to 0.37 %.
    assert moments == pytest.approx(moments_of_fibres(size, terms, [0.0, top, 0.0]), rel=4e-3)
    if terms != [(0.0, 0.0)]:
        # A surface that moved is left sooner on the way back than one that grew by as much.
        alone = moments_of_fibres(
            lambda p: size(p) + sum(c * p if g == 0 else c / g * -np.expm1(-g * p) for c, g in terms),
            [(0.0, 0.0)],
            [0.0, top, 0.0],
        )
        assert moments[0] == pytest.approx(alone[0], rel=4e-3)
        assert -moments[1] < -alone[1] * 0.98
