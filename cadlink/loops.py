"""The boundary of a face in its (u, v): closed exactly and cut where v turns.

A point is inside where a ray towards +u crosses the boundary an odd number of times. That count
is exact when (1) the boundary has no gap at all, so neighbouring pieces share the same floating
point v, and (2) v is monotone along each piece. Both are made true here, once, while reading.
"""

from typing import NamedTuple

import numpy as np

from cadlink.bezier import clip, points, project_ctrl


class Piece(NamedTuple):
    """One monotone piece of a boundary: ends (u0, v0, u1, v1), and control points unless straight.

    The box (ulo, uhi) holds the piece in u.
    """

    ends: tuple
    ctrl: np.ndarray | None
    ulo: float
    uhi: float


def matched(traces):
    """For each trace of a wire, which trace follows it: starts paired with the nearest ends."""
    n = len(traces)
    starts = np.array([t.start for t in traces])
    ends = np.array([t.end for t in traces])
    span = np.ptp(np.vstack([starts, ends]), axis=0)
    span[span == 0.0] = 1.0
    far = np.linalg.norm((ends[:, None] - starts[None]) / span, axis=2)
    # Among equally near partners prefer the order of the wire: it keeps corners right.
    far[np.arange(n), (np.arange(n) + 1) % n] -= 1e-9
    following = np.full(n, -1)
    taken = np.zeros(n, bool)
    for flat in np.argsort(far, axis=None, kind="stable"):
        i, j = divmod(int(flat), n)
        if following[i] < 0 and not taken[j]:
            following[i], taken[j] = j, True
    return following


def pieces_of_wire(traces, following):
    """The closed boundary of one wire as monotone pieces."""
    # Corner points, one for each start: whatever gap there is to the trace before is bridged.
    pieces = []
    for i, trace in enumerate(traces):
        arcs = trace.arcs
        joints = [end_of(a.ctrl, 0) for a in arcs]
        joints.append(end_of(arcs[-1].ctrl, -1))
        for arc, start, end in zip(arcs, joints[:-1], joints[1:], strict=True):
            pieces += monotone_pieces(arc, start, end)
        tail = joints[0] if trace.reversed else joints[-1]
        after = traces[following[i]]
        which = -1 if after.reversed else 0
        head = end_of(after.arcs[which].ctrl, which)
        pieces.append(straight(tail, head))
    # Pieces along u cross no ray, but they tell where a boundary passes (leaves.py).
    return [p for p in pieces if p.ends[:2] != p.ends[2:]]


def end_of(ctrl, which):
    """Start (0) or end (-1) of an arc."""
    return ctrl[which, :-1] / ctrl[which, -1]


def straight(start, end):
    ulo, uhi = sorted((start[0], end[0]))
    return Piece((start[0], start[1], end[0], end[1]), None, ulo, uhi)


def monotone_pieces(arc, start, end):
    """An arc cut where dv/ds changes sign; consecutive pieces share their end exactly."""
    ctrl = arc.ctrl
    if len(ctrl) == 2:
        return [straight(start, end)]
    flat = project_ctrl(ctrl)
    if np.all(flat[:, 1] == flat[0, 1]):
        ends = (start[0], start[1], end[0], start[1])
        return [Piece(ends, None, flat[:, 0].min(), flat[:, 0].max())]
    steps = np.diff(flat[:, 1])
    cuts = [0.0, 1.0]
    if not (np.all(steps >= 0.0) or np.all(steps <= 0.0)):
        cuts = [0.0, *turns(ctrl), 1.0]
    joints = points(ctrl, cuts)
    joints[0], joints[-1] = start, end
    pieces = []
    for k in range(len(cuts) - 1):
        part = clip(ctrl, cuts[k], cuts[k + 1])
        hull = np.append(project_ctrl(part)[:, 0], [joints[k, 0], joints[k + 1, 0]])
        ends = (*joints[k], *joints[k + 1])
        pieces.append(Piece(ends, part, hull.min(), hull.max()))
    return pieces


def turns(ctrl):
    """Parameters where dv/ds changes sign, by bisection between samples."""

    def slope(s):
        p = len(ctrl) - 1
        h = points_h(ctrl, s)
        dh = p * points_h(np.diff(ctrl, axis=0), s)
        return dh[:, -2] * h[:, -1] - h[:, -2] * dh[:, -1]

    s = np.linspace(0.0, 1.0, 8 * len(ctrl) + 1)
    f = slope(s)
    k = np.flatnonzero(f[:-1] * f[1:] < 0.0)
    lo, hi, sign = s[k], s[k + 1], f[k]
    for _ in range(52 if len(k) else 0):
        middle = 0.5 * (lo + hi)
        before = slope(middle) * sign > 0.0
        lo, hi = np.where(before, middle, lo), np.where(before, hi, middle)
    level = np.flatnonzero((f[1:-1] == 0.0) & (f[:-2] * f[2:] < 0.0)) + 1
    return sorted([*(0.5 * (lo + hi)), *s[level]])


def points_h(ctrl, s):
    """Homogeneous points of an arc."""
    b = np.broadcast_to(ctrl, (len(s), *ctrl.shape)).copy()
    s = np.asarray(s)[:, None, None]
    while b.shape[1] > 1:
        b = (1.0 - s) * b[:, :-1] + s * b[:, 1:]
    return b[:, 0]


def uv_box(traces, pieces):
    """(u0, u1, v0, v1) of a boundary."""
    p = np.array([q for t in traces for q in (t.start, t.end)])
    lo, hi = p.min(axis=0), p.max(axis=0)
    for piece in pieces:
        lo = np.minimum(lo, [piece.ulo, min(piece.ends[1], piece.ends[3])])
        hi = np.maximum(hi, [piece.uhi, max(piece.ends[1], piece.ends[3])])
    return np.array([lo[0], hi[0], lo[1], hi[1]])
