"""What OpenCASCADE knows of a STEP file, as plain arrays. Runs as a process of its own:

    python -m cadlink.brep FILE SEW OUT

writes a pickle of {"unit", "parts"} or {"error"} to OUT; loose faces are sewn within SEW mm. A file that crashes
OpenCASCADE then costs one line, not the session. `step.py` starts it and reads the pickle.
"""

import io
import pickle
import sys
from collections import Counter
from functools import lru_cache

import numpy as np
from OCP.BinTools import BinTools, BinTools_FormatVersion
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
)
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Pnt2d
from OCP.GProp import GProp_GProps
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideContinuity
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_IN,
    TopAbs_REVERSED,
    TopAbs_SOLID,
    TopAbs_WIRE,
)
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Iterator
from OCP.TopTools import TopTools_IndexedMapOfShape

from cadlink.curves import STATIONS, crossed, edge_curve, points_along, trace_of, xyz
from cadlink.display import tessellate
from cadlink.errors import CadError
from cadlink.faces import KINDS, FaceProbe, face_record
from cadlink.loops import matched, pieces_of_wire, uv_box
from cadlink.recognize import recognized

SMALLEST = 1e-3  # mm: parts below it are taken for a mistake in the unit
CREASE = 1e-4  # rad: smoother C0 knots of a B-spline are not made into edges


def explore(shape, kind, avoid=None):
    """Sub-shapes of one kind in file order, each once."""
    seen = TopTools_IndexedMapOfShape()
    found = []
    walk = TopExp_Explorer(shape, kind) if avoid is None else TopExp_Explorer(shape, kind, avoid)
    while walk.More():
        if not seen.Contains(walk.Current()):
            seen.Add(walk.Current())
            found.append(walk.Current())
        walk.Next()
    return found


def faces_of(shape):
    return [TopoDS.Face_s(f) for f in explore(shape, TopAbs_FACE)]


# --- one part ------------------------------------------------------------------------------------


def part_record(shape, recognize=True):
    """Everything the parent keeps of one solid, shell or face, already placed and in mm.

    recognize : splines that are planes, cylinders, cones, spheres or tori become these (recognize.py)
    """
    shape, flipped = outward(shape)
    faces = faces_of(shape)
    stream = io.BytesIO()
    version = BinTools_FormatVersion.BinTools_FormatVersion_CURRENT
    BinTools.Write_s(shape, stream, False, False, version)
    corners = bounding_box(faces)
    diagonal = float(np.linalg.norm(corners[1] - corners[0]))
    if diagonal < SMALLEST:
        raise CadError(f"a part in it is {diagonal:.1e} mm large, expected {SMALLEST} mm or more: is its unit right?")
    points, cells = tessellate(shape, faces, diagonal)
    solid = shape.ShapeType() == TopAbs_SOLID
    kinds = [KINDS[FaceProbe(f).adaptor.GetType()] for f in faces]
    areas = [area_of(face) for face in faces]
    divided, parent_face = divide_creases(shape, faces)
    return {
        "solid": solid,
        "brep": stream.getvalue(),
        "box": corners,
        "kinds": Counter(kinds),
        "kind_of_face": kinds,
        "points": points,
        "cells": cells,
        "planes": plane_records(faces, kinds, areas),
        "skin": skin_record(divided, parent_face, recognize),
        "face_widths": [width_of(face, area) for face, area in zip(faces, areas, strict=True)],
        "flipped": flipped,
    }


def bounding_box(faces):
    """Lowest and highest corner (2, 3) of faces, exactly."""
    box = Bnd_Box()
    for face in faces:
        if FaceProbe(face).adaptor.GetType() == GeomAbs_SurfaceType.GeomAbs_Torus:
            add_torus(box, face)
        else:
            BRepBndLib.AddOptimal_s(face, box, False, False)
    box.SetGap(0.0)
    return np.array([xyz(box.CornerMin()), xyz(box.CornerMax())])


