"""How far a foot is from the rim of its face: inside, outside, or too near to tell without care.

    room    how far [mm] the *point* may move before its foot can come into the face
    band    width [mm] of the strip along the rim where neighbouring faces may miss each other by
            the file's own gaps and kinks: feet there are left to the careful search (closest.py)

A trim that is a box in (u, v) is tested by half-planes, without angles: of a wedge of meridian
planes u0 .. u1 about the axis, x s - y c is the distance to its sides. Any other trim has a
raster: for each of its cells the number of cells to the nearest one that the boundary passes
through, + inside the face, - outside; 0 asks the exact boundary (trim.py).
"""

from math import atan2, pi, sin, sqrt

import numpy as np
from numba import njit

from cadlink.kernels import POINT
from cadlink.nurbs import WORK, arc_point, to_ramp
from cadlink.records import CONE, CYLINDER, PATCHES, PLANE, SPHERE, TORUS
from cadlink.trim import first_turn, inside

IN, UNSURE, OUT = 1, 0, -1
BOX, RASTER, ODD = 0, 1, 2  # kinds of rim; ODD: closed forms with a second foot beyond their axis
TIP = 1e-3  # of a face's largest radius: where it comes nearer than this to its axis, it is ODD
FINE, COARSE, MANY = 256, 64, 32  # cells along each side of a raster; coarse ones for more than MANY faces
FAR = 127  # cells counted at most

# Rim of one face.
#   turn   cos u0, sin u0, cos u1, sin u1, and the same of v, where they are angles
#   full   whether u, v go all the way round;  wide  whether u, v span more than half a turn
#   gap    mm, angle  rad: band = gap + angle x distance
#   first  of its cells in the rasters;  slope  cos and sin of a cone's half angle
#   group  faces that continue each other smoothly share it;  loose  mm, the largest slack of any edge or vertex
RIM = np.dtype(
    [
        ("kind", "i8"),
        ("turn", "f8", 8),
        ("full", "i8", 2),
        ("wide", "i8", 2),
        ("gap", "f8"),
        ("angle", "f8"),
        ("first", "i8"),
        ("slope", "f8", 2),
        ("group", "i8"),
        ("loose", "f8"),
    ]
)


# --- build ---------------------------------------------------------------------------------------


def build_rims(faces, pieces, ctrl):
    """RIM records of all faces (gap, angle and group still 0) and their rasters (n, cells, cells)."""
    rims = np.zeros(len(faces), RIM)
    drawn = []
    for number, (rim, face) in enumerate(zip(rims, faces, strict=True)):
        u0, u1, v0, v1 = face["box"]
        form = face["form"]
        rim["turn"] = [f(a) for a in (u0, u1, v0, v1) for f in (np.cos, np.sin)]
        around = np.array([form not in (PLANE, PATCHES), form in (SPHERE, TORUS)])
        span = np.array([u1 - u0, v1 - v0])
        rim["full"] = around & (span > 2.0 * pi - 1e-9)
        rim["wide"] = around & (span > pi)
        if form == CONE:
            rim["slope"] = np.cos(face["size"][1]), np.sin(face["size"][1])
        mine = pieces[face["piece_first"] : face["piece_last"]]
        if second_foot(face):
            rim["kind"] = ODD
        elif not is_box(mine, face["box"]):
            rim["kind"], rim["first"] = RASTER, len(drawn)
            drawn.append(number)
    cells = FINE if len(drawn) <= MANY else COARSE
    rasters = np.zeros((len(drawn), cells, cells), np.int8)
    if drawn:
        draw_rasters(faces, pieces, ctrl, np.array(drawn), rasters)
    return rims, rasters


