"""Bezier arcs cut from splines and conics are the same curves."""

from math import cos, cosh, pi, sin, sinh

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from cadlink import bezier

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 13])
def test_arcs_of_a_spline_are_the_spline(degree):
    inner = np.sort(RNG.random(4))
    knots = np.concatenate([np.zeros(degree + 1), inner, [inner[-1]] * (degree > 1), np.ones(degree + 1)])
    n = len(knots) - degree - 1
    ctrl = np.hstack([RNG.normal(size=(n, 3)), 0.5 + RNG.random((n, 1))])
    spline = BSpline(knots, ctrl, degree)
    arcs = bezier.arcs_of_spline(knots, degree, ctrl, 0.1, 0.93)
    assert arcs[0].t0 == 0.1 and arcs[-1].t1 == 0.93
    for arc in arcs:
        t = np.linspace(arc.t0, arc.t1, 7)[:-1]
        h = spline(t)
        made = bezier.points(arc.ctrl, [arc.at(x) for x in t])
        assert made == pytest.approx(h[:, :3] / h[:, 3:], abs=1e-9)


def test_periodic_spline_may_wrap_round():
    """A range across the seam continues with the start of the curve."""
    knots, ctrl = np.array([0.0, 0.0, 0.5, 1.0, 1.0]), np.array([[0, 0, 1.0], [2, 0, 1.0], [0, 0, 1.0]])
    arcs = bezier.arcs_of_spline(knots, 1, ctrl, 0.75, 1.25, period=1.0)
    assert [(a.t0, a.t1) for a in arcs] == [(0.75, 1.0), (1.0, 1.25)]
    assert bezier.points(arcs[0].ctrl, [0.0])[0] == pytest.approx([1.0, 0.0])
    assert bezier.points(arcs[1].ctrl, [1.0])[0] == pytest.approx([1.0, 0.0])


@given(st.floats(-7.0, 7.0), st.floats(0.01, 2.0 * pi), st.floats(0.0, 1.0))
@settings(max_examples=60, deadline=None)
def test_ellipse_arcs_keep_the_angle(first, turn, part):
    centre, x, y = np.array([1.0, 2.0]), np.array([3.0, 1.0]), np.array([-0.5, 2.0])
    arcs = bezier.arcs_of_ellipse(centre, x, y, first, first + turn)
    t = first + part * turn
    arc = next(a for a in arcs if t <= a.t1 + 1e-12)
    assert bezier.points(arc.ctrl, [arc.at(t)])[0] == pytest.approx(centre + cos(t) * x + sin(t) * y, abs=1e-12)
    assert arc.param(arc.at(t)) == pytest.approx(t, abs=1e-12)


def test_hyperbola_and_parabola_arcs():
    o, x, y = np.zeros(2), np.array([1.0, 0.2]), np.array([0.0, 2.0])
    for t in np.linspace(-1.4, 2.0, 9):
        arc = next(a for a in bezier.arcs_of_hyperbola(o, x, y, -1.5, 2.1) if t <= a.t1)
        assert bezier.points(arc.ctrl, [arc.at(t)])[0] == pytest.approx(cosh(t) * x + sinh(t) * y)
        assert arc.param(arc.at(t)) == pytest.approx(t)
        (arc,) = bezier.arcs_of_parabola(o, x, y, 0.7, -1.5, 2.1)
        assert bezier.points(arc.ctrl, [arc.at(t)])[0] == pytest.approx(t * t / 2.8 * x + t * y)


@given(st.integers(1, 13), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
@settings(max_examples=60, deadline=None)
def test_halves_are_parts_of_the_whole(degree, cut, part):
    ctrl = np.random.default_rng(degree).normal(size=(degree + 1, 2)) + 3.0
    ctrl = np.hstack([ctrl, np.ones((degree + 1, 1))])
    left, right = bezier.split(ctrl, cut)
    whole = bezier.points(ctrl, [part * cut, cut + part * (1.0 - cut)])
    assert bezier.points(left, [part])[0] == pytest.approx(whole[0], abs=1e-10)
    assert bezier.points(right, [part])[0] == pytest.approx(whole[1], abs=1e-10)


def test_fit_meets_its_tolerance():
    arcs = bezier.fit_curve(lambda t: np.array([np.exp(t), np.sin(3 * t)]), [0.0, 1.0, 2.0], 1e-11)
    for arc in arcs:
        s = RNG.random(20)
        t = arc.t0 + s * (arc.t1 - arc.t0)
        truth = np.column_stack([np.exp(t), np.sin(3 * t)])
        assert np.abs(bezier.points(arc.ctrl, s) - truth).max() < 2e-11
