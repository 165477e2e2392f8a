"""The skin of a part as the arrays that the closest-point kernels walk.

    item   anything a foot can lie on: a closed-form face, a leaf of a patch, a piece of an edge,
           a vertex; kind[item] says which and ref[item] where its data are
    side   an edge as one of its faces sees it
    tau    parameter along an edge, 0 at its start and 1 at its end
    slack  how much nearer than a face an edge or vertex must be to count [mm]: the file's own gap
"""

from typing import NamedTuple

import numpy as np

from cadlink.boxtree import BoxTree, build_tree
from cadlink.leaves import Leaves, cut_arc, cut_patches
from cadlink.nurbs import Patches
from cadlink.records import CONE, CYLINDER, PATCHES, PLANE, SPHERE
from cadlink.trim import Trims, pack_trims

FACE, LEAF, LINE, CIRCLE, ARC, VERTEX = range(6)  # kinds of item
SMOOTH = 8.7e-4  # rad (0.05 deg): faces that meet at a smaller angle continue each other
TIE = 1e-10  # mm: at equal distance a face goes before an edge, an edge before a vertex


class Faces(NamedTuple):
    form: np.ndarray  # (n,)
    frame: np.ndarray  # (n, 4, 3)
    size: np.ndarray  # (n, 2)
    sense: np.ndarray  # (n,)
    label: np.ndarray  # (n,) index of the face in the part
    grid: np.ndarray  # (n, 5) first patch, nu, nv, first u break, first v break
    breaks: np.ndarray


class Edges(NamedTuple):
    """Pieces of edges; straight ones and circles have one piece."""

    edge: np.ndarray  # (n_pieces,)
    frame: np.ndarray  # (n_pieces, 3, 3): start, end - start | centre, x radius, y radius
    ctrl_first: np.ndarray  # (n_pieces,)
    degree: np.ndarray  # (n_pieces,)
    ctrl: np.ndarray
    span: np.ndarray  # (n_pieces, 8): angles t0, t1 | arc s0, s1, t0, t1, ramp, first, last of edge
    open_end: np.ndarray  # (n_pieces, 2): a vertex ends it there
    slack: np.ndarray  # (n_edges,)
    side_first: np.ndarray  # (n_edges + 1,)
    side_face: np.ndarray  # (n_sides,)
    side_uv_first: np.ndarray  # (n_sides + 1,)
    side_uv: np.ndarray  # (n_samples, 2)


class Vertices(NamedTuple):
    point: np.ndarray  # (n, 3)
    slack: np.ndarray  # (n,)
    normal: np.ndarray  # (n, 3) pseudo-normal, unit
    smooth: np.ndarray  # (n,) all faces share one tangent plane
    face: np.ndarray  # (n,)
    uv: np.ndarray  # (n, 2) on that face


class Skin(NamedTuple):
    tree: BoxTree
    low: np.ndarray
    high: np.ndarray
    kind: np.ndarray
    ref: np.ndarray
    faces: Faces
    trims: Trims
    patches: Patches
    leaves: Leaves
    edges: Edges
    vertices: Vertices


def build_skin(record, chosen=None):
    """Skin of the faces of a part (all, or those chosen by their index).

    record : "skin" of what the reading process returned
    """
    parent = record["parent_face"]
    mine = np.arange(len(parent)) if chosen is None else np.flatnonzero(np.isin(parent, chosen))
    renumber = np.full(len(parent), -1)
    renumber[mine] = np.arange(len(mine))
    records = [record["faces"][i] for i in mine]
    boxes = record["uv_boxes"][mine]
    trims = pack_trims([record["trims"][i] for i in mine], boxes, [r.period for r in records])
    patches, faces = pack_faces(records, parent[mine])
    edges, edge_kind, edge_low, edge_high = pack_edges(record, renumber)
    scale = float(np.ptp(np.vstack([edge_low, edge_high]), axis=0).max()) if len(edge_low) else 1.0
    leaves, leaf_low, leaf_high = cut_patches(patches, trims, 1e-7 * scale)
    vertices = pack_vertices(record, renumber)
    closed = np.flatnonzero(faces.form < PATCHES)
    face_low, face_high = closed_form_boxes(records, boxes, record, mine, closed)

    kind = np.concatenate(
        [
            np.full(len(closed), FACE),
            np.full(len(leaves.patch), LEAF),
            edge_kind,
            np.full(len(vertices.point), VERTEX),
        ]
    )
    ref = np.concatenate(
        [closed, np.arange(len(leaves.patch)), np.arange(len(edge_kind)), np.arange(len(vertices.point))]
    )
    low = np.vstack([face_low, leaf_low, edge_low, vertices.point])
    high = np.vstack([face_high, leaf_high, edge_high, vertices.point])
    scale = float(np.ptp(np.vstack([low, high]), axis=0).max())
    pad = 1e-9 * max(scale, 1e-3)
    low, high = low - pad, high + pad
    return Skin(
        build_tree(low, high),
        low,
        high,
        kind.astype(np.int64),
        ref.astype(np.int64),
        faces,
        trims,
        patches,
        leaves,
        edges,
        vertices,
    )


