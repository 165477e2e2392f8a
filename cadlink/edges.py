"""Edges of a part as polylines: for drawbeads, and whatever else runs along one.

Edges have numbers, as faces do, in the order of the file; a person names one by a point it passes. Arcs are rational
Bezier curves c(s) with homogeneous control points, divided where they bend so that no chord strays by more than asked.
"""

import numpy as np

from cadlink.bezier import points
from cadlink.errors import CadError

FINEST = 12  # halvings of an arc
TOUCH = 1e-6  # of the longest edge: ends nearer than this meet


def edge_polyline(part, numbers, through, chord):
    """Corners (k, 3) [mm] of a chain of edges.

    numbers : of the edges in order along the chain, or None; through : in their place points (x, y, z), each near its
    edge; chord : mm, largest distance of the polyline from the edges
    raises : CadError, one line, for edges the part does not have or that do not meet
    """
    if not (np.isfinite(chord) and chord > 0.0):
        raise CadError(f"part {part.name!r}: chord {chord!r}, expected a length in mm above 0")
    curves = part.record["skin"]["edges"]
    if numbers is None:
        numbers = [nearest_edge(part, point, chord) for point in np.atleast_2d(np.asarray(through, dtype=float))]
    for number in numbers:
        if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or not 0 <= number < len(curves):
            raise CadError(f"part {part.name!r} has edges 0 to {len(curves) - 1}, found {number!r}")
    if not len(numbers):
        raise CadError(f"part {part.name!r}: an empty list of edges, expected numbers or points")
    chain = [sampled(curves[number], chord) for number in numbers]
    near = TOUCH * max(np.linalg.norm(np.ptp(line, axis=0)) for line in chain)
    if len(chain) > 1 and min(np.linalg.norm(chain[0][-1] - end) for end in chain[1][[0, -1]]) > near:
        chain[0] = chain[0][::-1]
    found = chain[0]
    for line in chain[1:]:
        gaps = [np.linalg.norm(found[-1] - end) for end in (line[0], line[-1])]
        if min(gaps) > near:
            raise CadError(
                f"part {part.name!r}: edges of a chain are {min(gaps):.3g} mm apart, expected ones that meet"
            )
        found = np.vstack([found, (line if gaps[0] <= gaps[1] else line[::-1])[1:]])
    return found


def nearest_edge(part, point, chord):
    """Number of the edge nearest to a point (3,) [mm]."""
    if np.shape(point) != (3,) or not np.isfinite(point).all():
        raise CadError(f"part {part.name!r}: edge through {point!r}, expected a point, 3 numbers in mm")
    return int(np.argmin([_distance(point, sampled(curve, chord)) for curve in part.record["skin"]["edges"]]))


def _distance(point, line):
    """From a point to a polyline."""
    start, side = line[:-1], np.diff(line, axis=0)
    length = np.maximum(np.sum(side * side, axis=1), 1e-300)
    s = np.clip(np.sum((point - start) * side, axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(start + s[:, None] * side - point, axis=1).min())


def sampled(curve, chord):
    """Points (k, 3) on an edge, its arcs halved until they are straight to within a chord."""
    found = []
    for arc in curve.arcs:
        first, last = (min(max(arc.at(t), 0.0), 1.0) for t in (max(curve.first, arc.t0), min(curve.last, arc.t1)))
        if last <= first:
            continue
        pieces = 1 if len(arc.ctrl) == 2 else 2
        for _ in range(FINEST):
            s = np.linspace(first, last, 2 * pieces + 1)
            p = points(arc.ctrl, s)
            sag = np.linalg.norm(p[1::2] - 0.5 * (p[:-1:2] + p[2::2]), axis=1).max()
            if sag <= chord:
                break
            pieces *= 2
        found.append(p[::2] if not found else p[2::2])
    return np.concatenate(found)
