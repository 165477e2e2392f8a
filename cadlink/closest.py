"""The closest point of a trimmed skin: candidates, the best of them, and what it tells.

    p       the point;  m = p - foot
    n       unit normal out of the material;  d = signed distance, grad d = n
    k, e    curvatures and principal direction: hess d = sum k_i / (1 + k_i d) e_i e_i^T
    best    smallest distance so far, plus the slack of an edge or vertex

A closest point on a trimmed skin is a foot inside a face, a foot on an edge, or a vertex. The
tree proposes items in order of nearness; each is measured exactly; the smallest distance wins.

On an edge with tangent T and curvature vector c, d = |p - C(t)| gives grad d = n = m / d and

    hess d = 1/d (across)^2 + k/(1 + k d) T T^T,   k = -c . n

so an edge is a surface whose curvature across is without bound; at a vertex both are. SHARP
stands for that bound. Where m enters the material (a re-entrant edge) both d and SHARP are
negative.
"""

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np
from numba import njit, prange

from cadlink.boxtree import DEPTH, box_distance
from cadlink.nurbs import (
    WORK,
    arc_derivatives,
    arc_foot,
    cross,
    dot,
    from_ramp,
    minus,
    patch_foot,
    shape_on_patch,
    to_ramp,
)
from cadlink.primitives import foot_on_form, shape_on_form
from cadlink.records import CONE, PATCHES, TORUS
from cadlink.skin import ON_ARC, ON_CIRCLE, ON_FACE, ON_LEAF, ON_LINE, SMOOTH
from cadlink.trim import inside

SHARP = 1e12  # 1/mm, stands for the curvature across a sharp edge
TOUCH = 1e-9  # mm: nearer to an edge than this, m has no direction and the mean normal is used
END = 1e-9  # of an edge's length: feet this far past its end still count as on it
CHUNK = 64  # points that share one scratch space


# --- one item ------------------------------------------------------------------------------------


@njit
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


@njit
def leaf_bound(leaf, p):
    """Distance from a point to the aligned box of a leaf, and its height above the middle."""
    frame, half = leaf.frame, leaf.half
    x, y, z = p[0] - frame[0, 0], p[1] - frame[0, 1], p[2] - frame[0, 2]
    a = x * frame[1, 0] + y * frame[1, 1] + z * frame[1, 2]
    b = x * frame[2, 0] + y * frame[2, 1] + z * frame[2, 2]
    c = x * frame[3, 0] + y * frame[3, 1] + z * frame[3, 2]
    da = max(0.0, abs(a) - half[0])
    db = max(0.0, abs(b) - half[1])
    dc = max(0.0, abs(c) - half[2])
    return sqrt(da * da + db * db + dc * dc), c


@njit
def starts_for(leaf, bound, height):
    """How many Newton starts: where a leaf may bend round the point there may be several minima."""
    if abs(height) <= leaf.half[2]:
        bend = max(leaf.bend[0], leaf.bend[1])
    else:
        bend = leaf.bend[0] if height > 0.0 else leaf.bend[1]
    return 1 if (bound + 2.0 * leaf.half[2]) * bend < 0.7 else 10


