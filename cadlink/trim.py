"""Is a point of the (u, v) plane inside the boundary of a face?

Even-odd rule with a ray towards +u. The boundary is closed exactly and its pieces are monotone in
v (loops.py), so the count is right to round-off: straight pieces by one comparison, curved ones by
solving v(s) = v on the piece itself. Nothing is approximated by polygons.

    piece   one monotone piece: ends (u0, v0, u1, v1), range (ulo, uhi) of u, control points
"""

from math import floor
from typing import NamedTuple

import numpy as np
from numba import njit

from cadlink.nurbs import arc_point

ROUND_OFF = 1e-11  # relative to the (u, v) box: a point this far outside it counts as on its border


class Trims(NamedTuple):
    """Boundaries of all faces: pieces first[face] .. first[face + 1]."""

    first: np.ndarray  # (n_faces + 1,)
    box: np.ndarray  # (n_faces, 4) u0, u1, v0, v1
    period: np.ndarray  # (n_faces, 2), 0 where there is none
    ends: np.ndarray  # (n_pieces, 4)
    reach: np.ndarray  # (n_pieces, 2) ulo, uhi
    degree: np.ndarray  # (n_pieces,), 1 for a straight piece
    ctrl_first: np.ndarray  # (n_pieces,)
    ctrl: np.ndarray  # (n_ctrl, 4): w u, w v, w, 0


def pack_trims(trims, boxes, periods):
    """Trims from the lists of Piece that the reading process made."""
    pieces = [p for face in trims for p in face]
    counts = [len(face) for face in trims]
    curved = [p.ctrl for p in pieces if p.ctrl is not None]
    degree = np.array([1 if p.ctrl is None else len(p.ctrl) - 1 for p in pieces], np.int64)
    used = np.array([0 if p.ctrl is None else len(p.ctrl) for p in pieces], np.int64)
    ctrl = np.zeros((max(1, used.sum()), 4))
    if curved:
        ctrl[:, :3] = np.vstack(curved)
    return Trims(
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.ascontiguousarray(boxes, float).reshape(-1, 4),
        np.ascontiguousarray(periods, float).reshape(-1, 2),
        np.array([p.ends for p in pieces], float).reshape(-1, 4),
        np.array([(p.ulo, p.uhi) for p in pieces], float).reshape(-1, 2),
        degree,
        np.concatenate([[0], np.cumsum(used)[:-1]]).astype(np.int64),
        ctrl,
    )


@njit
def crosses(trims, piece, u, v, work):
    """Whether the ray from (u, v) towards +u meets a piece; ends count half-open in v."""
    u0, v0 = trims.ends[piece, 0], trims.ends[piece, 1]
    u1, v1 = trims.ends[piece, 2], trims.ends[piece, 3]
    if (v0 <= v) == (v1 <= v):
        return False
    if u < trims.reach[piece, 0]:
        return True
    if u > trims.reach[piece, 1]:
        return False
    if trims.degree[piece] == 1:
        return u < u0 + (v - v0) / (v1 - v0) * (u1 - u0)
    # Root of v(s) = v between 0 and 1: Newton, kept inside a shrinking bracket.
    first, degree = trims.ctrl_first[piece], trims.degree[piece]
    lo, hi = 0.0, 1.0
    s = (v - v0) / (v1 - v0)
    for _ in range(60):
        arc_point(trims.ctrl, first, degree, s, work)
        w = work[0, 2]
        miss = work[0, 1] / w - v
        if miss == 0.0:
            break
        if (miss < 0.0) == (v1 > v0):
            lo = s
        else:
            hi = s
        slope = (work[1, 1] - work[0, 1] / w * work[1, 2]) / w
        new = s - miss / slope if slope != 0.0 else -1.0
        if not (lo < new < hi):
            new = 0.5 * (lo + hi)
        if abs(new - s) <= 1e-16 or new == lo or new == hi:
            break
        s = new
    return u < work[0, 0] / work[0, 2]


@njit
def inside_once(trims, face, u, v, work):
    odd = False
    for piece in range(trims.first[face], trims.first[face + 1]):
        if crosses(trims, piece, u, v, work):
            odd = not odd
    return odd


@njit(forceinline=True)
def nudged(x, lo, hi):
    """x moved just inside [lo, hi] where round-off, and only round-off, put it on or over an end."""
    room = ROUND_OFF * (hi - lo)
    if lo - room <= x < lo + room:
        return lo + room
    if hi - room < x <= hi + room:
        return hi - room
    return x


@njit(forceinline=True)
def first_turn(x, lo, hi, period):
    """x shifted by whole periods to lie in [lo, lo + period), round-off below lo included."""
    if period == 0.0:
        return x
    room = ROUND_OFF * (hi - lo)
    return x - floor((x - lo + room) / period) * period


@njit
def inside(trims, face, u, v, work):
    """Whether (u, v) lies in a face. Parameters that wrap round are shifted to the face's own turn."""
    u0, u1 = trims.box[face, 0], trims.box[face, 1]
    v0, v1 = trims.box[face, 2], trims.box[face, 3]
    u = nudged(first_turn(u, u0, u1, trims.period[face, 0]), u0, u1)
    v = nudged(first_turn(v, v0, v1, trims.period[face, 1]), v0, v1)
    if u < u0 or u > u1 or v < v0 or v > v1:
        return False
    return inside_once(trims, face, u, v, work)
