"""Where a plane cuts the faces of a part, as exact curves in the plane. Runs as a child process.

OpenCASCADE finds the curves: lines, circles, ellipses, parabolas and hyperbolas in closed form, others as B-splines
that miss the faces a little. Those are corrected: each point is moved onto face and plane by Newton, across the curve,
and polynomial arcs through the moved points are kept within 1e-10 mm.

    x, y, n    axes of the plane's coordinates and its normal, in space
"""

import sys
from math import hypot

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Section
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.GeomAdaptor import GeomAdaptor_Curve
from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt, gp_Vec
from OCP.ShapeAnalysis import ShapeAnalysis_Surface
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopoDS import TopoDS, TopoDS_Face

from cadlink.bezier import fit_curve, points
from cadlink.brep import explore, faces_of
from cadlink.child import serve
from cadlink.curves import arcs_of, flat_knots, xyz
from cadlink.errors import CadError
from cadlink.faces import FaceProbe
from cadlink.tessellation import shape_of

KINDS = {
    GeomAbs_CurveType.GeomAbs_Line: "line",
    GeomAbs_CurveType.GeomAbs_Circle: "circle",
    GeomAbs_CurveType.GeomAbs_Ellipse: "ellipse",
    GeomAbs_CurveType.GeomAbs_Parabola: "parabola",
    GeomAbs_CurveType.GeomAbs_Hyperbola: "hyperbola",
}
MISS = 1e-9  # mm: a curve nearer to its face than this is kept as it is
FIT = 1e-10  # mm, of the arcs of a corrected curve
FLAT = 1e-5  # sine of the angle at which a face counts as lying in the plane
NEAR = 1e-5  # mm: faces this near to the middle of a curve may be its own


def work(job):
    """Curves of a cut.

    job : {"brep": bytes, "origin", "x", "y", "normal": (3,) each}
    returns : {"curves": list of {"kind", "arcs": control points (k + 1, 3) of each (w x, w y, w), "circle": (center,
        radius) or None, "face", "miss" mm}}; arcs run with the material on their left
    """
    shape = shape_of(job["brep"])
    origin, x, y, normal = (np.asarray(job[k], float) for k in ("origin", "x", "y", "normal"))
    plane = gp_Pln(gp_Ax3(gp_Pnt(*origin), gp_Dir(*normal), gp_Dir(*x)))
    cut = BRepAlgoAPI_Section(shape, plane, False)
    cut.ComputePCurveOn1(False)
    cut.Approximation(True)
    cut.Build()
    if not cut.IsDone():
        raise CadError("OpenCASCADE found no section")
    faces = faces_of(shape)
    probes = [FaceProbe(f) for f in faces]
    finders = [ShapeAnalysis_Surface(BRep_Tool.Surface_s(f)) for f in faces]
    curves = []
    for edge in explore(cut.Shape(), TopAbs_EDGE):
        found = cut_curve(TopoDS.Edge_s(edge), cut, faces, probes, finders, (origin, x, y, normal))
        if found is not None:
            curves.append(found)
    return {"curves": curves}


def cut_curve(edge, cut, faces, probes, finders, plane):
    """One curve of the cut, or None for one without a length."""
    origin, x, y, normal = plane
    curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
    if curve is None:
        return None
    first, last = BRep_Tool.Range_s(edge)
    adaptor = GeomAdaptor_Curve(curve, first, last)
    middle, ahead = gp_Pnt(), gp_Vec()
    adaptor.D1(0.5 * (first + last), middle, ahead)
    if ahead.Magnitude() == 0.0:
        return None
    face, outward = owner_of(edge, xyz(middle), cut, faces, probes, finders, normal)
    kind = KINDS.get(adaptor.GetType(), "spline")
    arcs, miss = arcs_of(adaptor, first, last, False, 1e-11), 0.0
    if kind == "spline":
        miss = largest_miss(adaptor, first, last, probes[face], finders[face])
        if miss > MISS:
            arcs = corrected(adaptor, first, last, probes[face], finders[face], origin, normal)
            samples = np.vstack([points(arc.ctrl, np.array([0.0, 0.4, 0.9])) for arc in arcs])
            miss = max(on_face(p, probes[face], finders[face]) for p in samples)
    flat = [flattened(arc.ctrl, origin, x, y) for arc in arcs]
    # The material on the left: the normal of the face points right.
    tangent = np.array([xyz(ahead) @ x, xyz(ahead) @ y])
    out = np.array([outward @ x, outward @ y])
    if tangent[1] * out[0] - tangent[0] * out[1] < 0.0:
        flat = [c[::-1] for c in reversed(flat)]
    circle = None
    if kind == "circle":
        conic = adaptor.Circle()
        at = xyz(conic.Location()) - origin
        circle = (np.array([at @ x, at @ y]), conic.Radius())
    return {"kind": kind, "arcs": flat, "circle": circle, "face": face, "miss": miss}


