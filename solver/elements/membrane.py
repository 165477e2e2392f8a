"""Membrane triangle with torsion stabilisation (theory.md 1 and 2; seed section 1).

Symbols: N_I,a gradients of the linear shape functions in the element's initial axes (axis 1 is the
rolling direction projected on the element); a_b = sum_I x_I N_I,b; C_ab = a_a . a_b; S second
Piola-Kirchhoff stress; V = t0 A0 volume; n the element's normal at the start of the increment; T* torsion modulus
[MPa], which acts on the rotations n . a_b of the increment out of that plane.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from ..kernels import FUSED_POINT, POINT
from .vectors import dot, minus, plus, scaled


class Membranes(NamedTuple):
    """What does not change: cells (m, 3), gradients (m, 3, 2) 1/mm, area (m,) mm^2, volume (m,) mm^3,
    axes (m, 3, 3): rows are the initial axes 1, 2 and the normal."""

    cells: np.ndarray
    gradients: np.ndarray
    area: np.ndarray
    volume: np.ndarray
    axes: np.ndarray


def build_membranes(points, cells, thickness, rolling):
    """Operators of every triangle in its initial shape.

    points : (n, 3) mm; cells : (m, 3); thickness : mm; rolling : (3,) direction
    A triangle that stands across the rolling direction takes its first side as axis 1.
    """
    corner = points[cells]
    side1, side2 = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    normal = np.cross(side1, side2)
    double_area = np.linalg.norm(normal, axis=1)
    normal /= double_area[:, None]
    rolling = np.asarray(rolling, dtype=float) / np.linalg.norm(rolling)
    axis1 = rolling - np.einsum("mi,i,mj->mj", normal, rolling, normal)
    across = np.linalg.norm(axis1, axis=1) < 1e-6
    axis1[across] = side1[across]
    axis1 /= np.linalg.norm(axis1, axis=1)[:, None]
    axis2 = np.cross(normal, axis1)
    plane = np.stack([axis1, axis2], axis=2)
    p = np.einsum("mik,mka->mia", corner - corner[:, :1], plane)
    rotated = p[:, [1, 2, 0]] - p[:, [2, 0, 1]]
    gradients = np.stack([rotated[:, :, 1], -rotated[:, :, 0]], axis=2) / double_area[:, None, None]
    return Membranes(
        np.ascontiguousarray(cells, dtype=np.int64),
        np.ascontiguousarray(gradients),
        0.5 * double_area,
        0.5 * double_area * thickness,
        np.ascontiguousarray(np.stack([axis1, axis2, normal], axis=1)),
    )


@njit(**POINT)
def tangent_vectors(x, nodes, g, a):
    """Fills a (2, 3) with the current tangent vectors of one triangle."""
    for b in range(2):
        for c in range(3):
            a[b, c] = x[nodes[0], c] * g[0, b] + x[nodes[1], c] * g[1, b] + x[nodes[2], c] * g[2, b]


@njit(**FUSED_POINT)
def tangents(x, cells, g, tri):
    """a_1 and a_2 of one triangle. x (3 n,), cells (3 m,), g (6 m,): flat, so that the compiler knows their strides"""
    i, j, k, q = 3 * cells[3 * tri], 3 * cells[3 * tri + 1], 3 * cells[3 * tri + 2], 6 * tri
    x0 = x[i], x[i + 1], x[i + 2]
    e1, e2 = minus((x[j], x[j + 1], x[j + 2]), x0), minus((x[k], x[k + 1], x[k + 2]), x0)
    return plus(scaled(g[q + 2], e1), g[q + 4], e2), plus(scaled(g[q + 3], e1), g[q + 5], e2)


@njit(parallel=True, cache=True)
def metrics(x, cells, gradients, metric):
    """Fills metric (m, 3) = C11, C22, C12 from current positions x (n, 3)."""
    n_tris, x, cells, g, metric = (
        len(cells),
        x.reshape(-1),
        cells.reshape(-1),
        gradients.reshape(-1),
        metric.reshape(-1),
    )
    for tri in prange(n_tris):
        a1, a2 = tangents(x, cells, g, tri)
        metric[3 * tri], metric[3 * tri + 1], metric[3 * tri + 2] = dot(a1, a1), dot(a2, a2), dot(a1, a2)


@njit(parallel=True, cache=True)
def unit_normals(x, cells, normal):
    """Fills normal (m, 3) with each triangle's unit normal."""
    for tri in prange(cells.shape[0]):
        i, j, k = cells[tri]
        for c in range(3):
            c1, c2 = (c + 1) % 3, (c + 2) % 3
            normal[tri, c] = (x[j, c1] - x[i, c1]) * (x[k, c2] - x[i, c2])
            normal[tri, c] -= (x[j, c2] - x[i, c2]) * (x[k, c1] - x[i, c1])
        size = sqrt(normal[tri, 0] ** 2 + normal[tri, 1] ** 2 + normal[tri, 2] ** 2)
        for c in range(3):
            normal[tri, c] /= size


