"""Patches and curved edges cut into leaves: pieces so nearly flat that a foot on them is mostly unique.

A leaf is a start for Newton and a box that says whether to start at all. Cutting goes on until
the legs of the control net turn less than TURN in either direction, all patches of one degree at
a time. The box is aligned with the leaf; it holds the control net, so it holds the leaf
(weights are positive).
"""

from math import acos, sqrt

import numpy as np
from numba import njit

from cadlink.bezier import project_ctrl, split
from cadlink.leaf_measures import measure_leaves
from cadlink.nurbs import WORK, from_ramp
from cadlink.trim import inside

TURN = 0.3  # rad
LEVELS = 16  # halvings at most


# Part of a patch.
#   rect   s0, s1, t0, t1;  uv  the same in the parameters of its face;  period  of these, 0 for none
#   frame  centre and axes (third: near S_s x S_t) of its box, half  its size
#   bend   largest curvature towards, and away from, S_s x S_t [1/mm]
#   whole  1 where no boundary of the face passes through: every foot counts
#   cone   sine of the angle its normals make with the third axis at most
#   start  of Newton: s, t of the middle, its place along the first two axes, and the inverse of
#          the map from s, t to that plane
#   inner  s0, s1, t0, t1 within which every foot on the patch counts (rim.py)
#   sense, group   of its face and of that face's rim
#   cell   mm along the first two axes, of its three by three cells: from one to the next along s and along t,
#          and half the size of a box that holds any of them (leaf_bounds.py)
#   tiny   steps in s and t so short that a Taylor series ends them (power.py)
#   twist  bounds of the first and second derivative of the curvature [1/mm^2, 1/mm^3];  calm  quarter of its
#          smaller side [mm] (osculating.py)
LEAF = np.dtype(
    [
        ("patch", "i8"),
        ("face", "i8"),
        ("rect", "f8", 4),
        ("uv", "f8", 4),
        ("period", "f8", 2),
        ("frame", "f8", (4, 3)),
        ("half", "f8", 3),
        ("bend", "f8", 2),
        ("whole", "i8"),
        ("cone", "f8"),
        ("start", "f8", 8),
        ("cell", "f8", (3, 2)),
        ("tiny", "f8", 2),
        ("twist", "f8", 2),
        ("calm", "f8"),
        ("inner", "f8", 4),
        ("sense", "f8"),
        ("group", "i8"),
    ]
)


def cut_patches(patches, faces, pieces, ctrl, power, smallest):
    """Leaves of all patches and the control points of each, those outside their trim left out.

    smallest : mm, a net smaller than this is not cut further
    returns : LEAF records, low (n, 3), high (n, 3) boxes along the axes of space
    """
    found_patch, found_rect, found_nets = [], [], []
    degree = patches["degree"]
    for p, q in np.unique(degree, axis=0):
        ids = np.flatnonzero((degree[:, 0] == p) & (degree[:, 1] == q))
        take = patches["ctrl"][ids][:, None] + np.arange((p + 1) * (q + 1))
        nets = ctrl[take].reshape(-1, p + 1, q + 1, 4)
        rects = np.tile([0.0, 1.0, 0.0, 1.0], (len(ids), 1))
        for level in range(LEVELS + 1):
            part = where_inside(patches, faces, pieces, ctrl, ids, rects)
            ids, rects, nets = ids[part > 0], rects[part > 0], nets[part > 0]
            flat, along_u = flatness(nets, smallest)
            if level == LEVELS:
                flat[:] = True
            found_patch.append(ids[flat])
            found_rect.append(rects[flat])
            found_nets.append(project_ctrl(nets[flat]).reshape(-1, (p + 1) * (q + 1), 3))
            ids, rects, nets, along_u = ids[~flat], rects[~flat], nets[~flat], along_u[~flat]
            if not len(ids):
                break
            ids, rects, nets = halves(ids, rects, nets, along_u)
    found = sum(len(f) for f in found_patch)
    leaves, low, high = np.zeros(found, LEAF), np.zeros((found, 3)), np.zeros((found, 3))
    if not found:
        return leaves, low, high
    leaves["patch"], leaves["rect"] = np.concatenate(found_patch), np.concatenate(found_rect)
    part = where_inside(patches, faces, pieces, ctrl, leaves["patch"], leaves["rect"])
    leaves["whole"] = part == 2
    leaves["face"] = patches["face"][leaves["patch"]]
    leaves["period"] = faces["period"][leaves["face"]]
    measure_leaves(patches, ctrl, power, leaves)
    first = 0
    for nets in found_nets:
        mine = slice(first, first + len(nets))
        first = mine.stop
        low[mine], high[mine] = nets.min(axis=1), nets.max(axis=1)
        frame = leaves["frame"][mine]
        local = (nets - frame[:, :1]) @ frame[:, 1:].transpose(0, 2, 1)
        least, most = local.min(axis=1), local.max(axis=1)
        middle = 0.5 * (least + most)
        frame[:, 0] += np.einsum("kc,kcx->kx", middle, frame[:, 1:])
        leaves["half"][mine] = 0.5 * (most - least)
        leaves["start"][mine, 2:4] = -middle[:, :2]
    return leaves, low, high


