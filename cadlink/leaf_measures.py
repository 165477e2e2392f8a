"""What is known of a leaf before any point is: curvature, cone of normals, how far its Taylor series serve.

    s, t    parameters of its patch;  n, e, f  normal and principal directions;  k1 >= k2  curvatures [1/mm]

Most of it is sampled on a grid with three more points each way than the patch's degree, and given some room.
"""

from math import acos, pi, sin, sqrt

import numpy as np
from numba import njit

from cadlink.nurbs import WORK, arc_derivatives, cross, dot, from_ramp, minus, shape_of, shape_on_patch
from cadlink.osculating import TRACKED
from cadlink.patch_foot import patch_derivatives

REACH = 2.0  # mm: distance from the skin at which Newton's steps are promised
SAFETY = 1.25  # on curvatures sampled at more points of a leaf than its degree has waves
TWIST_SAFETY = 2.0  # on differences over a few pieces of a leaf
MIXED = sqrt(2.0)  # what stands for a mixed component and its mirror image in a norm


@njit(cache=True)
def measure_leaves(patches, ctrl, power, leaves):
    """Centre and axes of each leaf, largest curvature to either side, cone of normals, Newton's steps."""
    work = np.zeros(WORK)
    for k in range(len(leaves)):
        leaf = leaves[k]
        patch = patches[leaf.patch]
        s, t = 0.5 * (leaf.rect[0] + leaf.rect[1]), 0.5 * (leaf.rect[2] + leaf.rect[3])
        centre, d_s, d_t, _, _, _ = patch_derivatives(patch, ctrl, power, s, t, work)
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
        measure_shape(patch, ctrl, power, leaf, work)
        measure_steps(patch, ctrl, power, leaf, work)
        measure_cells(patch, ctrl, power, leaf, centre, a, b, d_s, d_t, work)


@njit
def measure_shape(patch, ctrl, power, leaf, work):
    """Fill bend and cone, and twist: bounds of the first and second derivative of the curvature along the leaf.

    From differences of the curvature tensor k1 e e^T + k2 f f^T over neighbours u along s and v along t, at an angle a:

        first <= sqrt(c_u^2 + c_v^2) / sin a,     second <= sqrt(c_uu^2 + 2 c_uv^2 + c_vv^2) / sin^2 a

    As tensors of space they also hold the turning of the tangent plane, k^2 and 2 k^3. At a pole neighbours
    coincide; those have nothing to say.
    """
    n_s, n_t = max(4, patch.degree[0] + 3), max(4, patch.degree[1] + 3)
    # Places, and tensors as xx, yy, zz and the mixed ones.
    place, tensor = np.zeros((n_s, n_t, 3)), np.zeros((n_s, n_t, 6))
    axis = (leaf.frame[3, 0], leaf.frame[3, 1], leaf.frame[3, 2])
    size_s, size_t, cosine = 0.0, 0.0, 1.0
    for i in range(n_s):
        for j in range(n_t):
            s = leaf.rect[0] + (leaf.rect[1] - leaf.rect[0]) * (0.001 + 0.998 * i / (n_s - 1.0))
            t = leaf.rect[2] + (leaf.rect[3] - leaf.rect[2]) * (0.001 + 0.998 * j / (n_t - 1.0))
            x, d_s, d_t, d_ss, d_st, d_tt = patch_derivatives(patch, ctrl, power, s, t, work)
            m = cross(d_s, d_t)
            if sqrt(dot(m, m)) > 1e-9 * (dot(d_s, d_s) + dot(d_t, d_t)):
                n, k1, k2, e = shape_of(d_s, d_t, d_ss, d_st, d_tt, 1.0)
            else:
                n, k1, k2, e = shape_on_patch(patch, ctrl, s, t, 1.0, work)
            f = cross(n, e)
            leaf.bend[0], leaf.bend[1] = max(leaf.bend[0], -SAFETY * k2), max(leaf.bend[1], SAFETY * k1)
            cosine = min(cosine, dot(n, axis))
            size_s = max(size_s, sqrt(dot(d_s, d_s)) * (leaf.rect[1] - leaf.rect[0]))
            size_t = max(size_t, sqrt(dot(d_t, d_t)) * (leaf.rect[3] - leaf.rect[2]))
            for c in range(3):
                place[i, j, c] = x[c]
                tensor[i, j, c] = k1 * e[c] * e[c] + k2 * f[c] * f[c]
                a, b = c, (c + 1) % 3
                tensor[i, j, 3 + c] = MIXED * (k1 * e[a] * e[b] + k2 * f[a] * f[b])
    leaf.cone = sin(min(0.5 * pi, 1.2 * acos(max(-1.0, cosine)) + 0.01))
    leaf.calm = 0.25 * min(size_s, size_t)
    for i in range(1, n_s - 1):
        for j in range(1, n_t - 1):
            uu = vv = uv = 0.0
            for c in range(3):
                u, v = 0.5 * (place[i + 1, j, c] - place[i - 1, j, c]), 0.5 * (place[i, j + 1, c] - place[i, j - 1, c])
                uu, vv, uv = uu + u * u, vv + v * v, uv + u * v
            if not (sqrt(uu) > 1e-3 * size_s / n_s and sqrt(vv) > 1e-3 * size_t / n_t):
                continue
            first_u = first_v = second_u = second_v = mixed = 0.0
            for c in range(6):
                here = tensor[i, j, c]
                before_u, after_u = tensor[i - 1, j, c], tensor[i + 1, j, c]
                before_v, after_v = tensor[i, j - 1, c], tensor[i, j + 1, c]
                first_u, first_v = (
                    first_u + 0.25 * (after_u - before_u) ** 2,
                    first_v + 0.25 * (after_v - before_v) ** 2,
                )
                second_u, second_v = (
                    second_u + (after_u - 2.0 * here + before_u) ** 2,
                    second_v + (after_v - 2.0 * here + before_v) ** 2,
                )
            for a in (-1, 1):
                for b in (-1, 1):
                    square = 0.0
                    for c in range(6):
                        corner = tensor[i + a, j + b, c] - tensor[i + a, j, c] - tensor[i, j + b, c] + tensor[i, j, c]
                        square += corner * corner
                    mixed = max(mixed, square)
            # 1 / sin^2 of the angle between u and v.
            skew = 1.0 / max(1.0 - uv * uv / (uu * vv), 1e-12)
            first = first_u / uu + first_v / vv
            second = second_u / (uu * uu) + second_v / (vv * vv) + 2.0 * mixed / (uu * vv)
            leaf.twist[0] = max(leaf.twist[0], TWIST_SAFETY * sqrt(first * skew))
            leaf.twist[1] = max(leaf.twist[1], TWIST_SAFETY * sqrt(second) * skew)


