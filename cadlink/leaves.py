"""Patches and curved edges cut into leaves: pieces so nearly flat that a foot on them is unique.

A leaf is a start for Newton and a box that says whether to start at all. Cutting goes on until
the legs of the control net turn less than TURN in either direction, all patches of one degree at
a time. The box is aligned with the leaf; it holds the control net, so it holds the leaf
(weights are positive).
"""

from math import acos, pi, sin, sqrt

import numpy as np
from numba import njit

from cadlink.bezier import project_ctrl, split
from cadlink.nurbs import WORK, arc_derivatives, cross, dot, from_ramp, minus, patch_point, shape_on_patch
from cadlink.osculating import TRACKED
from cadlink.trim import inside

TURN = 0.3  # rad
LEVELS = 16  # halvings at most
REACH = 2.0  # mm: distance from the skin at which they are promised
TWIST_SAFETY = 2.0  # on differences over a few pieces of a leaf
SAFETY = 1.25  # on curvatures sampled at more points of a leaf than its degree has waves


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


def cut_patches(patches, faces, pieces, ctrl, smallest):
    """Leaves of all patches and the control points of each, those outside their trim left out.

    smallest : mm, a net smaller than this is not cut further
    returns : LEAF records, low (n, 3), high (n, 3) boxes along the axes of space
    """
    found_patch, found_rect, found_net = [], [], []
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
            found_net += [net.reshape(-1, 3) for net in project_ctrl(nets[flat])]
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
    measure_leaves(patches, ctrl, leaves)
    for k, net in enumerate(found_net):
        low[k], high[k] = net.min(axis=0), net.max(axis=0)
        frame = leaves["frame"][k]
        local = (net - frame[0]) @ frame[1:].T
        least, most = local.min(axis=0), local.max(axis=0)
        frame[0] += 0.5 * (least + most) @ frame[1:]
        leaves["half"][k] = 0.5 * (most - least)
        leaves["start"][k, 2:4] = -0.5 * (least + most)[:2]
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
    p = project_ctrl(nets)
    size = np.linalg.norm(np.ptp(p.reshape(len(p), -1, 3), axis=1), axis=1)
    turn_u, turn_v = np.zeros(len(p)), np.zeros(len(p))
    for legs in (np.diff(p, axis=1), np.diff(p, axis=2)):
        length = np.linalg.norm(legs, axis=3)
        unit = legs / np.maximum(length, 1e-300)[..., None]
        # Legs of no length (poles, double points) have no direction.
        real = length > 1e-7 * size[:, None, None]
        for axis in (1, 2):
            mean = np.where(real[..., None], unit, 0.0).sum(axis=axis, keepdims=True)
            mean /= np.maximum(np.linalg.norm(mean, axis=3, keepdims=True), 1e-300)
            cosine = np.where(real, (unit * mean).sum(axis=3), 1.0)
            turn = np.arccos(np.clip(cosine.reshape(len(p), -1).min(axis=1), -1.0, 1.0))
            if axis == 1:
                turn_u = np.maximum(turn_u, turn)
            else:
                turn_v = np.maximum(turn_v, turn)
    flat = (np.maximum(turn_u, turn_v) < TURN) | (size < smallest)
    return flat, turn_u >= turn_v


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


@njit(cache=True)
def measure_leaves(patches, ctrl, leaves):
    """Centre and axes of each leaf, largest curvature to either side, cone of normals, Newton's steps."""
    work = np.zeros(WORK)
    for k in range(len(leaves)):
        leaf = leaves[k]
        patch = patches[leaf.patch]
        s0, s1, t0, t1 = leaf.rect[0], leaf.rect[1], leaf.rect[2], leaf.rect[3]
        s, t = 0.5 * (s0 + s1), 0.5 * (t0 + t1)
        centre, d_s, d_t, _, _, _ = patch_point(patch, ctrl, s, t, work)
        n, _, _, e = shape_on_patch(patch, ctrl, s, t, 1.0, work)
        # First axis along the leaf: S_s, or e where S_s vanishes.
        length = sqrt(dot(d_s, d_s))
        a = (d_s[0] / length, d_s[1] / length, d_s[2] / length) if length > 0.0 else e
        b = cross(n, a)
        for c in range(3):
            leaf.frame[0, c] = centre[c]
            leaf.frame[1, c], leaf.frame[2, c], leaf.frame[3, c] = a[c], b[c], n[c]
        leaf.start[0], leaf.start[1] = s, t
        for end in range(2):
            leaf.uv[end] = from_ramp(leaf.rect[end], patch.uv[0], patch.uv[1], patch.ramp[0])
            leaf.uv[2 + end] = from_ramp(leaf.rect[2 + end], patch.uv[2], patch.uv[3], patch.ramp[1])
        det = length * dot(d_t, b)
        if abs(det) > 1e-9 * (length * length + dot(d_t, d_t)):
            leaf.start[4], leaf.start[5] = dot(d_t, b) / det, -dot(d_t, a) / det
            leaf.start[7] = length / det
        turn = 0.0
        n_s, n_t = max(4, patch.degree[0] + 3), max(4, patch.degree[1] + 3)
        for i in range(n_s):
            for j in range(n_t):
                s = s0 + (s1 - s0) * (0.001 + 0.998 * i / (n_s - 1.0))
                t = t0 + (t1 - t0) * (0.001 + 0.998 * j / (n_t - 1.0))
                m, k1, k2, _ = shape_on_patch(patch, ctrl, s, t, 1.0, work)
                leaf.bend[0] = max(leaf.bend[0], -SAFETY * k2)
                leaf.bend[1] = max(leaf.bend[1], SAFETY * k1)
                turn = max(turn, acos(min(1.0, dot(m, n))) if dot(m, n) > -1.0 else pi)
        leaf.cone = sin(min(0.5 * pi, 1.2 * turn + 0.01))
        measure_steps(patch, ctrl, leaf, work)
        measure_twist(patch, ctrl, leaf, work)
        measure_cells(patch, ctrl, leaf, work)


