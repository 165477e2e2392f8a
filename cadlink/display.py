"""Triangles of a shape for pictures only: nothing in the mechanics ever reads them.

Runs in the reading process only.
"""

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location

CHORD = 1e-3  # largest distance of a triangle from the face, relative to the part's diagonal
ANGLE = 0.25  # largest angle between neighbouring triangles [rad]


def tessellate(shape, faces, diagonal):
    """points (n, 3) [mm] and cells (m, 3), wound so that normals leave the material."""
    BRepMesh_IncrementalMesh(shape, CHORD * diagonal, False, ANGLE, False)
    return triangles_of(faces)


def triangles_of(faces):
    """The same of faces that have been meshed."""
    points, cells, count = [], [], 0
    for face in faces:
        at = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, at)
        if mesh is None:
            continue
        move = at.Transformation()
        nodes = (mesh.Node(i) for i in range(1, mesh.NbNodes() + 1))
        if not at.IsIdentity():
            nodes = (q.Transformed(move) for q in nodes)
        p = np.array([(q.X(), q.Y(), q.Z()) for q in nodes])
        c = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)])
        c = c.reshape(-1, 3) - 1 + count
        if (face.Orientation() == TopAbs_REVERSED) != move.IsNegative():
            c = c[:, ::-1]
        points.append(p)
        cells.append(c)
        count += len(p)
    if not points:
        return np.zeros((0, 3)), np.zeros((0, 3), int)
    return np.vstack(points), np.ascontiguousarray(np.vstack(cells))
