"""The answer at a known nearest item: once after a search, and alone while the point stays in reach.

out   distance, foot (3), normal (3), direction of k1 (3), k1, k2
D     S, S_s, S_t, S_ss, S_st, S_tt at a foot on a patch (power.py)
"""

from math import sqrt

from numba import njit

from cadlink.answer import TOUCH, answer, answer_from_edge, edge_at
from cadlink.form_foot import distance_to_form, shape_of_form
from cadlink.items import try_item
from cadlink.kernels import INNER, POINT
from cadlink.nurbs import dot, shape_of
from cadlink.power import FOUND, foot_in_box
from cadlink.quick import OVER, place_on_face, place_on_leaf, surely_in
from cadlink.rim import IN
from cadlink.skin import ON_ARC, ON_LEAF, SMOOTH, STATIONS

ANSWER = 12
SURE = 0.2  # cosine between the way to an edge and its mean normal from which on the side is clear


@njit(forceinline=True, **POINT)
def write(out, d, foot, n, k1, k2, e):
    out[0], out[10], out[11] = d, k1, k2
    for c in range(3):
        out[1 + c], out[4 + c], out[7 + c] = foot[c], n[c], e[c]


@njit(**POINT)
def answer_on_patch(p, found, sense, out):
    """Fill out from the derivatives at a foot; False where the surface is singular."""
    d_s, d_t = (found[1, 0], found[1, 1], found[1, 2]), (found[2, 0], found[2, 1], found[2, 2])
    d_ss, d_st = (found[3, 0], found[3, 1], found[3, 2]), (found[4, 0], found[4, 1], found[4, 2])
    d_tt = (found[5, 0], found[5, 1], found[5, 2])
    a, b, c = dot(d_s, d_s), dot(d_t, d_t), dot(d_s, d_t)
    if not (a * b - c * c > 1e-12 * (a + b) * (a + b)):
        return False
    n, k1, k2, e = shape_of(d_s, d_t, d_ss, d_st, d_tt, sense)
    x, y, z = p[0] - found[0, 0], p[1] - found[0, 1], p[2] - found[0, 2]
    write(out, x * n[0] + y * n[1] + z * n[2], (found[0, 0], found[0, 1], found[0, 2]), n, k1, k2, e)
    return True


@njit(**INNER)
def answer_off_face(skin, item, a, b, p, foot, work, out):
    """Fill out at a foot on an edge or vertex, or wherever else care is needed; returns the face."""
    kind, ref = skin.items[item].kind, skin.items[item].ref
    if ON_LEAF < kind <= ON_ARC:
        curve = skin.curves[ref]
        edge = skin.edges[curve.edge]
        if edge.turn[0] > 1.5 * SMOOTH:
            # Sharp all along: the table of mean normals tells the side, if it is clear.
            tau, tangent, bend = edge_at(kind, curve, skin.ctrl, a, work)
            mean = edge.normal[min(STATIONS - 1, max(0, int(tau * STATIONS)))]
            x, y, z = p[0] - foot[0], p[1] - foot[1], p[2] - foot[2]
            h = sqrt(x * x + y * y + z * z)
            if h > TOUCH and abs(x * mean[0] + y * mean[1] + z * mean[2]) > SURE * h:
                d, q, n, k1, k2, e = answer_from_edge(p, foot, (mean[0], mean[1], mean[2]), tangent, bend)
                write(out, d, q, n, k1, k2, e)
                return skin.faces[skin.sides[edge.side_first].face].label
    d, q, n, k1, k2, e, label = answer(skin, item, a, b, p, foot, work)
    write(out, d, q, n, k1, k2, e)
    return label


@njit(forceinline=True, **POINT)
def track_face(face, rim, rasters, pieces, ctrl, p, sure, work):
    """The answer at the foot on a closed form, and the face: -1 where it is not surely inside.

    sure : the foot is known to be inside (room_inside)
    """
    single, d, x, y, z, rho, m, v = distance_to_form(face, rim, p)
    label = face.label if single and sure else -1
    if single and not sure:
        where, _ = place_on_face(face, rim, rasters, pieces, ctrl, x, y, z, rho, m, v, abs(d), work)
        if where == IN:
            label = face.label
    foot, n, k1, k2, e = shape_of_form(face, rim, x, y, z, rho, m, v)
    return face.sense * d, foot, n, k1, k2, e, label


@njit(forceinline=True, **POINT)
def still_on(leaf, s, t):
    """Whether a foot lies on a leaf or hardly beside it, where what is known of the leaf holds."""
    rect = leaf.rect
    w_s, w_t = OVER * (rect[1] - rect[0]), OVER * (rect[3] - rect[2])
    return rect[0] - w_s <= s <= rect[1] + w_s and rect[2] - w_t <= t <= rect[3] + w_t


@njit(forceinline=True, **POINT)
def track_leaf(leaf, patch, face, rim, rasters, pieces, ctrl, power, p, s, t, tiny, found, work, out):
    """The same on a leaf, from its last foot, filled into out: s, t, face, last step of Newton [mm].

    tiny : of Leaf.tiny, first steps that the Taylor series ends (power.py)
    """
    code, s1, t1, h, step = foot_in_box(
        patch, power, p, s, t, 0.0, 1.0, 0.0, 1.0, leaf.tiny[0], leaf.tiny[1], tiny, found
    )
    label = -1
    if code == FOUND and still_on(leaf, s1, t1):
        where = IN
        if not surely_in(leaf, s1, t1):
            where, _ = place_on_leaf(leaf, patch, face, rim, rasters, pieces, ctrl, s1, t1, found, h, work)
        if where == IN and answer_on_patch(p, found, leaf.sense, out):
            label = face.label
    return s1, t1, label, step


@njit(**INNER)
def track_edge(skin, item, a, b, p, work, out):
    """The same on an edge or vertex."""
    h, a, b, foot = try_item(skin, item, p, 1e300, a, b, work)
    if h < 1e300:
        return a, b, answer_off_face(skin, item, a, b, p, foot, work, out)
    return a, b, -1


@njit(forceinline=True, **POINT)
def form_of(face, rim, p):
    """Whether the foot on a closed form is single, and the answer there, inside its trim or not."""
    single, d, x, y, z, rho, m, v = distance_to_form(face, rim, p)
    foot, n, k1, k2, e = shape_of_form(face, rim, x, y, z, rho, m, v)
    return single, face.sense * d, foot, n, k1, k2, e


@njit(**INNER)
def settle(skin, item, a, b, p, found, work, out):
    """Fill out at the item a search has found, closed forms excepted; returns the face."""
    foot = p
    if skin.items[item].kind == ON_LEAF:
        foot = (found[0, 0], found[0, 1], found[0, 2])
    else:
        _, a, b, foot = try_item(skin, item, p, 1e300, a, b, work)
    return answer_off_face(skin, item, a, b, p, foot, work, out)