@njit
def measure_cells(patch, ctrl, leaf, work):
    """Fill cell: steps as the middle of the leaf has them, sizes from the corners of the cells, with some room."""
    w_s, w_t = (leaf.rect[1] - leaf.rect[0]) / 3.0, (leaf.rect[3] - leaf.rect[2]) / 3.0
    middle, d_s, d_t, _, _, _ = patch_point(patch, ctrl, leaf.start[0], leaf.start[1], work)
    a = (leaf.frame[1, 0], leaf.frame[1, 1], leaf.frame[1, 2])
    b = (leaf.frame[2, 0], leaf.frame[2, 1], leaf.frame[2, 2])
    leaf.cell[0, 0], leaf.cell[0, 1] = w_s * dot(d_s, a), w_s * dot(d_s, b)
    leaf.cell[1, 0], leaf.cell[1, 1] = w_t * dot(d_t, a), w_t * dot(d_t, b)
    for i in range(4):
        for j in range(4):
            corner, _, _, _, _, _ = patch_point(patch, ctrl, leaf.rect[0] + i * w_s, leaf.rect[2] + j * w_t, work)
            away = minus(corner, middle)
            x, y = dot(away, a), dot(away, b)
            # Seen from the cells that meet there.
            for k in range(max(0, i - 1), min(3, i + 1)):
                for m in range(max(0, j - 1), min(3, j + 1)):
                    dx = x - (k - 1) * leaf.cell[0, 0] - (m - 1) * leaf.cell[1, 0]
                    dy = y - (k - 1) * leaf.cell[0, 1] - (m - 1) * leaf.cell[1, 1]
                    leaf.cell[2, 0] = max(leaf.cell[2, 0], SAFETY * abs(dx))
                    leaf.cell[2, 1] = max(leaf.cell[2, 1], SAFETY * abs(dy))


@njit
def measure_steps(patch, ctrl, leaf, work):
    """How short a Newton step must be for a Taylor series to end it: errors of TRACKED.

    Over steps of a quarter of the leaf the series misses by e (third order, all of it); a step of x
    leaves misses by e (4 x)^3. Newton itself leaves a foot error of second order from the tangential
    part q of S_xx and, at the distance REACH, from the third derivatives.
    """
    w_s, w_t = leaf.rect[1] - leaf.rect[0], leaf.rect[3] - leaf.rect[2]
    miss, drift, even, first_s, first_t = 0.0, 0.0, 1.0, 0.0, 0.0
    for i in range(3):
        for j in range(3):
            s, t = leaf.rect[0] + 0.5 * i * w_s, leaf.rect[2] + 0.5 * j * w_t
            x, d_s, d_t, d_ss, d_st, d_tt = patch_point(patch, ctrl, s, t, work)
            a, b = (-0.25 if i > 0 else 0.25) * w_s, (-0.25 if j > 0 else 0.25) * w_t
            y, _, _, _, _, _ = patch_point(patch, ctrl, s + a, t + b, work)
            e = 0.0
            for c in range(3):
                series = x[c] + a * d_s[c] + b * d_t[c] + 0.5 * (a * a * d_ss[c] + b * b * d_tt[c]) + a * b * d_st[c]
                e += (y[c] - series) * (y[c] - series)
            e = sqrt(e)
            miss = max(miss, e)
            size_s, size_t = sqrt(dot(d_s, d_s)) * w_s, sqrt(dot(d_t, d_t)) * w_t
            # How unevenly the parameters run: 0 at a pole.
            first_s, first_t = (size_s, size_t) if i + j == 0 else (first_s, first_t)
            even = min(even, min(size_s / max(first_s, 1e-300), size_t / max(first_t, 1e-300)))
            even = min(even, min(first_s / max(size_s, 1e-300), first_t / max(size_t, 1e-300)))
            for d, w2 in ((d_ss, w_s * w_s), (d_st, w_s * w_t), (d_tt, w_t * w_t)):
                along = max(abs(dot(d, d_s)) * w_s / max(size_s, 1e-300), abs(dot(d, d_t)) * w_t / max(size_t, 1e-300))
                drift = max(drift, 1.5 * w2 * along)
            drift = max(drift, 3.0 * 64.0 * e * REACH / max(min(size_s, size_t), 1e-300))
    step = min(0.25, (TRACKED[0] / max(64.0 * miss, 1e-300)) ** (1.0 / 3.0), sqrt(TRACKED[1] / max(drift, 1e-300)))
    if even < 0.1:
        step = 1e-9  # near a pole the second derivatives must be those of the foot itself
    leaf.tiny[0], leaf.tiny[1] = step * w_s, step * w_t


