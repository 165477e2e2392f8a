"""Triangles of a part within a chord tolerance, with the exact normals at their corners. Runs as a child process."""

import io
import sys

import numpy as np
from OCP.BinTools import BinTools
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt2d
from OCP.TopAbs import TopAbs_FACE, TopAbs_OUT, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape

from cadlink.brep import explore
from cadlink.child import serve
from cadlink.curves import xyz
from cadlink.errors import CadError
from cadlink.faces import FaceProbe

BESIDE = 1e-4  # of the way to the far side of a triangle
ON = 1e-9  # of (u, v): on the rim of a face


def shape_of(brep):
    """The shape in OpenCASCADE's binary BREP."""
    shape = TopoDS_Shape()
    BinTools.Read_s(shape, io.BytesIO(brep))
    return shape


def work(job):
    """Triangles of the faces of a part.

    job : {"brep": bytes, "chord": mm, "angle": rad, "faces": indices or None}
    returns : {"points" (n, 3) mm, "cells" (m, 3), "normals" (m, 3, 3) exact at the corners, out of the material,
        "face" (m,) index of the CAD face, "on_face" (k, 3) mm, points of the faces amid triangles and their sides};
        points on an edge come once for each of its faces
    """
    shape = shape_of(job["brep"])
    BRepMesh_IncrementalMesh(shape, job["chord"], False, job["angle"], False)
    points, cells, normals, label, on_face, count = [], [], [], [], [], 0
    for number, face in enumerate(TopoDS.Face_s(f) for f in explore(shape, TopAbs_FACE)):
        if job["faces"] is not None and number not in job["faces"]:
            continue
        at = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, at)
        if mesh is None or mesh.NbTriangles() == 0:
            raise CadError(f"face {number} could not be divided into triangles; try another chord")
        move = at.Transformation()
        n = mesh.NbNodes()
        p = np.array([xyz(mesh.Node(i).Transformed(move)) for i in range(1, n + 1)])
        c = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]).reshape(-1, 3) - 1
        if (face.Orientation() == TopAbs_REVERSED) != move.IsNegative():
            c = c[:, ::-1]
        probe = FaceProbe(face)
        uv = [mesh.UVNode(i) for i in range(1, n + 1)]
        exact = np.array([probe.normal((q.X(), q.Y())) for q in uv])
        flat = np.cross(p[c[:, 1]] - p[c[:, 0]], p[c[:, 2]] - p[c[:, 0]])
        size = np.linalg.norm(flat, axis=1, keepdims=True)
        flat /= np.where(size > 0.0, size, 1.0)
        # At a pole or an apex the face has no normal: each triangle takes the one that its own side tends to.
        at_corner, places = exact[c], np.array([(q.X(), q.Y()) for q in uv])[c]
        for k, i in np.argwhere(~at_corner.any(axis=2)):
            at_corner[k, i] = limit_normal(probe, places[k, i], places[k, [i - 1, i - 2]].mean(axis=0))
        lost = ~at_corner.any(axis=2)
        at_corner[lost] = np.broadcast_to(flat[:, None], at_corner.shape)[lost]
        lost = ~at_corner.any(axis=2)
        at_corner[lost] = [0.0, 0.0, 1.0]  # a triangle without an area: dropped later
        amid = np.concatenate([places.mean(axis=1, keepdims=True), 0.5 * (places + np.roll(places, 1, axis=1))], axis=1)
        inside = BRepTopAdaptor_FClass2d(probe.face, ON)  # the chord of a hole's rim is outside
        on_face += [probe.point(q) for q in amid.reshape(-1, 2) if inside.Perform(gp_Pnt2d(*q)) != TopAbs_OUT]
        points.append(p)
        cells.append(c + count)
        normals.append(at_corner)
        label.append(np.full(len(c), number))
        count += n
    return {
        "points": np.vstack(points),
        "cells": np.ascontiguousarray(np.vstack(cells)),
        "normals": np.vstack(normals),
        "face": np.concatenate(label),
        "on_face": np.array(on_face).reshape(-1, 3),
    }


def limit_normal(probe, at, middle):
    """Normal just beside a collapsed side of (u, v), on the line through the middle of a triangle's far side."""
    u, v = at
    if not probe.normal((middle[0], v)).any():
        return probe.normal((middle[0], v + BESIDE * (middle[1] - v)))
    return probe.normal((u + BESIDE * (middle[0] - u), middle[1]))


def main(job, out):
    serve(work, job, out)


if __name__ == "__main__":
    main(*sys.argv[1:])
