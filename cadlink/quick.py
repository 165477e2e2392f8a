"""The quick way to the nearest foot, and how far the point may move before another can be nearest.

    best    distance of the nearest foot so far [mm]
    bound   lower bound of the distance to an item [mm]
    room    how far [mm] the point may move before an item can hold its nearest foot
    reach   smallest room of all other items: within it the next call looks at one item

Only faces, leaves of patches, sharp edges and sharp vertices are asked (smooth.py says why). An
item is out of the question
    - where its bound exceeds best: distance is 1-Lipschitz, so for (bound - best)/2 of motion;
    - where the foot on the untrimmed surface lies outside its trim: for the room to the trim (rim.py);
    - a leaf whose normals make at most an angle c with its axis, where the point is farther beside
      the leaf than best sin c: no normal of the leaf then reaches the point;
    - a leaf that continues the one with the best foot, where distance times curvature is so small
      that the distance along the surface has one minimum only.
A leaf that may bend round the point, or on which Newton fails, is asked again with several starts (items.py)
once the best foot is known. Whatever else is in doubt (a foot in the band along a rim, near an axis) is left
to the careful search of closest.py.
"""

from math import floor, sqrt

import numpy as np
from numba import njit

from cadlink.boxtree import box_distance
from cadlink.form_foot import distance_to_form
from cadlink.items import start_in_leaf, try_item, try_leaf
from cadlink.kernels import POINT
from cadlink.leaf_bounds import UNIQUE, bend_by_height, bend_by_point, leaf_beside, room_of_bend
from cadlink.nurbs import from_ramp
from cadlink.power import CONVERGED, DOUBTFUL, FOUND, foot_in_box
from cadlink.records import CYLINDER, PLANE, SPHERE, TORUS
from cadlink.rim import (
    IN,
    ODD,
    OUT,
    RASTER,
    UNSURE,
    at_boundary,
    box_room,
    cell_of,
    patch_room,
    room_of_cells,
    room_to_boundary,
    uv_of_form,
)
from cadlink.skin import ON_FACE, ON_LEAF

SKIN = 0.1  # mm: reach that the search looks for; a larger one, for which it would look at more items, comes by itself
TURNED = 0.93  # cosine between leaves that continue each other
BESIDE = 0.7  # the same of leaves that touch
OVER = 0.05  # of a leaf's sides, by which a foot may lie over them
WAITING = 256  # nodes and items that may wait; points in the middle of everything are left to the careful search
HIT, MISS, DOUBT, SEVERAL = 1, 0, -1, 2
APART, NEXT, ACROSS = 0, 1, 2
CAREFUL, AGAIN = -1.0, -2.0
PENDING = 8  # items that the nearest foot, once known, may excuse


# --- one item ------------------------------------------------------------------------------------


@njit(**POINT)
def band_scale(face, rim, h, v):
    """How much wider than at the foot the band may be at a distance h."""
    form, size = face.form, face.size
    if form == PLANE:
        return 1.0
    if form == CYLINDER or form == SPHERE:
        least = size[0]
    elif form == TORUS:
        # The narrowest parallel: of the ring, or where a trim on the outer sheet of a wider tube ends (rim.py).
        narrowest = size[0] - size[1]
        if narrowest <= 0.0:
            narrowest = size[0] + size[1] * min(rim.turn[4], rim.turn[6])
        least = min(size[1], narrowest)
    else:
        least = size[0] + v * rim.slope[1]
    return 1.0 + h / least


@njit(forceinline=True, **POINT)
def place_on_face(face, rim, rasters, pieces, ctrl, x, y, z, rho, m, v, h, work):
    """IN, UNSURE or OUT of a foot on a closed form, and the room where it is out."""
    room = box_room(face, rim, x, y, z, rho, v)
    where = IN
    if room < 0.0:
        band = (rim.gap + rim.angle * h) * band_scale(face, rim, h, v)
        where = OUT if -room > band else UNSURE
        room = -room
    elif rim.kind == RASTER:
        s, t, per_s, per_t = uv_of_form(face, rim, x, y, z, rho, m, v)
        cells = cell_of(face, rim, rasters, s, t)
        if cells == 0:
            band = rim.gap + rim.angle * h
            where, room = at_boundary(face, pieces, ctrl, s, t, band / per_s, band / per_t, work), 0.0
        elif cells < 0:
            where, room = OUT, room_of_cells(face, cells, rasters.shape[1], rho, m)
    return where, room


