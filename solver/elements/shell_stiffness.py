"""Exact tangent of the shell triangle (theory_shell.md 5); symbols as in `shell.py`.

Over the nodes its quadratic form is a sum of products of two rows, U_j V_j. Six U are the strains' variations,
dE_11, dE_22, 2 dE_12 and the turns' dt_i, with V = D U. The second derivative of a turn brings six more, nu_b and
E^c_b: with y = dd - d^b da_b, nu_b = n.da_b, E^c_b = a^c.da_b, raised indices y^b = a^b.y, and l in place of an index
that is summed with l_c,

    F d2t = nu_b (-2 y^b - s A^bc nu_c + 2 t A^lb n.y - 2 t s (A^bc E^l_c + A^lc E^b_c)) - 2 t E^l_b y^b - 2 dt dF,

dF = -y^l - s A^lb nu_b, which follows from n.n = 1 and n.a_c = 0: dn = -nu_c a^c, da^c = -E^c_b a^b + A^cb nu_b n.
This is F d2t = d2s - t d2F - 2 dt dF. What unfolding takes from d.d has, with X = 2 rho - d.a^l and dX = dF,
d2(s r) = 2 r d2s - r^2 d2F + 2 X dr^2: the same again, and three rows dr_i.
Normal forces also turn with the triangles they act in, each component of the nodes alike. An edge slope only adds to
its turn.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from ..kernels import POINT
from .patches import SHARED
from .section import section_stiffness
from .vectors import dot, inverse_and_normal, minus, plus, scaled

NODES = 18  # unknowns: 3 translations of 6 patch nodes; 3 edge slopes follow
CHUNK = 64  # triangles that share scratch arrays


class Scratch(NamedTuple):
    """Room for one triangle: left and right (15, 18) the rows U and V, in the order dE, dt, dr, nu_b, E^1_b, E^2_b;
    spread (5, 6) the normal forces' part on a_1, a_2, d_i from the nodes; section, sides (6, 6) stiffness by curvature
    and by turns; power (5, 3, 3)."""

    left: np.ndarray
    right: np.ndarray
    spread: np.ndarray
    section: np.ndarray
    sides: np.ndarray
    power: np.ndarray


@njit(**POINT)
def place(u, node):
    """Place of a node."""
    return u[node, 0], u[node, 1], u[node, 2]


@njit(**POINT)
def mirrored(x, planes, image):
    """Reflection of x at a plane."""
    normal = planes[image, 0], planes[image, 1], planes[image, 2]
    return plus(x, 2.0 * (planes[image, 3] - dot(normal, x)), normal)


@njit(**POINT)
def tangent_vectors(u, slots, linear, tri):
    """Nodes x0, x1 - x0, x2 - x0 of a triangle, and a_1, a_2."""
    x0 = place(u, slots[tri, 0])
    e1, e2 = minus(place(u, slots[tri, 1]), x0), minus(place(u, slots[tri, 2]), x0)
    a1 = plus(scaled(linear[tri, 1, 0], e1), linear[tri, 2, 0], e2)
    a2 = plus(scaled(linear[tri, 1, 1], e1), linear[tri, 2, 1], e2)
    return x0, e1, e2, a1, a2


@njit(**POINT)
def apex_offset(u, slots, beyond, image, planes, tri, i, x0, e1, e2):
    """d of side i: of the apex across, from where the triangle goes on."""
    x = place(u, slots[tri, 3 + i])
    if image[tri, i] >= 0:
        x = mirrored(x, planes, image[tri, i])
    return plus(plus(minus(x, x0), -beyond[tri, i, 1], e1), -beyond[tri, i, 2], e2)


@njit(**POINT)
def new_scratch():
    """Scratch of one chunk."""
    return Scratch(
        np.empty((15, NODES)), np.empty((15, NODES)), np.empty((5, 6)), np.empty((6, 6)), np.empty((6, 6)),
        np.empty((5, 3, 3)),
    )  # fmt: skip


@njit(**POINT)
def add(row, node, w, vector):
    """row += w vector at a node."""
    row[3 * node] += w * vector[0]
    row[3 * node + 1] += w * vector[1]
    row[3 * node + 2] += w * vector[2]


@njit(**POINT)
def turns_stiffness(section, linear, tri, sides):
    """Fills sides (6, 6) with the stiffness (6, 6) by [E, t] from that by [E, k], k_v = T_vi t_i."""
    for i in range(3):
        l1, l2 = linear[tri, i, 0], linear[tri, i, 1]
        t1, t2, t3 = -2.0 * l1 * l1, -2.0 * l2 * l2, -4.0 * l1 * l2
        for v in range(3):
            sides[v, i] = section[v, i]
            sides[v, 3 + i] = section[v, 3] * t1 + section[v, 4] * t2 + section[v, 5] * t3
            sides[3 + i, v] = sides[v, 3 + i]
        # Curvature's moments from this turn, on all turns.
        m1 = section[3, 3] * t1 + section[3, 4] * t2 + section[3, 5] * t3
        m2 = section[4, 3] * t1 + section[4, 4] * t2 + section[4, 5] * t3
        m3 = section[5, 3] * t1 + section[5, 4] * t2 + section[5, 5] * t3
        for j in range(3):
            l1, l2 = linear[tri, j, 0], linear[tri, j, 1]
            sides[3 + j, 3 + i] = -2.0 * (m1 * l1 * l1 + m2 * l2 * l2 + 2.0 * m3 * l1 * l2)


@njit(**POINT)
def fill_rows(u, slots, linear, area, beyond, image, planes, result, tri, work):
    """Fills the rows U, those V that come from the moments, and the normal forces' spread, of one triangle."""
    left, right, spread = work.left, work.right, work.spread
    left[:], right[:], spread[:] = 0.0, 0.0, 0.0
    x0, e1, e2, a1, a2 = tangent_vectors(u, slots, linear, tri)
    i11, i22, i12, n = inverse_and_normal(a1, a2)
    up1, up2 = plus(scaled(i11, a1), i12, a2), plus(scaled(i12, a1), i22, a2)
    size = area[tri]
    n11, n22, n12 = size * result[tri, 0], size * result[tri, 1], size * result[tri, 2]
    m11, m22, m12 = -2.0 * size * result[tri, 3], -2.0 * size * result[tri, 4], -4.0 * size * result[tri, 5]
    mean1, mean2 = a1, a2
    stretched = turned1 = turned2 = 0.0
    for k in range(3):
        k1, k2 = linear[tri, k, 0], linear[tri, k, 1]
        spread[0, k], spread[1, k] = n11 * k1 + n12 * k2, n12 * k1 + n22 * k2
        add(left[9], k, k1, n)
        add(left[10], k, k2, n)
        add(left[11], k, k1, up1)
        add(left[12], k, k2, up1)
        add(left[13], k, k1, up2)
        add(left[14], k, k2, up2)
    for i in range(3):
        if slots[tri, 3 + i] < 0:
            continue
        l1, l2 = linear[tri, i, 0], linear[tri, i, 1]
        d, rho = apex_offset(u, slots, beyond, image, planes, tri, i, x0, e1, e2), -beyond[tri, i, i]
        d1, d2, s = dot(d, up1), dot(d, up2), dot(d, n)
        c, below, x = SHARED / (1.0 + rho), 1.0 / (1.0 + rho - l1 * d1 - l2 * d2), 2.0 * rho - l1 * d1 - l2 * d2
        m, t, r = (m11 * l1 * l1 + m22 * l2 * l2 + m12 * l1 * l2) * below, s * below, s / x
        al1, al2 = i11 * l1 + i12 * l2, i12 * l1 + i22 * l2
        up = plus(scaled(l1, up1), l2, up2)
        tip, nod = scaled(below, plus(n, t, up)), scaled(1.0 / x, plus(n, r, up))
        share = c / (1.0 + rho)
        g1, g2 = plus(scaled(-c, a1), share * l1, d), plus(scaled(-c, a2), share * l2, d)
        fold = plus(scaled(2.0 * share * r, n), share * r * r, up)
        p1, p2 = -c * (n11 * l1 + n12 * l2), -c * (n12 * l1 + n22 * l2)
        p = -(p1 * l1 + p2 * l2) / (1.0 + rho)
        # What works on d2s, and on -d2F.
        on_s, on_f = m + 2.0 * p * r, m * t + p * r * r
        push1 = plus(scaled(2.0 * on_f * al1, n), -2.0 * on_s, up1)
        push2 = plus(scaled(2.0 * on_f * al2, n), -2.0 * on_s, up2)
        mean1, mean2 = plus(mean1, -c * l1, d), plus(mean2, -c * l2, d)
        stretched += on_s * s
        turned1, turned2 = turned1 - 2.0 * on_f * s * l1, turned2 - 2.0 * on_f * s * l2
        for k in range(4):
            # Weight of this node in d, and in y.
            node, flat, w, along = 3 + i, 1.0, 1.0, 0.0
            if k < 3:
                k1, k2 = linear[tri, k, 0], linear[tri, k, 1]
                node, flat, along = k, -beyond[tri, i, k], al1 * k1 + al2 * k2
                w = flat - d1 * k1 - d2 * k2
                spread[2 + i, k] = p1 * k1 + p2 * k2
            # Half the variation of d.d, and of what a fold takes from it.
            unfold = plus(scaled(w, fold), share * r * r * s * along, n)
            add(left[0], node, l1, plus(scaled(flat, g1), l1, unfold))
            add(left[1], node, l2, plus(scaled(flat, g2), l2, unfold))
            add(left[2], node, l1, plus(scaled(flat, g2), l2, unfold))
            add(left[2], node, l2, plus(scaled(flat, g1), l1, unfold))
            add(left[3 + i], node, 1.0, plus(scaled(w, tip), t * t * along, n))
            add(right[3 + i], node, 2.0 * m, plus(scaled(w, up), s * along, n))
            nods = plus(scaled(w, nod), r * r * along, n)
            add(left[6 + i], node, 1.0, nods)
            add(right[6 + i], node, 2.0 * p * x, nods)
            add(right[9], node, w, push1)
            add(right[10], node, w, push2)
            add(right[11], node, -2.0 * on_f * l1 * w, up1)
            add(right[12], node, -2.0 * on_f * l1 * w, up2)
            add(right[13], node, -2.0 * on_f * l2 * w, up1)
            add(right[14], node, -2.0 * on_f * l2 * w, up2)
            spread[0, node] += p1 * flat
            spread[1, node] += p2 * flat
            spread[2 + i, node] += p * flat
    lift1, lift2 = i11 * turned1 + i12 * turned2, i12 * turned1 + i22 * turned2
    for k in range(3):
        k1, k2 = linear[tri, k, 0], linear[tri, k, 1]
        add(left[0], k, k1, mean1)
        add(left[1], k, k2, mean2)
        add(left[2], k, k1, mean2)
        add(left[2], k, k2, mean1)
        # What nu_b brings of nu_c and E^c_b.
        c1, c2, high = i11 * k1 + i12 * k2, i12 * k1 + i22 * k2, lift1 * k1 + lift2 * k2
        add(right[9], k, -stretched * c1, n)
        add(right[10], k, -stretched * c2, n)
        add(right[9], k, turned1 * c1 + high, up1)
        add(right[9], k, turned2 * c1, up2)
        add(right[10], k, turned1 * c2, up1)
        add(right[10], k, turned2 * c2 + high, up2)


