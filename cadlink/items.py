"""The foot of a point on one item of a skin, with care: branches, several starts, exact trims.

p       the point
best    smallest distance so far, plus the slack of an edge or vertex
a, b    parameters of a foot: u, v of a face, s, t of a patch, tau, angle or s of an edge
"""

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np
from numba import njit

from cadlink.kernels import INNER, POINT
from cadlink.leaf_bounds import UNIQUE, bend_by_height, bend_by_point, cell_beside, leaf_beside
from cadlink.nurbs import arc_foot, dot, from_ramp, minus
from cadlink.patch_foot import patch_foot
from cadlink.primitives import foot_on_form
from cadlink.records import CONE, TORUS
from cadlink.skin import ON_ARC, ON_CIRCLE, ON_FACE, ON_LEAF, ON_LINE
from cadlink.trim import inside

END = 1e-9  # of an edge's length: feet this far past its end still count as on it
CELLS, STARTS = 9, 18  # of a leaf: each cell has two starts


@njit(**POINT)
def try_face(face, pieces, ctrl, p, best, work):
    """Nearest foot inside a closed-form face: distance (inf for none), u, v, foot."""
    distance, u, v, foot = np.inf, 0.0, 0.0, p
    branches = 2 if face.form == CONE or face.form == TORUS else 1
    for branch in range(branches):
        exists, a, b, q = foot_on_form(face, p, branch)
        m = minus(p, q)
        h = sqrt(dot(m, m))
        if exists and h < min(best, distance) and inside(face, pieces, ctrl, a, b, work):
            distance, u, v, foot = h, a, b, q
    return distance, u, v, foot


@njit(**POINT)
def start_in_leaf(leaf, cell, x, y):
    """Parameters below a point at x, y in the axes of a leaf, kept to one of its nine cells or, < 0, to the leaf; of
    nine more cells the middle."""
    s0, s1, t0, t1 = leaf.rect[0], leaf.rect[1], leaf.rect[2], leaf.rect[3]
    if cell >= 0:
        i, j, w_s, w_t = cell % 3, cell % CELLS // 3, (s1 - s0) / 3.0, (t1 - t0) / 3.0
        s0, s1, t0, t1 = s0 + i * w_s, s0 + (i + 1) * w_s, t0 + j * w_t, t0 + (j + 1) * w_t
        if cell >= CELLS:
            return 0.5 * (s0 + s1), 0.5 * (t0 + t1)
    start = leaf.start
    x, y = x - start[2], y - start[3]
    s, t = start[0] + start[4] * x + start[5] * y, start[1] + start[6] * x + start[7] * y
    return min(s1, max(s0, s)), min(t1, max(t0, t))


@njit(**POINT)
def leaf_holds(leaf, patch, face, pieces, ctrl, s, t, work):
    """Whether a point of a patch lies inside its face's boundary, which is not asked where none passes the leaf."""
    s0, s1, t0, t1 = leaf.rect[0], leaf.rect[1], leaf.rect[2], leaf.rect[3]
    if leaf.whole and s0 <= s <= s1 and t0 <= t <= t1:
        return True
    u = from_ramp(s, patch.uv[0], patch.uv[1], patch.ramp[0])
    v = from_ramp(t, patch.uv[2], patch.uv[3], patch.ramp[1])
    return inside(face, pieces, ctrl, u, v, work)


@njit(**POINT)
def try_leaf(leaf, patch, face, pieces, ctrl, power, p, best, s, t, work):
    """Nearest foot inside the face, downhill from s, t (from below the point where s < 0) and from the leaf's cells."""
    distance, found_s, found_t, foot = np.inf, 0.0, 0.0, p
    bound, beside, x, y, z = leaf_beside(leaf, p)
    if bound >= best or beside > best * leaf.cone:
        return distance, found_s, found_t, foot
    for cell in range(-1, STARTS):
        nearest = min(best, distance)
        # The cells come in where the leaf may bend round the point, those where no normal reaches it excepted: each
        # from its nearest place, and from its middle, for beyond a bend the way down leads elsewhere.
        if cell == 0 and (bound + 2.0 * leaf.half[2]) * bend_by_height(leaf, z) < UNIQUE:
            break
        if cell >= 0 and cell_beside(leaf, cell % CELLS, x, y) > nearest * leaf.cone:
            continue
        a, b = (s, t) if cell < 0 and s >= 0.0 else start_in_leaf(leaf, cell, x, y)
        a, b, q, f, free, _ = patch_foot(patch, ctrl, power, p, a, b, work)
        h = sqrt(f)
        if not free or h >= nearest or not leaf_holds(leaf, patch, face, pieces, ctrl, a, b, work):
            continue
        distance, found_s, found_t, foot = h, a, b, q
        if h * bend_by_point(leaf, p, q) < UNIQUE:
            break
    return distance, found_s, found_t, foot


