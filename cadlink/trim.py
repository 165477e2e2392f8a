"""Is a point of the (u, v) plane inside the boundary of a face?

Even-odd rule with a ray towards +u. The boundary is closed exactly and its pieces are monotone in
v (loops.py), so the count is right to round-off: straight pieces by one comparison, curved ones by
solving v(s) = v on the piece itself. Nothing is approximated by polygons.

    piece   one monotone piece: ends (u0, v0, u1, v1), range (ulo, uhi) of u, control points
"""

from math import floor

import numpy as np
from numba import njit

from cadlink.kernels import POINT
from cadlink.nurbs import arc_point

ROUND_OFF = 1e-11  # relative to the (u, v) box: a point this far outside it counts as on its border


PIECE = np.dtype([("ends", "f8", 4), ("reach", "f8", 2), ("degree", "i8"), ("ctrl", "i8")])


def pack_pieces(pieces, ctrl_count):
    """PIECE records and control points (w u, w v, w, 0) of boundary pieces, numbered from ctrl_count."""
    records = np.zeros(len(pieces), PIECE)
    nets = []
    for record, piece in zip(records, pieces, strict=True):
        record["ends"] = piece.ends
        record["reach"] = piece.ulo, piece.uhi
        record["degree"] = 1
        if piece.ctrl is not None:
            record["degree"] = len(piece.ctrl) - 1
            record["ctrl"] = ctrl_count
            nets.append(np.pad(piece.ctrl, ((0, 0), (0, 1))))
            ctrl_count += len(piece.ctrl)
    return records, nets


@njit(**POINT)
def crosses(piece, ctrl, u, v, work):
    """Whether the ray from (u, v) towards +u meets a piece; ends count half-open in v."""
    u0, v0, u1, v1 = piece.ends[0], piece.ends[1], piece.ends[2], piece.ends[3]
    if (v0 <= v) == (v1 <= v):
        return False
    if u < piece.reach[0]:
        return True
    if u > piece.reach[1]:
        return False
    if piece.degree == 1:
        return u < u0 + (v - v0) / (v1 - v0) * (u1 - u0)
    # Root of v(s) = v between 0 and 1: Newton, kept inside a shrinking bracket.
    first, degree = piece.ctrl, piece.degree
    lo, hi = 0.0, 1.0
    s = (v - v0) / (v1 - v0)
    for _ in range(60):
        arc_point(ctrl, first, degree, s, work)
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


@njit(**POINT)
def inside_once(face, pieces, ctrl, u, v, work):
    odd = False
    for k in range(face.piece_first, face.piece_last):
        if crosses(pieces[k], ctrl, u, v, work):
            odd = not odd
    return odd


@njit(forceinline=True, **POINT)
def nudged(x, lo, hi):
    """x moved just inside [lo, hi] where round-off, and only round-off, put it on or over an end."""
    room = ROUND_OFF * (hi - lo)
    if lo - room <= x < lo + room:
        return lo + room
    if hi - room < x <= hi + room:
        return hi - room
    return x


@njit(forceinline=True, **POINT)
def first_turn(x, lo, hi, period):
    """x shifted by whole periods to lie in [lo, lo + period), round-off below lo included."""
    if period == 0.0:
        return x
    room = ROUND_OFF * (hi - lo)
    return x - floor((x - lo + room) / period) * period


@njit(**POINT)
def inside(face, pieces, ctrl, u, v, work):
    """Whether (u, v) lies in a face. Parameters that wrap round are shifted to the face's own turn."""
    u0, u1 = face.box[0], face.box[1]
    v0, v1 = face.box[2], face.box[3]
    u = nudged(first_turn(u, u0, u1, face.period[0]), u0, u1)
    v = nudged(first_turn(v, v0, v1, face.period[1]), v0, v1)
    if u < u0 or u > u1 or v < v0 or v > v1:
        return False
    return inside_once(face, pieces, ctrl, u, v, work)
