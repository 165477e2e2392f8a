"""A CAD face as plain arrays: kind, closed-form parameters or Bezier patches, and its trim.

Runs in the reading process only. Planes, cylinders, cones, spheres and tori keep their closed form.
B-splines, Bezier surfaces, surfaces of revolution and extrusions become rational Bezier patches,
exactly; offset surfaces, which are not rational, are interpolated to 1e-11 of their size where they can be, and
`FaceRecord.gap` says how far they are missed.
"""

from itertools import pairwise, product
from math import hypot

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.Geom import Geom_RectangularTrimmedSurface
from OCP.GeomAbs import GeomAbs_Shape, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Curve
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TColStd import TColStd_Array1OfReal
from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopoDS import TopoDS

from cadlink.bezier import LINEAR, Arc, arcs_of_ellipse, bernstein, fit_patch, span_matrices
from cadlink.curves import arcs_of, crossed, flat_knots, xyz
from cadlink.records import CONE, CYLINDER, PATCHES, PLANE, SPHERE, TORUS, FaceRecord

KINDS = {
    GeomAbs_SurfaceType.GeomAbs_Plane: "plane",
    GeomAbs_SurfaceType.GeomAbs_Cylinder: "cylinder",
    GeomAbs_SurfaceType.GeomAbs_Cone: "cone",
    GeomAbs_SurfaceType.GeomAbs_Sphere: "sphere",
    GeomAbs_SurfaceType.GeomAbs_Torus: "torus",
    GeomAbs_SurfaceType.GeomAbs_BezierSurface: "bezier",
    GeomAbs_SurfaceType.GeomAbs_BSplineSurface: "bspline",
    GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution: "revolution",
    GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion: "extrusion",
    GeomAbs_SurfaceType.GeomAbs_OffsetSurface: "offset",
    GeomAbs_SurfaceType.GeomAbs_OtherSurface: "other",
}
FORMS = {"plane": PLANE, "cylinder": CYLINDER, "cone": CONE, "sphere": SPHERE, "torus": TORUS}
MOST_PATCHES = 4096  # of a surface that is fitted


class FaceProbe:
    """Points and normals of one face, asked of OpenCASCADE while reading; many at once by formula where there is one.

    record : FaceRecord of a closed form, None before face_record and for patches
    """

    def __init__(self, face):
        self.record = None
        self.face = TopoDS.Face_s(face.Oriented(TopAbs_FORWARD))
        self.sense = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
        self.adaptor = BRepAdaptor_Surface(self.face, False)
        self._p, self._u, self._v = gp_Pnt(), gp_Vec(), gp_Vec()

    def point(self, uv):
        return xyz(self.adaptor.Value(uv[0], uv[1]))

    def normal(self, uv):
        """Unit normal out of the material, or zeros at a singular point."""
        self.adaptor.D1(uv[0], uv[1], self._p, self._u, self._v)
        n = self._u.Crossed(self._v)
        size = n.Magnitude()
        if size <= 1e-12 * (self._u.Magnitude() + self._v.Magnitude()) ** 2:
            return np.zeros(3)
        return self.sense / size * xyz(n)

    def points(self, uv):
        """Points (n, 3) at parameters (n, 2)."""
        if self.record is not None:
            return points_on_form(self.record, uv)
        return np.array([self.point(q) for q in uv])

    def normals(self, uv):
        """Normals (n, 3) at parameters (n, 2)."""
        if self.record is not None:
            return normals_on_form(self.record, uv)
        return np.array([self.normal(q) for q in uv])


def face_record(probe, box):
    """FaceRecord of a face whose trim lies in the (u, v) box (u0, u1, v0, v1)."""
    adaptor = probe.adaptor
    kind = KINDS[adaptor.GetType()]
    record = FaceRecord(kind, FORMS.get(kind, PATCHES), probe.sense)
    if adaptor.IsUPeriodic():
        record.period[0] = adaptor.UPeriod()
    if adaptor.IsVPeriodic():
        record.period[1] = adaptor.VPeriod()
    if record.form == PATCHES:
        surface = BRep_Tool.Surface_s(probe.face)
        grid = patch_grid(surface, box)
        record.u_arcs, record.v_arcs, record.patches = grid
        if record.kind not in ("bspline", "bezier"):
            record.gap = misfit(record, adaptor)
    else:
        closed_form(record, adaptor)
        probe.record = record
    return record


def closed_form(record, adaptor):
    shape = getattr(adaptor, record.kind.capitalize())()
    at = shape.Position()
    x, y, z = xyz(at.XDirection()), xyz(at.YDirection()), xyz(at.Direction())
    right_handed = crossed(x, y) @ z > 0.0
    if record.form == PLANE:
        z = crossed(x, y)
    elif not right_handed:
        record.sense = -record.sense
    record.frame = np.array([xyz(at.Location()), x, y, z])
    if record.form in (CYLINDER, SPHERE):
        record.size[0] = shape.Radius()
    elif record.form == CONE:
        record.size[:] = shape.RefRadius(), shape.SemiAngle()
    elif record.form == TORUS:
        record.size[:] = shape.MajorRadius(), shape.MinorRadius()