@njit(**POINT)
def room_inside(face, rim, rasters, pieces, p):
    """How far [mm] a point whose foot is inside its face may move before the foot can leave it; 0 where that is
    not told: by curved faces with a raster, which may go on beyond its end."""
    single, _, x, y, z, rho, m, v = distance_to_form(face, rim, p)
    room = box_room(face, rim, x, y, z, rho, v)
    if rim.kind == RASTER:
        cells = cell_of(face, rim, rasters, x, y) if face.form == PLANE else -1
        if cells > 1:
            room = min(room, room_of_cells(face, cells, rasters.shape[1], rho, m))
        else:
            room = room_to_boundary(face, pieces, x, y) if cells >= 0 else 0.0
    return max(room, 0.0) if single and rim.kind != ODD else 0.0


@njit(forceinline=True, **POINT)
def quick_face(face, rim, rasters, pieces, ctrl, p, best, work):
    """HIT, MISS or DOUBT; distance to the untrimmed surface, room."""
    single, d, x, y, z, rho, m, v = distance_to_form(face, rim, p)
    h, code, room = abs(d), MISS, 0.0
    if not single or rim.kind == ODD:
        code, h = DOUBT, 0.0
    elif h < best + 2.0 * SKIN:
        where, room = place_on_face(face, rim, rasters, pieces, ctrl, x, y, z, rho, m, v, h, work)
        if where == IN:
            code = HIT
        elif where == UNSURE and h < best + 1e-9:
            code, room = DOUBT, 0.0
    return code, h, room


@njit(forceinline=True, **POINT)
def room_beyond(face, h, best):
    """Room of a point at h from a closed form, no point of whose trimmed part is nearer than best.

    On a plane the foot is sqrt(best^2 - h^2) = D away from that part. On a cylinder or sphere with the point at m from
    the axis or centre, a part at the angle a and z along the axis has 4 m R sin^2(a/2) + z^2 >= D^2, and becomes the
    foot of points that are sqrt(m^2 sin^2 a + z^2) away: at least D sqrt(3 m / 4 R) up to a = 60 degrees.
    """
    if not h < best:
        return 0.0
    beyond = sqrt(best * best - h * h)
    if face.form == PLANE:
        return beyond
    if face.form == CYLINDER or face.form == SPHERE:
        m = max(0.0, face.size[0] - h)
        return min(beyond * sqrt(0.75 * m / face.size[0]), 0.86 * m)
    return 0.0


@njit(**POINT)
def place_on_leaf(leaf, patch, face, rim, rasters, pieces, ctrl, s, t, derivatives, h, work):
    """IN, UNSURE or OUT of a foot on a patch, and the room where it is out."""
    uv = patch.uv
    u = from_ramp(s, uv[0], uv[1], patch.ramp[0])
    v = from_ramp(t, uv[2], uv[3], patch.ramp[1])
    d_s, d_t = derivatives[1], derivatives[2]
    # Half of the mean speed: conic arcs are not run through evenly.
    per_u = 0.5 * sqrt(d_s[0] * d_s[0] + d_s[1] * d_s[1] + d_s[2] * d_s[2]) / (uv[1] - uv[0])
    per_v = 0.5 * sqrt(d_t[0] * d_t[0] + d_t[1] * d_t[1] + d_t[2] * d_t[2]) / (uv[3] - uv[2])
    band = rim.gap + rim.angle * h
    return patch_room(face, rim, rasters, pieces, ctrl, u, v, per_u, per_v, band, work)


@njit(forceinline=True, **POINT)
def surely_in(leaf, s, t):
    """Whether a foot lies where no boundary passes."""
    inner = leaf.inner
    return inner[0] <= s <= inner[1] and inner[2] <= t <= inner[3]


