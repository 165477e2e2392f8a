"""The parts of a STEP file with names, colours and places. Runs in the reading process only."""

from collections import Counter
from typing import NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.IFSelect import IFSelect_RetDone
from OCP.Quantity import Quantity_Color
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.StepGeom import StepGeom_CartesianTransformationOperator3d
from OCP.StepRepr import StepRepr_RepresentationItem
from OCP.TCollection import TCollection_ExtendedString
from OCP.TColStd import TColStd_SequenceOfAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_AttributeIterator, TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from cadlink.references import wrong_references
from cadlink.sewing import faces_in, is_loose, sew

UNITS = {
    "millimetre": "mm",
    "metre": "m",
    "centimetre": "cm",
    "micrometre": "um",
    "nanometre": "nm",
    "decimetre": "dm",
    "hectometre": "hm",
    "kilometre": "km",
    "inch": "inch",
    "foot": "ft",
}
UNNAMED = ("", "NONE")  # what writers put where a name is missing


def read_parts(path, part_record, tolerance=0.0):
    """{"unit", "parts": [(name, colour, record)]} of a STEP file, or {"error": line}.

    tolerance : mm, within which loose faces of a product are sewn; 0 leaves them loose
    """
    document = TDocStd_Document(TCollection_ExtendedString("cad"))
    XCAFDoc_ShapeTool.SetAutoNaming_s(False)
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(True)
    if reader.ReadFile(path) != IFSelect_RetDone:
        return {"error": "it starts like STEP but OpenCASCADE cannot parse it"}
    wrong = wrong_references(reader.ChangeReader().WS().Model(), path)
    if wrong:
        return {"error": wrong}
    if is_mirrored(reader.ChangeReader().WS().Model()):
        return {
            "error": "it places a part as its mirror image, which OpenCASCADE would turn instead; "
            "export the mirrored part as a solid of its own"
        }
    unit = source_unit(reader.ChangeReader())
    if not reader.Transfer(document):
        return {"error": "found STEP data but no shape in it, expected solids, shells or faces"}
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    roots = TDF_LabelSequence()
    shapes.GetFreeShapes(roots)
    found = []
    for i in range(1, roots.Length() + 1):
        collect(roots.Value(i), TopLoc_Location(), (), None, colors, tolerance, found)
    if not found:
        return {"error": "found no face in it, expected solids, shells or faces"}
    for body in found:
        n = sum(BRep_Tool.Surface_s(TopoDS.Face_s(face)) is None for face in body.faces)
        if n:
            called = repr(body.name) if body.name else "without a name"
            found_here = f"part {called} is tessellated: {n} of its faces are triangles, expected exact faces"
            return {"error": f"{found_here}; export it as B-rep, or read a mesh file with FacetSurface"}
    names = distinct([body.name for body in found])
    file_names = face_namer(reader.ChangeReader())
    parts = []
    for name, body in zip(names, found, strict=True):
        record = part_record(placed(body.shape, body.place))
        record["face_names"] = [file_names(face) for face in body.faces]
        record["face_colors"] = [shape_color(face, colors) or body.base_color for face in body.faces]
        record["tree"], record["sewn"] = body.tree, body.sewn
        parts.append((name, body.color, record))
    return {"unit": unit, "parts": parts}


def is_mirrored(model):
    """Whether a file has a placement whose axes are left-handed (CARTESIAN_TRANSFORMATION_OPERATOR_3D)."""
    for i in range(1, model.NbEntities() + 1):
        entity = model.Value(i)
        if not isinstance(entity, StepGeom_CartesianTransformationOperator3d):
            continue
        axes = entity.Axis1(), entity.Axis2(), entity.Axis3()
        if any(axis is None for axis in axes):
            continue  # the third then follows from the others
        x, y, z = (np.array([axis.DirectionRatiosValue(k) for k in (1, 2, 3)]) for axis in axes)
        if np.cross(x, y) @ z < 0.0:
            return True
    return False


class Body(NamedTuple):
    """A solid, shell or face of a product, where it is placed, and what it is called.

    color : shown for the whole; base_color : what a face has that is not coloured itself
    faces : the faces of the file its faces come from; tree : names of the products from the top of the assembly down
    sewn : (tolerance [mm], number of faces, number of free edges) where loose faces were joined, or None
    """

    name: str
    color: tuple | None
    base_color: tuple | None
    shape: TopoDS_Shape
    place: TopLoc_Location
    faces: list
    tree: tuple
    sewn: tuple | None = None


def placed(shape, place):
    """A shape at its place; one that is mirrored or scaled there is made anew, since locations may only move."""
    move = place.Transformation()
    if move.IsNegative() or abs(move.ScaleFactor() - 1.0) > 1e-12:
        return BRepBuilderAPI_Transform(shape, move, True).Shape()
    return shape.Moved(place)


def face_namer(reader: STEPControl_Reader):
    """A function that tells the name of a face's ADVANCED_FACE in the file, "" for none."""
    transfer = reader.WS().TransferReader()

    def name_of(face):
        entity = transfer.EntityFromShapeResult(face, 1)
        if not isinstance(entity, StepRepr_RepresentationItem) or entity.Name() is None:
            return ""
        name = entity.Name().ToCString().strip()
        return "" if name in UNNAMED else name

    return name_of


