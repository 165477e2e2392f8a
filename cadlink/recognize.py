"""Planes, cylinders, cones, spheres and tori that a file has written as splines, in their closed form again.

Runs in the reading process only. A face is recognized where points on a grid over its (u, v) box lie on the closed form
within GAP of their extent, normals with them, and so many points of each knot span that its polynomials can do nothing
else in between. Each form follows from points p and unit normals n by linear
least squares:

    sphere    p = c + r n                      cylinder  n . a = 0, and in the plane across a: p = c + r n
    cone      n . a = const, and tangent planes pass through the apex q: n . q = n . p
    torus     normal lines meet the axis: (p x n) . a + n . (o x a) = 0 (Pottmann & Wallner, Computational Line
              Geometry, 2001), and in the meridian half plane p = (R, h) + r n

(GeomConvert_SurfToAnaSurf finds the planes and spheres of a converted die, but not its rational cylinders and tori.)
Trims follow point by point: each trace is carried to the parameters of the closed form and fitted there. A face whose
parameters cannot be carried over without a jump, as round a pole in its middle, stays a spline.
"""

import numpy as np

from cadlink.bezier import fit_curve, line_arc, points
from cadlink.curves import STATIONS, Trace
from cadlink.faces import inner_breaks, normals_on_form, points_on_form
from cadlink.records import CONE, CYLINDER, PLANE, SPHERE, TORUS, FaceRecord

GAP = 1e-9  # of the extent of a face: 1e-7 mm for 100 mm
GRID = 17
MANY = 100_000  # points of all knot spans; splines with more stay what they are
STEP = 1.0  # rad: angles change by less between neighbours of the grid, or go round a pole
CLOSED = 1e-6  # of the (u, v) box: jumps of a boundary that are taken for round-off
FIT = 1e-12  # of the (u, v) box
OTHER_DEGREE = 8  # of the curves that surfaces of revolution and extrusions are made of, and offsets of surfaces
KINDS = ("bspline", "bezier", "revolution", "extrusion", "offset")


def recognized(probe, kind, box, wires):
    """A FormProbe, and the wires' traces in its parameters; (None, wires) where the face is none of the forms.

    box : u0, u1, v0, v1 of the face; wires : list of lists of (edge, Trace)
    """
    if kind not in KINDS:
        return None, wires
    u, v = np.linspace(box[0], box[1], GRID), np.linspace(box[2], box[3], GRID)
    at = np.array([[probe.point((a, b)) for b in v] for a in u])
    normal = np.array([[probe.normal((a, b)) for b in v] for a in u])
    extent = float(np.linalg.norm(np.ptp(at.reshape(-1, 3), axis=0)))
    for fit in (plane_of, sphere_of, cylinder_of, cone_of, torus_of):
        record = fit(at, normal)
        if record is None:
            continue
        gap = miss(record, at, normal, extent)
        if gap <= GAP * extent:
            gap = max(gap, miss_of_spans(record, probe, kind, box))
        if gap <= GAP * extent:
            record.kind, record.gap = kind, gap
            form = FormProbe(probe, record, box, at)
            carried = form.carry(wires) if form.single_valued else None
            return (form, carried) if carried is not None else (None, wires)
    return None, wires


def miss(record, at, normal, extent):
    """Largest distance of points from a closed form [mm]; infinite where their normals are not its normals."""
    p, n = at.reshape(-1, 3), normal.reshape(-1, 3)
    _, _, off, own = foot_of(record, p)
    real = n.any(axis=1)
    turned = np.abs((own * n).sum(axis=1) - 1.0)[real]
    if not (turned < 1e-9).all() or record.size.max() > 1e4 * extent:
        return np.inf
    return float(np.abs(off).max())


def miss_of_spans(record, probe, kind, box):
    """The same over all knot spans of a face, 2 p + 1 points of each: a quadric of a patch has twice its degree p."""
    adaptor, stations = probe.adaptor, []
    for letter, first, last in (("U", box[0], box[1]), ("V", box[2], box[3])):
        breaks = inner_breaks(adaptor, letter, first, last)
        degree = getattr(adaptor, f"{letter}Degree")() if kind in ("bspline", "bezier") else OTHER_DEGREE
        ends = zip(breaks[:-1], breaks[1:], strict=True)
        stations.append(np.concatenate([np.linspace(a, b, 2 * degree + 1) for a, b in ends]))
    if len(stations[0]) * len(stations[1]) > MANY:
        return np.inf
    p = np.array([probe.point((u, v)) for u in stations[0] for v in stations[1]])
    return float(np.abs(foot_of(record, p)[2]).max())