def flattened(ctrl, origin, x, y):
    """(k + 1, 3) control points in the plane of (k + 1, 4) in space, homogeneous."""
    w = ctrl[:, 3:]
    p = ctrl[:, :3] - w * origin
    return np.hstack([p @ x[:, None], p @ y[:, None], w])


def owner_of(edge, middle, cut, faces, probes, finders, normal):
    """The face a curve is cut from, and its outward normal in the middle: of several the one steepest to the plane."""
    candidates = []
    ancestor = TopoDS_Face()
    if cut.HasAncestorFaceOn1(edge, ancestor):
        candidates = [i for i, f in enumerate(faces) if f.IsSame(ancestor)]
    best = steepest(candidates, middle, probes, finders, normal)
    if best is None:
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*middle)).Vertex()
        near = [i for i, f in enumerate(faces) if BRepExtrema_DistShapeShape(vertex, f).Value() <= NEAR]
        best = steepest(near, middle, probes, finders, normal)
    if best is None:
        at = middle.round(6).tolist()
        raise CadError(f"the plane touches a face near {at} without cutting it; move it a little")
    return best


def steepest(candidates, middle, probes, finders, normal):
    best, sine = None, FLAT
    for i in candidates:
        uv = finders[i].ValueOfUV(gp_Pnt(*middle), 1e-9)
        n = probes[i].normal((uv.X(), uv.Y()))
        across = np.linalg.norm(n - (n @ normal) * normal)
        if across > sine:
            best, sine = (i, n), across
    return best


def on_face(p, probe, finder):
    """Distance of a point from the surface of a face [mm]."""
    uv = finder.ValueOfUV(gp_Pnt(*map(float, p)), 1e-10)
    return float(np.linalg.norm(probe.point((uv.X(), uv.Y())) - p))


def largest_miss(adaptor, first, last, probe, finder):
    return max(on_face(xyz(adaptor.Value(t)), probe, finder) for t in np.linspace(first, last, 9))


def corrected(adaptor, first, last, probe, finder, origin, normal):
    """Arcs through the points of face and plane nearest to a curve, within FIT."""
    point, tangent = gp_Pnt(), gp_Vec()
    p, su, sv = gp_Pnt(), gp_Vec(), gp_Vec()

    def value(t):
        adaptor.D1(t, point, tangent)
        c, d = xyz(point), xyz(tangent)
        d /= np.linalg.norm(d)
        uv = finder.ValueOfUV(point, 1e-10)
        u, v = uv.X(), uv.Y()
        for _ in range(8):
            probe.adaptor.D1(u, v, p, su, sv)
            q, a, b = xyz(p), xyz(su), xyz(sv)
            matrix = np.array([[a @ normal, b @ normal], [a @ d, b @ d]])
            miss = np.array([(origin - q) @ normal, (c - q) @ d])
            if abs(np.linalg.det(matrix)) <= 1e-14 * max(1e-300, np.abs(matrix).max() ** 2):
                return c
            du, dv = np.linalg.solve(matrix, miss)
            u, v = u + du, v + dv
            if hypot(*miss) < 1e-12:
                break
        q = probe.point((u, v))
        return q - ((q - origin) @ normal) * normal

    breaks = [first, last]
    if adaptor.GetType() == GeomAbs_CurveType.GeomAbs_BSplineCurve:
        spline = adaptor.BSpline()
        knots = flat_knots(spline.Knot, spline.Multiplicity, spline.NbKnots())
        tiny = 1e-9 * (last - first)
        breaks = [first, *[t for t in np.unique(knots) if first + tiny < t < last - tiny], last]
    return fit_curve(value, breaks, FIT, depth=4)


def main(job, out):
    serve(work, job, out)


if __name__ == "__main__":
    main(*sys.argv[1:])