# --- faces ---------------------------------------------------------------------------------------


def pack_faces(records, labels):
    nets, degree, ramp, uv_range, natural, owner = [], [], [], [], [], []
    grid, breaks = np.zeros((len(records), 5), np.int64), []
    for number, r in enumerate(records):
        if r.patches is None:
            continue
        nu, nv = len(r.u_arcs), len(r.v_arcs)
        grid[number] = len(nets), nu, nv, len(breaks), len(breaks) + nu + 1
        breaks += [*r.u_arcs[:, 0], r.u_arcs[-1, 1], *r.v_arcs[:, 0], r.v_arcs[-1, 1]]
        for i, (u0, u1, ramp_u) in enumerate(r.u_arcs):
            for j, (v0, v1, ramp_v) in enumerate(r.v_arcs):
                net = r.patches[i][j]
                nets.append(net.reshape(-1, 4))
                degree.append((net.shape[0] - 1, net.shape[1] - 1))
                ramp.append((ramp_u, ramp_v))
                uv_range.append((u0, u1, v0, v1))
                natural.append((i == 0, i == nu - 1, j == 0, j == nv - 1))
                owner.append(number)
    counts = [len(n) for n in nets]
    patches = Patches(
        np.array(degree, np.int64).reshape(-1, 2),
        np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64) if nets else np.zeros(0, np.int64),
        np.vstack(nets) if nets else np.zeros((1, 4)),
        np.array(ramp, np.int64).reshape(-1, 2),
        np.array(uv_range, float).reshape(-1, 4),
        np.array(natural, bool).reshape(-1, 4),
        np.array(owner, np.int64),
    )
    faces = Faces(
        np.array([r.form for r in records], np.int64),
        np.array([r.frame for r in records], float).reshape(-1, 4, 3),
        np.array([r.size for r in records], float).reshape(-1, 2),
        np.array([r.sense for r in records], float),
        np.asarray(labels, np.int64),
        grid,
        np.array(breaks, float),
    )
    return patches, faces


def closed_form_boxes(records, uv_boxes, record, mine, closed):
    """Boxes of planes, cylinders, cones, spheres and tori over their (u, v) box, a little large."""
    low, high = np.zeros((len(closed), 3)), np.zeros((len(closed), 3))
    for k, number in enumerate(closed):
        r, (u0, u1, v0, v1) = records[number], uv_boxes[number]
        if r.form == PLANE:
            local = np.array([[u0, u1], [v0, v1], [0.0, 0.0]])
        else:
            c, s = range_of_cosine(u0, u1), range_of_cosine(u0 - 0.5 * np.pi, u1 - 0.5 * np.pi)
            size, angle = r.size
            if r.form == CYLINDER:
                radius, height = np.array([size, size]), np.array([v0, v1])
            elif r.form == CONE:
                radius = np.sort(size + np.array([v0, v1]) * np.sin(angle))
                height = np.sort(np.array([v0, v1]) * np.cos(angle))
            else:
                around = range_of_cosine(v0, v1)
                up = range_of_cosine(v0 - 0.5 * np.pi, v1 - 0.5 * np.pi)
                tube = size if r.form == SPHERE else angle
                radius = tube * around + (0.0 if r.form == SPHERE else size)
                height = tube * up
            local = np.array([spread(radius, c), spread(radius, s), height])
        corners = np.stack(np.meshgrid(*local, indexing="ij"), axis=-1).reshape(-1, 3)
        space = r.frame[0] + corners @ r.frame[1:]
        low[k], high[k] = space.min(axis=0), space.max(axis=0)
    return low, high


def range_of_cosine(a, b):
    """Smallest and largest cosine between angles a and b."""
    values = [np.cos(a), np.cos(b)]
    first = np.ceil(a / np.pi)
    values += [np.cos(k * np.pi) for k in np.arange(first, min(np.floor(b / np.pi), first + 2) + 1)]
    return np.array([min(values), max(values)])


def spread(a, b):
    """Range of products of two ranges."""
    products = np.outer(a, b)
    return np.array([products.min(), products.max()])


# --- edges and vertices --------------------------------------------------------------------------


