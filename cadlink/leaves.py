"""Patches and curved edges cut into leaves: pieces so nearly flat that a foot on them is unique.

A leaf is a start for Newton and a box that says whether to start at all. Cutting goes on until
the legs of the control net turn less than TURN in either direction, all patches of one degree at
a time. The box is aligned with the leaf; it holds the control net, so it holds the leaf
(weights are positive).
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from cadlink.bezier import project_ctrl, split
from cadlink.nurbs import WORK, from_ramp, patch_point, shape_on_patch
from cadlink.trim import inside

TURN = 0.3  # rad
LEVELS = 16  # halvings at most
SAFETY = 1.5  # on curvatures sampled at nine points of a leaf


class Leaves(NamedTuple):
    """Parts of patches.

    rect   (n, 4) s0, s1, t0, t1 in the patch
    frame  (n, 4, 3) centre and axes (third: near the normal S_s x S_t) of the aligned box
    half   (n, 3) its half sizes
    bend   (n, 2) largest curvature towards, and away from, the normal [1/mm]
    whole  (n,) True where no boundary of the face passes through: every foot counts
    """

    patch: np.ndarray
    rect: np.ndarray
    frame: np.ndarray
    half: np.ndarray
    bend: np.ndarray
    whole: np.ndarray


def cut_patches(patches, trims, smallest):
    """Leaves of all patches and the control points of each, those outside their trim left out.

    smallest : mm, a net smaller than this is not cut further
    returns : Leaves, low (n, 3), high (n, 3) boxes along the axes of space
    """
    found_patch, found_rect, found_net = [], [], []
    for p, q in np.unique(patches.degree, axis=0):
        ids = np.flatnonzero((patches.degree[:, 0] == p) & (patches.degree[:, 1] == q))
        take = patches.ctrl_first[ids][:, None] + np.arange((p + 1) * (q + 1))
        nets = patches.ctrl[take].reshape(-1, p + 1, q + 1, 4)
        rects = np.tile([0.0, 1.0, 0.0, 1.0], (len(ids), 1))
        for level in range(LEVELS + 1):
            part = where_inside(patches, trims, ids, rects)
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
    if not found_patch:
        return empty_leaves(), np.zeros((0, 3)), np.zeros((0, 3))
    patch, rect = np.concatenate(found_patch), np.concatenate(found_rect)
    whole = where_inside(patches, trims, patch, rect) == 2
    frame, bend = np.zeros((len(patch), 4, 3)), np.zeros((len(patch), 2))
    measure_leaves(patches, patch, rect, frame, bend)
    half = np.zeros((len(patch), 3))
    low, high = np.zeros((len(patch), 3)), np.zeros((len(patch), 3))
    for k, net in enumerate(found_net):
        low[k], high[k] = net.min(axis=0), net.max(axis=0)
        local = (net - frame[k, 0]) @ frame[k, 1:].T
        least, most = local.min(axis=0), local.max(axis=0)
        frame[k, 0] += 0.5 * (least + most) @ frame[k, 1:]
        half[k] = 0.5 * (most - least)
    return Leaves(patch, rect, frame, half, bend, whole), low, high


def empty_leaves():
    return Leaves(
        np.zeros(0, np.int64),
        np.zeros((0, 4)),
        np.zeros((0, 4, 3)),
        np.zeros((0, 3)),
        np.zeros((0, 2)),
        np.zeros(0, bool),
    )


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


def where_inside(patches, trims, ids, rects):
    """2 where a piece of a patch lies inside its face, 0 outside, 1 where a boundary passes."""
    part = np.zeros(len(ids), np.int64)
    classify(patches, trims, np.ascontiguousarray(ids), np.ascontiguousarray(rects), part)
    return part


@njit(cache=True)
def classify(patches, trims, ids, rects, part):
    work = np.zeros(WORK)
    for k in range(len(ids)):
        patch = ids[k]
        face = patches.face[patch]
        r = patches.uv_range[patch]
        u0 = from_ramp(rects[k, 0], r[0], r[1], patches.ramp[patch, 0])
        u1 = from_ramp(rects[k, 1], r[0], r[1], patches.ramp[patch, 0])
        v0 = from_ramp(rects[k, 2], r[2], r[3], patches.ramp[patch, 1])
        v1 = from_ramp(rects[k, 3], r[2], r[3], patches.ramp[patch, 1])
        touched = False
        for turn_u in range(-1, 2):
            for turn_v in range(-1, 2):
                du = turn_u * trims.period[face, 0]
                dv = turn_v * trims.period[face, 1]
                for piece in range(trims.first[face], trims.first[face + 1]):
                    low = min(trims.ends[piece, 1], trims.ends[piece, 3])
                    high = max(trims.ends[piece, 1], trims.ends[piece, 3])
                    touched |= (
                        trims.reach[piece, 0] <= u1 + du
                        and trims.reach[piece, 1] >= u0 + du
                        and low <= v1 + dv
                        and high >= v0 + dv
                    )
        if touched:
            part[k] = 1
        elif inside(trims, face, 0.5 * (u0 + u1), 0.5 * (v0 + v1), work):
            part[k] = 2


@njit(cache=True)
def measure_leaves(patches, ids, rects, frame, bend):
    """Centre and axes of each leaf, and the largest curvature to either side."""
    work = np.zeros(WORK)
    for k in range(len(ids)):
        for i in range(3):
            for j in range(3):
                s = rects[k, 0] + (rects[k, 1] - rects[k, 0]) * (0.5 * i * 0.998 + 0.001)
                t = rects[k, 2] + (rects[k, 3] - rects[k, 2]) * (0.5 * j * 0.998 + 0.001)
                n, k1, k2, e = shape_on_patch(patches, ids[k], s, t, 1.0, work)
                bend[k, 0] = max(bend[k, 0], -SAFETY * k2)
                bend[k, 1] = max(bend[k, 1], SAFETY * k1)
                if i == 1 and j == 1:
                    centre, d_s, d_t = patch_point(patches, ids[k], s, t, work)[:3]
                    # First axis along the leaf: S_s, or e where S_s vanishes.
                    length = np.sqrt(d_s[0] ** 2 + d_s[1] ** 2 + d_s[2] ** 2)
                    for c in range(3):
                        frame[k, 0, c] = centre[c]
                        frame[k, 3, c] = n[c]
                        frame[k, 1, c] = d_s[c] / length if length > 0.0 else e[c]
        a, b = frame[k, 1], frame[k, 3]
        frame[k, 2, 0] = b[1] * a[2] - b[2] * a[1]
        frame[k, 2, 1] = b[2] * a[0] - b[0] * a[2]
        frame[k, 2, 2] = b[0] * a[1] - b[1] * a[0]


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
