"""Loose faces of a product joined along the edges they share within a tolerance. Runs in the reading process only."""

from typing import NamedTuple

from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape


class Sewn(NamedTuple):
    """A body made of loose faces.

    shape   solid where the faces close, shell otherwise, or a face that joined no other
    olds    the faces of the file its faces come from, in the order of faces_in(shape)
    n_free  edges of the shell that only one face has
    """

    shape: TopoDS_Shape
    olds: list
    n_free: int


def faces_in(shape):
    """Faces in file order, each once: the numbers of Part."""
    seen = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, TopAbs_FACE, seen)
    return [seen.FindKey(i + 1) for i in range(seen.Extent())]


def is_loose(body):
    """Whether a body is a face, or a shell of a single one."""
    kind = body.ShapeType()
    return kind == TopAbs_FACE or (kind == TopAbs_SHELL and len(faces_in(body)) == 1)


def sew(bodies, tolerance):
    """Bodies that loose faces make when sewn within a tolerance [mm]: a list of Sewn, or None where none join."""
    sewing = BRepBuilderAPI_Sewing(tolerance)
    olds = [face for body in bodies for face in faces_in(body)]
    for face in olds:
        sewing.Add(face)
    sewing.Perform()
    result = sewing.SewedShape()
    if result.IsNull():
        return None
    news = TopTools_IndexedMapOfShape()
    old_of = []
    for old in olds:
        new = sewing.ModifiedSubShape(old) if sewing.IsModifiedSubShape(old) else old
        if news.FindIndex(new) == 0:
            news.Add(new)
            old_of.append(old)
    found = []
    for kind, avoid in ((TopAbs_SHELL, None), (TopAbs_FACE, TopAbs_SHELL)):
        walk = TopExp_Explorer(result, kind) if avoid is None else TopExp_Explorer(result, kind, avoid)
        while walk.More():
            body = walk.Current()
            walk.Next()
            numbers = [news.FindIndex(face) for face in faces_in(body)]
            if 0 in numbers:
                return None  # a face was cut in two: what it is called would be lost
            n_free = free_edges(body)
            if kind == TopAbs_SHELL and n_free == 0 and BRep_Tool.IsClosed_s(body):
                body = BRepBuilderAPI_MakeSolid(TopoDS.Shell_s(body)).Solid()
            found.append(Sewn(body, [old_of[k - 1] for k in numbers], n_free))
    if sum(len(s.olds) for s in found) != len(olds) or len(found) == len(bodies):
        return None
    return found


def free_edges(shape):
    """How many edges only one face has; seams and poles do not count."""
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

    around = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_EDGE, TopAbs_FACE, around)
    count = 0
    for i in range(1, around.Extent() + 1):
        edge = TopoDS.Edge_s(around.FindKey(i))
        faces = around.FindFromIndex(i)
        if faces.Size() == 1 and not BRep_Tool.Degenerated_s(edge):
            face = TopoDS.Face_s(faces.First())
            count += not BRep_Tool.IsClosed_s(edge, face)
    return count