def second_foot(face):
    """Whether points may have a second foot beyond the axis: cones near their apex, and tori across their axis.

    A torus whose tube is wider than its ring cuts its axis and has two sheets, the outer with R + r cos v > 0. On a
    sheet by itself every point has one foot, that of the circle about (R, 0) in the point's own half plane: its squared
    distance from a point at radius w > 0, height h and angle u from it, (rho - w)^2 + 2 rho w (1 - cos u) + (z - h)^2,
    has its only minimum over u at 0, and along an arc of a circle one at most. So a trim on the outer sheet is met like
    any other torus.
    """
    (radius, other), (v0, v1) = face["size"], face["box"][2:]
    if face["form"] == CONE:
        ends = radius + face["box"][2:] * np.sin(other)
        return bool((ends < TIP * np.abs(ends).max()).any())
    if face["form"] != TORUS or 0.0 < other < radius:
        return False
    inner = np.floor((v1 - pi) / (2.0 * pi)) > np.floor((v0 - pi) / (2.0 * pi))
    least = radius + other * min(np.cos(v0), np.cos(v1))
    return bool(inner or not (radius > 0.0 and least > TIP * (radius + other)))


def is_box(pieces, box):
    """Whether a boundary runs along the sides of its own box."""
    u0, u1, v0, v1 = box
    tiny_u, tiny_v = 1e-11 * (u1 - u0), 1e-11 * (v1 - v0)
    ends, reach = pieces["ends"], pieces["reach"]
    on_side = [np.maximum(np.abs(reach[:, 0] - u), np.abs(reach[:, 1] - u)) <= tiny_u for u in (u0, u1)]
    on_side += [np.maximum(np.abs(ends[:, 1] - v), np.abs(ends[:, 3] - v)) <= tiny_v for v in (v0, v1)]
    return bool(np.any(on_side, axis=0).all())


@njit(cache=True)
def draw_rasters(faces, pieces, ctrl, drawn, rasters):
    work = np.zeros(WORK)
    for number in range(len(drawn)):
        face, cells = faces[drawn[number]], rasters[number]
        n = len(cells)
        cells[:, :] = FAR
        for k in range(face.piece_first, face.piece_last):
            mark_piece(face, pieces[k], ctrl, cells, work)
        # Cells to the nearest marked one: a sweep from either corner, over the neighbours behind it.
        for sweep in range(2):
            way = 1 if sweep == 0 else -1
            for i1 in range(n):
                for j1 in range(n):
                    i, j = (i1, j1) if sweep == 0 else (n - 1 - i1, n - 1 - j1)
                    least = cells[i, j]
                    back = i - way
                    if 0 <= back < n:
                        for b in range(max(0, j - 1), min(n, j + 2)):
                            least = min(least, cells[back, b] + 1)
                    if 0 <= j - way < n:
                        least = min(least, cells[i, j - way] + 1)
                    cells[i, j] = least
        # Neighbours that the boundary does not part are on the same side of it.
        u0, v0 = face.box[0], face.box[2]
        du, dv = (face.box[1] - u0) / n, (face.box[3] - v0) / n
        for i in range(n):
            known, side = False, False
            for j in range(n):
                if cells[i, j] == 0:
                    known = False
                    continue
                if not known:
                    known, side = True, inside(face, pieces, ctrl, u0 + (i + 0.5) * du, v0 + (j + 0.5) * dv, work)
                if not side:
                    cells[i, j] = -cells[i, j]


@njit(**POINT)
def mark_piece(face, piece, ctrl, cells, work):
    """Zero in every cell a boundary piece passes through, and half a cell round it."""
    u0, v0 = face.box[0], face.box[2]
    n = len(cells)
    per_u, per_v = n / (face.box[1] - u0), n / (face.box[3] - v0)
    a, b = (piece.ends[0] - u0) * per_u, (piece.ends[1] - v0) * per_v
    last_a, last_b = (piece.ends[2] - u0) * per_u, (piece.ends[3] - v0) * per_v
    s, step = 0.0, 1.0 / 16.0
    while s < 1.0:
        # Steps so short that the chord stays in the cells it crosses.
        new = min(1.0, s + step)
        if new == 1.0:
            c, d = last_a, last_b
        elif piece.degree == 1:
            c, d = a + (new - s) / (1.0 - s) * (last_a - a), b + (new - s) / (1.0 - s) * (last_b - b)
        else:
            arc_point(ctrl, piece.ctrl, piece.degree, new, work)
            c, d = (work[0, 0] / work[0, 2] - u0) * per_u, (work[0, 1] / work[0, 2] - v0) * per_v
        if max(abs(c - a), abs(d - b)) > 0.3 and step > 1e-6:
            step *= 0.5
            continue
        for i in range(max(0, int(min(a, c) - 0.5)), min(n, int(max(a, c) + 0.5) + 1)):
            for j in range(max(0, int(min(b, d) - 0.5)), min(n, int(max(b, d) + 0.5) + 1)):
                cells[i, j] = 0
        a, b, s = c, d, new
        step *= 1.5