def source_unit(reader: STEPControl_Reader):
    """The file's own length unit."""
    lengths, angles, solid_angles = (TColStd_SequenceOfAsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    found = [lengths.Value(i).ToCString().lower() for i in range(1, lengths.Length() + 1)]
    if not found:
        return "mm"
    return UNITS.get(found[0], found[0])


def collect(label, place, tree, color, colors, tolerance, found):
    """Append the Body of every solid, free shell and free face below a label.

    The name is the product's, or the nearest one above it; an instance's own name is only an id.
    """
    color = label_color(label, colors) or color
    if XCAFDoc_ShapeTool.IsReference_s(label):
        place = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
        product = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(label, product)
        label = product
        color = color or label_color(label, colors)
    own_name = label_name(label)
    tree = (*tree, own_name) if own_name else tree
    name = tree[-1] if tree else ""
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        parts = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetComponents_s(label, parts)
        for i in range(1, parts.Length() + 1):
            collect(parts.Value(i), place, tree, color, colors, tolerance, found)
        return
    bodies = bodies_of(XCAFDoc_ShapeTool.GetShape_s(label))
    own_names = sub_shape_names(label)
    many = len(bodies) > 1
    loose = [body for body in bodies if is_loose(body)] if tolerance > 0.0 else []
    joined = sew(loose, tolerance) if len(loose) > 1 else None
    for body in bodies:
        if joined is not None and is_loose(body):
            continue
        called = next((n for s, n in own_names if s.IsSame(body)), name) if many else name
        base = shape_color(body, colors) or color
        shown = base or face_color(body, colors)
        found.append(Body(called, shown, base, body, place, faces_in(body), tree))
    for new in joined or ():
        report = (tolerance, len(new.olds), new.n_free) if len(new.olds) > 1 else None
        shown = color or face_color(new.olds[0], colors)
        found.append(Body(name, shown, color, new.shape, place, new.olds, tree, report))


def bodies_of(shape):
    """Solids, then shells outside solids, then faces outside shells."""
    bodies = []
    for kind, avoid in (
        (TopAbs_SOLID, None),
        (TopAbs_SHELL, TopAbs_SOLID),
        (TopAbs_FACE, TopAbs_SHELL),
    ):
        walk = TopExp_Explorer(shape, kind)
        if avoid is not None:
            walk = TopExp_Explorer(shape, kind, avoid)
        while walk.More():
            bodies.append(walk.Current())
            walk.Next()
    return [b for b in bodies if TopExp_Explorer(b, TopAbs_FACE).More()]


def distinct(names):
    """Names as they are; "solid" for none; "-2", "-3" after the second and third of a kind."""
    names = [n or "solid" for n in names]
    total, seen, taken, result = Counter(names), Counter(), set(names), []
    for name in names:
        seen[name] += 1
        k = seen[name]
        new = name if k == 1 and name != "solid" else f"{name}-{k}"
        while total[name] > 1 and k > 1 and new in taken:
            k += 1
            new = f"{name}-{k}"
        taken.add(new)
        result.append(new)
    return result


def label_name(label):
    """The name on a label, "" for none. (FindAttribute crashes on labels of faces: iterate.)"""
    attributes = TDF_AttributeIterator(label, True)
    while attributes.More():
        attribute = attributes.Value()
        if isinstance(attribute, TDataStd_Name):
            return attribute.Get().ToExtString().strip()
        attributes.Next()
    return ""


def sub_shape_names(label):
    """(shape, name) of the named solids and shells inside a product."""
    parts = TDF_LabelSequence()
    XCAFDoc_ShapeTool.GetSubShapes_s(label, parts)
    labels = [parts.Value(i) for i in range(1, parts.Length() + 1)]
    named = [(XCAFDoc_ShapeTool.GetShape_s(x), label_name(x)) for x in labels]
    return [(s, n) for s, n in named if n]


KINDS_OF_COLOR = (
    XCAFDoc_ColorType.XCAFDoc_ColorSurf,
    XCAFDoc_ColorType.XCAFDoc_ColorGen,
    XCAFDoc_ColorType.XCAFDoc_ColorCurv,
)


def label_color(label, colors):
    for kind in KINDS_OF_COLOR:
        color = Quantity_Color()
        if colors.GetColor_s(label, kind, color):
            return rgb(color)
    return None


def shape_color(shape, colors):
    for kind in KINDS_OF_COLOR:
        color = Quantity_Color()
        if colors.GetColor(shape, kind, color):
            return rgb(color)
    return None


def face_color(shape, colors):
    """The most frequent colour of its faces."""
    counts = Counter()
    walk = TopExp_Explorer(shape, TopAbs_FACE)
    while walk.More():
        counts[shape_color(walk.Current(), colors)] += 1
        walk.Next()
    counts.pop(None, None)
    return counts.most_common(1)[0][0] if counts else None


def rgb(color):
    """(r, g, b) in 0..1 as the file has it (sRGB; OpenCASCADE keeps it linear)."""
    linear = (color.Red(), color.Green(), color.Blue())
    return tuple(round(12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055, 4) for c in linear)
