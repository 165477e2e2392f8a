"""A part cut by a plane: exact curves for plane-strain and axisymmetric scenes, with `project` in two dimensions."""

from typing import NamedTuple

import numpy as np

from cadlink.bezier import split
from cadlink.child import in_child
from cadlink.errors import CadError
from cadlink.projection import checked_points, checked_seed

CUTTER = "cadlink.plane_cut"
TIMEOUT = 300.0  # s
AXES = {
    "xy": ((1.0, 0, 0), (0, 1.0, 0)),
    "xz": ((1.0, 0, 0), (0, 0, 1.0)),
    "yz": ((0, 1.0, 0), (0, 0, 1.0)),
}
JOINED = 1e-6  # mm: ends nearer than this, or than twice the file's own gaps, meet
SMOOTH = 8.7e-4  # rad (0.05 deg): curves that meet at a smaller angle continue each other
TURN = 0.5  # rad: pieces of a curve turn by less, so that their feet are easily told apart


class Curve(NamedTuple):
    """One curve of a profile, in the coordinates of the plane [mm]; the material is on its left.

    kind    "line", "circle", "ellipse", "parabola", "hyperbola" or "spline"
    arcs    list of (k + 1, 3) control points (w x, w y, w): rational Bezier arcs of degree k, one after the other
    center, radius   of a circle, None otherwise
    start, end       (2,)
    face    number of the face it is cut from
    """

    kind: str
    arcs: list
    center: np.ndarray | None
    radius: float | None
    start: np.ndarray
    end: np.ndarray
    face: int


class ProfileProjection(NamedTuple):
    """Closest points of n given points, lengths in mm.

    distance   (n,) signed: + outside the material, - inside
    point      (n, 2) foot on the profile
    normal     (n, 2) unit, out of the material: the gradient of `distance`
    curvature  (n,) 1/mm, + where the material bulges out; 1e12 (or -1e12) at a corner
    face       (n,) number of the curve
    seed       (n, 2) to be passed back with the same points after a small move
    """

    distance: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    face: np.ndarray
    seed: np.ndarray


class Profile:
    """Curves in which a plane cuts a part.

    curves   list of Curve, loop after loop
    loops    list of arrays: numbers of the curves of each loop, in the order they are run through
    closed   whether every loop comes back to its start
    origin, x, y, normal   (3,) of the plane: a point (a, b) of the profile is origin + a x + b y in space
    """

    def __init__(self, curves, origin=(0.0, 0, 0), x=(1.0, 0, 0), y=(0, 1.0, 0), part=None, joined=JOINED):
        if not curves:
            raise CadError("a profile needs at least one curve")
        self.joined = joined
        order, self.closed = in_loops(curves, joined)
        self.curves = [curves[k] for loop in order for k in loop]
        ends = np.cumsum([len(loop) for loop in order])
        self.loops = [np.arange(end - len(loop), end) for end, loop in zip(ends, order, strict=True)]
        self.origin, self.x, self.y = (np.asarray(v, float) for v in (origin, x, y))
        self.normal = np.cross(self.x, self.y)
        self.part = part
        self.shape = None

    def __repr__(self):
        loops = f"{len(self.loops)} loop{'s' if len(self.loops) > 1 else ''}"
        return f"<Profile: {len(self.curves)} curves in {loops}, {'closed' if self.closed else 'open'}>"

    def in_space(self, points):
        """(n, 3) mm of points (n, 2) of the profile."""
        points = np.asarray(points, float)
        return self.origin + points[:, :1] * self.x + points[:, 1:] * self.y

    def polyline(self, per_arc=16):
        """List of (k, 2) points along each curve, for pictures."""
        from cadlink.bezier import points

        s = np.linspace(0.0, 1.0, per_arc + 1)
        return [np.vstack([points(arc, s[bool(k) :]) for k, arc in enumerate(c.arcs)]) for c in self.curves]

    def project(self, points, seed=None):
        """Closest points on the profile.

        points : (n, 2) mm in the coordinates of the plane; seed : what the last call returned for these points, or None
        returns : ProfileProjection; distance d, normal n and curvature k satisfy grad d = n and, along the tangent t,
            hess d = k / (1 + k d) t t^T
        raises : ValueError for points of another shape or points that are not finite
        """
        from cadlink.profile_closest import pack_profile, project_on_profile  # numba loads when asked for

        points = checked_points(points, 2)
        n = len(points)
        seed = checked_seed(seed, n, 2, -1.0)
        if self.shape is None:
            self.shape = pack_profile(self.curves, SMOOTH, self.joined)
        hit = ProfileProjection(
            np.empty(n), np.empty((n, 2)), np.empty((n, 2)), np.empty(n), np.empty(n, np.int64), np.empty((n, 2))
        )
        if n:
            project_on_profile(self.shape, points, seed, *hit)
        return hit