@njit(**POINT)
def try_line(curve, p):
    """Foot on a straight edge, its ends left to the vertices: distance, tau, foot."""
    f = curve.frame
    a, d = (f[0, 0], f[0, 1], f[0, 2]), (f[1, 0], f[1, 1], f[1, 2])
    size = dot(d, d)
    tau = dot(minus(p, a), d) / size if size > 0.0 else -1.0
    if not (-END <= tau <= 1.0 + END):
        return np.inf, 0.0, p
    tau = min(1.0, max(0.0, tau))
    q = (a[0] + tau * d[0], a[1] + tau * d[1], a[2] + tau * d[2])
    m = minus(p, q)
    return sqrt(dot(m, m)), tau, q


@njit(**POINT)
def try_circle(curve, p):
    """Foot on a circular edge: distance, angle, foot."""
    f = curve.frame
    x, y = (f[1, 0], f[1, 1], f[1, 2]), (f[2, 0], f[2, 1], f[2, 2])
    q = minus(p, (f[0, 0], f[0, 1], f[0, 2]))
    t0, t1 = curve.span[0], curve.span[1]
    room = END * (t1 - t0)
    t = atan2(dot(q, y), dot(q, x))
    t -= floor((t - t0 + room) / (2.0 * pi)) * 2.0 * pi
    if t > t1 + room:
        return np.inf, 0.0, p
    t = min(t1, max(t0, t))
    c, s = cos(t), sin(t)
    foot = (
        f[0, 0] + c * x[0] + s * y[0],
        f[0, 1] + c * x[1] + s * y[1],
        f[0, 2] + c * x[2] + s * y[2],
    )
    m = minus(p, foot)
    return sqrt(dot(m, m)), t, foot


@njit(**POINT)
def try_arc(curve, ctrl, p, s, work):
    """Foot on one piece of a curved edge: distance, parameter of the piece, foot."""
    distance, found, foot = np.inf, 0.0, p
    for start in range(3):
        a = 0.5 if start == 0 else (0.1 if start == 1 else 0.9)
        if start == 0 and s >= 0.0:
            a = s
        a, q, d1, _, f = arc_foot(ctrl, curve.ctrl, curve.degree, p, a, work)
        h = sqrt(f)
        # Beyond the end of the edge the vertex answers; between pieces the end is a point as good.
        past = abs(dot(minus(q, p), d1)) > END * dot(d1, d1)
        ends = (a <= 0.0 and curve.ends_there[0]) or (a >= 1.0 and curve.ends_there[1])
        if h < distance and not (past and ends):
            distance, found, foot = h, a, q
        if h * curve.bend < UNIQUE:
            break
    return distance, found, foot


@njit(**INNER)
def try_item(skin, item, p, best, a, b, work):
    """Foot on any item: distance with its slack, two parameters, foot."""
    kind, ref = skin.items[item].kind, skin.items[item].ref
    if kind == ON_FACE:
        return try_face(skin.faces[ref], skin.pieces, skin.ctrl, p, best, work)
    if kind == ON_LEAF:
        leaf = skin.leaves[ref]
        patch = skin.patches[leaf.patch]
        face = skin.faces[patch.face]
        return try_leaf(leaf, patch, face, skin.pieces, skin.ctrl, skin.power, p, best, a, b, work)
    if kind <= ON_ARC:
        curve = skin.curves[ref]
        if kind == ON_LINE:
            h, a, foot = try_line(curve, p)
        elif kind == ON_CIRCLE:
            h, a, foot = try_circle(curve, p)
        else:
            h, a, foot = try_arc(curve, skin.ctrl, p, a, work)
        return h + skin.edges[curve.edge].slack, a, 0.0, foot
    vertex = skin.vertices[ref]
    foot = (vertex.point[0], vertex.point[1], vertex.point[2])
    m = minus(p, foot)
    return sqrt(dot(m, m)) + vertex.slack, 0.0, 0.0, foot