@njit(cache=True)
def fill_inner(leaves, patches, faces, rims):
    """Where every foot on the patch of a leaf counts: its part of a box-shaped trim, or a whole leaf."""
    for k in range(len(leaves)):
        leaf = leaves[k]
        leaf.inner[0], leaf.inner[1], leaf.inner[2], leaf.inner[3] = 1.0, 0.0, 1.0, 0.0
        if leaf.whole:
            for c in range(4):
                leaf.inner[c] = leaf.rect[c]
        patch = patches[leaf.patch]
        face, uv = faces[patch.face], patch.uv
        if rims[patch.face].kind != BOX:
            continue
        for axis in range(2):
            first, last, ramp = uv[2 * axis], uv[2 * axis + 1], patch.ramp[axis]
            low, high = 1.0, 0.0
            # Of the turns of the trim, the one that covers most of the patch.
            for turn in range(-1, 2):
                a = max(first, face.box[2 * axis] + turn * face.period[axis])
                b = min(last, face.box[2 * axis + 1] + turn * face.period[axis])
                if b > a:
                    s, t = to_ramp(a, first, last, ramp), to_ramp(b, first, last, ramp)
                    if t - s > high - low:
                        low, high = s, t
            leaf.inner[2 * axis], leaf.inner[2 * axis + 1] = low + 1e-12, high - 1e-12


# --- query ---------------------------------------------------------------------------------------


@njit(forceinline=True, **POINT)
def wedge(x, y, c0, s0, c1, s1, wide):
    """Room inside (+) or outside (-) a wedge about the origin from direction 0 to direction 1."""
    e0, e1 = c0 * y - s0 * x, s1 * x - c1 * y
    return max(e0, e1) if wide else min(e0, e1)


@njit(forceinline=True, **POINT)
def box_room(face, rim, x, y, z, rho, v):
    """Room of a point in the frame of a closed form, + inside its box.

    rho : distance from the axis; v : along the generator
    """
    form, box, turn = face.form, face.box, rim.turn
    if form == PLANE:
        return min(min(x - box[0], box[1] - x), min(y - box[2], box[3] - y))
    room = np.inf
    if not rim.full[0]:
        room = wedge(x, y, turn[0], turn[1], turn[2], turn[3], rim.wide[0])
    if form == CYLINDER or form == CONE:
        return min(room, min(v - box[2], box[3] - v))
    if not rim.full[1]:
        across = rho if form == SPHERE else rho - face.size[0]
        room = min(room, wedge(across, z, turn[4], turn[5], turn[6], turn[7], rim.wide[1]))
    return room


@njit(forceinline=True, **POINT)
def cell_of(face, rim, rasters, u, v):
    """The cell of (u, v) in the raster of a face; parameters that wrap round are turned into the face's own turn."""
    u0, u1, v0, v1 = face.box[0], face.box[1], face.box[2], face.box[3]
    u, v = first_turn(u, u0, u1, face.period[0]), first_turn(v, v0, v1, face.period[1])
    n = rasters.shape[1]
    i = min(n - 1, max(0, int((u - u0) / (u1 - u0) * n)))
    j = min(n - 1, max(0, int((v - v0) / (v1 - v0) * n)))
    return rasters[rim.first, i, j]