def section(part, plane, timeout=TIMEOUT):
    """The exact profile in which a plane cuts a part.

    part : Part of an assembly read by `read_step`
    plane : "xy", "xz" or "yz" (through the origin; the profile's coordinates are those two), or (origin, normal), or
        (origin, normal, x) with the direction of the profile's first axis; the second is normal x first
    returns : Profile
    raises : CadError, one line, for a plane that does not cut the part, or only touches it along a face
    """
    origin, x, y, normal = plane_axes(plane)
    job = {"brep": part.brep, "origin": origin, "x": x, "y": y, "normal": normal}
    about = f"section of part {part.name!r}"
    found = in_child(CUTTER, job, timeout, "cutting it", about)["curves"]
    curves = [made(c) for c in found]
    curves = [c for c in curves if c is not None]
    if not curves:
        raise CadError(f"{about}: the plane does not cut it")
    gaps = part.gap_report()
    return Profile(curves, origin, x, y, part, max(JOINED, 2.0 * max(gaps.edge, gaps.vertex)))


def plane_axes(plane):
    """origin, x, y, normal of a plane, (3,) each, as `section` takes it."""
    if isinstance(plane, str):
        if plane not in AXES:
            raise CadError(f"plane {plane!r}, expected one of {', '.join(AXES)}, or (origin, normal)")
        x, y = (np.array(v, float) for v in AXES[plane])
        return np.zeros(3), x, y, np.cross(x, y)
    if hasattr(plane, "origin") and hasattr(plane, "normal"):
        plane = (plane.origin, plane.normal)
    try:
        origin, normal, *rest = (np.asarray(v, float) for v in plane)
        shapes = {v.shape for v in (origin, normal, *rest)}
    except (TypeError, ValueError):
        shapes = None
    if shapes != {(3,)} or len(rest) > 1:
        raise CadError(f"plane {plane!r}, expected (origin, normal) or (origin, normal, x), three numbers each")
    size = np.linalg.norm(normal)
    if not (np.isfinite(origin).all() and np.isfinite(size) and size > 0.0):
        raise CadError(f"plane normal {normal.tolist()}, expected a direction")
    normal = normal / size
    x = rest[0] if rest else np.eye(3)[next(k for k in range(3) if abs(normal[k]) < 0.9)]
    x = x - (x @ normal) * normal
    if np.linalg.norm(x) <= 1e-9:
        raise CadError("plane: its x is along its normal, expected a direction in it")
    x = x / np.linalg.norm(x)
    return origin, x, np.cross(normal, x), normal


def made(found):
    """Curve of what the child found; None for one without a length."""
    arcs = found["arcs"]
    hull = np.vstack([a[:, :2] / a[:, 2:] for a in arcs])
    if np.ptp(hull, axis=0).max() < 1e-9:
        return None
    center, radius = found["circle"] or (None, None)
    return Curve(found["kind"], arcs, center, radius, hull[0], hull[-1], found["face"])


def in_loops(curves, joined):
    """Curves chained end to start: a list of lists of numbers, and whether all come back to their start.

    joined : mm, ends nearer than this meet
    """
    starts, ends = np.array([c.start for c in curves]), np.array([c.end for c in curves])
    away = np.linalg.norm(starts[:, None] - ends[None], axis=2)  # of each start from each end
    left, loops, closed = set(range(len(curves))), [], True
    # Chains that have a beginning first.
    heads = sorted(range(len(curves)), key=lambda k: (away[k].min() <= joined, k))
    for head in heads:
        if head not in left:
            continue
        loop = [head]
        left.discard(head)
        while away[head, loop[-1]] > joined:
            after = [k for k in left if away[k, loop[-1]] <= joined]
            if not after:
                closed = False
                break
            loop.append(min(after, key=away[:, loop[-1]].__getitem__))
            left.discard(loop[-1])
        loops.append(loop)
    return loops, closed


def gentle_pieces(ctrl):
    """Pieces (s0, s1, control points (k + 1, 3)) of an arc that turn by less than TURN."""
    todo, pieces = [(0.0, 1.0, np.asarray(ctrl, float), 0)], []
    while todo:
        s0, s1, net, level = todo.pop()
        p = net[:, :2] / net[:, 2:]
        legs = np.diff(p, axis=0)
        legs = legs[np.linalg.norm(legs, axis=1) > 1e-14]
        turn = 0.0
        if len(legs) > 1:
            cross = legs[:-1, 0] * legs[1:, 1] - legs[:-1, 1] * legs[1:, 0]
            turn = np.abs(np.arctan2(cross, (legs[:-1] * legs[1:]).sum(axis=1))).sum()
        if turn <= TURN or level >= 8:
            pieces.append((s0, s1, net))
            continue
        left, right = split(net, 0.5)
        m = 0.5 * (s0 + s1)
        todo += [(m, s1, right, level + 1), (s0, m, left, level + 1)]
    return pieces