@njit
def measure_twist(patch, ctrl, leaf, work):
    """Fill twist: bounds of the first and second derivative of the curvature along the leaf.

    From differences of the curvature tensor k1 e e^T + k2 f f^T over neighbours u along s and v along t, at an angle a:

        first <= sqrt(c_u^2 + c_v^2) / sin a,     second <= sqrt(c_uu^2 + 2 c_uv^2 + c_vv^2) / sin^2 a

    As tensors of space they also hold the turning of the tangent plane, k^2 and 2 k^3. At a pole neighbours
    coincide; those have nothing to say.
    """
    n_s, n_t = max(4, patch.degree[0] + 3), max(4, patch.degree[1] + 3)
    place, tensor = np.zeros((n_s, n_t, 3)), np.zeros((n_s, n_t, 3, 3))
    size = np.zeros(2)
    for i in range(n_s):
        for j in range(n_t):
            s = leaf.rect[0] + (leaf.rect[1] - leaf.rect[0]) * (0.001 + 0.998 * i / (n_s - 1.0))
            t = leaf.rect[2] + (leaf.rect[3] - leaf.rect[2]) * (0.001 + 0.998 * j / (n_t - 1.0))
            x, d_s, d_t, _, _, _ = patch_point(patch, ctrl, s, t, work)
            n, k1, k2, e = shape_on_patch(patch, ctrl, s, t, 1.0, work)
            f = cross(n, e)
            size[0] = max(size[0], sqrt(dot(d_s, d_s)) * (leaf.rect[1] - leaf.rect[0]))
            size[1] = max(size[1], sqrt(dot(d_t, d_t)) * (leaf.rect[3] - leaf.rect[2]))
            for a in range(3):
                place[i, j, a] = x[a]
                for b in range(3):
                    tensor[i, j, a, b] = k1 * e[a] * e[b] + k2 * f[a] * f[b]
    for i in range(1, n_s - 1):
        for j in range(1, n_t - 1):
            u, v = 0.5 * (place[i + 1, j] - place[i - 1, j]), 0.5 * (place[i, j + 1] - place[i, j - 1])
            uu, vv, uv = (u * u).sum(), (v * v).sum(), (u * v).sum()
            if sqrt(uu) > 1e-3 * size[0] / n_s and sqrt(vv) > 1e-3 * size[1] / n_t:
                # 1 / sin^2 of the angle between them.
                skew = 1.0 / max(1.0 - uv * uv / (uu * vv), 1e-12)
                c_u, c_v = 0.5 * (tensor[i + 1, j] - tensor[i - 1, j]), 0.5 * (tensor[i, j + 1] - tensor[i, j - 1])
                c_uu = tensor[i + 1, j] - 2.0 * tensor[i, j] + tensor[i - 1, j]
                c_vv = tensor[i, j + 1] - 2.0 * tensor[i, j] + tensor[i, j - 1]
                for a in (-1, 1):
                    for b in (-1, 1):
                        c_uv = tensor[i + a, j + b] - tensor[i + a, j] - tensor[i, j + b] + tensor[i, j]
                        first = (c_u * c_u).sum() / uu + (c_v * c_v).sum() / vv
                        second = (c_uu * c_uu).sum() / (uu * uu) + (c_vv * c_vv).sum() / (vv * vv)
                        second += 2.0 * (c_uv * c_uv).sum() / (uu * vv)
                        leaf.twist[0] = max(leaf.twist[0], TWIST_SAFETY * sqrt(first * skew))
                        leaf.twist[1] = max(leaf.twist[1], TWIST_SAFETY * sqrt(second) * skew)
    leaf.calm = 0.25 * min(size[0], size[1])


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


@njit(cache=True)
def measure_arcs(curves, ctrl):
    """Fill the largest curvature of curves that are arcs, those of one leg excepted: they are straight."""
    work = np.zeros(WORK)
    for k in range(len(curves)):
        curve = curves[k]
        if curve.degree < 2:
            continue
        n = max(4, curve.degree + 3)
        for i in range(n):
            _, d1, d2 = arc_derivatives(ctrl, curve.ctrl, curve.degree, i / (n - 1.0), work)
            m, speed = cross(d1, d2), sqrt(dot(d1, d1))
            bend = sqrt(dot(m, m)) / speed**3 if speed > 0.0 else np.inf
            curve.bend = max(curve.bend, SAFETY * bend)
