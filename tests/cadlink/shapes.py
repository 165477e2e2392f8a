"""Solids and shells for the tests, one for each kind of face and each trap."""

from math import pi

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_NurbsConvert,
    BRepBuilderAPI_Transform,
)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell, BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.Geom import (
    Geom_BezierSurface,
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Ellipse,
    Geom_OffsetSurface,
    Geom_ToroidalSurface,
)
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Circ, gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array2OfPnt, TColgp_HArray1OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal, TColStd_Array2OfReal
from OCP.TopAbs import TopAbs_EDGE, TopAbs_SOLID
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS

TILTED = gp_Ax2(gp_Pnt(1.0, -2.0, 0.5), gp_Dir(1.0, 2.0, 3.0))


def solid_in(shape):
    """The one solid in the result of a Boolean operation or a fillet."""
    return TopExp_Explorer(shape, TopAbs_SOLID).Current()


def box():
    return BRepPrimAPI_MakeBox(gp_Pnt(-10.0, -7.0, -4.0), 20.0, 14.0, 8.0).Solid()


def cylinder(radius=8.0, height=12.0):
    return BRepPrimAPI_MakeCylinder(TILTED, radius, height).Solid()


def cylinder_with_cross_hole():
    """The hole leaves through the seam."""
    axes = gp_Ax2(gp_Pnt(-20.0, 0.0, 6.0), gp_Dir(1.0, 0.0, 0.0))
    body = BRepPrimAPI_MakeCylinder(8.0, 12.0).Solid()
    hole = BRepPrimAPI_MakeCylinder(axes, 3.0, 40.0).Solid()
    return solid_in(BRepAlgoAPI_Cut(body, hole).Shape())


def cone():
    return BRepPrimAPI_MakeCone(TILTED, 9.0, 3.0, 10.0).Solid()


def cone_with_apex():
    return BRepPrimAPI_MakeCone(TILTED, 9.0, 0.0, 10.0).Solid()


def sphere():
    return BRepPrimAPI_MakeSphere(TILTED, 7.0).Solid()


def sphere_cap():
    return BRepPrimAPI_MakeSphere(TILTED, 7.0, -0.3, 1.2, 2.0).Solid()


def torus():
    return BRepPrimAPI_MakeTorus(TILTED, 12.0, 4.0).Solid()


def torus_part():
    return BRepPrimAPI_MakeTorus(TILTED, 12.0, 4.0, 0.3, 2.5, 4.0).Solid()


def rounded(body, radius, chosen):
    """Edges rounded whose ends (2, 3) `chosen` takes."""
    fillet = BRepFilletAPI_MakeFillet(body)
    walk = TopExp_Explorer(body, TopAbs_EDGE)
    while walk.More():
        edge = TopoDS.Edge_s(walk.Current())
        ends = [BRep_Tool.Pnt_s(v) for v in (TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge))]
        if chosen(np.array([[p.X(), p.Y(), p.Z()] for p in ends])):
            fillet.Add(radius, edge)
        walk.Next()
    return solid_in(fillet.Shape())


def pin(radius=8.0, round=6.0):
    """A pin rounded by more than half its radius: a torus whose tube is wider than its ring."""
    body = BRepPrimAPI_MakeCylinder(radius, 12.0).Solid()
    return rounded(body, round, lambda ends: (ends[:, 2] > 11.0).all() and np.ptp(ends, axis=0).max() < 1e-9)


def punch(corner=4.0, round=3.0):
    """A box whose corners in plan are rounded by `corner` and its foot by `round`: quarters of such a torus."""
    upright = rounded(box(), corner, lambda ends: np.ptp(ends[:, 2]) > 1.0)
    return rounded(upright, round, lambda ends: (ends[:, 2] < -3.9).all())


def bowl():
    """The cavity that such a punch leaves in a block."""
    block = BRepPrimAPI_MakeBox(gp_Pnt(-14.0, -11.0, -8.0), 28.0, 22.0, 10.0).Solid()
    return solid_in(BRepAlgoAPI_Cut(block, punch()).Shape())


def spindle_sheet(first, last, ring=2.0, tube=8.0):
    """A piece of the surface of a torus that cuts its axis, from one angle of the tube to another."""
    surface = Geom_ToroidalSurface(gp_Ax3(TILTED), ring, tube)
    return BRepBuilderAPI_MakeFace(surface, 0.4, 3.0, first, last, 1e-6).Face()


def as_nurbs(shape):
    return BRepBuilderAPI_NurbsConvert(shape, True).Shape()


