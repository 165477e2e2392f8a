"""Many points and normals of a closed form at once, by formula: those that OpenCASCADE tells one by one."""

import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.BRepTools import BRepTools
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf

from cadlink.brep import edge_curve, explore, faces_of
from cadlink.curves import points_along, xyz
from cadlink.faces import FaceProbe, face_record

AT = gp_Ax2(gp_Pnt(3.0, -2.0, 5.0), gp_Dir(1.0, 2.0, 3.0))
BODIES = {
    "box": lambda: BRepPrimAPI_MakeBox(AT, 4.0, 5.0, 6.0).Solid(),
    "cylinder": lambda: BRepPrimAPI_MakeCylinder(AT, 4.0, 9.0).Solid(),
    "cone": lambda: BRepPrimAPI_MakeCone(AT, 6.0, 0.0, 9.0).Solid(),
    "sphere": lambda: BRepPrimAPI_MakeSphere(AT, 4.0).Solid(),
    "torus": lambda: BRepPrimAPI_MakeTorus(AT, 12.0, 4.0).Solid(),
}


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("name", BODIES)
def test_many_points_at_once_are_those_of_opencascade(name, mirrored):
    shape = BODIES[name]()
    if mirrored:
        mirror = gp_Trsf()
        mirror.SetMirror(gp_Ax2(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 1.0, 1.0)))
        shape = BRepBuilderAPI_Transform(shape, mirror, True).Shape()
    rng = np.random.default_rng(0)
    for face in faces_of(shape):
        probe = FaceProbe(face)
        u0, u1, v0, v1 = box = BRepTools.UVBounds_s(face)
        uv = [u0, v0] + rng.random((20, 2)) * [u1 - u0, v1 - v0]
        points, normals = (np.array([one(q) for q in uv]) for one in (probe.point, probe.normal))
        # A pole or an apex has none.
        uv_all = np.vstack([uv, [[u0, v1]]]) if name in ("cone", "sphere") else uv
        last = probe.normal(uv_all[-1])
        face_record(probe, box)
        assert probe.record is not None
        assert np.abs(probe.points(uv) - points).max() < 1e-13
        assert np.abs(probe.normals(uv) - normals).max() < 1e-13
        assert np.abs(probe.normals(uv_all)[-1] - last).max() < 1e-13


@pytest.mark.parametrize("name", ["box", "cone"])
def test_many_points_of_an_edge_are_those_of_opencascade(name):
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopoDS import TopoDS

    edges = [TopoDS.Edge_s(edge) for edge in explore(BODIES[name](), TopAbs_EDGE)]
    for edge, curve in ((edge, edge_curve(edge)) for edge in edges):
        if curve is not None:
            t, adaptor = np.linspace(curve.first, curve.last, 7), BRepAdaptor_Curve(edge)
            assert np.abs(points_along(edge, curve, t) - [xyz(adaptor.Value(s)) for s in t]).max() < 1e-13