@njit
def measure_steps(patch, ctrl, power, leaf, work):
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
            x, d_s, d_t, d_ss, d_st, d_tt = patch_derivatives(patch, ctrl, power, s, t, work)
            a, b = (-0.25 if i > 0 else 0.25) * w_s, (-0.25 if j > 0 else 0.25) * w_t
            y, _, _, _, _, _ = patch_derivatives(patch, ctrl, power, s + a, t + b, work)
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
def measure_cells(patch, ctrl, power, leaf, middle, a, b, d_s, d_t, work):
    """Fill cell: steps as the middle of the leaf has them, sizes from the corners of the cells, with some room.

    middle, d_s, d_t : of the leaf, with the derivatives there; a, b : its first two axes
    """
    w_s, w_t = (leaf.rect[1] - leaf.rect[0]) / 3.0, (leaf.rect[3] - leaf.rect[2]) / 3.0
    leaf.cell[0, 0], leaf.cell[0, 1] = w_s * dot(d_s, a), w_s * dot(d_s, b)
    leaf.cell[1, 0], leaf.cell[1, 1] = w_t * dot(d_t, a), w_t * dot(d_t, b)
    for i in range(4):
        for j in range(4):
            s, t = leaf.rect[0] + i * w_s, leaf.rect[2] + j * w_t
            corner, _, _, _, _, _ = patch_derivatives(patch, ctrl, power, s, t, work)
            away = minus(corner, middle)
            x, y = dot(away, a), dot(away, b)
            # Seen from the cells that meet there.
            for k in range(max(0, i - 1), min(3, i + 1)):
                for m in range(max(0, j - 1), min(3, j + 1)):
                    dx = x - (k - 1) * leaf.cell[0, 0] - (m - 1) * leaf.cell[1, 0]
                    dy = y - (k - 1) * leaf.cell[0, 1] - (m - 1) * leaf.cell[1, 1]
                    leaf.cell[2, 0] = max(leaf.cell[2, 0], SAFETY * abs(dx))
                    leaf.cell[2, 1] = max(leaf.cell[2, 1], SAFETY * abs(dy))


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