def mirrored(shape):
    """Mirrored in the y-z plane: frames become left-handed."""
    move = gp_Trsf()
    move.SetMirror(gp_Ax2(gp_Pnt(3.0, 0.0, 0.0), gp_Dir(1.0, 0.0, 0.0)))
    return BRepBuilderAPI_Transform(shape, move, True).Shape()


def moved(shape):
    """Placed by a location, as in an assembly."""
    from OCP.TopLoc import TopLoc_Location

    move = gp_Trsf()
    move.SetRotation(gp_Ax1(gp_Pnt(1.0, 2.0, 3.0), gp_Dir(1.0, -1.0, 0.5)), 0.8)
    return shape.Moved(TopLoc_Location(move))


def spline_curve(points, degree=3, weights=None, knots=None, multiplicities=None):
    n = len(points)
    poles = TColgp_Array1OfPnt(1, n)
    for i, p in enumerate(points):
        poles.SetValue(i + 1, gp_Pnt(*map(float, p)))
    if knots is None:
        inner = n - degree - 1
        knots = np.linspace(0.0, 1.0, inner + 2)
        multiplicities = [degree + 1, *[1] * inner, degree + 1]
    k, m = TColStd_Array1OfReal(1, len(knots)), TColStd_Array1OfInteger(1, len(knots))
    for i, (knot, count) in enumerate(zip(knots, multiplicities, strict=True)):
        k.SetValue(i + 1, float(knot))
        m.SetValue(i + 1, int(count))
    if weights is None:
        return Geom_BSplineCurve(poles, k, m, degree)
    w = TColStd_Array1OfReal(1, n)
    for i, x in enumerate(weights):
        w.SetValue(i + 1, float(x))
    return Geom_BSplineCurve(poles, w, k, m, degree)


def closed_profile(curve):
    """Face in the x-z plane between a curve and the straight way back from its end."""
    edge = BRepBuilderAPI_MakeEdge(curve).Edge()
    back = BRepBuilderAPI_MakeEdge(curve.EndPoint(), curve.StartPoint()).Edge()
    return BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(edge, back).Wire()).Face()


WAVE = [(5, 0, 0), (9, 0, 1), (6, 0, 4), (12, 0, 6), (6, 0, 9), (5, 0, 11)]


def revolution(angle=2.0 * pi):
    """A spline turned about the z axis."""
    axis = gp_Ax1(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0))
    return BRepPrimAPI_MakeRevol(closed_profile(spline_curve(WAVE)), axis, angle).Shape()


def revolution_of_ellipse():
    """An ellipse turned about an axis outside it: neither u nor v is a polynomial parameter."""
    ellipse = Geom_Ellipse(gp_Ax2(gp_Pnt(12.0, 0.0, 1.0), gp_Dir(0.0, 1.0, 0.0)), 5.0, 2.0)
    wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(ellipse).Edge()).Wire()
    axis = gp_Ax1(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0))
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(wire).Face(), axis, 2.0).Shape()


def extrusion():
    """A rational spline swept along a slanted line."""
    weights = [1.0, 2.0, 0.7, 1.5, 0.6, 1.0]
    face = closed_profile(spline_curve(WAVE, weights=weights))
    return BRepPrimAPI_MakePrism(face, gp_Vec(2.0, 9.0, 1.0)).Shape()


def extrusion_of_ellipse():
    ellipse = Geom_Ellipse(TILTED, 8.0, 3.0)
    wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(ellipse).Edge()).Wire()
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire).Face(), gp_Vec(1.0, 2.0, 9.0)).Shape()


def bumpy_surface(rational=False, crease=False, seed=7):
    """Bicubic B-spline over about 20 x 20 mm; with a crease along u = 0.5 if asked."""
    rng = np.random.default_rng(seed)
    n = 7
    poles = TColgp_Array2OfPnt(1, n, 1, n)
    weights = TColStd_Array2OfReal(1, n, 1, n)
    for i in range(n):
        for j in range(n):
            height = 3.0 * rng.random()
            if crease:
                height = 2.0 * abs(i - 3) + 0.2 * j
            poles.SetValue(i + 1, j + 1, gp_Pnt(3.3 * i, 3.3 * j + 0.3 * i, height))
            weights.SetValue(i + 1, j + 1, float(0.5 + rng.random()) if rational else 1.0)
    inner = [1.0] if crease else [0.25, 0.5, 0.75]
    counts = [4, 3, 4] if crease else [4, 1, 1, 1, 4]
    knots = [0.0, 0.5, 1.0] if crease else [0.0, *inner, 1.0]
    k, m = TColStd_Array1OfReal(1, len(knots)), TColStd_Array1OfInteger(1, len(knots))
    for i, (knot, count) in enumerate(zip(knots, counts, strict=True)):
        k.SetValue(i + 1, knot)
        m.SetValue(i + 1, count)
    if rational:
        return Geom_BSplineSurface(poles, weights, k, k, m, m, 3, 3)
    return Geom_BSplineSurface(poles, k, k, m, m, 3, 3)