def pack_edges(record, renumber):
    piece_edge, frame, first, degree, ctrl, span, open_end, kind = [], [], [], [], [], [], [], []
    low, high, slack, side_face, side_first, side_uv = [], [], [], [], [0], []
    ctrl_count, n_edges = 0, 0
    ends = [p for c in record["edges"] for a in (c.arcs[0], c.arcs[-1]) for p in a.ctrl[:, :3]]
    smallest = 1e-7 * float(np.ptp(np.array(ends), axis=0).max()) if ends else 0.0
    for curve, sides, gap in zip(
        record["edges"], record["sides"], record["edge_gaps"], strict=True
    ):
        sides = [(renumber[f], uv) for f, uv in sides if renumber[f] >= 0]
        if not sides:
            continue
        closed = np.allclose(curve_end(curve, 0), curve_end(curve, -1), rtol=0.0, atol=1e-12)
        if curve.form == 0:
            a, b = curve_end(curve, 0), curve_end(curve, -1)
            rows = [(np.array([a, b - a, np.zeros(3)]), None, np.zeros(8), (True, True))]
            boxes = [np.array([a, b])]
            kind.append(LINE)
        elif curve.form == 1:
            limits = np.zeros(8)
            limits[:2] = curve.first, curve.last
            turn = curve.last - curve.first > 2.0 * np.pi - 1e-9
            rows = [(curve.frame, None, limits, (not turn, not turn))]
            hull = [a.ctrl[:, :3] / a.ctrl[:, 3:] for a in curve.arcs]
            boxes = [np.vstack(hull)]
            kind.append(CIRCLE)
        else:
            rows, boxes = [], []
            for i, arc in enumerate(curve.arcs):
                for s0, s1, b in cut_arc(arc.ctrl, smallest):
                    starts = i == 0 and s0 == 0.0 and not closed
                    stops = i == len(curve.arcs) - 1 and s1 == 1.0 and not closed
                    limits = np.array([s0, s1, arc.t0, arc.t1, arc.ramp, curve.first, curve.last, 0])
                    rows.append((np.zeros((3, 3)), b, limits, (starts, stops)))
                    boxes.append(b[:, :3] / b[:, 3:])
                    kind.append(ARC)
        for (f, b, limits, ends), box in zip(rows, boxes, strict=True):
            piece_edge.append(n_edges)
            frame.append(f)
            first.append(ctrl_count)
            degree.append(0 if b is None else len(b) - 1)
            if b is not None:
                ctrl.append(b)
                ctrl_count += len(b)
            span.append(limits)
            open_end.append(ends)
            low.append(box.min(axis=0))
            high.append(box.max(axis=0))
        slack.append(gap + TIE)
        for face, uv in sides:
            side_face.append(face)
            side_uv.append(uv)
        side_first.append(len(side_face))
        n_edges += 1
    counts = [len(uv) for uv in side_uv]
    edges = Edges(
        np.array(piece_edge, np.int64),
        np.array(frame, float).reshape(-1, 3, 3),
        np.array(first, np.int64),
        np.array(degree, np.int64),
        np.vstack(ctrl) if ctrl else np.zeros((1, 4)),
        np.array(span, float).reshape(-1, 8),
        np.array(open_end, bool).reshape(-1, 2),
        np.array(slack, float),
        np.array(side_first, np.int64),
        np.array(side_face, np.int64),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.vstack(side_uv) if side_uv else np.zeros((0, 2)),
    )
    return edges, np.array(kind, np.int64), np.array(low).reshape(-1, 3), np.array(high).reshape(-1, 3)


def curve_end(curve, which):
    """Start (0) or end (-1) of an edge."""
    h = curve.arcs[which].ctrl[which]
    return h[:3] / h[3]


def pack_vertices(record, renumber):
    n = len(record["vertices"])
    normal, smooth = np.zeros((n, 3)), np.ones(n, bool)
    face, uv = np.full(n, -1), np.zeros((n, 2))
    seen = [None] * n
    for vertex, number, weighted, angle, at in record["corners"]:
        number = renumber[number]
        if number < 0:
            continue
        normal[vertex] += weighted
        size = np.linalg.norm(weighted)
        if face[vertex] < 0:
            face[vertex], uv[vertex] = number, at
        # Normals that spread round one corner cancel in part: an apex, not a pole.
        if size > (1.0 - 1e-4) * angle > 0.0:
            unit = weighted / size
            if seen[vertex] is None:
                seen[vertex] = unit
            elif np.linalg.norm(np.cross(unit, seen[vertex])) > SMOOTH or unit @ seen[vertex] < 0.0:
                smooth[vertex] = False
        else:
            smooth[vertex] = False
    used = np.flatnonzero(face >= 0)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0)
    return Vertices(
        record["vertices"][used],
        record["vertex_gaps"][used] + 2.0 * TIE,
        normal[used],
        smooth[used],
        face[used].astype(np.int64),
        uv[used],
    )
