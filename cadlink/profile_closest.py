"""The closest point of a plane profile: pieces of rational Bezier curves, and what happens where curves meet.

    p, q     point and foot;  m = p - q
    C, s     a piece and its parameter in [0, 1];  g = (C - p) . C', zero at a foot
    T, n     unit tangent, the material on its left; unit normal, on its right
    k        curvature of the outward side, + where the material bulges out

Lines are met in closed form. Elsewhere pieces turn by less than half a radian; Newton on g, kept inside a shrinking
bracket, starts from three places, since a point near the centre of curvature may have several feet.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from cadlink.bezier import bernstein
from cadlink.profile import gentle_pieces

SHARP = 1e12  # 1/mm, stands for the curvature of a corner
END = 1e-12  # of a piece: a foot this near to its end is the end
TOUCH = 1e-9  # mm: nearer than this m has no direction
PIECE = np.dtype(
    [
        ("low", "f8", 2),
        ("high", "f8", 2),
        ("curve", "i8"),
        ("ctrl", "i8"),
        ("degree", "i8"),
        ("bend", "f8"),  # 1/mm, about the largest curvature
        ("ends_there", "i8", 2),  # whether the curve starts at its start, ends at its end
    ]
)


class ProfileShape(NamedTuple):
    pieces: np.ndarray  # (k,) PIECE
    ctrl: np.ndarray  # (m, 3) control points (w x, w y, w)
    joint: np.ndarray  # (n, 2, 2) sum of the normals that meet at the start and end of each curve
    sharp: np.ndarray  # (n, 2) bool: a corner or a free end


def pack_profile(curves, smooth, joined):
    """ProfileShape of curves; ends within `joined` mm meet, at less than `smooth` rad they continue each other."""
    pieces, nets, count = [], [], 0
    for number, curve in enumerate(curves):
        mine = [net for arc in curve.arcs for _, _, net in gentle_pieces(arc)]
        for k, net in enumerate(mine):
            hull = net[:, :2] / net[:, 2:]
            there = (k == 0, k == len(mine) - 1)
            pieces.append((hull.min(axis=0), hull.max(axis=0), number, count, len(net) - 1, largest_bend(net), there))
            nets.append(net)
            count += len(net)
    normals = np.array([[end_normal(c.arcs[0], 0), end_normal(c.arcs[-1], 1)] for c in curves])
    at = np.array([[c.start, c.end] for c in curves])
    joint, sharp = normals.copy(), np.ones((len(curves), 2), bool)
    for k in range(len(curves)):
        for end in (0, 1):
            # The start of a curve meets the end of another, or its own.
            near = np.flatnonzero(np.linalg.norm(at[:, 1 - end] - at[k, end], axis=1) <= joined)
            for other in near:
                joint[k, end] += normals[other, 1 - end]
            if len(near):
                angle = max(np.linalg.norm(normals[o, 1 - end] - normals[k, end]) for o in near)
                sharp[k, end] = angle > smooth
    return ProfileShape(np.array(pieces, PIECE), np.vstack(nets), joint, sharp)


def largest_bend(net):
    """Half more than the largest curvature at eleven points of a piece [1/mm]; 0 for a line."""
    if len(net) == 2:
        return 0.0
    bends = []
    for s in np.linspace(0.0, 1.0, 11):
        _, _, dx, dy, ddx, ddy = point_at(net, 0, len(net) - 1, s)
        bends.append(abs(dx * ddy - dy * ddx) / max(np.hypot(dx, dy) ** 3, 1e-300))
    return 1.5 * max(bends)


def end_normal(ctrl, end):
    """Unit normal at the start (0) or end (1) of an arc, on the right of its direction."""
    p = ctrl[:, :2] / ctrl[:, 2:]
    legs = np.diff(p, axis=0)
    legs = legs[np.linalg.norm(legs, axis=1) > 1e-14]
    if not len(legs):
        legs = np.diff(points_of(ctrl), axis=0)
    t = legs[-1 if end else 0]
    return np.array([t[1], -t[0]]) / np.linalg.norm(t)


def points_of(ctrl):
    h = bernstein(len(ctrl) - 1, np.array([0.0, 1.0])) @ ctrl
    return h[:, :2] / h[:, 2:]


@njit
def point_at(ctrl, first, degree, s):
    """Point, first and second derivative of a piece at s: Horner on the binomial form, quotient rule."""
    r = 1.0 - s
    x0 = x1 = x2 = y0 = y1 = y2 = w0 = w1 = w2 = 0.0
    power, power1, power2, binomial = 1.0, 0.0, 0.0, 1.0
    for i in range(degree + 1):
        f, f1, f2 = binomial * power, binomial * i * power1, binomial * i * (i - 1.0) * power2
        bx, by, bw = ctrl[first + i, 0], ctrl[first + i, 1], ctrl[first + i, 2]
        x2, x1, x0 = x2 * r - 2.0 * x1 + f2 * bx, x1 * r - x0 + f1 * bx, x0 * r + f * bx
        y2, y1, y0 = y2 * r - 2.0 * y1 + f2 * by, y1 * r - y0 + f1 * by, y0 * r + f * by
        w2, w1, w0 = w2 * r - 2.0 * w1 + f2 * bw, w1 * r - w0 + f1 * bw, w0 * r + f * bw
        power2, power1, power = power1, power, power * s
        binomial *= (degree - i) / (i + 1.0)
    x, y = x0 / w0, y0 / w0
    dx, dy = (x1 - w1 * x) / w0, (y1 - w1 * y) / w0
    ddx, ddy = (x2 - 2.0 * w1 * dx - w2 * x) / w0, (y2 - 2.0 * w1 * dy - w2 * y) / w0
    return x, y, dx, dy, ddx, ddy


@njit
def foot_on_piece(piece, ctrl, px, py):
    """s of the nearest point of a piece, its distance squared."""
    first, degree = piece.ctrl, piece.degree
    best, found = np.inf, 0.0
    for start in range(5):
        s = 0.0 if start == 0 else (1.0 if start == 1 else (0.5 if start == 2 else (0.12 if start == 3 else 0.88)))
        if start == 2 and degree == 1:
            ax, ay, aw = ctrl[first, 0], ctrl[first, 1], ctrl[first, 2]
            bx, by, bw = ctrl[first + 1, 0], ctrl[first + 1, 1], ctrl[first + 1, 2]
            ax, ay, bx, by = ax / aw, ay / aw, bx / bw, by / bw
            dx, dy = bx - ax, by - ay
            size = dx * dx + dy * dy
            s = min(1.0, max(0.0, ((px - ax) * dx + (py - ay) * dy) / size)) if size > 0.0 else 0.0
            # Equal weights are not assumed: the parameter of the same point.
            s = s * aw / (s * aw + (1.0 - s) * bw)
        elif start >= 2:
            lo, hi = 0.0, 1.0
            for _ in range(60):
                x, y, dx, dy, ddx, ddy = point_at(ctrl, first, degree, s)
                mx, my = x - px, y - py
                g = mx * dx + my * dy
                if g > 0.0:
                    hi = s
                else:
                    lo = s
                slope = dx * dx + dy * dy + mx * ddx + my * ddy
                if slope > 0.0:
                    new = s - g / slope
                else:
                    new = s - 0.25 if g > 0.0 else s + 0.25
                if not lo <= new <= hi:
                    new = 0.5 * (lo + hi)
                step = abs(new - s)
                s = new
                if step <= 1e-15:
                    break
            s = 0.0 if s < END else (1.0 if s > 1.0 - END else s)
        x, y, _, _, _, _ = point_at(ctrl, first, degree, s)
        h = (x - px) ** 2 + (y - py) ** 2
        if h < best:
            best, found = h, s
        # One start will do where the piece cannot bend round the point.
        if start == 2 and (degree == 1 or best * piece.bend * piece.bend < 0.25):
            break
    return found, best


@njit
def box_distance2(piece, px, py):
    dx = max(0.0, max(piece.low[0] - px, px - piece.high[0]))
    dy = max(0.0, max(piece.low[1] - py, py - piece.high[1]))
    return dx * dx + dy * dy


@njit
def nearest_piece(shape, px, py, seed):
    """Number of the nearest piece and the parameter of the foot on it; seed : piece to begin with, or -1."""
    pieces = shape.pieces
    start = seed
    if start < 0 or start >= len(pieces):
        # The piece whose box is nearest; of several that hold the point, the one about whose middle it is.
        start, near = 0, np.inf
        for k in range(len(pieces)):
            dx = 0.5 * (pieces[k].low[0] + pieces[k].high[0]) - px
            dy = 0.5 * (pieces[k].low[1] + pieces[k].high[1]) - py
            away = box_distance2(pieces[k], px, py) + 1e-6 * (dx * dx + dy * dy)
            if away < near:
                near, start = away, k
    s, best = foot_on_piece(pieces[start], shape.ctrl, px, py)
    item = start
    for k in range(len(pieces)):
        if k != start and box_distance2(pieces[k], px, py) < best:
            r, h = foot_on_piece(pieces[k], shape.ctrl, px, py)
            if h < best:
                best, item, s = h, k, r
    return item, s


@njit
def profile_answer(shape, item, s, px, py):
    """Signed distance, foot (2), normal (2) and curvature at the foot on a piece."""
    piece = shape.pieces[item]
    x, y, dx, dy, ddx, ddy = point_at(shape.ctrl, piece.ctrl, piece.degree, s)
    mx, my = px - x, py - y
    h = sqrt(mx * mx + my * my)
    speed2 = dx * dx + dy * dy
    speed = sqrt(speed2)
    nx, ny = dy / speed, -dx / speed
    bend = -(ddx * nx + ddy * ny) / speed2
    ux, uy, sharp = nx, ny, False
    # Where curves meet the sum of their normals tells the side.
    if s <= 0.0 and piece.ends_there[0]:
        ux, uy = shape.joint[piece.curve, 0, 0], shape.joint[piece.curve, 0, 1]
        sharp = shape.sharp[piece.curve, 0]
    elif s >= 1.0 and piece.ends_there[1]:
        ux, uy = shape.joint[piece.curve, 1, 0], shape.joint[piece.curve, 1, 1]
        sharp = shape.sharp[piece.curve, 1]
    sign = 1.0 if mx * ux + my * uy >= 0.0 else -1.0
    if sharp:
        bend = sign * SHARP
        size = sqrt(ux * ux + uy * uy)
        if h > TOUCH:
            nx, ny = sign * mx / h, sign * my / h
        elif size > 0.0:
            nx, ny = ux / size, uy / size
    return sign * h, x, y, nx, ny, bend


@njit(parallel=True, cache=True)
def project_on_profile(shape, points, seed, distance, point, normal, curvature, face, new_seed):
    """Fill the fields of a ProfileProjection. Points are independent: the same bits at any thread count."""
    for i in prange(len(points)):
        px, py = points[i, 0], points[i, 1]
        item, s = nearest_piece(shape, px, py, int(seed[i, 0]))
        d, x, y, nx, ny, k = profile_answer(shape, item, s, px, py)
        distance[i], curvature[i], face[i] = d, k, shape.pieces[item].curve
        point[i, 0], point[i, 1] = x, y
        normal[i, 0], normal[i, 1] = nx, ny
        new_seed[i, 0], new_seed[i, 1] = item, s