def face_on(surface):
    return BRepBuilderAPI_MakeFace(surface, 1e-6).Face()


def bezier_face():
    rng = np.random.default_rng(3)
    poles = TColgp_Array2OfPnt(1, 5, 1, 4)
    for i in range(5):
        for j in range(4):
            poles.SetValue(i + 1, j + 1, gp_Pnt(5.0 * i, 6.0 * j, 8.0 * rng.random()))
    return face_on(Geom_BezierSurface(poles))


def valley(profile, width=30.0):
    """A Bezier curve of poles (x, z) drawn along y."""
    poles = TColgp_Array2OfPnt(1, len(profile), 1, 2)
    for i, (x, z) in enumerate(profile):
        for j in range(2):
            poles.SetValue(i + 1, j + 1, gp_Pnt(float(x), width * j, float(z)))
    return face_on(Geom_BezierSurface(poles))


def offset_face(distance=0.3):
    return face_on(Geom_OffsetSurface(bumpy_surface(), distance))


def bumpy_solid(rational=False, seed=7):
    """A B-spline face swept down: freeform top and bottom, extruded sides, trimmed by a hole."""
    body = BRepPrimAPI_MakePrism(face_on(bumpy_surface(rational, seed=seed)), gp_Vec(0.0, 0.0, -6.0)).Shape()
    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(9.0, 11.0, -20.0), gp_Dir(0.1, 0.2, 1.0)), 3.0, 40.0)
    return solid_in(BRepAlgoAPI_Cut(body, drill.Solid()).Shape())


def creased_face():
    return face_on(bumpy_surface(crease=True))


def filleted_box(radius=1.5):
    body = box()
    fillet = BRepFilletAPI_MakeFillet(body)
    walk = TopExp_Explorer(body, TopAbs_EDGE)
    while walk.More():
        fillet.Add(radius, TopoDS.Edge_s(walk.Current()))
        walk.Next()
    return solid_in(fillet.Shape())


def l_profile(radius=0.3):
    """Two legs that meet in a concave fillet."""
    legs = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 10.0, 6.0, 2.0).Solid()
    up = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 2.0, 6.0, 8.0).Solid()
    body = BRepAlgoAPI_Fuse(legs, up)
    body.SimplifyResult()
    body = body.Shape()
    return rounded(body, radius, lambda ends: (np.abs(ends[:, [0, 2]] - 2.0) < 1e-9).all())


def boss_sliver():
    """A plate with a boss 1e-4 mm high."""
    plate = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 20.0, 20.0, 2.0).Solid()
    axes = gp_Ax2(gp_Pnt(10.0, 10.0, 1.0), gp_Dir(0.0, 0.0, 1.0))
    boss = BRepPrimAPI_MakeCylinder(axes, 4.0, 1.0001).Solid()
    return solid_in(BRepAlgoAPI_Fuse(plate, boss).Shape())


def star_vertex():
    """A cube with a notch whose corner touches: convex, concave and saddle vertices."""
    body = box()
    notch = BRepPrimAPI_MakeBox(gp_Pnt(0.0, 0.0, 0.0), 30.0, 30.0, 30.0).Solid()
    spike = BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(-5.0, 0.0, 4.0), gp_Dir(0, 0, 1)), 3.0, 0.0, 5.0).Solid()
    return solid_in(BRepAlgoAPI_Fuse(BRepAlgoAPI_Cut(body, notch).Shape(), spike).Shape())


def plane_face():
    """One free planar face with a hole."""
    plane = gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0.3, 0.2, 1.0))
    face = BRepBuilderAPI_MakeFace(plane, -5.0, 5.0, -4.0, 4.0).Face()
    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, -9), gp_Dir(0, 0, 1)), 2.0, 20.0).Solid()
    return BRepAlgoAPI_Cut(face, drill).Shape()