# --- the forms -----------------------------------------------------------------------------------


def real_ones(at, normal):
    """Points and normals as (n, 3), those without a normal (poles) left out."""
    p, n = at.reshape(-1, 3), normal.reshape(-1, 3)
    real = n.any(axis=1)
    return p[real], n[real]


def frame_about(origin, z, towards):
    """(4, 3) origin, x, y, z: right-handed, x as near to a direction as it can be."""
    x = towards - (towards @ z) * z
    size = np.linalg.norm(x)
    if size <= 1e-6 * np.linalg.norm(towards) or size == 0.0:
        x = np.cross(z, np.eye(3)[np.abs(z).argmin()])
        size = np.linalg.norm(x)
    x = x / size
    return np.array([origin, x, np.cross(z, x), z])


def form(kind, frame, size, sense):
    return FaceRecord("", kind, sense, frame=frame, size=np.array(size, float))


def plane_of(at, normal):
    _, n = real_ones(at, normal)
    if len(n) == 0:
        return None
    z = n.mean(axis=0)
    z /= max(np.linalg.norm(z), 1e-300)
    # Its normal from the points, which know it better.
    p = at.reshape(-1, 3)
    middle = p.mean(axis=0)
    axis = np.linalg.svd(p - middle, full_matrices=False)[2][2]
    z = axis if axis @ z > 0.0 else -axis
    return form(PLANE, frame_about(middle, z, at[-1, 0] - at[0, 0]), (0.0, 0.0), 1.0)


def round_of(p, n):
    """Centre and signed radius of p = c + r n, in any dimension."""
    dp, dn = p - p.mean(axis=0), n - n.mean(axis=0)
    spread = (dn * dn).sum()
    if spread < 1e-9 * len(n):
        return None, 0.0
    r = (dp * dn).sum() / spread
    return p.mean(axis=0) - r * n.mean(axis=0), r