def meridian(record, v):
    """Radius and height at v of a closed form, and the radial and axial part of its normal."""
    big, small = record.size
    if record.form == CYLINDER:
        return np.full_like(v, big), v, np.ones_like(v), np.zeros_like(v)
    if record.form == CONE:
        c, s = np.cos(small), np.sin(small)
        return big + v * s, v * c, np.full_like(v, c), np.full_like(v, -s)
    c, s = np.cos(v), np.sin(v)
    if record.form == SPHERE:
        return big * c, big * s, c, s
    return big + small * c, small * s, c, s


def points_on_form(record, uv):
    """Points (n, 3) of a closed form at parameters (n, 2)."""
    o, x, y, z = record.frame
    u, v = np.asarray(uv).T[..., None]
    if record.form == PLANE:
        return o + u * x + v * y
    radius, height, _, _ = meridian(record, v)
    return o + radius * (np.cos(u) * x + np.sin(u) * y) + height * z


def normals_on_form(record, uv):
    """Unit normals (n, 3) out of the material there, zeros at a pole or an apex."""
    _, x, y, z = record.frame
    u, v = np.asarray(uv).T[..., None]
    if record.form == PLANE:
        return np.repeat(record.sense * z[None], len(u), axis=0)
    radius, _, nr, nh = meridian(record, v)
    # Beyond an apex, or on the inner sheet of a torus across its axis, they point the other way.
    side = np.sign(radius) * (np.abs(radius) > 1e-9 * record.size[0])
    return record.sense * side * (nr * (np.cos(u) * x + np.sin(u) * y) + nh * z)


# --- patches -------------------------------------------------------------------------------------


def patch_grid(surface, box):
    """Rational Bezier patches of a surface over a (u, v) box.

    returns : u_arcs (nu, 3), v_arcs (nv, 3) with t0, t1, ramp of each row and column of patches,
        and the nested list of control nets
    """
    while isinstance(surface, Geom_RectangularTrimmedSurface):
        surface = surface.BasisSurface()
    name = type(surface).__name__
    if name in ("Geom_BSplineSurface", "Geom_BezierSurface"):
        return spline_grid(surface)
    if name == "Geom_SurfaceOfLinearExtrusion":
        return extrusion_grid(surface, box)
    if name == "Geom_SurfaceOfRevolution":
        return revolution_grid(surface, box)
    return fitted_grid(surface, box)


def spline_grid(surface):
    if type(surface).__name__ == "Geom_BezierSurface":
        u_knots = np.repeat([0.0, 1.0], surface.UDegree() + 1)
        v_knots = np.repeat([0.0, 1.0], surface.VDegree() + 1)
    else:
        if surface.IsUPeriodic() or surface.IsVPeriodic():
            surface = surface.Copy()
            surface.SetUNotPeriodic()
            surface.SetVNotPeriodic()
        u_knots = flat_knots(surface.UKnot, surface.UMultiplicity, surface.NbUKnots())
        v_knots = flat_knots(surface.VKnot, surface.VMultiplicity, surface.NbVKnots())
    nu, nv = surface.NbUPoles(), surface.NbVPoles()
    net = np.ones((nu, nv, 4))
    rational = surface.IsURational() or surface.IsVRational()
    for i in range(nu):
        for j in range(nv):
            p = surface.Pole(i + 1, j + 1)
            net[i, j, :3] = p.X(), p.Y(), p.Z()
            if rational:
                net[i, j, 3] = surface.Weight(i + 1, j + 1)
    net[..., :3] *= net[..., 3:]
    u_spans = span_matrices(u_knots, surface.UDegree())
    v_spans = span_matrices(v_knots, surface.VDegree())
    patches = []
    for _, _, i, m in u_spans:
        row = np.tensordot(m, net[i : i + len(m)], axes=(1, 0))
        patches.append(
            [np.moveaxis(np.tensordot(k, row[:, j : j + len(k)], axes=(1, 1)), 0, 1) for _, _, j, k in v_spans]
        )
    u_arcs = np.array([[a, b, LINEAR] for a, b, _, _ in u_spans])
    v_arcs = np.array([[a, b, LINEAR] for a, b, _, _ in v_spans])
    return u_arcs, v_arcs, patches


def widened(first, last, lowest, highest):
    """A parameter range with a little room, inside what the curve allows."""
    room = 1e-3 * (last - first)
    return max(lowest, first - room), min(highest, last + room)


def basis_arcs(curve, first, last):
    """Arcs of a basis curve over the trimmed range only (it may be a line without end)."""
    adaptor = GeomAdaptor_Curve(curve)
    if not adaptor.IsPeriodic():
        first, last = widened(first, last, adaptor.FirstParameter(), adaptor.LastParameter())
    arcs = arcs_of(GeomAdaptor_Curve(curve), first, last, False, 1e-11)
    return arcs, np.array([[a.t0, a.t1, a.ramp] for a in arcs])