def halves(ids, rects, nets, along_u):
    """Both halves of each net, cut along s where along_u and along t elsewhere."""
    out_ids, out_rects, out_nets = [], [], []
    for axis, pick in ((0, along_u), (1, ~along_u)):
        if not pick.any():
            continue
        left, right = split(nets[pick], 0.5, axis + 1)
        first, second = rects[pick].copy(), rects[pick].copy()
        middle = 0.5 * (first[:, 2 * axis] + first[:, 2 * axis + 1])
        first[:, 2 * axis + 1], second[:, 2 * axis] = middle, middle
        out_ids += [ids[pick], ids[pick]]
        out_rects += [first, second]
        out_nets += [left, right]
    return np.concatenate(out_ids), np.concatenate(out_rects), np.concatenate(out_nets)


def flatness(nets, smallest):
    """(flat, along_u): nets that need no cut, and those that turn more along s than along t."""
    turn, size = np.zeros((len(nets), 2)), np.zeros(len(nets))
    turns_of_nets(project_ctrl(nets), turn, size)
    return (turn.max(axis=1) < TURN) | (size < smallest), turn[:, 0] >= turn[:, 1]


@njit(cache=True)
def turns_of_nets(nets, turn, size):
    """Fill the largest angle of a leg with the mean of its row, rows along s and along t [rad], and the size [mm].

    nets : (n, p + 1, q + 1, 3)
    """
    rows, columns = nets.shape[1], nets.shape[2]
    for k in range(len(nets)):
        for c in range(3):
            low = high = nets[k, 0, 0, c]
            for i in range(rows):
                for j in range(columns):
                    low, high = min(low, nets[k, i, j, c]), max(high, nets[k, i, j, c])
            size[k] += (high - low) ** 2
        size[k] = sqrt(size[k])
        # Legs along s, then along t, each in rows along either.
        for leg in range(2):
            i1, j1 = (1, 0) if leg == 0 else (0, 1)
            m, n = rows - i1, columns - j1
            for axis in range(2):
                least = 1.0
                for row in range(n if axis == 0 else m):
                    x = y = z = 0.0
                    # The mean of the row's directions, then how far each turns from it.
                    for sweep in range(2):
                        for along in range(m if axis == 0 else n):
                            i, j = (along, row) if axis == 0 else (row, along)
                            a = nets[k, i + i1, j + j1, 0] - nets[k, i, j, 0]
                            b = nets[k, i + i1, j + j1, 1] - nets[k, i, j, 1]
                            c = nets[k, i + i1, j + j1, 2] - nets[k, i, j, 2]
                            length = sqrt(a * a + b * b + c * c)
                            # Legs of no length (poles, double points) have no direction.
                            if length <= 1e-7 * size[k]:
                                continue
                            if sweep == 0:
                                x, y, z = x + a / length, y + b / length, z + c / length
                            else:
                                least = min(least, (a * x + b * y + c * z) / length)
                        mean = sqrt(x * x + y * y + z * z)
                        if sweep == 0 and mean > 0.0:
                            x, y, z = x / mean, y / mean, z / mean
                turn[k, axis] = max(turn[k, axis], acos(max(-1.0, least)))


def where_inside(patches, faces, pieces, ctrl, ids, rects):
    """2 where a piece of a patch lies inside its face, 0 outside, 1 where a boundary passes."""
    part = np.zeros(len(ids), np.int64)
    ids, rects = np.ascontiguousarray(ids), np.ascontiguousarray(rects)
    classify(patches, faces, pieces, ctrl, ids, rects, part)
    return part


@njit(cache=True)
def classify(patches, faces, pieces, ctrl, ids, rects, part):
    work = np.zeros(WORK)
    for k in range(len(ids)):
        patch = patches[ids[k]]
        face, r = faces[patch.face], patch.uv
        u0 = from_ramp(rects[k, 0], r[0], r[1], patch.ramp[0])
        u1 = from_ramp(rects[k, 1], r[0], r[1], patch.ramp[0])
        v0 = from_ramp(rects[k, 2], r[2], r[3], patch.ramp[1])
        v1 = from_ramp(rects[k, 3], r[2], r[3], patch.ramp[1])
        touched = False
        for turn_u in range(-1, 2):
            for turn_v in range(-1, 2):
                du, dv = turn_u * face.period[0], turn_v * face.period[1]
                for number in range(face.piece_first, face.piece_last):
                    piece = pieces[number]
                    low = min(piece.ends[1], piece.ends[3])
                    high = max(piece.ends[1], piece.ends[3])
                    touched |= (
                        piece.reach[0] <= u1 + du and piece.reach[1] >= u0 + du and low <= v1 + dv and high >= v0 + dv
                    )
        if touched:
            part[k] = 1
        elif inside(face, pieces, ctrl, 0.5 * (u0 + u1), 0.5 * (v0 + v1), work):
            part[k] = 2


def cut_arc(ctrl, smallest):
    """Pieces (s0, s1, ctrl) of a 3-D arc, each turning less than TURN."""
    todo, done = [(0.0, 1.0, ctrl, 0)], []
    while todo:
        s0, s1, b, level = todo.pop()
        p = project_ctrl(b)
        legs = np.diff(p, axis=0)
        length = np.linalg.norm(legs, axis=1)
        total = length.sum()
        real = length > 1e-9 * total
        unit = legs[real] / length[real, None]
        mean = unit.sum(axis=0)
        size = np.linalg.norm(mean)
        flat = size > 0.0 and (unit @ mean).min() > np.cos(TURN) * size
        if flat or total < smallest or level >= LEVELS:
            done.append((s0, s1, b))
            continue
        left, right = split(b, 0.5)
        middle = 0.5 * (s0 + s1)
        todo += [(middle, s1, right, level + 1), (s0, middle, left, level + 1)]
    return done
