"""Rational Bezier arcs and patches as numpy arrays: cut from B-splines, conics and fits.

    ctrl   control points in homogeneous coordinates (w x, w y, [w z,] w), axis 0 (and 1) runs
           over the control points, the last axis over the components
    s      parameter of one arc, in [0, 1]
    t      parameter of the CAD curve the arc was cut from, in [t0, t1]
    ramp   how t follows s: LINEAR t = t0 + s (t1 - t0); ANGLE (conic arcs of half angle a about
           tm) t = tm + 2 atan((2s - 1) tan(a/2)); RAPIDITY (hyperbolas) the same with tanh

Everything here is exact to round-off except `fit_curve` and `fit_patch`, which interpolate and
state their tolerance.
"""

from functools import lru_cache
from math import atan, atanh, ceil, comb, cos, cosh, pi, sin, sinh, tan, tanh
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

LINEAR, ANGLE, RAPIDITY = 0, 1, 2


class Arc(NamedTuple):
    ctrl: np.ndarray
    t0: float
    t1: float
    ramp: int = LINEAR

    def at(self, t):
        """Curve parameter t -> arc parameter s."""
        middle, half = 0.5 * (self.t0 + self.t1), 0.5 * (self.t1 - self.t0)
        if self.ramp == ANGLE:
            return 0.5 * (1.0 + tan(0.5 * (t - middle)) / tan(0.5 * half))
        if self.ramp == RAPIDITY:
            return 0.5 * (1.0 + tanh(0.5 * (t - middle)) / tanh(0.5 * half))
        return (t - self.t0) / (self.t1 - self.t0)

    def param(self, s):
        """Arc parameter s -> curve parameter t."""
        middle, half = 0.5 * (self.t0 + self.t1), 0.5 * (self.t1 - self.t0)
        if self.ramp == ANGLE:
            return middle + 2.0 * atan((2.0 * s - 1.0) * tan(0.5 * half))
        if self.ramp == RAPIDITY:
            return middle + 2.0 * atanh((2.0 * s - 1.0) * tanh(0.5 * half))
        return self.t0 + s * (self.t1 - self.t0)


def split(ctrl, s, axis=0):
    """Control points left and right of s (de Casteljau)."""
    b = np.moveaxis(np.asarray(ctrl, float), axis, 0)
    left, right = [b[0]], [b[-1]]
    while len(b) > 1:
        b = (1.0 - s) * b[:-1] + s * b[1:]
        left.append(b[0])
        right.append(b[-1])
    left, right = np.array(left), np.array(right[::-1])
    return np.moveaxis(left, 0, axis), np.moveaxis(right, 0, axis)


def clip(ctrl, s0, s1, axis=0):
    """Control points of the piece between s0 and s1."""
    if s1 < 1.0:
        ctrl = split(ctrl, s1, axis)[0]
    if s0 > 0.0:
        ctrl = split(ctrl, s0 / s1, axis)[1]
    return ctrl


def bernstein(degree, s):
    """Bernstein polynomials, (len(s), degree + 1)."""
    s = np.atleast_1d(np.asarray(s, float))[:, None]
    i = np.arange(degree + 1)
    binomial = np.array([comb(degree, k) for k in i])
    return binomial * s**i * (1.0 - s) ** (degree - i)


def points(ctrl, s):
    """Cartesian points of an arc at parameters s, (len(s), dim)."""
    h = bernstein(len(ctrl) - 1, s) @ ctrl
    return h[:, :-1] / h[:, -1:]


def project_ctrl(ctrl):
    """Control points in ordinary space; the arc lies in their hull (positive weights)."""
    return ctrl[..., :-1] / ctrl[..., -1:]


# --- cut from B-splines --------------------------------------------------------------------------


def span_matrices(knots, degree):
    """Spans (a, b, first, M) of a flat knot vector: Bezier points = M @ d[first : first+degree+1].

    Rows of M are blossoms of the spline at (a, .., a, b, .., b): Ramshaw 1987; de Boor's algorithm
    with one argument per level.
    """
    knots = np.asarray(knots, float)
    spans = []
    for k in range(degree, len(knots) - degree - 1):
        a, b = knots[k], knots[k + 1]
        if b <= a:
            continue
        rows = []
        for i in range(degree + 1):
            d = np.eye(degree + 1)
            for r in range(1, degree + 1):
                t = a if r <= degree - i else b
                lo, hi = knots[k - degree + r : k + 1], knots[k + 1 : k + 2 + degree - r]
                x = ((t - lo) / (hi - lo))[:, None]
                d[r:] = (1.0 - x) * d[r - 1 : -1] + x * d[r:]
            rows.append(d[degree].copy())
        spans.append((a, b, k - degree, np.array(rows)))
    return spans