def extrusion_grid(surface, box):
    """S(u, v) = C(u) + v D."""
    arcs, u_arcs = basis_arcs(surface.BasisCurve(), box[0], box[1])
    v0, v1 = widened(box[2], box[3], -np.inf, np.inf)
    d = xyz(surface.Direction())
    patches = []
    for arc in arcs:
        w = arc.ctrl[:, 3:]
        ends = [np.hstack([arc.ctrl[:, :3] + v * d * w, w]) for v in (v0, v1)]
        patches.append([np.stack(ends, axis=1)])
    return u_arcs, np.array([[v0, v1, LINEAR]]), patches


def revolution_grid(surface, box):
    """S(u, v) = C(v) turned by u about the axis, one rational quadratic arc per quarter turn.

    A point with axial part c and radial part r turns on c + cos(u) r + sin(u) (z x r); its
    middle control point is cos(a) c + cos(um) r + sin(um) (z x r), times its own weight.
    """
    axis = surface.Axis()
    o, z = xyz(axis.Location()), xyz(axis.Direction())
    arcs, v_arcs = basis_arcs(surface.BasisCurve(), box[2], box[3])
    turns = arcs_of_ellipse(np.zeros(3), np.eye(3)[0], np.eye(3)[1], box[0], box[1])
    u_arcs = np.array([[a.t0, a.t1, a.ramp] for a in turns])
    patches = []
    for turn in turns:
        row = []
        for arc in arcs:
            w = arc.ctrl[:, 3:]
            p = arc.ctrl[:, :3] - w * o
            along = (p @ z)[:, None] * z
            r = p - along
            q = np.cross(z, r)
            net = [np.hstack([c[3] * (w * o + along) + c[0] * r + c[1] * q, c[3] * w]) for c in turn.ctrl]
            row.append(np.stack(net))
        patches.append(row)
    return u_arcs, v_arcs, patches


def fitted_grid(surface, box):
    """Polynomial patches through a surface that is not rational, to 1e-11 of its size.

    Rows and columns that miss it are halved, as long as there are no more than MOST_PATCHES; misfit tells the rest.
    """

    def value(u, v):
        return xyz(surface.Value(u, v))

    corners = np.array([value(u, v) for u in box[:2] for v in box[2:]])
    tolerance = 1e-11 * max(1.0, hypot(*np.ptp(corners, axis=0)))
    from OCP.GeomAdaptor import GeomAdaptor_Surface  # needed only here

    adaptor, fitted = GeomAdaptor_Surface(surface), {}
    u_breaks = inner_breaks(adaptor, "U", box[0], box[1])
    v_breaks = inner_breaks(adaptor, "V", box[2], box[3])
    while True:
        u_ends, v_ends = list(pairwise(u_breaks)), list(pairwise(v_breaks))
        for cell in product(u_ends, v_ends):
            if cell not in fitted:
                fitted[cell] = fit_patch(value, *cell[0], *cell[1])
        missed = np.array([[fitted[u, v][1] > tolerance for v in v_ends] for u in u_ends])
        finer = halved(u_breaks, missed.any(axis=1)), halved(v_breaks, missed.any(axis=0))
        if not missed.any() or (len(finer[0]) - 1) * (len(finer[1]) - 1) > MOST_PATCHES:
            break
        u_breaks, v_breaks = finer
    u_arcs, v_arcs = (np.array([[a, b, LINEAR] for a, b in ends]) for ends in (u_ends, v_ends))
    return u_arcs, v_arcs, [[fitted[u, v][0] for v in v_ends] for u in u_ends]


def halved(breaks, which):
    """Breaks with the middles of some of their spans between them."""
    return np.sort(np.append(breaks, 0.5 * (breaks[1:] + breaks[:-1])[which]))


def misfit(record, adaptor):
    """Largest distance found between the patches of a face and its surface, at 8 x 8 points of each [mm]."""
    checks, gap = np.linspace(0.01, 0.99, 8), 0.0
    u, v = ([[Arc(None, *arc).param(s) for s in checks] for arc in arcs] for arcs in (record.u_arcs, record.v_arcs))
    for i, row in enumerate(record.patches):
        for j, net in enumerate(row):
            along, across = (bernstein(n - 1, checks) for n in net.shape[:2])
            made = np.einsum("ik,jl,klx->ijx", along, across, net)
            truth = np.array([[xyz(adaptor.Value(a, b)) for b in v[j]] for a in u[i]])
            gap = max(gap, float(np.linalg.norm(made[..., :3] / made[..., 3:] - truth, axis=2).max()))
    return gap


def inner_breaks(adaptor, letter, first, last):
    """Parameters between which a surface is smooth, cut to [first, last]."""
    n = getattr(adaptor, f"Nb{letter}Intervals")(GeomAbs_Shape.GeomAbs_CN)
    found = TColStd_Array1OfReal(1, n + 1)
    getattr(adaptor, f"{letter}Intervals")(found, GeomAbs_Shape.GeomAbs_CN)
    inner = [found.Value(i) for i in range(1, n + 2)]
    tiny = 1e-9 * (last - first)
    inner = [t for t in inner if first + tiny < t < last - tiny]
    return np.array([first, *inner, last])