def add_torus(box, face):
    """A torus' part of a box: its edges, and the points inside that face along an axis (OCC takes 20 ms)."""
    for edge in explore(face, TopAbs_EDGE):
        if not BRep_Tool.Degenerated_s(TopoDS.Edge_s(edge)):
            BRepBndLib.AddOptimal_s(edge, box, False, False)
    adaptor = FaceProbe(face).adaptor
    at = adaptor.Torus().Position()
    frame = np.array([xyz(at.XDirection()), xyz(at.YDirection()), xyz(at.Direction())])
    judge = BRepTopAdaptor_FClass2d(TopoDS.Face_s(face), 1e-9)
    for x, y, z in frame.T:
        # Where the normal is along an axis: two meridians, and on each the two ends of its circle.
        for turn in (0.0, np.pi):
            u, v = np.arctan2(y, x) + turn, np.arctan2(z, np.hypot(x, y) * (1.0 if turn == 0.0 else -1.0))
            for uv in ((u, v), (u, v + np.pi)):
                if judge.Perform(gp_Pnt2d(*uv), True) == TopAbs_IN:
                    box.Add(adaptor.Value(*uv))


def outward(shape):
    """The shape with normals out of the material: a solid written inside out is turned round."""
    if shape.ShapeType() != TopAbs_SOLID:
        return shape, False
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, True, False, True)
    if properties.Mass() < 0.0:
        return shape.Reversed(), True
    return shape, False


def area_of(face):
    """Area and centroid of a face."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return properties


def width_of(face, area):
    """Mean width of a face [mm]: twice its area over its boundary; that of a long strip is its width."""
    boundary = GProp_GProps()
    BRepGProp.LinearProperties_s(face, boundary)
    return 2.0 * abs(area.Mass()) / boundary.Mass() if boundary.Mass() > 0.0 else np.inf


def plane_records(faces, kinds, areas):
    """Planar faces: (centroid (3,), outward normal (3,), area, face index)."""
    found = []
    for i, (face, kind) in enumerate(zip(faces, kinds, strict=True)):
        if kind != "plane":
            continue
        normal = FaceProbe(face).normal((0.0, 0.0))
        found.append((xyz(areas[i].CentreOfMass()), normal, areas[i].Mass(), i))
    return found


def divide_creases(shape, faces):
    """The shape with an edge along every crease inside a face, and which face each part is from.

    A B-spline with a knot of full multiplicity may have a crease there that the topology does not
    know of.
    """
    same = [(f, i) for i, f in enumerate(faces)]
    if not any(may_crease(f) for f in faces):
        return [f for f, _ in same], [i for _, i in same]
    from OCP.GeomAbs import GeomAbs_Shape  # needed only here

    tool = ShapeUpgrade_ShapeDivideContinuity(shape)
    tool.SetSurfaceCriterion(GeomAbs_Shape.GeomAbs_C1)
    tool.SetPCurveCriterion(GeomAbs_Shape.GeomAbs_C0)
    tool.SetBoundaryCriterion(GeomAbs_Shape.GeomAbs_C0)
    tool.SetTolerance(1e-7)
    if not tool.Perform():
        return [f for f, _ in same], [i for _, i in same]
    context = tool.GetContext()
    divided, parent = [], []
    for face, i in same:
        for new in faces_of(context.Apply(face)):
            divided.append(new)
            parent.append(i)
    return divided, parent


def may_crease(face):
    """Whether normals jump across a C0 knot of the face's own surface."""
    surface = BRep_Tool.Surface_s(face)
    u_knots, v_knots = c0_knots(surface)
    if not u_knots and not v_knots:
        return False
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    probe = FaceProbe(face)
    for axis, knots, (a, b), (c, d) in (
        (0, u_knots, (u0, u1), (v0, v1)),
        (1, v_knots, (v0, v1), (u0, u1)),
    ):
        tiny = 1e-7 * (b - a)
        for knot in knots:
            if not a + tiny < knot < b - tiny:
                continue
            for along in np.linspace(c, d, 9):
                uv = [(knot + step, along)[:: 1 - 2 * axis] for step in (-tiny, tiny)]
                n, m = probe.normal(uv[0]), probe.normal(uv[1])
                if np.linalg.norm(np.cross(n, m)) > CREASE:
                    return True
    return False


def c0_knots(surface):
    """Inner knots in u and in v across which a surface is only continuous."""
    if isinstance(surface, Geom_BSplineSurface):
        u, v = surface.UDegree(), surface.VDegree()
        return (
            full_knots(surface.UKnot, surface.UMultiplicity, surface.NbUKnots(), u),
            full_knots(surface.VKnot, surface.VMultiplicity, surface.NbVKnots(), v),
        )
    if isinstance(surface, (Geom_SurfaceOfRevolution, Geom_SurfaceOfLinearExtrusion)):
        curve = surface.BasisCurve()
        if isinstance(curve, Geom_BSplineCurve):
            knots = full_knots(curve.Knot, curve.Multiplicity, curve.NbKnots(), curve.Degree())
            return ([], knots) if isinstance(surface, Geom_SurfaceOfRevolution) else (knots, [])
    return [], []


