"""The skin of a part as the records that the closest-point kernels walk.

item   anything a foot can lie on: a closed-form face, a leaf of a patch, a piece of an edge
       ("curve"), a vertex; its kind, and ref: where its data are
side   an edge as one of its faces sees it
tau    parameter along an edge, 0 at its start and 1 at its end
slack  how much nearer than a face an edge or vertex must be to count [mm]: the file's own gap
"""

from typing import NamedTuple

import numpy as np

from cadlink.boxtree import NODE, build_tree
from cadlink.leaf_measures import measure_arcs
from cadlink.leaves import cut_arc, cut_patches
from cadlink.nurbs import PATCH
from cadlink.power import to_power
from cadlink.records import CIRCLE, CONE, CYLINDER, LINE, PATCHES, PLANE, SPHERE
from cadlink.rim import build_rims, fill_inner
from cadlink.trim import pack_pieces

ON_FACE, ON_LEAF, ON_LINE, ON_CIRCLE, ON_ARC, ON_VERTEX = range(6)  # kinds of item
SMOOTH = 8.7e-4  # rad (0.05 deg): faces that meet at a smaller angle continue each other
STATIONS = 16  # along an edge
TIE = 1e-10  # mm: at equal distance a face goes before an edge, an edge before a vertex

# smooth: an edge or vertex at which faces continue each other; the quick search passes it over.
ITEM = np.dtype([("low", "f8", 3), ("high", "f8", 3), ("kind", "i8"), ("ref", "i8"), ("smooth", "i8")])

# One face. label: its index in the part; grid: first patch, nu, nv, first u and v break;
# box: u0, u1, v0, v1 of its trim; piece_first .. piece_last: the boundary.
FACE = np.dtype(
    [
        ("form", "i8"),
        ("frame", "f8", (4, 3)),
        ("size", "f8", 2),
        ("sense", "f8"),
        ("label", "i8"),
        ("grid", "i8", 5),
        ("box", "f8", 4),
        ("period", "f8", 2),
        ("piece_first", "i8"),
        ("piece_last", "i8"),
    ]
)

# One piece of an edge. frame: start and way to the end | centre, x radius, y radius;
# span: angles t0, t1 | s0, s1 on the arc, its t0, t1 and ramp, first and last of the edge;
# ends_there: a vertex ends the edge at the piece's start, at its end; bend: largest curvature of an arc [1/mm].
CURVE = np.dtype(
    [
        ("edge", "i8"),
        ("frame", "f8", (3, 3)),
        ("ctrl", "i8"),
        ("degree", "i8"),
        ("span", "f8", 7),
        ("ends_there", "i8", 2),
        ("bend", "f8"),
    ]
)
# turn: least and largest sine between its faces; normal: their mean at equal steps along it (smooth.py).
EDGE = np.dtype(
    [
        ("slack", "f8"),
        ("side_first", "i8"),
        ("side_last", "i8"),
        ("turn", "f8", 2),
        ("normal", "f8", (STATIONS, 3)),
    ]
)
SIDE = np.dtype([("face", "i8"), ("uv_first", "i8"), ("uv_last", "i8")])

# One vertex. normal: pseudo-normal; smooth: its faces share a tangent plane; uv: on that face.
VERTEX = np.dtype(
    [
        ("point", "f8", 3),
        ("slack", "f8"),
        ("normal", "f8", 3),
        ("smooth", "i8"),
        ("face", "i8"),
        ("uv", "f8", 2),
    ]
)


class Skin(NamedTuple):
    nodes: np.ndarray  # two trees: over the items of the quick search, and over the smooth edges and vertices
    order: np.ndarray
    roots: np.ndarray  # (2,) first nodes of the trees, -1 for none
    items: np.ndarray
    faces: np.ndarray
    pieces: np.ndarray
    patches: np.ndarray
    leaves: np.ndarray
    curves: np.ndarray
    edges: np.ndarray
    sides: np.ndarray
    vertices: np.ndarray
    ctrl: np.ndarray  # (n, 4) control points of patches, boundary pieces and curves
    breaks: np.ndarray  # (n,) parameters between the patches of a grid
    side_uv: np.ndarray  # (n, 2) samples of (u, v) along sides
    power: np.ndarray  # (n, 4) patches in the power basis, numbered as in ctrl
    rims: np.ndarray
    rasters: np.ndarray  # (n, cells, cells) int8


