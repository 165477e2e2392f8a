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
from cadlink.skin import ARC, CIRCLE, FACE, LEAF, LINE, SMOOTH, Skin
from cadlink.trim import inside

SHARP = 1e12  # 1/mm, stands for the curvature across a sharp edge
TOUCH = 1e-9  # mm: nearer to an edge than this, m has no direction and the mean normal is used
END = 1e-9  # of an edge's length: feet this far past its end still count as on it
CHUNK = 64  # points that share one scratch space


# --- one item ------------------------------------------------------------------------------------


@njit
def try_face(skin, face, p, best, work):
    """Nearest foot inside a closed-form face: distance (inf for none), u, v, foot."""
    distance, u, v, foot = np.inf, 0.0, 0.0, p
    faces = skin.faces
    for branch in range(2):
        if branch == 1 and faces.form[face] != CONE and faces.form[face] != TORUS:
            break
        exists, a, b, x, y, z = foot_on_form(
            faces.form[face], faces.frame[face], faces.size[face], p[0], p[1], p[2], branch
        )
        m = minus(p, (x, y, z))
        h = sqrt(dot(m, m))
        if exists and h < min(best, distance) and inside(skin.trims, face, a, b, work):
            distance, u, v, foot = h, a, b, (x, y, z)
    return distance, u, v, foot


@njit
def leaf_bound(leaves, leaf, p):
    """Distance from a point to the aligned box of a leaf, and its coordinates there."""
    frame = leaves.frame[leaf]
    q = minus(p, (frame[0, 0], frame[0, 1], frame[0, 2]))
    a = q[0] * frame[1, 0] + q[1] * frame[1, 1] + q[2] * frame[1, 2]
    b = q[0] * frame[2, 0] + q[1] * frame[2, 1] + q[2] * frame[2, 2]
    c = q[0] * frame[3, 0] + q[1] * frame[3, 1] + q[2] * frame[3, 2]
    da = max(0.0, abs(a) - leaves.half[leaf, 0])
    db = max(0.0, abs(b) - leaves.half[leaf, 1])
    dc = max(0.0, abs(c) - leaves.half[leaf, 2])
    return sqrt(da * da + db * db + dc * dc), a, b, c