def arcs_of_spline(knots, degree, ctrl, first, last, period=0.0):
    """Arcs of a B-spline between parameters first and last; a periodic one may wrap round."""
    arcs = []
    tiny = 1e-12 * (knots[-1] - knots[0])
    spans = span_matrices(knots, degree)
    for turn in (-2, -1, 0, 1, 2) if period else (0,):
        for a, b, start, matrix in spans:
            a1, b1 = a + turn * period, b + turn * period
            lo, hi = max(a1, first), min(b1, last)
            if hi - lo <= tiny:
                continue
            piece = matrix @ ctrl[start : start + degree + 1]
            s0 = 0.0 if lo - a1 <= tiny else (lo - a1) / (b1 - a1)
            s1 = 1.0 if b1 - hi <= tiny else (hi - a1) / (b1 - a1)
            arcs.append(Arc(clip(piece, s0, s1), lo, hi))
    return arcs


# --- conics --------------------------------------------------------------------------------------


def arcs_of_ellipse(centre, x, y, first, last):
    """Exact rational quadratic arcs of centre + cos(t) x + sin(t) y, each at most a quarter turn.

    Weights 1, cos a, 1 with half angle a (Piegl & Tiller, The NURBS Book, 7.3).
    """
    n = max(1, ceil((last - first) / (0.5 * pi) - 1e-9))
    ends = np.linspace(first, last, n + 1)
    half = 0.5 * (last - first) / n
    arcs = []
    for t0, t1 in zip(ends[:-1], ends[1:], strict=True):
        tm = 0.5 * (t0 + t1)
        p0 = centre + cos(t0) * x + sin(t0) * y
        p1 = cos(half) * centre + cos(tm) * x + sin(tm) * y
        p2 = centre + cos(t1) * x + sin(t1) * y
        ctrl = np.array([[*p0, 1.0], [*p1, cos(half)], [*p2, 1.0]])
        arcs.append(Arc(ctrl, t0, t1, ANGLE))
    return arcs


def arcs_of_hyperbola(centre, x, y, first, last):
    """Exact rational quadratic arcs of centre + cosh(t) x + sinh(t) y."""
    n = max(1, ceil(last - first))
    ends = np.linspace(first, last, n + 1)
    half = 0.5 * (last - first) / n
    arcs = []
    for t0, t1 in zip(ends[:-1], ends[1:], strict=True):
        tm = 0.5 * (t0 + t1)
        p0 = centre + cosh(t0) * x + sinh(t0) * y
        p1 = cosh(half) * centre + cosh(tm) * x + sinh(tm) * y
        p2 = centre + cosh(t1) * x + sinh(t1) * y
        ctrl = np.array([[*p0, 1.0], [*p1, cosh(half)], [*p2, 1.0]])
        arcs.append(Arc(ctrl, t0, t1, RAPIDITY))
    return arcs


def arcs_of_parabola(origin, x, y, focal, first, last):
    """The parabola origin + t^2/(4 focal) x + t y as one quadratic arc."""

    def blossom(a, b):
        return np.array([*(origin + a * b / (4.0 * focal) * x + 0.5 * (a + b) * y), 1.0])

    ctrl = np.array([blossom(first, first), blossom(first, last), blossom(last, last)])
    return [Arc(ctrl, first, last)]


def line_arc(start, end, first, last):
    return Arc(np.array([[*start, 1.0], [*end, 1.0]]), first, last)


# --- fits: for the few curves and surfaces that are not rational ---------------------------------


@lru_cache
def fit_matrix(degree):
    """Nodes in [0, 1] and the matrix that takes values there to Bernstein coefficients."""
    nodes = 0.5 * (chebpts1(degree + 1) + 1.0)
    return nodes, np.linalg.inv(bernstein(degree, nodes))


def fit_curve(value, breaks, tolerance, degree=11, depth=10):
    """Polynomial arcs within `tolerance` of value(t) between each two breaks, halved as needed."""
    nodes, matrix = fit_matrix(degree)
    checks = np.linspace(0.03, 0.97, 12)
    arcs, todo = [], [(a, b, 0) for a, b in zip(breaks[:-1], breaks[1:], strict=True)][::-1]
    while todo:
        a, b, level = todo.pop()
        samples = np.array([value(a + s * (b - a)) for s in nodes])
        ctrl = matrix @ samples
        ctrl = np.hstack([ctrl, np.ones((degree + 1, 1))])
        truth = np.array([value(a + s * (b - a)) for s in checks])
        if np.abs(points(ctrl, checks) - truth).max() <= tolerance or level >= depth:
            arcs.append(Arc(ctrl, a, b))
        else:
            m = 0.5 * (a + b)
            todo += [(m, b, level + 1), (a, m, level + 1)]
    return arcs


def fit_patch(value, a, b, c, d, degree=9):
    """Polynomial patch through value(u, v) on [a, b] x [c, d], and its largest miss at checks."""
    nodes, matrix = fit_matrix(degree)
    grid = np.array([[value(a + s * (b - a), c + r * (d - c)) for r in nodes] for s in nodes])
    ctrl = np.einsum("ik,jl,klx->ijx", matrix, matrix, grid)
    ctrl = np.concatenate([ctrl, np.ones((degree + 1, degree + 1, 1))], axis=2)
    checks = np.linspace(0.04, 0.96, 7)
    truth = np.array([[value(a + s * (b - a), c + r * (d - c)) for r in checks] for s in checks])
    basis = bernstein(degree, checks)
    made = np.einsum("ik,jl,klx->ijx", basis, basis, ctrl)[..., :3]
    return ctrl, float(np.abs(made - truth).max())