def build_skin(record, chosen=None):
    """Skin of the faces of a part (all, or those chosen by their index).

    record : "skin" of what the reading process returned
    """
    parent = record["parent_face"]
    mine = np.arange(len(parent)) if chosen is None else np.flatnonzero(np.isin(parent, chosen))
    renumber = np.full(len(parent), -1)
    renumber[mine] = np.arange(len(mine))

    faces, pieces, patches, breaks, nets = pack_faces(record, mine)
    curves, kinds, edges, sides, side_uv, curve_boxes = pack_edges(record, renumber, nets)
    ctrl = np.vstack(nets) if nets else np.zeros((1, 4))
    box = record["vertices"] if len(record["vertices"]) else curve_boxes.reshape(-1, 3)
    smallest = 1e-7 * float(np.ptp(box, axis=0).max()) if len(box) else 0.0
    measure_arcs(curves, ctrl)
    power = to_power(patches, ctrl)
    leaves, leaf_low, leaf_high = cut_patches(patches, faces, pieces, ctrl, power, smallest)
    vertices = pack_vertices(record, renumber)

    closed = np.flatnonzero(faces["form"] < PATCHES)
    face_boxes = [closed_form_box(faces[k]) for k in closed]
    face_boxes = np.array(face_boxes).reshape(-1, 2, 3)
    groups = (
        (np.full(len(closed), ON_FACE), closed, face_boxes[:, 0], face_boxes[:, 1]),
        (np.full(len(leaves), ON_LEAF), np.arange(len(leaves)), leaf_low, leaf_high),
        (kinds, np.arange(len(kinds)), curve_boxes[:, 0], curve_boxes[:, 1]),
        (
            np.full(len(vertices), ON_VERTEX),
            np.arange(len(vertices)),
            vertices["point"],
            vertices["point"],
        ),
    )
    items = np.zeros(sum(len(g[0]) for g in groups), ITEM)
    for name, column in zip(("kind", "ref", "low", "high"), zip(*groups, strict=True), strict=True):
        items[name] = np.concatenate(column)
    pad = 1e-9 * max(1e-3, float(np.ptp(items["low"], axis=0).max()))
    items["low"] -= pad
    items["high"] += pad
    rims, rasters = build_rims(faces, pieces, ctrl)
    fill_inner(leaves, patches, faces, rims)
    skin = Skin(
        np.zeros(0, NODE), np.zeros(0, np.int64), np.full(2, -1), items, faces, pieces, patches, leaves, curves,
        edges, sides, vertices, ctrl, breaks, side_uv, power, rims, rasters,
    )  # fmt: skip
    corners = [(renumber[face], number) for number, face, *_ in record["corners"] if renumber[face] >= 0]
    from cadlink.smooth import group_faces, survey_edges  # they need the records of this module

    survey_edges(skin)
    group_faces(skin, [(face, record["vertex_gaps"][number]) for face, number in corners])
    return plant_trees(skin)


def plant_trees(skin):
    """The skin with its trees: quick items, and smooth edges and vertices."""
    items, kind, ref = skin.items, skin.items["kind"], skin.items["ref"]
    on_curve = (kind >= ON_LINE) & (kind <= ON_ARC)
    items["smooth"][on_curve] = skin.edges["turn"][skin.curves["edge"][ref[on_curve]], 1] <= SMOOTH
    on_vertex = kind == ON_VERTEX
    items["smooth"][on_vertex] = skin.vertices["smooth"][ref[on_vertex]]
    nodes, orders, roots = [], [], np.full(2, -1)
    n_nodes = n_items = 0
    for which in (0, 1):
        mine = np.flatnonzero(items["smooth"] == which)
        if not len(mine):
            continue
        tree, order = build_tree(items["low"][mine], items["high"][mine])
        tree["child"][tree["child"] >= 0] += n_nodes
        tree["start"] += n_items
        tree["stop"] += n_items
        roots[which] = n_nodes
        nodes.append(tree)
        orders.append(mine[order])
        n_nodes, n_items = n_nodes + len(tree), n_items + len(mine)
    if nodes:
        skin = skin._replace(nodes=np.concatenate(nodes), order=np.concatenate(orders))
    return skin._replace(roots=roots)