@njit(**FUSED_POINT)
def node_forces(tri, x, cells, g, volume, s, normal, torsion):
    """Forces of one triangle on its three nodes. x, cells, g, normal : flat; s : its stress, three numbers"""
    i, j, k, size, q = 3 * tri, 3 * tri + 1, 3 * tri + 2, volume[tri], 6 * tri
    a1, a2 = tangents(x, cells, g, tri)
    n = normal[i], normal[j], normal[k]
    rot1, rot2 = torsion * dot(n, a1), torsion * dot(n, a2)
    on_a1 = scaled(size, plus(plus(scaled(s[0], a1), s[2], a2), rot1, n))
    on_a2 = scaled(size, plus(plus(scaled(s[2], a1), s[1], a2), rot2, n))
    on_0 = plus(scaled(g[q], on_a1), g[q + 1], on_a2)
    on_1 = plus(scaled(g[q + 2], on_a1), g[q + 3], on_a2)
    return on_0, on_1, plus(scaled(g[q + 4], on_a1), g[q + 5], on_a2)


@njit(parallel=True, cache=True)
def internal_forces(x, cells, gradients, volume, s, normal, torsion, force):
    """Fills force (m, 3, 3): nodal forces of every triangle [N], membrane and torsion.

    x : (n, 3); s : (m, 3); normal : (m, 3), fixed over the increment; torsion : T* [MPa]
    """
    n_tris, x, cells, g, s = len(cells), x.reshape(-1), cells.reshape(-1), gradients.reshape(-1), s.reshape(-1)
    normal, force = normal.reshape(-1), force.reshape(-1)
    for tri in prange(n_tris):
        own = s[3 * tri], s[3 * tri + 1], s[3 * tri + 2]
        on_0, on_1, on_2 = node_forces(tri, x, cells, g, volume, own, normal, torsion)
        i = 9 * tri
        force[i], force[i + 1], force[i + 2] = on_0
        force[i + 3], force[i + 4], force[i + 5] = on_1
        force[i + 6], force[i + 7], force[i + 8] = on_2


@njit(parallel=True, cache=True)
def stiffnesses(x, cells, gradients, volume, s, ds_de, normal, torsion, stiffness):
    """Fills stiffness (m, 9, 9): derivative of the force of node i, component c, with respect to the position of
    node j, component d [N/mm]: stiffness[m, 3 i + c, 3 j + d].

    ds_de : (m, 3, 3) derivative of S with respect to [E11, E22, 2 E12]
    """
    for tri in prange(cells.shape[0]):
        a = np.empty((2, 3))
        b = np.empty((3, 3, 3))  # derivative of [E11, E22, 2 E12] with respect to node i, component c
        g = gradients[tri]
        tangent_vectors(x, cells[tri], g, a)
        for i in range(3):
            for c in range(3):
                b[i, c, 0] = g[i, 0] * a[0, c]
                b[i, c, 1] = g[i, 1] * a[1, c]
                b[i, c, 2] = g[i, 0] * a[1, c] + g[i, 1] * a[0, c]
        for i in range(3):
            w1 = s[tri, 0] * g[i, 0] + s[tri, 2] * g[i, 1]
            w2 = s[tri, 2] * g[i, 0] + s[tri, 1] * g[i, 1]
            for j in range(3):
                geometric = w1 * g[j, 0] + w2 * g[j, 1]
                lift = torsion * (g[i, 0] * g[j, 0] + g[i, 1] * g[j, 1])
                for c in range(3):
                    for d in range(3):
                        total = lift * normal[tri, c] * normal[tri, d]
                        if c == d:
                            total += geometric
                        for k in range(3):
                            for el in range(3):
                                total += b[i, c, k] * ds_de[tri, k, el] * b[j, d, el]
                        stiffness[tri, 3 * i + c, 3 * j + d] = volume[tri] * total
