"""The blank in a CAD part: the mid-plane of a plate, or a planar sheet face, as an outline.

A plate is a solid; its two largest planar faces that are parallel and face away from each other are its
sides, and their distance is its thickness. Lengths in mm, as read_step gives them.
"""

from dataclasses import dataclass
from io import BytesIO
from math import pi

import numpy as np

from cadlink.errors import CadError
from cadlink.outline import Disc, Rectangle

THICKEST = 0.25  # of the square root of a side's area: beyond that a solid is a block, not a plate
PARALLEL = 1e-6  # rad between the two sides of a plate
SAME = 1e-6  # relative to the size of the face: when a curve counts as a side of a rectangle, or as one circle


@dataclass(frozen=True, eq=False)
class FaceOutline:
    """A planar face, with its holes, where it lies in space.

    brep : the face in its own plane (first two axes, z = 0), as Open CASCADE B-rep bytes
    origin : (3,) the point of the plane nearest to the origin [mm]
    axes : (3, 3) rows: two axes in the plane, and the normal, whose largest component is positive
    area : [mm^2]
    thickness : of the plate whose mid-plane this is [mm]; None for a sheet face
    simple : Rectangle or Disc in the face's own axes where the face is one, without holes; else None
    """

    brep: bytes
    origin: np.ndarray
    axes: np.ndarray
    area: float
    thickness: float | None
    simple: Rectangle | Disc | None
    name: str = ""

    @property
    def center(self):
        """Where a node is placed: the centre of a rectangle or disc, else the origin of the own axes."""
        return self.simple.center if self.simple else (0.0, 0.0)


def blank_outline(part):
    """The outline of the blank in a part, on the mid-plane if the part is a plate.

    part : cadlink Part, or an Open CASCADE shape in mm
    returns : FaceOutline with .thickness [mm], None for a sheet face
    raises : CadError if the part is neither a plate nor a single planar face
    """
    shape, name = shape_of(part)
    faces = planar_faces(shape)
    if not faces:
        raise CadError(f"{name}: has no planar face; expected a flat plate or a planar face")
    if has_solid(shape):
        face, distance = largest_pair(faces, name)
        return face_outline(face, name, shift=-0.5 * distance, thickness=distance)
    if len(faces) > 1 or count_faces(shape) > 1:
        raise CadError(f"{name}: {count_faces(shape)} faces without a solid; expected one planar face, or a plate")
    return face_outline(faces[0], name)


@dataclass(frozen=True, eq=False)
class PlanarFace:
    """A planar face: its Open CASCADE face, a point, the normal out of the material, the area."""

    shape: object
    point: np.ndarray
    normal: np.ndarray
    area: float


def shape_of(part):
    """The Open CASCADE shape of a part, and the name for messages."""
    from OCP.TopoDS import TopoDS_Shape

    if isinstance(part, TopoDS_Shape):
        return part, "blank"
    if callable(getattr(part, "shape", None)):
        return part.shape(), part.name
    raise CadError(f"blank: expected an outline, a Part or a shape, got {type(part).__name__}")


def write_brep(shape):
    """B-rep bytes of a shape."""
    from OCP.BRepTools import BRepTools

    stream = BytesIO()
    BRepTools.Write_s(shape, stream)
    return stream.getvalue()


def subshapes(shape, kind):
    """The faces, edges ... of a shape, in its own order."""
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def has_solid(shape):
    from OCP.TopAbs import TopAbs_ShapeEnum

    return next(subshapes(shape, TopAbs_ShapeEnum.TopAbs_SOLID), None) is not None


def count_faces(shape):
    from OCP.TopAbs import TopAbs_ShapeEnum

    return sum(1 for _ in subshapes(shape, TopAbs_ShapeEnum.TopAbs_FACE))


