"""What a leaf says of a point before any Newton: how far away it is at least, and whether it has one foot at most.

    p       the point;  r = p - q from a point q of the leaf
    x, y, z p in the axes of the leaf, z along the third
    c       largest angle its normals make with the third axis; leaf.cone = sin c

A foot at the distance h lies at most h sin c beside the point, seen along the third axis: no other normal reaches it.
"""

from math import sqrt

from numba import njit

from cadlink.kernels import POINT

UNIQUE = 0.85  # distance times curvature, below which the distance along a leaf has one minimum


@njit(**POINT)
def leaf_beside(leaf, p):
    """Distance from a point to the box of a leaf, the part of it beside the third axis, and the place in its axes."""
    frame, half = leaf.frame, leaf.half
    x, y, z = p[0] - frame[0, 0], p[1] - frame[0, 1], p[2] - frame[0, 2]
    a = x * frame[1, 0] + y * frame[1, 1] + z * frame[1, 2]
    b = x * frame[2, 0] + y * frame[2, 1] + z * frame[2, 2]
    c = x * frame[3, 0] + y * frame[3, 1] + z * frame[3, 2]
    da, db = max(0.0, abs(a) - half[0]), max(0.0, abs(b) - half[1])
    dc = max(0.0, abs(c) - half[2])
    beside = da * da + db * db
    return sqrt(beside + dc * dc), sqrt(beside), a, b, c


@njit(forceinline=True, **POINT)
def bend_seen(leaf, above, unclear):
    """Largest curvature of a leaf towards a point on the side `above` of it; of both sides where that is not clear."""
    if abs(above) <= unclear:
        return max(leaf.bend[0], leaf.bend[1])
    return leaf.bend[0] if above > 0.0 else leaf.bend[1]


@njit(forceinline=True, **POINT)
def bend_by_height(leaf, z):
    """The same of a point at a height above the middle of the box, if that is above all of the leaf."""
    return bend_seen(leaf, z, leaf.half[2])


@njit(**POINT)
def room_of_bend(leaf, z, h):
    """How far [mm] a point at a height z and a distance h may move before distance times curvature reaches UNIQUE."""
    least = UNIQUE / max(max(leaf.bend[0], leaf.bend[1]), 1e-300) - h
    clear = abs(z) - leaf.half[2]
    # While it stays above or below all of the leaf one side counts.
    if clear > 0.0:
        least = max(least, min(clear, UNIQUE / max(bend_by_height(leaf, z), 1e-300) - h))
    return least


@njit(**POINT)
def bend_by_point(leaf, p, q):
    """The same by one point q of the leaf: steeper than its steepest tangent, p - q stays on one side of it."""
    x, y, z = p[0] - q[0], p[1] - q[1], p[2] - q[2]
    axis = leaf.frame[3]
    above = x * axis[0] + y * axis[1] + z * axis[2]
    return bend_seen(leaf, above, leaf.cone * sqrt(x * x + y * y + z * z))


@njit(forceinline=True, **POINT)
def cell_beside(leaf, cell, x, y):
    """How far beside the point one of the leaf's nine cells is at least [mm]."""
    i, j, size = cell % 3 - 1, cell // 3 - 1, leaf.cell
    dx = abs(x - leaf.start[2] - i * size[0, 0] - j * size[1, 0]) - size[2, 0]
    dy = abs(y - leaf.start[3] - i * size[0, 1] - j * size[1, 1]) - size[2, 1]
    dx, dy = max(0.0, dx), max(0.0, dy)
    return sqrt(dx * dx + dy * dy)
