"""Edges of a CAD shape as plain arrays: 3-D curves, and their traces (pcurves) in a face's (u, v).

Runs in the reading process only: the one place, with faces.py, that asks OpenCASCADE for geometry.
"""

from typing import NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
from OCP.GeomAbs import GeomAbs_CurveType as CurveType
from OCP.GeomAdaptor import GeomAdaptor_Curve

from cadlink.bezier import (
    arcs_of_ellipse,
    arcs_of_hyperbola,
    arcs_of_parabola,
    arcs_of_spline,
    fit_curve,
    line_arc,
)
from cadlink.records import BEZIER, CIRCLE, LINE, EdgeCurve

STATIONS = 33  # samples along an edge


def xyz(p):
    """A gp point, vector or direction as an array."""
    return np.array([p.X(), p.Y(), p.Z()])


def xy(p):
    return np.array([p.X(), p.Y()])


def crossed(a, b):
    """Cross products along the last axis; np.cross takes ten times as long for a few."""
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]


def arcs_of(adaptor, first, last, flat, tolerance):
    """Arcs of a 2-D (flat) or 3-D curve adaptor between two parameters."""
    vec = xy if flat else xyz
    kind = adaptor.GetType()
    if kind == CurveType.GeomAbs_Line:
        return [line_arc(vec(adaptor.Value(first)), vec(adaptor.Value(last)), first, last)]
    if kind in (CurveType.GeomAbs_Circle, CurveType.GeomAbs_Ellipse):
        circle = kind == CurveType.GeomAbs_Circle
        conic = adaptor.Circle() if circle else adaptor.Ellipse()
        rx, ry = (conic.Radius(),) * 2 if circle else (conic.MajorRadius(), conic.MinorRadius())
        x, y = vec(conic.XAxis().Direction()), vec(conic.YAxis().Direction())
        return arcs_of_ellipse(vec(conic.Location()), rx * x, ry * y, first, last)
    if kind == CurveType.GeomAbs_Hyperbola:
        conic = adaptor.Hyperbola()
        x, y = vec(conic.XAxis().Direction()), vec(conic.YAxis().Direction())
        rx, ry = conic.MajorRadius(), conic.MinorRadius()
        return arcs_of_hyperbola(vec(conic.Location()), rx * x, ry * y, first, last)
    if kind == CurveType.GeomAbs_Parabola:
        conic = adaptor.Parabola()
        axis = conic.Axis() if flat else conic.Position()
        x = vec(axis.XAxis().Direction()) if flat else vec(axis.XDirection())
        y = vec(axis.YAxis().Direction()) if flat else vec(axis.YDirection())
        origin = vec(conic.Location())
        return arcs_of_parabola(origin, x, y, conic.Focal(), first, last)
    if kind == CurveType.GeomAbs_BezierCurve:
        curve = adaptor.Bezier()
        degree = curve.Degree()
        knots = np.repeat([0.0, 1.0], degree + 1)
        return arcs_of_spline(knots, degree, poles_of(curve, vec), first, last)
    if kind == CurveType.GeomAbs_BSplineCurve:
        curve = adaptor.BSpline()
        period = 0.0
        if curve.IsPeriodic():
            period = curve.LastParameter() - curve.FirstParameter()
            curve = curve.Copy()
            curve.SetNotPeriodic()
        knots = flat_knots(curve.Knot, curve.Multiplicity, curve.NbKnots())
        degree = curve.Degree()
        return arcs_of_spline(knots, degree, poles_of(curve, vec), first, last, period)
    # Offset and other curves are not rational: interpolate, far below any CAD tolerance.
    breaks = np.linspace(first, last, 5)
    return fit_curve(lambda t: vec(adaptor.Value(t)), breaks, tolerance)


def poles_of(curve, vec):
    """Homogeneous control points of a Geom or Geom2d Bezier or B-spline curve."""
    n = curve.NbPoles()
    p = np.array([vec(curve.Pole(i)) for i in range(1, n + 1)])
    w = np.ones((n, 1))
    if curve.IsRational():
        w[:, 0] = [curve.Weight(i) for i in range(1, n + 1)]
    return np.hstack([p * w, w])


def flat_knots(knot, multiplicity, n):
    return np.repeat([knot(i) for i in range(1, n + 1)], [multiplicity(i) for i in range(1, n + 1)])


def edge_curve(edge):
    """The 3-D curve of an edge, or None for a degenerate one (a pole)."""
    if BRep_Tool.Degenerated_s(edge):
        return None
    curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
    if curve is None:
        return None
    first, last = BRep_Tool.Range_s(edge)
    adaptor = GeomAdaptor_Curve(curve, first, last)
    kind = adaptor.GetType()
    arcs = arcs_of(adaptor, first, last, False, 1e-11)
    frame = np.zeros((3, 3))
    form = BEZIER
    if kind == CurveType.GeomAbs_Line:
        form = LINE
    elif kind == CurveType.GeomAbs_Circle:
        form = CIRCLE
        circle = adaptor.Circle()
        r = circle.Radius()
        x, y = xyz(circle.XAxis().Direction()), xyz(circle.YAxis().Direction())
        frame = np.array([xyz(circle.Location()), r * x, r * y])
    return EdgeCurve(form, frame, arcs, first, last)


def points_along(edge, curve, t):
    """Points (n, 3) of an edge with its EdgeCurve at parameters (n,)."""
    if curve.form == LINE:
        a, b = curve.arcs[0].ctrl[:, :3]
        return a + ((t - curve.first) / (curve.last - curve.first))[:, None] * (b - a)
    if curve.form == CIRCLE:
        centre, x, y = curve.frame
        return centre + np.cos(t)[:, None] * x + np.sin(t)[:, None] * y
    adaptor = BRepAdaptor_Curve(edge)
    return np.array([xyz(adaptor.Value(s)) for s in t])


class Trace(NamedTuple):
    """An edge as one face sees it: its pcurve, in the direction the wire runs.

    arcs   list of Arc with 2-D control points, in the curve's own direction
    start, end   (2,) (u, v) where the wire enters and leaves it
    samples   (k, 2) of (u, v) at equal steps of the edge parameter; two on a straight pcurve
    near_start, near_end   (2,) (u, v) a thousandth of the way in from start and end
    """

    arcs: list
    reversed: bool
    start: np.ndarray
    end: np.ndarray
    samples: np.ndarray
    near_start: np.ndarray
    near_end: np.ndarray


def trace_of(edge, face, is_reversed):
    """The trace of an edge on a face (taken FORWARD), or None where there is no pcurve."""
    pcurve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
    if pcurve is None:
        return None
    first, last = BRep_Tool.Range_s(edge, face)
    adaptor = Geom2dAdaptor_Curve(pcurve, first, last)
    arcs = arcs_of(adaptor, first, last, True, 1e-12)
    straight = adaptor.GetType() == CurveType.GeomAbs_Line
    steps = (first, last) if straight else np.linspace(first, last, STATIONS)
    samples = np.array([xy(adaptor.Value(t)) for t in steps])
    inward = 1e-3 * (last - first)
    ends = [samples[0], samples[-1]]
    near = [xy(adaptor.Value(first + inward)), xy(adaptor.Value(last - inward))]
    if is_reversed:
        ends, near = ends[::-1], near[::-1]
    return Trace(arcs, is_reversed, ends[0], ends[1], samples, near[0], near[1])