@njit(forceinline=True, **POINT)
def overlap(a0, a1, b0, b1, period):
    """Whether two ranges of a parameter meet."""
    apart = 0.5 * (a0 + a1 - b0 - b1)
    if period > 0.0:
        apart -= period * floor(apart / period + 0.5)
    return abs(apart) <= 0.500001 * (a1 - a0 + b1 - b0)


@njit(**POINT)
def continues(leaf, other, height, other_height, best, foot, leap):
    """Whether a leaf continues the other with the best foot, near enough that it has no other foot: NEXT where they
    touch, ACROSS where others may lie between (which only holds if none of those has several feet), APART if not.

    height, other_height : of the point above both; leap : whether ACROSS may be the answer
    """
    if leaf.group != other.group:
        return APART
    a, b = leaf.frame, other.frame
    cosine = leaf.sense * other.sense * (a[3, 0] * b[3, 0] + a[3, 1] * b[3, 1] + a[3, 2] * b[3, 2])
    if cosine < BESIDE or (best + 2.0 * SKIN) * bend_by_height(leaf, height) >= UNIQUE:
        return APART
    if leaf.face == other.face and (best + 2.0 * SKIN) * bend_by_height(other, other_height) < UNIQUE:
        # Leaves that share a side or a corner.
        c, d = leaf.uv, other.uv
        if overlap(c[0], c[1], d[0], d[1], leaf.period[0]) and overlap(c[2], c[3], d[2], d[3], leaf.period[1]):
            return NEXT
    if not leap or cosine < TURNED:
        return APART
    apart, _, _, _, _ = leaf_beside(leaf, foot)
    return ACROSS if apart <= 0.7 * best + 1e-6 else APART


@njit(**POINT)
def room_of_both(leaf, other, height, other_height, best):
    """Room within which a leaf goes on to continue the other; heights of the point above both."""
    return max(SKIN, 0.5 * min(room_of_bend(leaf, height, best), room_of_bend(other, other_height, best)))


@njit(**POINT)
def quick_leaf(leaf, patch, other, known, other_height, leap, power, p, best, foot, s, t, found):
    """HIT where the foot may be on a leaf, or MISS; bound or distance, room, s, t, excusable, several, excuse.

    other : the leaf with the best foot where that is known, other_height of the point above it; leap : as above
    excuse : how it continues that leaf
    excusable : whether a MISS may be excused by a leaf with a nearer foot
    several : whether the leaf may hold nearer feet than this one, which several starts would find (items.py)
    """
    bound, beside, x, y, z = leaf_beside(leaf, p)
    room = (beside - best * leaf.cone) / (1.0 + leaf.cone)
    if room >= SKIN:
        return MISS, bound, room, s, t, False, False, APART
    excuse = continues(leaf, other, z, other_height, best, foot, leap) if known else APART
    if excuse != APART:
        return MISS, bound, room_of_both(leaf, other, z, other_height, best), s, t, False, False, excuse
    if room > 0.0:
        return MISS, bound, room, s, t, False, False, APART
    if bound >= best:
        return MISS, bound, 0.0, s, t, True, False, APART
    if not patch.steady:
        return MISS, bound, 0.0, s, t, True, True, APART
    if s < 0.0:
        s, t = start_in_leaf(leaf, -1, x, y)
    # A little over the sides, so that a foot between two leaves is in one of them.
    rect = leaf.rect
    w_s, w_t = OVER * (rect[1] - rect[0]), OVER * (rect[3] - rect[2])
    code, s, t, h, pull = foot_in_box(
        patch, power, p, s, t, max(0.0, rect[0] - w_s), min(1.0, rect[1] + w_s), max(0.0, rect[2] - w_t),
        min(1.0, rect[3] + w_t), leaf.tiny[0], leaf.tiny[1], CONVERGED, found,
    )  # fmt: skip
    if code == DOUBTFUL:
        return MISS, bound, 0.0, s, t, True, True, APART
    # A foot, or a nearest point on a side, is the only one as near if nothing on the way bends round the point.
    far = h if code == FOUND else min(h, bound + leaf.half[2])
    several = far * min(bend_by_height(leaf, z), bend_by_point(leaf, p, found[0])) >= UNIQUE
    if code == FOUND:
        return HIT, h, 0.0, s, t, True, several, APART
    return MISS, bound, min(SKIN, 0.2 * pull), s, t, True, several, APART