@njit
def try_leaf(leaf, patch, face, pieces, ctrl, p, best, s, t, work):
    """Nearest foot inside the face from a start in a leaf (its middle where s < 0)."""
    distance, found_s, found_t, foot = np.inf, 0.0, 0.0, p
    bound, height = leaf_bound(leaf, p)
    if bound >= best:
        return distance, found_s, found_t, foot
    s0, s1, t0, t1 = leaf.rect[0], leaf.rect[1], leaf.rect[2], leaf.rect[3]
    for start in range(starts_for(leaf, bound, height)):
        if start == 0:
            a = s if s >= 0.0 else 0.5 * (s0 + s1)
            b = t if s >= 0.0 else 0.5 * (t0 + t1)
        else:
            a = s0 + (s1 - s0) * (((start - 1) % 3) + 0.5) / 3.0
            b = t0 + (t1 - t0) * (((start - 1) // 3) + 0.5) / 3.0
        a, b, q, f, free, _ = patch_foot(patch, ctrl, p, a, b, work)
        h = sqrt(f)
        if not free or h >= min(best, distance):
            continue
        if not (leaf.whole and s0 <= a <= s1 and t0 <= b <= t1):
            u = from_ramp(a, patch.uv[0], patch.uv[1], patch.ramp[0])
            v = from_ramp(b, patch.uv[2], patch.uv[3], patch.ramp[1])
            if not inside(face, pieces, ctrl, u, v, work):
                continue
        distance, found_s, found_t, foot = h, a, b, q
    return distance, found_s, found_t, foot


@njit
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


@njit
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


@njit
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
        if past and ((a <= 0.0 and curve.ends_there[0]) or (a >= 1.0 and curve.ends_there[1])):
            continue
        if h < distance:
            distance, found, foot = h, a, q
    return distance, found, foot


@njit
def try_item(skin, item, p, best, a, b, work):
    """Foot on any item: distance with its slack, two parameters, foot."""
    kind, ref = skin.items[item].kind, skin.items[item].ref
    if kind == ON_FACE:
        return try_face(skin.faces[ref], skin.pieces, skin.ctrl, p, best, work)
    if kind == ON_LEAF:
        leaf = skin.leaves[ref]
        patch = skin.patches[leaf.patch]
        face = skin.faces[patch.face]
        return try_leaf(leaf, patch, face, skin.pieces, skin.ctrl, p, best, a, b, work)
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


# --- the nearest of all --------------------------------------------------------------------------


@njit
def nearest(skin, p, seed, stack, bounds, work):
    """The item with the closest point: item, two parameters, foot.

    seed : item and parameters found last time, item < 0 for none; it only tightens the search
    """
    best, item, a, b, foot = np.inf, -1, 0.0, 0.0, p
    seed_item = int(seed[0])
    # The seed comes first, then the tree from its root.
    other, a1, b1 = seed_item, seed[1], seed[2]
    stack[0], bounds[0], top = 0, 0.0, 1
    k, stop = 0, 0
    if not 0 <= seed_item < len(skin.items):
        other = -1
    while True:
        if other >= 0:
            value, a1, b1, foot1 = try_item(skin, other, p, best, a1, b1, work)
            if value < best:
                best, item, a, b, foot = value, other, a1, b1, foot1
            other = -1
        if k < stop:
            # Items of a leaf of the tree.
            if box_distance(skin.items[skin.order[k]], p) < best:
                other, a1, b1 = skin.order[k], -1.0, -1.0
            k += 1
            continue
        if top == 0:
            return item, a, b, foot
        top -= 1
        if bounds[top] >= best:
            continue
        node = skin.nodes[stack[top]]
        child = node.child
        if child < 0:
            k, stop = node.start, node.stop
            continue
        left, right = box_distance(skin.nodes[child], p), box_distance(skin.nodes[child + 1], p)
        # The nearer child goes on top of the stack.
        if left <= right:
            stack[top], bounds[top] = child + 1, right
            stack[top + 1], bounds[top + 1] = child, left
        else:
            stack[top], bounds[top] = child, left
            stack[top + 1], bounds[top + 1] = child + 1, right
        top += 2


# --- what the nearest point tells ----------------------------------------------------------------


@njit
def locate(breaks, first, n, x):
    """Row of a patch grid that holds parameter x."""
    lo, hi = 0, n
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if breaks[first + middle] <= x:
            lo = middle
        else:
            hi = middle
    return lo


@njit
def patch_at(face, patches, breaks, u, v):
    """Patch of a face that holds (u, v), and the parameters there."""
    first, nu, nv, at_u, at_v = face.grid[0], face.grid[1], face.grid[2], face.grid[3], face.grid[4]
    # Parameters that wrap round are brought into the surface's own turn.
    if face.period[0] > 0.0 and not (breaks[at_u] <= u <= breaks[at_u + nu]):
        u -= floor((u - breaks[at_u]) / face.period[0]) * face.period[0]
    if face.period[1] > 0.0 and not (breaks[at_v] <= v <= breaks[at_v + nv]):
        v -= floor((v - breaks[at_v]) / face.period[1]) * face.period[1]
    number = first + locate(breaks, at_u, nu, u) * nv + locate(breaks, at_v, nv, v)
    patch = patches[number]
    r = patch.uv
    s = to_ramp(min(r[1], max(r[0], u)), r[0], r[1], patch.ramp[0])
    t = to_ramp(min(r[3], max(r[2], v)), r[2], r[3], patch.ramp[1])
    return number, min(1.0, max(0.0, s)), min(1.0, max(0.0, t))


@njit
def uv_on_side(side, side_uv, tau):
    """(u, v) of a face beside an edge at tau, between the samples."""
    first, last = side.uv_first, side.uv_last - 1
    x = tau * (last - first)
    k = min(last - first - 1, int(x))
    x -= k
    return (
        (1.0 - x) * side_uv[first + k, 0] + x * side_uv[first + k + 1, 0],
        (1.0 - x) * side_uv[first + k, 1] + x * side_uv[first + k + 1, 1],
    )


@njit
def shape_on_face(skin, number, patch, a, b, work):
    """Outward normal, curvatures and direction at a foot: (u, v), or (s, t) of a patch."""
    face = skin.faces[number]
    if face.form == PATCHES:
        return shape_on_patch(skin.patches[patch], skin.ctrl, a, b, face.sense, work)
    return shape_on_form(face, a, b)


@njit
def edge_at(kind, curve, ctrl, a, work):
    """tau, tangent and curvature vector of an edge piece at its parameter."""
    f = curve.frame
    if kind == ON_LINE:
        d = (f[1, 0], f[1, 1], f[1, 2])
        h = sqrt(dot(d, d))
        return a, (d[0] / h, d[1] / h, d[2] / h), (0.0, 0.0, 0.0)
    if kind == ON_CIRCLE:
        t0, t1 = curve.span[0], curve.span[1]
        c, s = cos(a), sin(a)
        x, y = (f[1, 0], f[1, 1], f[1, 2]), (f[2, 0], f[2, 1], f[2, 2])
        r2 = dot(x, x)
        r = sqrt(r2)
        out = (c * x[0] + s * y[0], c * x[1] + s * y[1], c * x[2] + s * y[2])
        along = (c * y[0] - s * x[0], c * y[1] - s * x[1], c * y[2] - s * x[2])
        tangent = (along[0] / r, along[1] / r, along[2] / r)
        return (a - t0) / (t1 - t0), tangent, (-out[0] / r2, -out[1] / r2, -out[2] / r2)
    _, d1, d2 = arc_derivatives(ctrl, curve.ctrl, curve.degree, a, work)
    speed2 = max(dot(d1, d1), 1e-300)
    h = sqrt(speed2)
    tangent = (d1[0] / h, d1[1] / h, d1[2] / h)
    along = dot(d2, tangent)
    bend = (
        (d2[0] - along * tangent[0]) / speed2,
        (d2[1] - along * tangent[1]) / speed2,
        (d2[2] - along * tangent[2]) / speed2,
    )
    s0, s1, first, last = curve.span[0], curve.span[1], curve.span[5], curve.span[6]
    t = from_ramp(s0 + a * (s1 - s0), curve.span[2], curve.span[3], int(curve.span[4]))
    return min(1.0, max(0.0, (t - first) / (last - first))), tangent, bend


@njit
def continued(skin, number, u, v, p, foot, slack, work):
    """Foot on a face taken beyond its trim, near a point of a smooth edge or vertex.

    returns : whether there is one, patch, two parameters, foot
    """
    face = skin.faces[number]
    m = minus(p, foot)
    reach = 5e-3 * sqrt(dot(m, m)) + 10.0 * slack + 1e-6
    if face.form == PATCHES:
        patch, s, t = patch_at(face, skin.patches, skin.breaks, u, v)
        s, t, q, _, _, pull = patch_foot(skin.patches[patch], skin.ctrl, p, s, t, work)
        m = minus(q, foot)
        return dot(m, m) <= reach * reach and pull <= reach, patch, s, t, q
    for branch in range(2):
        exists, a, b, q = foot_on_form(face, p, branch)
        m = minus(q, foot)
        if exists and dot(m, m) <= reach * reach:
            return True, -1, a, b, q
    return False, -1, u, v, foot


@njit
def faces_at_edge(skin, edge, tau, work):
    """Mean outward normal of the faces at an edge, and whether they continue each other."""
    mean, n = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    smooth = edge.side_last - edge.side_first > 1
    for k in range(edge.side_first, edge.side_last):
        side = skin.sides[k]
        a, b = uv_on_side(side, skin.side_uv, tau)
        face, patch = skin.faces[side.face], -1
        if face.form == PATCHES:
            patch, a, b = patch_at(face, skin.patches, skin.breaks, a, b)
        other, _, _, _ = shape_on_face(skin, side.face, patch, a, b, work)
        if k == edge.side_first:
            n = other
        turn = cross(n, other)
        if dot(turn, turn) > SMOOTH * SMOOTH or dot(n, other) < 0.0:
            smooth = False
        mean = (mean[0] + other[0], mean[1] + other[1], mean[2] + other[2])
    size = sqrt(dot(mean, mean))
    if size == 0.0:
        return n, smooth
    return (mean[0] / size, mean[1] / size, mean[2] / size), smooth


@njit
def any_across(n):
    """A unit vector across n."""
    e = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    h = sqrt(dot(e, e))
    return e[0] / h, e[1] / h, e[2] / h


@njit
def answer_from_face(skin, number, patch, a, b, p, foot, work):
    """Signed distance, foot, normal, k1, k2, direction of k1 at a foot on a smooth face."""
    n, k1, k2, e = shape_on_face(skin, number, patch, a, b, work)
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    return (h if dot(m, n) >= 0.0 else -h), foot, n, k1, k2, e


@njit
def answer_from_edge(p, foot, mean, tangent, bend):
    """The same at a sharp edge with mean normal, tangent and curvature vector."""
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    sign = 1.0 if dot(m, mean) >= 0.0 else -1.0
    n = (sign * m[0] / h, sign * m[1] / h, sign * m[2] / h) if h > TOUCH else mean
    along = -dot(bend, n)
    across = cross(tangent, n)
    size = sqrt(dot(across, across))
    if size > 0.0:
        across = (across[0] / size, across[1] / size, across[2] / size)
    else:
        across = any_across(n)
    if sign > 0.0:
        return h, foot, n, SHARP, along, across
    return -h, foot, n, along, -SHARP, cross(across, n)


@njit
def answer_from_vertex(p, foot, mean):
    """The same at a vertex with pseudo-normal."""
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    sign = 1.0 if dot(m, mean) >= 0.0 else -1.0
    n = (sign * m[0] / h, sign * m[1] / h, sign * m[2] / h) if h > TOUCH else mean
    return sign * h, foot, n, sign * SHARP, sign * SHARP, any_across(n)


@njit
def answer(skin, item, a, b, p, foot, work):
    """Signed distance, foot, normal, k1, k2, direction of k1, face of the nearest item."""
    kind, ref = skin.items[item].kind, skin.items[item].ref
    face, patch, on_face = ref, -1, kind == ON_FACE
    mean = tangent = bend = (0.0, 0.0, 0.0)
    if kind == ON_LEAF:
        patch = skin.leaves[ref].patch
        face, on_face = skin.patches[patch].face, True
    elif not on_face:
        # Where all faces share a tangent plane they continue each other: the foot belongs to one
        # of them, taken past its trim.
        side_first, side_last, tau, u, v = 0, 1, 0.0, 0.0, 0.0
        if kind <= ON_ARC:
            curve = skin.curves[ref]
            edge = skin.edges[curve.edge]
            tau, tangent, bend = edge_at(kind, curve, skin.ctrl, a, work)
            mean, smooth = faces_at_edge(skin, edge, tau, work)
            slack, side_first, side_last = edge.slack, edge.side_first, edge.side_last
            face = skin.sides[side_first].face
        else:
            vertex = skin.vertices[ref]
            mean = (vertex.normal[0], vertex.normal[1], vertex.normal[2])
            slack, smooth, face = vertex.slack, vertex.smooth != 0, vertex.face
            u, v = vertex.uv[0], vertex.uv[1]
        if smooth:
            for k in range(side_first, side_last):
                if kind <= ON_ARC:
                    side = skin.sides[k]
                    face = side.face
                    u, v = uv_on_side(side, skin.side_uv, tau)
                ok, patch1, a1, b1, q = continued(skin, face, u, v, p, foot, slack, work)
                if ok:
                    on_face, patch, a, b, foot = True, patch1, a1, b1, q
                    break
    if on_face:
        d, q, n, k1, k2, e = answer_from_face(skin, face, patch, a, b, p, foot, work)
    elif kind <= ON_ARC:
        d, q, n, k1, k2, e = answer_from_edge(p, foot, mean, tangent, bend)
    else:
        d, q, n, k1, k2, e = answer_from_vertex(p, foot, mean)
    return d, q, n, k1, k2, e, skin.faces[face].label


@njit(parallel=True, cache=True)
def project_points(skin, points, seed, distance, point, normal, curvature, direction, face, new_seed):
    """Fill the fields of a Projection. Points are independent: the same bits at any thread count."""
    n = len(points)
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        stack, bounds = np.zeros(DEPTH, np.int64), np.zeros(DEPTH)
        work = np.zeros(WORK)
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            p = (points[i, 0], points[i, 1], points[i, 2])
            item, a, b, foot = nearest(skin, p, seed[i], stack, bounds, work)
            d, q, nrm, k1, k2, e, f = answer(skin, item, a, b, p, foot, work)
            distance[i], face[i] = d, f
            for c in range(3):
                point[i, c], normal[i, c], direction[i, c] = q[c], nrm[c], e[c]
            curvature[i, 0], curvature[i, 1] = k1, k2
            new_seed[i, 0], new_seed[i, 1], new_seed[i, 2] = item, a, b