@njit(parallel=True, cache=True, error_model="numpy")
def shell_stiffnesses(
    u, slots, linear, area, beyond, lever, image, planes, kappa, inverse, result, s, ds_de, height, weight, stretch,
    thickness, stiffness,
):  # fmt: skip
    """Fills stiffness (m, 21, 21): derivative of the forces [N/mm]; unknowns 3 I + c for patch node I, 18 + i for the
    slope of side i.

    kappa, inverse : (m, 3); result : (m, 6); s : (m n_layers, 3); ds_de : (m n_layers, 3, 3) derivative of S with
    respect to [E11, E22, 2 E12]
    """
    n_tris, n_layers = slots.shape[0], height.shape[0]
    for chunk in prange((n_tris + CHUNK - 1) // CHUNK):
        work = new_scratch()
        for tri in range(chunk * CHUNK, min((chunk + 1) * CHUNK, n_tris)):
            fill_rows(u, slots, linear, area, beyond, image, planes, result, tri, work)
            section_stiffness(
                s, ds_de, tri * n_layers, kappa, inverse, tri, height, weight, stretch, thickness, work.power,
                work.section,
            )  # fmt: skip
            turns_stiffness(work.section, linear, tri, work.sides)
            multiply_rows(area[tri], lever, tri, work, stiffness[tri])
            spread_normal_forces(linear, beyond, tri, work.spread, stiffness[tri])
            reflect(image, planes, tri, stiffness[tri])


@njit(**POINT)
def multiply_rows(size, lever, tri, work, k_tri):
    """Fills k_tri (21, 21) with the symmetric part of U' V, and with the slopes'."""
    left, right = work.left, work.right
    for i in range(3):
        for q in range(NODES):
            k_tri[NODES + i, q] = 0.0
        for v in range(6):
            stiff = size * lever[tri, i] * work.sides[3 + i, v]
            for q in range(NODES):
                k_tri[NODES + i, q] += stiff * left[v, q]
        for q in range(NODES):
            k_tri[q, NODES + i] = k_tri[NODES + i, q]
        for j in range(3):
            k_tri[NODES + i, NODES + j] = size * lever[tri, i] * work.sides[3 + i, 3 + j] * lever[tri, j]
    for v in range(6):
        for w in range(6):
            stiff = size * work.sides[v, w]
            for q in range(NODES):
                right[v, q] += stiff * left[w, q]
    for p in range(NODES):
        for q in range(NODES):
            k_tri[p, q] = 0.0
        for j in range(15 if p < 9 else 9):  # only the triangle's own nodes are in the last six U
            here = left[j, p]
            for q in range(NODES):
                k_tri[p, q] += here * right[j, q]
    for p in range(NODES):
        for q in range(p):
            k_tri[p, q] = 0.5 * (k_tri[p, q] + k_tri[q, p])
            k_tri[q, p] = k_tri[p, q]


@njit(**POINT)
def spread_normal_forces(linear, beyond, tri, spread, k_tri):
    """Adds the normal forces' part to k_tri (21, 21): of a_1, a_2, d_i as nodes move, on the nodes."""
    for k in range(3):
        k1, k2 = linear[tri, k, 0], linear[tri, k, 1]
        b0, b1, b2 = beyond[tri, 0, k], beyond[tri, 1, k], beyond[tri, 2, k]
        for q in range(6):
            total = k1 * spread[0, q] + k2 * spread[1, q] - b0 * spread[2, q] - b1 * spread[3, q] - b2 * spread[4, q]
            for c in range(3):
                k_tri[3 * k + c, 3 * q + c] += total
    for i in range(3):
        for q in range(6):
            for c in range(3):
                k_tri[9 + 3 * i + c, 3 * q + c] += spread[2 + i, q]


@njit(**POINT)
def reflect(image, planes, tri, k_tri):
    """A mirror image moves as its original, reflected."""
    for i in range(3):
        if image[tri, i] >= 0:
            n1, n2, n3 = planes[image[tri, i], 0], planes[image[tri, i], 1], planes[image[tri, i], 2]
            o = 9 + 3 * i
            for p in range(NODES + 3):
                back = 2.0 * (n1 * k_tri[o, p] + n2 * k_tri[o + 1, p] + n3 * k_tri[o + 2, p])
                k_tri[o, p] -= back * n1
                k_tri[o + 1, p] -= back * n2
                k_tri[o + 2, p] -= back * n3
            for p in range(NODES + 3):
                back = 2.0 * (n1 * k_tri[p, o] + n2 * k_tri[p, o + 1] + n3 * k_tri[p, o + 2])
                k_tri[p, o] -= back * n1
                k_tri[p, o + 1] -= back * n2
                k_tri[p, o + 2] -= back * n3