def full_knots(knot, multiplicity, n, degree):
    return [knot(i) for i in range(2, n) if multiplicity(i) >= degree]


# --- its skin ------------------------------------------------------------------------------------


def skin_record(faces, parent_face, recognize):
    """Faces with their trims, edges with their two sides, vertices with their corners."""
    edge_ids, vertex_ids = TopTools_IndexedMapOfShape(), TopTools_IndexedMapOfShape()
    for face in faces:
        TopExp.MapShapes_s(face, TopAbs_EDGE, edge_ids)
    edges = [TopoDS.Edge_s(edge_ids.FindKey(i + 1)) for i in range(edge_ids.Extent())]
    curves = [edge_curve(e) for e in edges]
    records, probes, trims, boxes = [], [], [], []
    sides = [[] for _ in edges]  # (face, uv samples) of each edge
    corners = []  # (vertex, face, weighted normal, angle, uv) of each corner of a face
    for number, face in enumerate(faces):
        probe = FaceProbe(face)
        wires = [coedges for wire in wires_of(probe.face) if (coedges := coedges_of(wire, probe.face))]
        form = None
        if recognize:
            kind = KINDS[probe.adaptor.GetType()]
            form, wires = recognized(probe, kind, BRepTools.UVBounds_s(probe.face), wires)
            probe = form or probe
        traces, pieces = [], []
        for coedges in wires:
            mine = [t for _, t in coedges]
            following = matched(mine)
            pieces += pieces_of_wire(mine, following)
            traces += mine
            for edge, trace in coedges:
                sides[edge_ids.FindIndex(edge) - 1].append((number, trace.samples))
            corners += corners_of(probe, number, coedges, following, vertex_ids)
        if not traces:
            raise ValueError(f"face {number} has no boundary that could be read")
        box = uv_box(traces, pieces)
        boxes.append(box)
        trims.append(pieces)
        records.append(form.record if form else face_record(probe, box))
        probes.append(probe)
    gaps = [edge_gap(e, c, s, probes) for e, c, s in zip(edges, curves, sides, strict=True)]
    kept = [i for i, c in enumerate(curves) if c is not None]
    vertices = [TopoDS.Vertex_s(vertex_ids.FindKey(i + 1)) for i in range(vertex_ids.Extent())]
    return {
        "faces": records,
        "parent_face": np.array(parent_face),
        "trims": trims,
        "uv_boxes": np.array(boxes),
        "edges": [curves[i] for i in kept],
        "sides": [sides[i] for i in kept],
        "edge_gaps": np.array([gaps[i] for i in kept]),
        "edge_turns": np.array([edge_turn(sides[i], probes) for i in kept]),
        "edge_tolerances": np.array([BRep_Tool.Tolerance_s(edges[i]) for i in kept]),
        "vertices": np.array([xyz(BRep_Tool.Pnt_s(v)) for v in vertices]).reshape(-1, 3),
        "vertex_gaps": vertex_gaps(edges, curves, gaps, vertices, vertex_ids),
        "vertex_tolerances": np.array([BRep_Tool.Tolerance_s(v) for v in vertices]),
        "corners": corners,
    }


def wires_of(face):
    walk = TopoDS_Iterator(face)
    while walk.More():
        if walk.Value().ShapeType() == TopAbs_WIRE:
            yield walk.Value()
        walk.Next()


def coedges_of(wire, face):
    """(edge, Trace) round a wire, in the order and direction of the wire."""
    found = []
    walk = TopoDS_Iterator(wire)
    while walk.More():
        edge = TopoDS.Edge_s(walk.Value())
        if edge.Orientation() in (TopAbs_FORWARD, TopAbs_REVERSED):
            trace = trace_of(edge, face, edge.Orientation() == TopAbs_REVERSED)
            if trace is not None and trace.arcs:
                found.append((edge, trace))
        walk.Next()
    return found


def edge_gap(edge, curve, sides, probes):
    """Largest distance found between an edge and its traces on the faces, at 33 stations [mm]."""
    if curve is None:
        return 0.0
    points = points_along(edge, curve, np.linspace(curve.first, curve.last, STATIONS))
    gap = 0.0
    for face, samples in sides:
        if len(samples) == 2:
            samples = evenly(samples, STATIONS)
        miss = points - probes[face].points(samples)
        gap = max(gap, float(np.linalg.norm(miss, axis=1).max()))
    return gap


