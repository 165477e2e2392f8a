"""What the closest point tells: signed distance, normal, curvatures and their direction.

    p       the point;  m = p - foot
    n       unit normal out of the material;  d = signed distance, grad d = n
    k, e    curvatures and principal direction: hess d = sum k_i / (1 + k_i d) e_i e_i^T

On an edge with tangent T and curvature vector c, d = |p - C(t)| gives grad d = n = m / d and

    hess d = 1/d (across)^2 + k/(1 + k d) T T^T,   k = -c . n

so an edge is a surface whose curvature across is without bound; at a vertex both are. SHARP
stands for that bound. Where m enters the material (a re-entrant edge) both d and SHARP are
negative. The side is told by the mean normal of the faces at an edge, and by the angle-weighted
one at a vertex (Baerentzen & Aanaes 2005).

Where all faces at an edge or vertex share a tangent plane they continue each other: the foot then
belongs to one of them, taken a little past its trim, and the curvature is that face's.
"""

from math import cos, floor, sin, sqrt

from numba import njit

from cadlink.kernels import INNER, POINT
from cadlink.nurbs import arc_derivatives, cross, dot, from_ramp, minus, shape_on_patch, to_ramp
from cadlink.patch_foot import patch_foot
from cadlink.primitives import foot_on_form, shape_on_form
from cadlink.records import PATCHES
from cadlink.skin import ON_ARC, ON_CIRCLE, ON_FACE, ON_LEAF, ON_LINE, SMOOTH

SHARP = 1e12  # 1/mm, stands for the curvature across a sharp edge
TOUCH = 1e-9  # mm: nearer to an edge than this, m has no direction and the mean normal is used


@njit(**POINT)
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


@njit(**POINT)
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


@njit(**POINT)
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


@njit(**INNER)
def shape_on_face(skin, number, patch, a, b, work):
    """Outward normal, curvatures and direction at a foot: (u, v), or (s, t) of a patch."""
    face = skin.faces[number]
    if face.form == PATCHES:
        return shape_on_patch(skin.patches[patch], skin.ctrl, a, b, face.sense, work)
    return shape_on_form(face, a, b)


@njit(**POINT)
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


@njit(**INNER)
def continued(skin, number, u, v, p, foot, slack, work):
    """Foot on a face taken beyond its trim, near a point of a smooth edge or vertex.

    returns : whether there is one, patch, two parameters, foot
    """
    face = skin.faces[number]
    m = minus(p, foot)
    reach = 5e-3 * sqrt(dot(m, m)) + 10.0 * slack + 1e-6
    if face.form == PATCHES:
        patch, s, t = patch_at(face, skin.patches, skin.breaks, u, v)
        s, t, q, _, _, pull = patch_foot(skin.patches[patch], skin.ctrl, skin.power, p, s, t, work)
        m = minus(q, foot)
        return dot(m, m) <= reach * reach and pull <= reach, patch, s, t, q
    for branch in range(2):
        exists, a, b, q = foot_on_form(face, p, branch)
        m = minus(q, foot)
        if exists and dot(m, m) <= reach * reach:
            return True, -1, a, b, q
    return False, -1, u, v, foot


@njit(**INNER)
def faces_at_edge(skin, edge, tau, work):
    """Mean outward normal of the faces at an edge, and the sine between them (2 for one face or opposite ones)."""
    mean, n = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    turn = 0.0 if edge.side_last - edge.side_first > 1 else 2.0
    for k in range(edge.side_first, edge.side_last):
        side = skin.sides[k]
        a, b = uv_on_side(side, skin.side_uv, tau)
        face, patch = skin.faces[side.face], -1
        if face.form == PATCHES:
            patch, a, b = patch_at(face, skin.patches, skin.breaks, a, b)
        other, _, _, _ = shape_on_face(skin, side.face, patch, a, b, work)
        if k == edge.side_first:
            n = other
        sine = cross(n, other)
        turn = max(turn, sqrt(dot(sine, sine)) if dot(n, other) >= 0.0 else 2.0)
        mean = (mean[0] + other[0], mean[1] + other[1], mean[2] + other[2])
    size = sqrt(dot(mean, mean))
    if size == 0.0:
        return n, turn
    return (mean[0] / size, mean[1] / size, mean[2] / size), turn


@njit(**POINT)
def any_across(n):
    """A unit vector across n."""
    e = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    h = sqrt(dot(e, e))
    return e[0] / h, e[1] / h, e[2] / h


@njit(**INNER)
def answer_from_face(skin, number, patch, a, b, p, foot, work):
    """Signed distance, foot, normal, k1, k2, direction of k1 at a foot on a smooth face."""
    n, k1, k2, e = shape_on_face(skin, number, patch, a, b, work)
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    return (h if dot(m, n) >= 0.0 else -h), foot, n, k1, k2, e


@njit(**POINT)
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


@njit(**POINT)
def answer_from_vertex(p, foot, mean):
    """The same at a vertex with pseudo-normal."""
    m = minus(p, foot)
    h = sqrt(dot(m, m))
    sign = 1.0 if dot(m, mean) >= 0.0 else -1.0
    n = (sign * m[0] / h, sign * m[1] / h, sign * m[2] / h) if h > TOUCH else mean
    return sign * h, foot, n, sign * SHARP, sign * SHARP, any_across(n)


@njit(**INNER)
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
            mean, turn = faces_at_edge(skin, edge, tau, work)
            smooth = turn <= SMOOTH
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
