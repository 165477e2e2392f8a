"""What OpenCASCADE says of distance and side: slow, and the truth the kernels are held against."""

from collections import namedtuple

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape, BRepExtrema_SupportType
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_FACE, TopAbs_IN, TopAbs_OUT, TopAbs_SHELL
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS_Compound

from cadlink.brep import part_record
from cadlink.step import Part

Comparison = namedtuple(
    "Comparison",
    "n away_error near_error n_near occ_missed unexplained wrong_side occ_wrong_side undecided",
)


def part_of(shape, name="part", recognize=False):
    """The Part that read_step would make of a shape, without a file; splines stay splines unless asked otherwise."""
    return Part(name, None, part_record(shape, recognize), "mm", "memory")


def skin_of(shape):
    """Shells of a shape (or its faces): asked of a solid, the distance is 0 for inside points."""
    builder, skin = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(skin)
    kind = TopAbs_SHELL if TopExp_Explorer(shape, TopAbs_SHELL).More() else TopAbs_FACE
    walk = TopExp_Explorer(shape, kind)
    while walk.More():
        builder.Add(skin, walk.Current())
        walk.Next()
    return skin


def distances(shape, points):
    """Distance of each point to the skin [mm], and whether OpenCASCADE's foot is inside a face."""
    skin = skin_of(shape)
    found, on_face = np.empty(len(points)), np.zeros(len(points), bool)
    for i, p in enumerate(points):
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, p))).Vertex()
        search = BRepExtrema_DistShapeShape(vertex, skin)
        found[i] = search.Value()
        kinds = [search.SupportTypeShape2(k) for k in range(1, search.NbSolution() + 1)]
        on_face[i] = all(k == BRepExtrema_SupportType.BRepExtrema_IsInFace for k in kinds)
    return found, on_face


def sides(shape, points):
    """+1 outside a solid, -1 inside, 0 where the classifier says neither."""
    judge = BRepClass3d_SolidClassifier(shape)
    found = np.zeros(len(points))
    for i, p in enumerate(points):
        judge.Perform(gp_Pnt(*map(float, p)), 1e-7)
        found[i] = {TopAbs_IN: -1.0, TopAbs_OUT: 1.0}.get(judge.State(), 0.0)
    return found


def winding(part, points):
    """How often the triangles of a part go round each point: 1 inside, 0 outside.

    A judge between kernel and classifier where they differ, independent of both (van Oosterom &
    Strackee 1983); good for points farther from the skin than the triangles are.
    """
    p, cells = part.triangles()
    found = np.empty(len(points))
    for i, q in enumerate(points):
        a, b, c = (p[cells[:, k]] - q for k in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
        solid_angle = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
        found[i] = solid_angle.sum() / (4.0 * np.pi)
    return found


def kernel_is_right(part, p, distance):
    """Whether the classifier errs where it contradicts the kernel.

    A ball whose radius is OpenCASCADE's own distance is free of skin, so all of it is on one side:
    walk through such balls, always to the roomiest point, until the skin is farther than the
    triangles are from it; there their winding number decides.
    """
    surface, shape = part.surface(), part.shape()
    clear = 1.5e-3 * np.linalg.norm(np.ptp(part.bounding_box, axis=0))
    rays = np.random.default_rng(0).normal(size=(400, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    room = distances(shape, p[None])[0][0]
    for _ in range(30):
        if room > clear:
            break
        around = p + 0.95 * room * rays
        p = around[np.abs(surface.project(around).distance).argmax()]
        room = distances(shape, p[None])[0][0]
    return room > clear and (winding(part, p[None])[0] > 0.5) == (distance < 0.0)


def points_around(surface, box, n, seed=0):
    """n points: half anywhere in the box and a quarter beyond, half within 2 % of the skin."""
    rng = np.random.default_rng(seed)
    size = np.ptp(box, axis=0)
    room = 0.2 * size + 0.05 * size.max()
    points = box[0] - room + rng.random((n, 3)) * (size + 2.0 * room)
    near = n // 2
    hit = surface.project(points[:near])
    away = rng.normal(size=(near, 1)) * 0.02 * size.max()
    points[:near] = hit.point + away * hit.normal + rng.normal(size=(near, 3)) * 1e-3
    return points


def compare(part, n, seed=0):
    """Kernels against OpenCASCADE at n points around a part (compare_at)."""
    return compare_at(part, points_around(part.surface(), part.bounding_box, n, seed))


def compare_at(part, points):
    """Kernels against OpenCASCADE at points.

    away_error    largest difference where both feet lie inside faces
    near_error    largest difference where either foot lies on an edge or vertex
    occ_missed    points where the kernel's foot is nearer than OpenCASCADE's by more than the
                  bound, and OpenCASCADE itself says that this foot lies on the skin
    occ_wrong_side   points where the classifier contradicts the kernel and errs (kernel_is_right)
    unexplained   points outside the bounds (1e-9 mm away from edges, plus the file's gap near
                  them) that are not such misses
    """
    surface, shape, n = part.surface(), part.shape(), len(points)
    hit = surface.project(points)
    truth, occ_on_face = distances(shape, points)
    gaps = part.gap_report()
    away = occ_on_face & (surface.skin.items["kind"][hit.seed[:, 0].astype(int)] < 2)
    bound = np.where(away, 1e-9, 1e-9 + max(gaps.edge, gaps.vertex))
    error = np.abs(hit.distance) - truth
    outside = np.abs(error) > bound
    missed = np.flatnonzero(outside & (error < 0.0))
    if len(missed):
        foot_off, _ = distances(shape, hit.point[missed])
        consistent = np.abs(np.linalg.norm(points - hit.point, axis=1) - np.abs(hit.distance))
        missed = missed[(foot_off <= bound[missed]) & (consistent[missed] < 1e-9)]
    explained = np.zeros(n, bool)
    explained[missed] = True
    unexplained = points[outside & ~explained]
    error[explained] = 0.0
    wrong, occ_wrong, undecided = points[:0], 0, 0
    if part.solid:
        side = sides(shape, points)
        differ = (side != 0.0) & (np.sign(hit.distance) != side) & (truth > bound)
        wrong = points[differ]
        undecided = int((side == 0.0).sum())
        if len(wrong):
            right = [kernel_is_right(part, p, d) for p, d in zip(wrong, hit.distance[differ], strict=True)]
            wrong, occ_wrong = wrong[~np.array(right)], int(sum(right))
    return Comparison(
        n,
        float(np.abs(error[away]).max(initial=0.0)),
        float(np.abs(error[~away]).max(initial=0.0)),
        int((~away).sum()),
        len(missed),
        unexplained,
        wrong,
        occ_wrong,
        undecided,
    )