# --- faces ---------------------------------------------------------------------------------------


def pack_faces(record, mine):
    """FACE, PIECE and PATCH records, breaks of the patch grids, control points so far."""
    faces = np.zeros(len(mine), FACE)
    pieces, patches, breaks, nets, count = [], [], [], [], 0
    for number, (face, old) in enumerate(zip(faces, mine, strict=True)):
        r = record["faces"][old]
        face["form"], face["frame"], face["size"] = r.form, r.frame, r.size
        face["sense"], face["period"] = r.sense, r.period
        face["label"], face["box"] = record["parent_face"][old], record["uv_boxes"][old]
        face["piece_first"] = len(pieces)
        pieces += record["trims"][old]
        face["piece_last"] = len(pieces)
        if r.patches is None:
            continue
        nu, nv = len(r.u_arcs), len(r.v_arcs)
        face["grid"] = len(patches), nu, nv, len(breaks), len(breaks) + nu + 1
        breaks += [*r.u_arcs[:, 0], r.u_arcs[-1, 1], *r.v_arcs[:, 0], r.v_arcs[-1, 1]]
        for i, (u0, u1, ramp_u) in enumerate(r.u_arcs):
            for j, (v0, v1, ramp_v) in enumerate(r.v_arcs):
                net = r.patches[i][j]
                degree = (net.shape[0] - 1, net.shape[1] - 1)
                natural = (i == 0, i == nu - 1, j == 0, j == nv - 1)
                uv = (u0, u1, v0, v1)
                patches.append((degree, count, (ramp_u, ramp_v), uv, natural, number, np.zeros(3), 0, 0))
                nets.append(net.reshape(-1, 4))
                count += len(nets[-1])
    pieces, more = pack_pieces(pieces, count)
    return faces, pieces, np.array(patches, PATCH), np.array(breaks, float), nets + more


def closed_form_box(face):
    """Box of a plane, cylinder, cone, sphere or torus over its (u, v) box: lowest, highest corner."""
    u0, u1, v0, v1 = face["box"]
    size, other = face["size"]
    form = face["form"]
    if form == PLANE:
        local = np.array([[u0, u1], [v0, v1], [0.0, 0.0]])
    else:
        if form == CYLINDER:
            radius, height = np.array([size, size]), np.array([v0, v1])
        elif form == CONE:
            radius = size + np.array([v0, v1]) * np.sin(other)
            height = np.array([v0, v1]) * np.cos(other)
        else:
            tube, ring = (size, 0.0) if form == SPHERE else (other, size)
            radius = ring + tube * range_of_cosine(v0, v1)
            height = tube * range_of_cosine(v0 - 0.5 * np.pi, v1 - 0.5 * np.pi)
        x = spread(radius, range_of_cosine(u0, u1))
        y = spread(radius, range_of_cosine(u0 - 0.5 * np.pi, u1 - 0.5 * np.pi))
        local = np.array([x, y, height])
    corners = np.stack(np.meshgrid(*local, indexing="ij"), axis=-1).reshape(-1, 3)
    space = face["frame"][0] + corners @ face["frame"][1:]
    return space.min(axis=0), space.max(axis=0)


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