def edge_turn(sides, probes):
    """Largest angle between the normals of the two faces at an edge, at nine stations [rad]; nan without two faces."""
    if len(sides) != 2:
        return np.nan
    n, m = (probes[face].normals(evenly(samples, 9)) for face, samples in sides)
    turn = np.arctan2(np.linalg.norm(crossed(n, m), axis=1), np.einsum("kc,kc->k", n, m))
    return float(turn[n.any(axis=1) & m.any(axis=1)].max(initial=0.0))


def evenly(samples, n):
    """n points (u, v) along samples, from the first to the last."""
    k, part = between(len(samples), n)
    return (1.0 - part) * samples[k] + part * samples[k + 1]


@lru_cache(maxsize=64)
def between(given, n):
    """Of n places evenly along so many samples: the sample before each (n,), and the part of the way on (n, 1)."""
    x = np.linspace(0.0, given - 1.0, n)
    k = np.minimum(given - 2, x.astype(int))
    return k, (x - k)[:, None]


def vertex_gaps(edges, curves, gaps, vertices, vertex_ids):
    """Largest gap at each vertex [mm]: from the ends of its edges, or of those edges themselves."""
    found = np.zeros(len(vertices))
    for edge, curve, gap in zip(edges, curves, gaps, strict=True):
        if curve is None:
            continue
        adaptor = BRepAdaptor_Curve(edge)
        forward = TopoDS.Edge_s(edge.Oriented(TopAbs_FORWARD))
        first, last = TopExp.FirstVertex_s(forward), TopExp.LastVertex_s(forward)
        for vertex, t in ((first, curve.first), (last, curve.last)):
            i = vertex_ids.FindIndex(vertex) - 1
            if i >= 0:
                miss = xyz(adaptor.Value(t)) - xyz(BRep_Tool.Pnt_s(vertex))
                found[i] = max(found[i], gap, float(np.linalg.norm(miss)))
    return found


def corners_of(probe, number, coedges, following, vertex_ids):
    """Corners (vertex, face, weighted normal, angle, uv) between the coedges of one wire.

    The weighted normal is the integral of the face's outward normal over the angle of the corner:
    summed over the corners at a vertex it is the pseudo-normal whose sign tells inside from
    outside (Baerentzen & Aanaes 2005).
    """
    found = []
    for i, (edge, trace) in enumerate(coedges):
        if BRep_Tool.Degenerated_s(edge):
            continue
        j = following[i]
        while BRep_Tool.Degenerated_s(coedges[j][0]) and j != i:
            j = following[j]
        after = coedges[j][1]
        vertex = TopExp.LastVertex_s(edge, True)
        if vertex.IsNull():
            continue
        at = xyz(BRep_Tool.Pnt_s(vertex))
        weighted, angle = corner_normal(probe, at, trace.near_end, after.near_start, trace.end)
        found.append((vertex_ids.Add(vertex) - 1, number, weighted, angle, trace.end))
    return found


def corner_normal(probe, at, uv_in, uv_out, uv):
    """Integral of the outward normal over the angle at `at` between two directions, and the angle."""
    natural = probe.sense * probe.normal(uv)
    if natural.any():
        a, b = probe.point(uv_out) - at, probe.point(uv_in) - at
        angle = np.arctan2(natural @ crossed(a, b), a @ b) % (2.0 * np.pi)
        return probe.sense * angle * natural, angle
    # A pole or an apex: follow the face round it, from one wire direction to the other.
    path = [uv_out + s * (uv_in - uv_out) for s in np.linspace(0.0, 1.0, 33)]
    rays = probe.points(path) - at
    rays /= np.maximum(np.linalg.norm(rays, axis=1), 1e-300)[:, None]
    normals = probe.normals(path)
    steps = np.linalg.norm(np.diff(rays, axis=0), axis=1)
    return (0.5 * (normals[1:] + normals[:-1]) * steps[:, None]).sum(axis=0), steps.sum()


def main(path, tolerance, out):
    from cadlink.assembly_tree import read_parts  # keeps this page about one part

    try:
        result = read_parts(path, part_record, float(tolerance))
    except Exception as error:  # whatever went wrong must reach the parent as a line
        line = " ".join(str(error).split())
        result = {"error": line if isinstance(error, CadError) else f"{type(error).__name__}: {line}"}
    with open(out, "wb") as stream:
        pickle.dump(result, stream, protocol=5)


if __name__ == "__main__":
    main(*sys.argv[1:])