def planar_faces(shape):
    """The planar faces of a shape."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepGProp import BRepGProp
    from OCP.GeomAbs import GeomAbs_SurfaceType
    from OCP.GProp import GProp_GProps
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    faces = []
    for item in subshapes(shape, TopAbs_ShapeEnum.TopAbs_FACE):
        face = TopoDS.Face(item)
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() != GeomAbs_SurfaceType.GeomAbs_Plane:
            continue
        plane = surface.Plane()
        normal = np.array(plane.Position().XDirection().Crossed(plane.Position().YDirection()).Coord())
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            normal = -normal
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties)
        faces.append(PlanarFace(face, np.array(plane.Location().Coord()), normal, abs(properties.Mass())))
    return faces


def largest_pair(faces, name):
    """The upper side of the plate and the distance to its lower side [mm]."""
    best = None
    for i, one in enumerate(faces):
        for other in faces[i + 1 :]:
            distance = float(np.dot(one.point - other.point, one.normal))
            opposite = np.linalg.norm(one.normal + other.normal) < PARALLEL
            area = min(one.area, other.area)
            if opposite and distance > 0.0 and (best is None or area > best[0] * (1 + 1e-9)):
                upper = one if one.normal[np.argmax(np.abs(one.normal))] > 0.0 else other
                best = area, upper, distance
    if best is None:
        raise CadError(f"{name}: no two of its planar faces are the sides of a plate; expected a flat plate")
    area, upper, distance = best
    if distance > THICKEST * area**0.5:
        raise CadError(f"{name}: its largest sides are {distance:g} mm apart; expected a thin, flat plate")
    return upper, distance


def face_outline(face, name, shift=0.0, thickness=None):
    """A planar face moved by `shift` along its outward normal, in its own axes."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf

    axes = own_axes(face.normal)
    normal = axes[2]
    origin = normal * np.dot(face.point + shift * face.normal, normal)

    # the rigid motion from space to the face's own axes, then z = 0 whatever the shift
    origin_of_face = normal * np.dot(face.point, normal)
    motion = gp_Trsf()
    frame = gp_Ax3(gp_Pnt(*map(float, origin_of_face)), gp_Dir(*map(float, normal)), gp_Dir(*map(float, axes[0])))
    motion.SetTransformation(frame)
    local = BRepBuilderAPI_Transform(face.shape, motion, True).Shape()
    return FaceOutline(write_brep(local), origin, axes, face.area, thickness, simple_outline(local), name)


def own_axes(normal):
    """(3, 3) right-handed rows: two axes in the plane, and its normal, the largest component made positive.

    A plane along two axes of space keeps them, in the order that gives the normal: z: x, y; x: y, z; y: z, x.
    """
    main = int(np.argmax(np.abs(normal)))
    normal = normal * np.sign(normal[main])
    first = np.zeros(3)
    first[(main + 1) % 3] = 1.0
    if np.abs(np.delete(normal, main)).max() < 1e-12:
        axis = np.zeros(3)
        axis[main] = 1.0
        return np.array([first, np.cross(axis, first), axis])
    first -= normal * np.dot(first, normal)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


def simple_outline(face):
    """The Rectangle or Disc that a face in the plane z = 0 is; None if it is neither, or has holes."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_CurveType
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    if sum(1 for _ in subshapes(face, TopAbs_ShapeEnum.TopAbs_WIRE)) != 1:
        return None
    curves = [BRepAdaptor_Curve(TopoDS.Edge(e)) for e in subshapes(face, TopAbs_ShapeEnum.TopAbs_EDGE)]
    kinds = {curve.GetType() for curve in curves}

    if kinds == {GeomAbs_CurveType.GeomAbs_Circle}:
        circles = [curve.Circle() for curve in curves]
        centres = np.array([circle.Location().Coord()[:2] for circle in circles])
        radii = np.array([circle.Radius() for circle in circles])
        turned = sum(abs(curve.LastParameter() - curve.FirstParameter()) for curve in curves)
        slack = SAME * radii.max()
        if np.ptp(radii) < slack and (np.ptp(centres, axis=0) < slack).all() and abs(turned - 2 * pi) < SAME:
            x, y = map(float, centres[0])
            return Disc(float(radii[0]), (x, y))

    if kinds == {GeomAbs_CurveType.GeomAbs_Line}:
        ends = np.array(
            [[curve.Value(t).Coord()[:2] for t in (curve.FirstParameter(), curve.LastParameter())] for curve in curves]
        )
        low, high = ends.min(axis=(0, 1)), ends.max(axis=(0, 1))
        slack = SAME * (high - low).max()
        on_low = (np.abs(ends - low) < slack).all(axis=1)  # (n_edges, 2): the edge lies on the side x (y) = low
        on_high = (np.abs(ends - high) < slack).all(axis=1)
        if (on_low | on_high).any(axis=1).all() and (high - low).min() > slack:
            (width, height), (x, y) = (high - low).tolist(), (0.5 * (low + high)).tolist()
            return Rectangle(width, height, (x, y))
    return None
