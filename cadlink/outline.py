"""Outlines of flat blanks: closed loops of straight lines and circular arcs in the plane, in mm.

Each outline gives `loops`, the outer loop first and one loop per hole behind it; `area`; and `center`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import atan2, hypot, isfinite, pi

import numpy as np

from cadlink.errors import CadError

ARC_STEPS = 64  # points that stand for a full circle where a loop is only sampled


@dataclass(frozen=True, eq=False)
class Loop:
    """A closed curve: corner points [mm], and for some edges the point an arc passes through.

    points : (n, 2) corners in order; a full circle has two
    arcs : {i: (x, y)}: the edge from corner i to the next is the arc through (x, y)
    """

    points: np.ndarray
    arcs: Mapping[int, tuple[float, float]] = field(default_factory=dict)

    def polyline(self, steps=ARC_STEPS):
        """(k, 2) points along the loop, without the first repeated; arcs by chords."""
        pieces = []
        for i, start in enumerate(self.points):
            if i in self.arcs:
                end = self.points[(i + 1) % len(self.points)]
                centre, radius, first, sweep = arc_of(start, self.arcs[i], end)
                n_steps = max(2, int(np.ceil(abs(sweep) / (2 * pi) * steps)))
                angle = first + sweep * np.arange(1, n_steps) / n_steps
                circle = centre + radius * np.column_stack((np.cos(angle), np.sin(angle)))
                pieces.append(np.vstack((start, circle)))
            else:
                pieces.append(start[None])
        return np.vstack(pieces)

    @property
    def area(self):
        """Enclosed area [mm^2], exact for arcs too; positive when the loop runs counter-clockwise."""
        total = shoelace(self.points)
        for i, middle in self.arcs.items():
            _, radius, _, sweep = arc_of(self.points[i], middle, self.points[(i + 1) % len(self.points)])
            total += 0.5 * radius**2 * (sweep - np.sin(sweep))  # the segment between chord and arc
        return total


class _Looped:
    """What the outlines share, given their loops."""

    loops: Sequence[Loop]

    @property
    def area(self):
        """Area between the outer loop and the holes [mm^2]."""
        outer, *holes = (abs(loop.area) for loop in self.loops)
        return outer - sum(holes)


@dataclass(frozen=True)
class Rectangle(_Looped):
    """A rectangle with sides along x and y [mm]; holes are outlines themselves."""

    width: float
    height: float
    center: tuple[float, float] = (0.0, 0.0)
    holes: Sequence = ()

    def __post_init__(self):
        _check_positive("Rectangle", width=self.width, height=self.height)
        _check_point("Rectangle center", self.center)
        _check_loops("Rectangle", self.loops)

    @property
    def bounds(self):
        """(x_min, x_max, y_min, y_max) [mm]."""
        (x, y), w, h = self.center, 0.5 * self.width, 0.5 * self.height
        return x - w, x + w, y - h, y + h

    @property
    def loops(self):
        x0, x1, y0, y1 = self.bounds
        outer = Loop(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]))
        return (outer, *_hole_loops(self.holes))


@dataclass(frozen=True)
class Disc(_Looped):
    """A disc [mm]; holes are outlines themselves."""

    radius: float
    center: tuple[float, float] = (0.0, 0.0)
    holes: Sequence = ()

    def __post_init__(self):
        _check_positive("Disc", radius=self.radius)
        _check_point("Disc center", self.center)
        _check_loops("Disc", self.loops)

    @property
    def loops(self):
        (x, y), r = self.center, self.radius
        circle = Loop(np.array([(x + r, y), (x - r, y)]), {0: (x, y + r), 1: (x, y - r)})
        return (circle, *_hole_loops(self.holes))


@dataclass(frozen=True, eq=False)
class Polygon(_Looped):
    """Any closed outline of straight and circular edges [mm].

    points : corners in order, either way round, the first not repeated
    arcs : {i: (x, y)}: the edge from corner i to the next is the circular arc through (x, y)
    holes : outlines that are cut out
    """

    points: Sequence
    arcs: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    holes: Sequence = ()

    def __post_init__(self):
        try:
            points = np.array(self.points, dtype=float)
        except (TypeError, ValueError):
            points = np.empty(0)
        if points.ndim != 2 or points.shape[-1] != 2 or not np.isfinite(points).all():
            raise CadError("Polygon points: expected a list of finite (x, y) in mm")
        if len(points) < (2 if self.arcs else 3):
            raise CadError(f"Polygon: {len(points)} points do not enclose an area; expected at least 3")
        for i, middle in self.arcs.items():
            if not (isinstance(i, int) and 0 <= i < len(points)):
                raise CadError(f"Polygon arcs: edge {i!r} does not exist; expected 0 to {len(points) - 1}")
            _check_point(f"Polygon arcs[{i}]", middle)
            arc_of(points[i], middle, points[(i + 1) % len(points)])
        object.__setattr__(self, "points", points)
        _check_loops("Polygon", self.loops)

    @property
    def loops(self):
        return (Loop(np.asarray(self.points), dict(self.arcs)), *_hole_loops(self.holes))

    @property
    def center(self):
        return (0.0, 0.0)


def shoelace(points):
    """Signed area of a polygon [mm^2]; points : (n, 2)."""
    x, y = (points - points[0]).T
    return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def arc_of(start, middle, end):
    """Circle through three points: centre (2,), radius [mm], start angle and signed sweep [rad]."""
    a, b = np.subtract(middle, start), np.subtract(end, start)
    cross = a[0] * b[1] - a[1] * b[0]
    scale = hypot(*a) * hypot(*np.subtract(end, middle))
    if abs(cross) <= 1e-9 * scale or scale == 0.0:
        full = hypot(*b)
        raise CadError(f"arc from {_show(start)} to {_show(end)}: {_show(middle)} is on its chord of {full:g} mm")
    # the centre is where both chords have their bisectors
    aa, bb = a @ a, b @ b
    offset = np.array([b[1] * aa - a[1] * bb, a[0] * bb - b[0] * aa]) / (2 * cross)
    first = atan2(-offset[1], -offset[0])
    last = atan2(b[1] - offset[1], b[0] - offset[0])
    sweep = (last - first) % (2 * pi) if cross > 0 else -((first - last) % (2 * pi))
    return np.asarray(start) + offset, hypot(*offset), first, sweep


def crossing_edges(polylines):
    """Two edges that touch without being neighbours, as (loop, edge, loop, edge); None if no two do.

    Every edge of every loop meets every other: fit for outlines of some thousand edges.
    """
    start = np.vstack(polylines)
    end = np.vstack([np.roll(p, -1, axis=0) for p in polylines])
    loop = np.repeat(np.arange(len(polylines)), [len(p) for p in polylines])
    edge = np.concatenate([np.arange(len(p)) for p in polylines])
    size = np.array([len(p) for p in polylines])[loop]
    for i in range(len(start)):
        later = np.arange(i + 1, len(start))
        same = loop[later] == loop[i]
        step = edge[later] - edge[i]
        neighbour = same & ((step == 1) | (step == size[i] - 1))
        later = later[~neighbour]
        hit = _segments_touch(start[i], end[i], start[later], end[later])
        if hit.any():
            j = later[np.argmax(hit)]
            return int(loop[i]), int(edge[i]), int(loop[j]), int(edge[j])
    return None


def _segments_touch(p, q, a, b):
    """Whether the segment p-q meets each of the segments a-b; (m,) bool."""

    def side(u, v, w):
        return (v[..., 0] - u[..., 0]) * (w[..., 1] - u[..., 1]) - (v[..., 1] - u[..., 1]) * (w[..., 0] - u[..., 0])

    apart = (np.maximum(a, b) < np.minimum(p, q)).any(axis=-1) | (np.minimum(a, b) > np.maximum(p, q)).any(axis=-1)
    straddles = (side(p, q, a) * side(p, q, b) <= 0) & (side(a, b, p) * side(a, b, q) <= 0)
    return straddles & ~apart


def inside(point, polyline):
    """Whether a point is inside a closed polyline (even-odd)."""
    x, y = point
    x0, y0 = polyline.T
    x1, y1 = np.roll(polyline, -1, axis=0).T
    spans = (y0 > y) != (y1 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    return bool(np.count_nonzero(spans & (x < crossing)) % 2)


def _hole_loops(holes):
    """The outer loops of the outlines given as holes."""
    loops = []
    for hole in holes:
        if not isinstance(hole, _Looped):
            raise CadError(f"hole: expected Rectangle, Disc or Polygon, got {type(hole).__name__}")
        if len(hole.loops) > 1:
            raise CadError("hole: an outline used as a hole has no holes of its own")
        loops.append(hole.loops[0])
    return loops


def _check_loops(kind, loops):
    """Refuses loops without area, that cross themselves or each other, and holes outside the outer loop."""
    names = ["outline", *(f"hole {k}" for k in range(1, len(loops)))]
    polylines = [loop.polyline() for loop in loops]
    for name, loop, polyline in zip(names, loops, polylines):
        length = np.hypot(*(np.roll(polyline, -1, axis=0) - polyline).T)
        if (length == 0.0).any():
            raise CadError(f"{kind} {name}: point {_show(polyline[np.argmin(length)])} is repeated")
        if abs(loop.area) <= 1e-12 * length.sum() ** 2:
            raise CadError(f"{kind} {name}: encloses no area")
    crossing = crossing_edges(polylines)
    if crossing is not None:
        first, _, second, _ = crossing
        pair = "crosses itself" if first == second else f"touches {names[second]}"
        raise CadError(f"{kind} {names[first]}: {pair}")
    for k, hole in enumerate(polylines[1:], 1):
        if not inside(hole[0], polylines[0]):
            raise CadError(f"{kind} {names[k]}: lies outside the outline")
        for other in range(1, len(polylines)):
            if other != k and inside(hole[0], polylines[other]):
                raise CadError(f"{kind} {names[k]}: lies inside {names[other]}")


def _check_positive(kind, **lengths):
    for name, value in lengths.items():
        if not _is_number(value) or not isfinite(value) or value <= 0.0:
            raise CadError(f"{kind} {name}: expected a length > 0 in mm, got {value!r}")


def _check_point(name, point):
    try:
        good = len(point) == 2 and all(_is_number(c) and isfinite(c) for c in point)
    except TypeError:
        good = False
    if not good:
        raise CadError(f"{name}: expected (x, y) in mm, got {point!r}")


def _is_number(value):
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _show(point):
    return f"({point[0]:g}, {point[1]:g})"