# --- the search ----------------------------------------------------------------------------------


@njit(forceinline=True, **POINT)
def push(entries, bounds, top, entry, bound):
    """Into a list whose last entry has the smallest bound."""
    k = top
    while k > 0 and bounds[k - 1] < bound:
        entries[k], bounds[k] = entries[k - 1], bounds[k - 1]
        k -= 1
    entries[k], bounds[k] = entry, bound
    return top + 1


@njit(forceinline=True, **POINT)
def quick_search(
    skin, items, nodes, order, root, faces, rims, leaves, patches, rasters, pieces, ctrl, power,
    p, hint, hint_a, hint_b, leap, entries, bounds, pending, found, work,
):  # fmt: skip
    """The nearest item and its reach: best first, down the tree of boxes.

    items .. power : arrays of the skin, already taken out of it
    hint : item to be tried first with its parameters, -1 for none
    leap : whether leaves may be excused across others (continues)
    entries, bounds : nodes, and items numbered after them, that wait in order of their bounds
    returns : item, two parameters, row of found with the derivatives of a patch, reach: AGAIN where a search
        without leaps must decide, CAREFUL where the careful one must
    """
    best, item, a, b, row, last = np.inf, -1, 0.0, 0.0, 0, -1
    others, room, foot, height = np.inf, np.inf, p, 0.0
    n_nodes, n_pending, top = len(nodes), 0, 0
    doubt = leapt = bends = False
    if root >= 0:
        top = push(entries, bounds, top, root, 0.0)
    if 0 <= hint < len(items) and not items[hint].smooth:
        top = push(entries, bounds, top, n_nodes + hint, 0.0)
    else:
        hint = -1
    while top > 0 and bounds[top - 1] < best + 2.0 * SKIN:
        top -= 1
        entry, bound = entries[top], bounds[top]
        if top + 2 > WAITING:
            doubt = True
            break
        if entry < n_nodes:
            node = nodes[entry]
            child = node.child
            if child >= 0:
                for k in range(child, child + 2):
                    bound = box_distance(nodes[k], p)
                    if bound < best + 2.0 * SKIN:
                        top = push(entries, bounds, top, k, bound)
                    else:
                        others = min(others, bound)
                continue
            for k in range(node.start, node.stop):
                other = order[k]
                if other == hint:
                    continue
                record = items[other]
                bound = box_distance(record, p)
                if record.kind == ON_LEAF and bound < best + 2.0 * SKIN:
                    bound, _, _, _, _ = leaf_beside(leaves[record.ref], p)
                if bound < best + 2.0 * SKIN:
                    top = push(entries, bounds, top, n_nodes + other, bound)
                else:
                    others = min(others, bound)
            continue
        other = entry - n_nodes
        a1, b1 = (hint_a, hint_b) if other == hint else (-1.0, -1.0)
        kind, ref = items[other].kind, items[other].ref
        excused = several = False
        if kind == ON_FACE:
            face, rim = faces[ref], rims[ref]
            code, h, free = quick_face(face, rim, rasters, pieces, ctrl, p, best, work)
            # Of a foot just outside its trim the room is known once the nearest foot is.
            excused = code == MISS and h < best and free <= 0.0
            h = h if excused else max(h, bound)
        elif kind == ON_LEAF:
            leaf = leaves[ref]
            patch, mine = patches[leaf.patch], found[1 - row]
            code, h, free, a1, b1, excused, several, excuse = quick_leaf(
                leaf, patch, leaves[last], last >= 0, height, leap, power, p, best, foot, a1, b1, mine
            )
            leapt |= excuse == ACROSS
            if code == HIT and not surely_in(leaf, a1, b1):
                face, rim = faces[patch.face], rims[patch.face]
                where, free = place_on_leaf(leaf, patch, face, rim, rasters, pieces, ctrl, a1, b1, mine, h, work)
                if where != IN:
                    code, free = DOUBT if where == UNSURE and h < best + 1e-9 else MISS, min(SKIN, free)
            if several and code != DOUBT:
                if n_pending < PENDING:
                    pending[n_pending, 0], pending[n_pending, 1] = other, 0.0
                    pending[n_pending, 2], pending[n_pending, 3] = bound, SEVERAL
                    n_pending += 1
                else:
                    doubt = True
                if code == MISS:
                    continue
        else:
            code, h, free = MISS, bound, 0.0
            if h < best:
                exact, a1, b1, _ = try_item(skin, other, p, best, a1, b1, work)
                if exact < np.inf:
                    code, h = HIT, exact
        if code == HIT and h < best:
            others = min(others, best)
            best, item, a, b, last = h, other, a1, b1, -1
            if kind == ON_LEAF:
                row, last = 1 - row, ref
                foot = (found[row, 0, 0], found[row, 0, 1], found[row, 0, 2])
                _, _, _, _, height = leaf_beside(leaf, p)
        elif code != DOUBT and (code == HIT or free <= 0.0 and not excused or 0.5 * (h - best) >= free):
            others = min(others, h)
        elif (code == DOUBT or excused or best == np.inf) and n_pending < PENDING:
            pending[n_pending, 0], pending[n_pending, 1] = other, free
            pending[n_pending, 2], pending[n_pending, 3] = h, code
            n_pending += 1
        elif code == DOUBT:
            doubt = True
        else:
            room = min(room, free)
    # What still waits is farther away.
    if top > 0:
        others = min(others, bounds[top - 1])
    room = min(room, 0.5 * (others - best))
    # Items that were in doubt, or looked at before the nearest foot was known.
    for k in range(n_pending):
        other, bound = int(pending[k, 0]), pending[k, 2]
        free = max(pending[k, 1], 0.5 * (bound - best))
        if free < room and items[other].kind == ON_FACE and pending[k, 3] == MISS:
            ref = items[other].ref
            free = max(free, room_beyond(faces[ref], bound, best - 2.0 * rims[ref].loose))
        if (free < room or free <= 1e-9) and items[other].kind == ON_LEAF:
            leaf = leaves[items[other].ref]
            _, beside, _, _, above = leaf_beside(leaf, p)
            free = max(free, (beside - best * leaf.cone) / (1.0 + leaf.cone))
            if last >= 0:
                excuse = continues(leaf, leaves[last], above, height, best, foot, leap)
                leapt |= excuse == ACROSS
                if excuse != APART:
                    free = max(free, room_of_both(leaf, leaves[last], above, height, best))
        if free <= 1e-9 and pending[k, 3] == DOUBT:
            doubt = True
        if free <= 1e-9 and pending[k, 3] == SEVERAL and not doubt:
            bends = True
            ref = items[other].ref
            leaf, mine = leaves[ref], found[1 - row]
            patch = patches[leaf.patch]
            h, a1, b1, _ = try_leaf(leaf, patch, faces[patch.face], pieces, ctrl, power, p, best, -1.0, -1.0, work)
            if h < best:
                code = DOUBTFUL
                if patch.steady:
                    code, a1, b1, h, _ = foot_in_box(
                        patch, power, p, a1, b1, 0.0, 1.0, 0.0, 1.0, leaf.tiny[0], leaf.tiny[1], CONVERGED, mine
                    )
                doubt = code != FOUND
                best, item, a, b, last, row = h, other, a1, b1, ref, 1 - row
                foot = (mine[0, 0], mine[0, 1], mine[0, 2])
                _, _, _, _, height = leaf_beside(leaf, p)
        room = min(room, free)
    if last >= 0:
        room = min(room, max(SKIN, room_of_bend(leaves[last], height, best)))
    reach = max(0.0, min(room, 0.5 * (others - best)))
    if doubt or item < 0:
        reach = CAREFUL
    elif bends and leapt:
        reach = AGAIN
    return item, a, b, row, reach