def pack_edges(record, renumber, nets):
    """CURVE records with the kind and box of each, EDGE and SIDE records, samples along sides.

    Control points are appended to nets.
    """
    count = sum(len(n) for n in nets)
    ends = [curve_end(c, k) for c in record["edges"] for k in (0, -1)]
    smallest = 1e-7 * float(np.ptp(np.array(ends), axis=0).max()) if ends else 0.0
    curves, kinds, boxes, edges, sides, side_uv = [], [], [], [], [], []
    uv_count = 0
    for curve, both, gap in zip(record["edges"], record["sides"], record["edge_gaps"], strict=True):
        both = [(renumber[f], uv) for f, uv in both if renumber[f] >= 0]
        if not both:
            continue
        edge = len(edges)
        edges.append((gap + TIE, len(sides), len(sides) + len(both), (0.0, 0.0), np.zeros((STATIONS, 3))))
        for face, uv in both:
            sides.append((face, uv_count, uv_count + len(uv)))
            side_uv.append(uv)
            uv_count += len(uv)
        a, b = curve_end(curve, 0), curve_end(curve, -1)
        if curve.form == LINE:
            curves.append((edge, (a, b - a, np.zeros(3)), 0, 0, np.zeros(7), (1, 1), 0.0))
            kinds.append(ON_LINE)
            boxes.append((np.minimum(a, b), np.maximum(a, b)))
        elif curve.form == CIRCLE:
            turn = curve.last - curve.first > 2.0 * np.pi - 1e-9
            span = (curve.first, curve.last, 0, 0, 0, 0, 0)
            curves.append((edge, curve.frame, 0, 0, span, (not turn, not turn), 0.0))
            kinds.append(ON_CIRCLE)
            hull = np.vstack([arc.ctrl[:, :3] / arc.ctrl[:, 3:] for arc in curve.arcs])
            boxes.append((hull.min(axis=0), hull.max(axis=0)))
        else:
            closed = np.linalg.norm(b - a) < 1e-12
            cuts = [(i, *cut) for i, arc in enumerate(curve.arcs) for cut in cut_arc(arc.ctrl, smallest)]
            for k, (i, s0, s1, net) in enumerate(cuts):
                arc = curve.arcs[i]
                span = (s0, s1, arc.t0, arc.t1, arc.ramp, curve.first, curve.last)
                here = (k == 0 and not closed, k == len(cuts) - 1 and not closed)
                curves.append((edge, np.zeros((3, 3)), count, len(net) - 1, span, here, 0.0))
                kinds.append(ON_ARC)
                nets.append(net)
                count += len(net)
                hull = net[:, :3] / net[:, 3:]
                boxes.append((hull.min(axis=0), hull.max(axis=0)))
    return (
        np.array(curves, CURVE),
        np.array(kinds, np.int64),
        np.array(edges, EDGE),
        np.array(sides, SIDE),
        np.vstack(side_uv) if side_uv else np.zeros((0, 2)),
        np.array(boxes, float).reshape(-1, 2, 3),
    )


def curve_end(curve, which):
    """Start (0) or end (-1) of an edge."""
    h = curve.arcs[which].ctrl[which]
    return h[:3] / h[3]


def pack_vertices(record, renumber):
    """VERTEX records of the vertices that the kept faces have."""
    n = len(record["vertices"])
    vertices = np.zeros(n, VERTEX)
    vertices["point"], vertices["slack"] = record["vertices"], record["vertex_gaps"] + 2.0 * TIE
    vertices["smooth"], vertices["face"] = 1, -1
    seen, around = [None] * n, np.zeros(n)
    for number, old_face, weighted, angle, uv in record["corners"]:
        face, vertex = renumber[old_face], vertices[number]
        if face < 0:
            continue
        vertex["normal"] += weighted
        around[number] += angle
        if vertex["face"] < 0:
            vertex["face"], vertex["uv"] = face, uv
        size = np.linalg.norm(weighted)
        # Normals that spread round one corner cancel in part: an apex, not a pole.
        if not size > (1.0 - 1e-4) * angle > 0.0:
            vertex["smooth"] = 0
            continue
        unit = weighted / size
        if seen[number] is None:
            seen[number] = unit
        turn = np.linalg.norm(np.cross(unit, seen[number]))
        if turn > SMOOTH or unit @ seen[number] < 0.0:
            vertex["smooth"] = 0
    # Faces that do not go all the way round leave a free edge.
    vertices["smooth"] &= around > 2.0 * np.pi - 0.1
    size = np.linalg.norm(vertices["normal"], axis=1, keepdims=True)
    vertices["normal"] /= np.where(size > 0.0, size, 1.0)
    return vertices[vertices["face"] >= 0]