def sphere_of(at, normal):
    p, n = real_ones(at, normal)
    centre, r = round_of(p, n)
    if centre is None:
        return None
    # Its axis goes through a pole of the face's own parameters, if there is one.
    z = np.array([0.0, 0.0, 1.0])
    for side in (at[:, 0], at[:, -1], at[0], at[-1]):
        if np.ptp(side, axis=0).max() < 1e-9 * abs(r):
            z = (side[0] - centre) / np.linalg.norm(side[0] - centre)
            break
    else:
        # Else across the mean of its directions: poles stay away from it.
        middle = n.mean(axis=0)
        z = np.linalg.svd(n - middle, full_matrices=False)[2][0]
        z = np.cross(np.cross(middle, z), middle)
        z /= max(np.linalg.norm(z), 1e-300)
    towards = at[GRID // 2, GRID // 2] - centre
    return form(SPHERE, frame_about(centre, z, towards), (abs(r), 0.0), 1.0 if r > 0.0 else -1.0)


def cylinder_of(at, normal):
    p, n = real_ones(at, normal)
    z = np.linalg.svd(n, full_matrices=False)[2][2]
    flat = np.array([frame_about(np.zeros(3), z, p[0] - p[-1])[k] for k in (1, 2)])
    centre, r = round_of(p @ flat.T, n @ flat.T)
    if centre is None:
        return None
    origin = centre @ flat + (p.mean(axis=0) @ z) * z
    towards = at[GRID // 2, GRID // 2] - origin
    return form(CYLINDER, frame_about(origin, z, towards), (abs(r), 0.0), 1.0 if r > 0.0 else -1.0)


def cone_of(at, normal):
    p, n = real_ones(at, normal)
    middle = p.mean(axis=0)
    apex, *_ = np.linalg.lstsq(n, ((p - middle) * n).sum(axis=1), rcond=1e-9)
    apex = apex + middle
    z = np.linalg.svd(n - n.mean(axis=0), full_matrices=False)[2][2]
    # From the apex into the face.
    along = (p - apex) @ z
    if along.mean() < 0.0:
        z, along = -z, -along
    radial = p - apex - along[:, None] * z
    rho = np.linalg.norm(radial, axis=1)
    slope = (rho @ along) / max(along @ along, 1e-300)
    h = float(along.mean())
    if not 1e-6 < slope < 1e6 or h <= 0.0:
        return None
    sense = 1.0 if ((radial * n).sum(axis=1)).mean() > 0.0 else -1.0
    origin = apex + h * z
    towards = at[GRID // 2, GRID // 2] - origin
    return form(CONE, frame_about(origin, z, towards), (h * slope, np.arctan(slope)), sense)


def torus_of(at, normal):
    p, n = real_ones(at, normal)
    middle = p.mean(axis=0)
    size = max(np.ptp(p, axis=0).max(), 1e-300)
    q = (p - middle) / size
    lines = np.hstack([np.cross(q, n), n])
    x = np.linalg.svd(lines, full_matrices=False)[2][5]
    a, moment = x[:3], x[3:]
    length = np.linalg.norm(a)
    if length < 1e-3:
        return None
    z = a / length
    origin = middle + size * np.cross(z, moment / length)
    away = p - origin
    h = away @ z
    radial = away - h[:, None] * z
    rho = np.linalg.norm(radial, axis=1)
    if (rho <= 0.0).any():
        return None
    n_rho = (n * radial).sum(axis=1) / rho
    centre, r = round_of(np.column_stack([rho, h]), np.column_stack([n_rho, n @ z]))
    if centre is None or r == 0.0 or centre[0] <= 0.0:
        return None
    origin = origin + centre[1] * z
    towards = at[GRID // 2, GRID // 2] - origin
    return form(TORUS, frame_about(origin, z, towards), (centre[0], abs(r)), 1.0 if r > 0.0 else -1.0)


# --- points and parameters -----------------------------------------------------------------------


def foot_of(record, p):
    """u, v of points (angles in any turn), their distance from the surface, its normals out of the material."""
    o, x, y, z = record.frame
    a, b, h = (p - o) @ x, (p - o) @ y, (p - o) @ z
    big, small = record.size
    if record.form == PLANE:
        return a, b, h, np.broadcast_to(record.sense * z, p.shape)
    rho, u = np.hypot(a, b), np.arctan2(b, a)
    if record.form == CYLINDER:
        v, off, nr, nh = h, rho - big, np.ones_like(h), np.zeros_like(h)
    elif record.form == CONE:
        c, s = np.cos(small), np.sin(small)
        v, off = (rho - big) * s + h * c, (rho - big) * c - h * s
        nr, nh = np.full_like(h, c), np.full_like(h, -s)
    else:
        ring, tube = (0.0, big) if record.form == SPHERE else (big, small)
        m = np.hypot(rho - ring, h)
        v, off = np.arctan2(h, rho - ring), m - tube
        nr, nh = np.cos(v), np.sin(v)
    normal = (nr * np.cos(u))[:, None] * x + (nr * np.sin(u))[:, None] * y + nh[:, None] * z
    return u, v, off, record.sense * normal


class FormProbe:
    """Points, normals and traces of a face in the parameters of its closed form; the same calls as FaceProbe."""

    def __init__(self, probe, record, box, at):
        self.probe, self.record, self.box = probe, record, np.asarray(box)
        self.face, self.sense = probe.face, probe.sense
        turn = 2.0 * np.pi
        if record.form != PLANE:
            record.period[0] = turn
        if record.form == TORUS:
            record.period[1] = turn
        # Sides of the face's own box that are one point.
        span = np.array([box[1] - box[0], box[3] - box[2]])
        scale = 1e-9 * max(np.ptp(at.reshape(-1, 3), axis=0).max(), 1e-300)
        sides = ((0, box[0], at[0]), (0, box[1], at[-1]), (1, box[2], at[:, 0]), (1, box[3], at[:, -1]))
        self.poles = [(axis, value) for axis, value, side in sides if np.ptp(side, axis=0).max() <= scale]
        self.span = span
        # Angles over the grid, without jumps.
        u, v = np.linspace(box[0], box[1], GRID), np.linspace(box[2], box[3], GRID)
        raw = self.raw(np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)).reshape(GRID, GRID, 2)
        self.grid, self.single_valued = raw.copy(), True
        for c in range(2):
            if record.period[c] == 0.0:
                continue
            first = np.unwrap(raw[:, 0, c])
            self.grid[..., c] = np.unwrap(raw[..., c], axis=1) + (first - raw[:, 0, c])[:, None]
            steps = [np.abs(np.diff(self.grid[..., c], axis=axis)).max() for axis in (0, 1)]
            self.single_valued &= max(steps) < STEP and np.ptp(self.grid[..., c]) < turn + 1e-6

    def raw(self, uv):
        """Parameters (n, 2) on the form at parameters (n, 2) of the face, angles in any turn."""
        p = np.array([self.probe.point(q) for q in uv])
        u, v, _, _ = foot_of(self.record, p)
        # At a pole the angle is that of the meridian that ends there.
        for axis, value in self.poles:
            near = np.flatnonzero(np.abs(uv[:, axis] - value) <= 1e-9 * self.span[axis])
            if len(near):
                inside = uv[near].copy()
                inside[:, axis] += 1e-4 * (0.5 * (self.box[2 * axis] + self.box[2 * axis + 1]) - value)
                u[near] = foot_of(self.record, np.array([self.probe.point(q) for q in inside]))[0]
        return np.column_stack([u, v])

    def carried(self, uv):
        """Parameters (n, 2) on the form, without jumps over the face."""
        found = self.raw(uv)
        x = np.clip((uv - self.box[[0, 2]]) / self.span, 0.0, 1.0) * (GRID - 1)
        k = np.minimum(GRID - 2, x.astype(int))
        x -= k
        for c in range(2):
            period = self.record.period[c]
            if period > 0.0:
                g = self.grid[..., c]
                i, j = k.T
                near = (1.0 - x[:, 0]) * ((1.0 - x[:, 1]) * g[i, j] + x[:, 1] * g[i, j + 1])
                near += x[:, 0] * ((1.0 - x[:, 1]) * g[i + 1, j] + x[:, 1] * g[i + 1, j + 1])
                found[:, c] += period * np.round((near - found[:, c]) / period)
        return found

    def carry(self, wires):
        """The wires with their traces in the parameters of the form, or None where one of them would jump."""
        reach = np.maximum(np.ptp(self.grid.reshape(-1, 2), axis=0), 1e-300)
        found = []
        for wire in wires:
            old = [trace for _, trace in wire]
            new = [self.carry_trace(trace, reach) for trace in old]
            for trace, moved in zip(old, new, strict=True):
                # Wherever the boundary was closed it must still be.
                for other, after in zip(old, new, strict=True):
                    if np.abs(trace.end - other.start).max() <= CLOSED * self.span.max():
                        if (np.abs(moved.end - after.start) > 1e3 * CLOSED * reach).any():
                            return None
            found.append([(edge, trace) for (edge, _), trace in zip(wire, new, strict=True)])
        return found

    def carry_trace(self, trace, reach):
        ends = self.carried(np.array([trace.start, trace.end, trace.near_start, trace.near_end]))
        samples = trace.samples
        if len(samples) == 2:
            part = np.linspace(0.0, 1.0, STATIONS)[:, None]
            samples = (1.0 - part) * samples[0] + part * samples[1]
        arcs = [piece for arc in trace.arcs for piece in self.carry_arc(arc, reach)]
        return Trace(arcs, trace.reversed, ends[0], ends[1], self.carried(samples), ends[2], ends[3])

    def carry_arc(self, arc, reach):
        """An arc of a trace: straight where it runs along a parameter, fitted elsewhere."""
        checks = self.carried(points(arc.ctrl, np.linspace(0.0, 1.0, 9)))
        for c in range(2):
            constant = np.ptp(checks[:, c]) <= 10.0 * FIT * reach[c]
            along = np.diff(checks[:, 1 - c])
            if constant and ((along >= 0.0).all() or (along <= 0.0).all()):
                start, end = checks[0].copy(), checks[-1].copy()
                start[c] = end[c] = checks[:, c].mean()
                return [line_arc(start, end, arc.t0, arc.t1)]

        def value(s):
            return self.carried(points(arc.ctrl, [s]))[0] / reach

        fitted = fit_curve(value, np.array([0.0, 1.0]), FIT)
        for piece in fitted:
            piece.ctrl[:, :2] *= reach
        return fitted

    def points(self, uv):
        return points_on_form(self.record, uv)

    def normals(self, uv):
        return normals_on_form(self.record, uv)

    def point(self, uv):
        return self.points([uv])[0]

    def normal(self, uv):
        """Unit normal out of the material, or zeros at a pole or an apex."""
        return self.normals([uv])[0]