@njit(**POINT)
def at_boundary(face, pieces, ctrl, u, v, band_u, band_v, work):
    """IN, UNSURE or OUT in a cell that the boundary passes through, by the boundary itself."""
    if inside(face, pieces, ctrl, u, v, work):
        return IN
    for k in range(4):
        a = u + (band_u if k == 0 else (-band_u if k == 1 else 0.0))
        b = v + (band_v if k == 2 else (-band_v if k == 3 else 0.0))
        if inside(face, pieces, ctrl, a, b, work):
            return UNSURE
    return OUT


@njit(**POINT)
def room_to_boundary(face, pieces, u, v):
    """How far (u, v) [mm] on a plane is at least from the boundary of a face: straight pieces exactly, curved ones by
    the box they lie in."""
    room = np.inf
    for k in range(face.piece_first, face.piece_last):
        piece = pieces[k]
        u0, v0, u1, v1 = piece.ends[0], piece.ends[1], piece.ends[2], piece.ends[3]
        if piece.degree == 1:
            du, dv = u1 - u0, v1 - v0
            size = du * du + dv * dv
            s = min(1.0, max(0.0, ((u - u0) * du + (v - v0) * dv) / size)) if size > 0.0 else 0.0
            a, b = u - u0 - s * du, v - v0 - s * dv
        else:
            a = max(0.0, max(piece.reach[0] - u, u - piece.reach[1]))
            b = max(0.0, max(min(v0, v1) - v, v - max(v0, v1)))
        room = min(room, a * a + b * b)
    return sqrt(room)


@njit(forceinline=True, **POINT)
def uv_of_form(face, rim, x, y, z, rho, m, v):
    """u, v of a point in the frame of a closed form, and the mm at its foot for a unit of each."""
    form, size = face.form, face.size
    if form == PLANE:
        return x, y, 1.0, 1.0
    u = atan2(y, x)
    if form == CYLINDER:
        return u, v, size[0], 1.0
    if form == CONE:
        return u, v, size[0] + v * rim.slope[1], 1.0
    if form == SPHERE:
        return u, atan2(z, rho), size[0] * rho / m, size[0]
    return u, atan2(z, rho - size[0]), size[0] + size[1] * (rho - size[0]) / m, size[1]


@njit(forceinline=True, **POINT)
def room_of_cells(face, cells, n, rho, m):
    """Room [mm] of a point whose foot is that many of n cells away from the boundary."""
    box, form, free = face.box, face.form, max(0, abs(cells) - 1) / n
    du, dv = free * (box[1] - box[0]), free * (box[3] - box[2])
    if form != PLANE:
        du = rho * sin(min(0.5 * pi, du))
    if form == SPHERE or form == TORUS:
        dv = m * sin(min(0.5 * pi, dv))
    return min(du, dv)


@njit(**POINT)
def patch_room(face, rim, rasters, pieces, ctrl, u, v, per_u, per_v, band, work):
    """IN, UNSURE or OUT of a foot at (u, v) of a face of patches, and its room [mm].

    The foot moves at most 1 / (1 - 0.7) times as fast as the point (leaf_search); a third of that for
    oblique parameters.
    """
    u0, u1, v0, v1 = face.box[0], face.box[1], face.box[2], face.box[3]
    a, b = first_turn(u, u0, u1, face.period[0]), first_turn(v, v0, v1, face.period[1])
    out_u = max(u0 - a, a - u1)
    if face.period[0] > 0.0:
        out_u = min(out_u, u0 + face.period[0] - a)
    out_v = max(v0 - b, b - v1)
    if face.period[1] > 0.0:
        out_v = min(out_v, v0 + face.period[1] - b)
    out = max(out_u * per_u, out_v * per_v)
    if out > band:
        return OUT, 0.1 * out
    if out > 0.0:
        return UNSURE, 0.0
    if rim.kind == BOX:
        return IN, 0.0
    cells = cell_of(face, rim, rasters, u, v)
    if cells == 0:
        return at_boundary(face, pieces, ctrl, a, b, band / per_u, band / per_v, work), 0.0
    free = max(0, abs(cells) - 1) / rasters.shape[1]
    return (IN if cells > 0 else OUT), 0.1 * free * min((u1 - u0) * per_u, (v1 - v0) * per_v)