def bent_tube(points=((0, 0, 0), (5, 0, 7), (18, 0, -3), (30, 0, 6)), radius=1.8):
    """A circle swept along a spline through points: its side is closed, of degree 6 around and 9 along."""
    through = TColgp_HArray1OfPnt(1, len(points))
    for i, p in enumerate(points):
        through.SetValue(i + 1, gp_Pnt(*map(float, p)))
    fit = GeomAPI_Interpolate(through, False, 1e-9)
    fit.Perform()
    path = fit.Curve()
    ring = BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(path.StartPoint(), gp_Dir(1.0, 0.0, 0.0)), radius)).Edge()
    pipe = BRepOffsetAPI_MakePipeShell(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(path).Edge()).Wire())
    pipe.Add(BRepBuilderAPI_MakeWire(ring).Wire(), False, False)
    pipe.Build()
    pipe.MakeSolid()
    return pipe.Shape()


def round_to_square(height=11.0, radius=8.3, x=12.0, y=9.0):
    """A rectangle of 2 x by 2 y lofted to a circle: four twisted sides."""
    corners = BRepBuilderAPI_MakePolygon()
    for a, b in ((-x, -y), (x, -y), (x, y), (-x, y)):
        corners.Add(gp_Pnt(a, b, 0.0))
    corners.Close()
    circle = gp_Circ(gp_Ax2(gp_Pnt(0.0, 0.0, height), gp_Dir(0.0, 0.0, 1.0)), radius)
    loft = BRepOffsetAPI_ThruSections(True)
    loft.AddWire(corners.Wire())
    loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire())
    return loft.Shape()


SOLIDS = {
    "box": box,
    "cylinder": cylinder,
    "cross hole": cylinder_with_cross_hole,
    "cone": cone,
    "apex": cone_with_apex,
    "sphere": sphere,
    "cap": sphere_cap,
    "torus": torus,
    "torus part": torus_part,
    "pin": pin,
    "punch": punch,
    "bowl": bowl,
    "revolution": revolution,
    "half revolution": lambda: revolution(2.5),
    "revolved ellipse": revolution_of_ellipse,
    "extrusion": extrusion,
    "extruded ellipse": extrusion_of_ellipse,
    "bspline": bumpy_solid,
    "rational": lambda: bumpy_solid(True),
    "rational torus": lambda: as_nurbs(torus()),
    "rational sphere": lambda: as_nurbs(sphere()),
    "rational cone": lambda: as_nurbs(cone_with_apex()),
    "bent tube": bent_tube,
    "loft": round_to_square,
    "filleted box": filleted_box,
    "L profile": l_profile,
    "sliver": boss_sliver,
    "notched": star_vertex,
    "mirrored torus": lambda: mirrored(torus_part()),
    "mirrored punch": lambda: mirrored(punch()),
    "mirrored cone": lambda: mirrored(cone()),
    "mirrored fillets": lambda: mirrored(filleted_box()),
    "mirrored bspline": lambda: mirrored(bumpy_solid()),
    "moved bspline": lambda: moved(bumpy_solid()),
    "moved fillets": lambda: moved(filleted_box()),
    "moved revolution": lambda: moved(revolution()),
}

SHELLS = {
    "bezier": bezier_face,
    "offset": offset_face,
    "crease": creased_face,
    "plane": plane_face,
    "outer sheet": lambda: spindle_sheet(-1.5, 1.7),
    "inner sheet": lambda: spindle_sheet(2.2, 4.0),
    "both sheets": lambda: spindle_sheet(0.5, 3.5),
}


def upright_cylinder():
    return BRepPrimAPI_MakeCylinder(6.0, 12.0).Solid()


def l_profile_sharp():
    legs = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 10.0, 6.0, 2.0).Solid()
    up = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 2.0, 6.0, 8.0).Solid()
    return solid_in(BRepAlgoAPI_Fuse(legs, up).Shape())


def box_sewn_with_a_gap(gap=5e-4):
    """A box whose top floats above its walls, sewn with a tolerance of 1e-3."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL

    sewing = BRepBuilderAPI_Sewing(1e-3)
    walk = TopExp_Explorer(box(), TopAbs_FACE)
    lift = gp_Trsf()
    lift.SetTranslation(gp_Vec(0.0, 0.0, gap))
    count = 0
    while walk.More():
        face = walk.Current()
        count += 1
        if count == 6:  # the top of a box by BRepPrimAPI_MakeBox
            face = BRepBuilderAPI_Transform(face, lift, True).Shape()
        sewing.Add(face)
        walk.Next()
    sewing.Perform()
    shell = TopExp_Explorer(sewing.SewedShape(), TopAbs_SHELL).Current()
    return BRepBuilderAPI_MakeSolid(TopoDS.Shell_s(shell)).Solid()


SOLIDS["gap"] = box_sewn_with_a_gap