@njit
def try_leaf(skin, leaf, p, best, s, t, work):
    """Nearest foot inside the face from a start in a leaf (its middle where s < 0)."""
    distance, found_s, found_t, foot = np.inf, 0.0, 0.0, p
    leaves, patches = skin.leaves, skin.patches
    patch = leaves.patch[leaf]
    bound, _, _, c = leaf_bound(leaves, leaf, p)
    if bound >= best:
        return distance, found_s, found_t, foot
    s0, s1, t0, t1 = leaves.rect[leaf]
    # Where a leaf may bend round the point the distance may have several minima: more starts.
    reach = bound + 2.0 * leaves.half[leaf, 2]
    bend = leaves.bend[leaf, 0] if c > 0.0 else leaves.bend[leaf, 1]
    if abs(c) <= leaves.half[leaf, 2]:
        bend = max(leaves.bend[leaf, 0], leaves.bend[leaf, 1])
    starts = 1 if reach * bend < 0.7 else 10
    for start in range(starts):
        if start == 0:
            a = s if s >= 0.0 else 0.5 * (s0 + s1)
            b = t if s >= 0.0 else 0.5 * (t0 + t1)
        else:
            a = s0 + (s1 - s0) * (((start - 1) % 3) + 0.5) / 3.0
            b = t0 + (t1 - t0) * (((start - 1) // 3) + 0.5) / 3.0
        a, b, q, f, free = patch_foot(patches, patch, p, a, b, work)
        h = sqrt(f)
        if not free or h >= min(best, distance):
            continue
        face = patches.face[patch]
        if not (leaves.whole[leaf] and s0 <= a <= s1 and t0 <= b <= t1):
            u = from_ramp(a, patches.uv_range[patch, 0], patches.uv_range[patch, 1], patches.ramp[patch, 0])
            v = from_ramp(b, patches.uv_range[patch, 2], patches.uv_range[patch, 3], patches.ramp[patch, 1])
            if not inside(skin.trims, face, u, v, work):
                continue
        distance, found_s, found_t, foot = h, a, b, q
    return distance, found_s, found_t, foot


@njit
def try_line(edges, piece, p):
    """Foot on a straight edge, its ends left to the vertices: distance, tau, foot."""
    f = edges.frame[piece]
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
def try_circle(edges, piece, p):
    """Foot on a circular edge: distance, angle, foot."""
    f = edges.frame[piece]
    x, y = (f[1, 0], f[1, 1], f[1, 2]), (f[2, 0], f[2, 1], f[2, 2])
    q = minus(p, (f[0, 0], f[0, 1], f[0, 2]))
    t0, t1 = edges.span[piece, 0], edges.span[piece, 1]
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
def try_arc(edges, piece, p, s, work):
    """Foot on one piece of a curved edge: distance, parameter of the piece, foot."""
    first, degree = edges.ctrl_first[piece], edges.degree[piece]
    distance, found, foot = np.inf, 0.0, p
    for start in range(3):
        a = 0.5 if start == 0 else (0.1 if start == 1 else 0.9)
        if start == 0 and s >= 0.0:
            a = s
        a, q, d1, _, f = arc_foot(edges.ctrl, first, degree, p, a, work)
        h = sqrt(f)
        # Beyond the end of the edge the vertex answers; between pieces the end is a point as good.
        past = abs(dot(minus(q, p), d1)) > END * dot(d1, d1)
        if past and ((a <= 0.0 and edges.open_end[piece, 0]) or (a >= 1.0 and edges.open_end[piece, 1])):
            continue
        if h < distance:
            distance, found, foot = h, a, q
    return distance, found, foot


@njit
def try_item(skin, item, p, best, a, b, work):
    """Foot on any item: distance, the same plus its slack, two parameters, foot."""
    kind, ref = skin.kind[item], skin.ref[item]
    if kind == FACE:
        h, a, b, foot = try_face(skin, ref, p, best, work)
        return h, h, a, b, foot
    if kind == LEAF:
        h, a, b, foot = try_leaf(skin, ref, p, best, a, b, work)
        return h, h, a, b, foot
    if kind == LINE:
        h, a, foot = try_line(skin.edges, ref, p)
        return h, h + skin.edges.slack[skin.edges.edge[ref]], a, 0.0, foot
    if kind == CIRCLE:
        h, a, foot = try_circle(skin.edges, ref, p)
        return h, h + skin.edges.slack[skin.edges.edge[ref]], a, 0.0, foot
    if kind == ARC:
        h, a, foot = try_arc(skin.edges, ref, p, a, work)
        return h, h + skin.edges.slack[skin.edges.edge[ref]], a, 0.0, foot
    q = skin.vertices.point[ref]
    foot = (q[0], q[1], q[2])
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    return h, h + skin.vertices.slack[ref], 0.0, 0.0, foot


# --- the nearest of all --------------------------------------------------------------------------


@njit
def nearest(skin, p, seed, stack, bounds, work):
    """The item with the closest point: item, two parameters, foot.

    seed : item and parameters found last time, item < 0 for none; it only tightens the search
    """
    tree = skin.tree
    best, item, a, b, foot = np.inf, -1, 0.0, 0.0, p
    seed_item = int(seed[0])
    if 0 <= seed_item < len(skin.kind):
        h, best, a, b, foot = try_item(skin, seed_item, p, best, seed[1], seed[2], work)
        if best < np.inf:
            item = seed_item
    stack[0], bounds[0], top = 0, box_distance(tree.low, tree.high, 0, p[0], p[1], p[2]), 1
    while top > 0:
        top -= 1
        node = stack[top]
        if bounds[top] >= best:
            continue
        child = tree.child[node]
        if child < 0:
            for k in range(tree.start[node], tree.stop[node]):
                other = tree.order[k]
                if box_distance(skin.low, skin.high, other, p[0], p[1], p[2]) >= best:
                    continue
                h, value, a1, b1, foot1 = try_item(skin, other, p, best, -1.0, -1.0, work)
                if value < best:
                    best, item, a, b, foot = value, other, a1, b1, foot1
            continue
        left = box_distance(tree.low, tree.high, child, p[0], p[1], p[2])
        right = box_distance(tree.low, tree.high, child + 1, p[0], p[1], p[2])
        # The nearer child goes on top of the stack.
        if left <= right:
            stack[top], bounds[top] = child + 1, right
            stack[top + 1], bounds[top + 1] = child, left
        else:
            stack[top], bounds[top] = child, left
            stack[top + 1], bounds[top + 1] = child + 1, right
        top += 2
    return item, a, b, foot


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
def patch_at(skin, face, u, v):
    """Patch of a face that holds (u, v), and the parameters there."""
    faces, patches = skin.faces, skin.patches
    first, nu, nv, at_u, at_v = faces.grid[face]
    u_first, u_last = faces.breaks[at_u], faces.breaks[at_u + nu]
    v_first, v_last = faces.breaks[at_v], faces.breaks[at_v + nv]
    # Parameters that wrap round are brought into the surface's own turn.
    if skin.trims.period[face, 0] > 0.0 and not (u_first <= u <= u_last):
        u -= floor((u - u_first) / skin.trims.period[face, 0]) * skin.trims.period[face, 0]
    if skin.trims.period[face, 1] > 0.0 and not (v_first <= v <= v_last):
        v -= floor((v - v_first) / skin.trims.period[face, 1]) * skin.trims.period[face, 1]
    patch = first + locate(faces.breaks, at_u, nu, u) * nv + locate(faces.breaks, at_v, nv, v)
    r = patches.uv_range[patch]
    s = to_ramp(min(r[1], max(r[0], u)), r[0], r[1], patches.ramp[patch, 0])
    t = to_ramp(min(r[3], max(r[2], v)), r[2], r[3], patches.ramp[patch, 1])
    return patch, min(1.0, max(0.0, s)), min(1.0, max(0.0, t))


@njit
def shape_at(skin, face, u, v, work):
    """Normal, curvatures and direction of a face at (u, v)."""
    faces = skin.faces
    if faces.form[face] == PATCHES:
        patch, s, t = patch_at(skin, face, u, v)
        return shape_on_patch(skin.patches, patch, s, t, faces.sense[face], work)
    x, y, z, k1, k2, ex, ey, ez = shape_on_form(
        faces.form[face], faces.frame[face], faces.size[face], faces.sense[face], u, v
    )
    return (x, y, z), k1, k2, (ex, ey, ez)


@njit
def side_normal(skin, side, tau, work):
    """Normal of a face beside an edge at tau, and (u, v) there."""
    edges = skin.edges
    first, last = edges.side_uv_first[side], edges.side_uv_first[side + 1] - 1
    x = tau * (last - first)
    k = min(last - first - 1, int(x))
    x -= k
    u = (1.0 - x) * edges.side_uv[first + k, 0] + x * edges.side_uv[first + k + 1, 0]
    v = (1.0 - x) * edges.side_uv[first + k, 1] + x * edges.side_uv[first + k + 1, 1]
    n, _, _, _ = shape_at(skin, edges.side_face[side], u, v, work)
    return n, u, v


@njit
def edge_at(skin, item, a, work):
    """Edge, tau, tangent and curvature vector of an edge piece at its parameter."""
    kind, piece = skin.kind[item], skin.ref[item]
    edges = skin.edges
    edge, f = edges.edge[piece], edges.frame[piece]
    if kind == LINE:
        d = (f[1, 0], f[1, 1], f[1, 2])
        h = sqrt(dot(d, d))
        return edge, a, (d[0] / h, d[1] / h, d[2] / h), (0.0, 0.0, 0.0)
    if kind == CIRCLE:
        t0, t1 = edges.span[piece, 0], edges.span[piece, 1]
        c, s = cos(a), sin(a)
        x, y = (f[1, 0], f[1, 1], f[1, 2]), (f[2, 0], f[2, 1], f[2, 2])
        r2 = dot(x, x)
        r = sqrt(r2)
        out = (c * x[0] + s * y[0], c * x[1] + s * y[1], c * x[2] + s * y[2])
        along = (c * y[0] - s * x[0], c * y[1] - s * x[1], c * y[2] - s * x[2])
        tangent = (along[0] / r, along[1] / r, along[2] / r)
        return edge, (a - t0) / (t1 - t0), tangent, (-out[0] / r2, -out[1] / r2, -out[2] / r2)
    _, d1, d2 = arc_derivatives(edges.ctrl, edges.ctrl_first[piece], edges.degree[piece], a, work)
    speed2 = max(dot(d1, d1), 1e-300)
    h = sqrt(speed2)
    tangent = (d1[0] / h, d1[1] / h, d1[2] / h)
    along = dot(d2, tangent)
    bend = (
        (d2[0] - along * tangent[0]) / speed2,
        (d2[1] - along * tangent[1]) / speed2,
        (d2[2] - along * tangent[2]) / speed2,
    )
    s0, s1, t0, t1, ramp, first, last = edges.span[piece, :7]
    t = from_ramp(s0 + a * (s1 - s0), t0, t1, int(ramp))
    return edge, min(1.0, max(0.0, (t - first) / (last - first))), tangent, bend


@njit
def continued(skin, face, u, v, p, foot, reach, work):
    """Foot on a face taken beyond its trim, near a point of a smooth edge or vertex.

    returns : whether it lies within reach of that point, foot, u or s, v or t, patch
    """
    faces = skin.faces
    if faces.form[face] == PATCHES:
        patch, s, t = patch_at(skin, face, u, v)
        s, t, q, _, _ = patch_foot(skin.patches, patch, p, s, t, work)
        m = minus(q, foot)
        return dot(m, m) <= reach * reach, q, s, t, patch
    for branch in range(2):
        exists, a, b, x, y, z = foot_on_form(
            faces.form[face], faces.frame[face], faces.size[face], p[0], p[1], p[2], branch
        )
        m = minus((x, y, z), foot)
        if exists and dot(m, m) <= reach * reach:
            return True, (x, y, z), a, b, -1
    return False, foot, u, v, -1


@njit
def answer_from_face(skin, face, patch, a, b, p, foot, work):
    """Signed distance, normal, curvatures and direction at a foot inside a face."""
    if patch >= 0:
        n, k1, k2, e = shape_on_patch(skin.patches, patch, a, b, skin.faces.sense[face], work)
    else:
        n, k1, k2, e = shape_at(skin, face, a, b, work)
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    d = h if dot(m, n) >= 0.0 else -h
    return d, foot, n, k1, k2, e, skin.faces.label[face]


@njit
def any_across(n):
    """A unit vector across n."""
    e = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    h = sqrt(dot(e, e))
    return e[0] / h, e[1] / h, e[2] / h


@njit
def answer_from_edge(skin, item, a, p, foot, work):
    edge, tau, tangent, bend = edge_at(skin, item, a, work)
    edges = skin.edges
    first, last = edges.side_first[edge], edges.side_first[edge + 1]
    mean, n, u, v = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0
    smooth = last - first > 1
    for side in range(first, last):
        other, u1, v1 = side_normal(skin, side, tau, work)
        if side == first:
            n, u, v = other, u1, v1
        turn = cross(n, other)
        if dot(turn, turn) > SMOOTH * SMOOTH or dot(n, other) < 0.0:
            smooth = False
        mean = (mean[0] + other[0], mean[1] + other[1], mean[2] + other[2])
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    if smooth:
        # The faces continue each other: the foot belongs to one of them, taken past its trim.
        reach = 5e-3 * h + 10.0 * edges.slack[edge] + 1e-6
        for side in range(first, last):
            face = edges.side_face[side]
            _, u, v = side_normal(skin, side, tau, work)
            ok, q, a1, b1, patch = continued(skin, face, u, v, p, foot, reach, work)
            if ok:
                return answer_from_face(skin, face, patch, a1, b1, p, q, work)
    face = skin.faces.label[edges.side_face[first]]
    size = sqrt(dot(mean, mean))
    if size > 0.0:
        mean = (mean[0] / size, mean[1] / size, mean[2] / size)
    else:
        mean = n
    sign = 1.0 if dot(m, mean) >= 0.0 else -1.0
    if h > TOUCH:
        n = (sign * m[0] / h, sign * m[1] / h, sign * m[2] / h)
    else:
        n = mean
    along = -dot(bend, n)
    across = cross(tangent, n)
    size = sqrt(dot(across, across))
    if size > 0.0:
        across = (across[0] / size, across[1] / size, across[2] / size)
    else:
        across = any_across(n)
    if sign > 0.0:
        return sign * h, foot, n, SHARP, along, across, face
    return sign * h, foot, n, along, -SHARP, cross(across, n), face


@njit
def answer_from_vertex(skin, item, p, foot, work):
    vertices = skin.vertices
    k = skin.ref[item]
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    face = vertices.face[k]
    if vertices.smooth[k]:
        reach = 5e-3 * h + 10.0 * vertices.slack[k] + 1e-6
        ok, q, a, b, patch = continued(
            skin, face, vertices.uv[k, 0], vertices.uv[k, 1], p, foot, reach, work
        )
        if ok:
            return answer_from_face(skin, face, patch, a, b, p, q, work)
    n = (vertices.normal[k, 0], vertices.normal[k, 1], vertices.normal[k, 2])
    sign = 1.0 if dot(m, n) >= 0.0 else -1.0
    if h > TOUCH:
        n = (sign * m[0] / h, sign * m[1] / h, sign * m[2] / h)
    return sign * h, foot, n, sign * SHARP, sign * SHARP, any_across(n), skin.faces.label[face]


@njit
def answer(skin, item, a, b, p, foot, work):
    """Signed distance, foot, normal, k1, k2, direction of k1, face of the nearest item."""
    kind, ref = skin.kind[item], skin.ref[item]
    if kind == FACE:
        return answer_from_face(skin, ref, -1, a, b, p, foot, work)
    if kind == LEAF:
        patch = skin.leaves.patch[ref]
        return answer_from_face(skin, skin.patches.face[patch], patch, a, b, p, foot, work)
    if kind == LINE or kind == CIRCLE or kind == ARC:
        return answer_from_edge(skin, item, a, p, foot, work)
    return answer_from_vertex(skin, item, p, foot, work)


@njit(parallel=True, cache=True)
def project_points(
    tree, low, high, kind, ref, faces, trims, patches, leaves, edges, vertices,
    points, seed, distance, point, normal, curvature, direction, face, new_seed,
):  # fmt: skip
    """Fill the fields of a Projection. The skin comes in parts: a parallel loop takes no nested tuple."""
    n = len(points)
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        stack, bounds = np.zeros(2 * DEPTH, np.int64), np.zeros(2 * DEPTH)
        work = np.zeros(WORK)
        skin = Skin(tree, low, high, kind, ref, faces, trims, patches, leaves, edges, vertices)
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            p = (points[i, 0], points[i, 1], points[i, 2])
            item, a, b, foot = nearest(skin, p, seed[i], stack, bounds, work)
            d, q, nrm, k1, k2, e, f = answer(skin, item, a, b, p, foot, work)
            distance[i], face[i] = d, f
            for c in range(3):
                point[i, c], normal[i, c], direction[i, c] = q[c], nrm[c], e[c]
            curvature[i, 0], curvature[i, 1] = k1, k2
            new_seed[i, 0], new_seed[i, 1], new_seed[i, 2] = item, a, b
