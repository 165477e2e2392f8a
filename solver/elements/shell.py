"""Shell triangle with translations only: metric shared with the neighbours, curvature from the turns across the sides
(theory_shell.md 3 and 4).

Symbols: x_k nodes of a triangle, k = 0..2; l_k,a gradients of its shape functions, so that l_i points inward from
side i and is 1/h_i long, h_i the altitude; a_b = l_k,b x_k tangent vectors, a^b = A^bc a_c their duals, n unit normal.
Across side i, x_q the apex; in the initial plane, unfolded, it is at sum_k b_ik p_k of the nodes' places p_k, and
rho_i = -b_ii is the altitude there relative to h_i. d_i = x_q - b_ik x_k is how far it is from where the triangle would
go on to. Nothing else is needed of the neighbour, whose own tangent vectors are g_b = a_b - l_i,b d_i/rho_i.

Metric C = OWN a.a + SHARED sum_i G^i.G^i, G^i = (a + rho g^i)/(1 + rho) the mean by areas of the two triangles' tangent
vectors, the neighbour's turned about the side into this one's plane; a without a neighbour. In the plane these are the
mid-side gradients of theory_shell.md 3, with a part of the triangle's own. Unfolded so, d is shorter, d.d - 2 rho s r
with r = s/(2 rho - d.a^l) and s below; exact where the neighbour keeps its altitude. With c = SHARED/(1 + rho)
C_ab = a_a.a_b + sum_i c (l_a l_b (d.d + 2 s r)/(1 + rho) - l_a d.a_b - l_b d.a_a).
(Folded, the mean gradient is shorter by sin(theta/2)^2 where the surface turns by theta: coarse curved meshes locked.
The mean of the two metrics does not fold, but exceeds the metric of the mean by the variance of the gradients. In
compression that variance releases work, resisted by the mean alone: rims zigzagged, triangle by triangle.)

Curvature k_ab = -2 sum_i l_i,a l_i,b t_i from the turns t_i of the sides, t = s/F, s = d.n,
F = 1 + rho - d.a^l, a^l = l_b a^b. Where the surface turns by theta between two equal triangles t = h tan(theta/2),
which grows with any fold; with sin(theta)/2 the moment would vanish as the fold closes. An edge slope phi adds h phi.

With y = (dd - d^b da_b) and nu_b = n.da_b the turn varies by dt = (n + t a^l).y/F + t^2 A^bc l_b nu_c, and r as t does,
with 2 rho - d.a^l for F; d(s r) = (2 r n + r^2 a^l).y + r^2 s A^bc l_b nu_c.
"""

from math import sqrt

from numba import njit, prange

from ..kernels import POINT
from .patches import SHARED
from .vectors import cross, dot, minus, plus, scaled


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
def inverse_and_normal(a1, a2):
    """A11, A22, A12 of the inverse metric, and the unit normal."""
    across = cross(a1, a2)
    d = 1.0 / dot(across, across)
    return dot(a2, a2) * d, dot(a1, a1) * d, -dot(a1, a2) * d, scaled(sqrt(d), across)


@njit(**POINT)
def apex_offset(u, slots, beyond, image, planes, tri, i, x0, e1, e2):
    """d of side i: of the apex across, from where the triangle goes on."""
    x = place(u, slots[tri, 3 + i])
    if image[tri, i] >= 0:
        x = mirrored(x, planes, image[tri, i])
    return plus(plus(minus(x, x0), -beyond[tri, i, 1], e1), -beyond[tri, i, 2], e2)


@njit(parallel=True, cache=True, error_model="numpy")
def shell_strains(u, slots, linear, beyond, lever, image, planes, metric, kappa):
    """Mean metric and curvature of every triangle.

    u : (n + k, 3) node places, then edge slopes in the first column; the operators are those of `Patches`
    fills metric (m, 3) = C11 C22 C12 and kappa (m, 3) = [11, 22, 2*12] [1/mm]
    """
    for tri in prange(slots.shape[0]):
        x0, e1, e2, a1, a2 = tangent_vectors(u, slots, linear, tri)
        i11, i22, i12, n = inverse_and_normal(a1, a2)
        m11, m22, m12 = dot(a1, a1), dot(a2, a2), dot(a1, a2)
        k11 = k22 = k12 = 0.0
        for i in range(3):
            l1, l2, turn = linear[tri, i, 0], linear[tri, i, 1], 0.0
            if slots[tri, 3 + i] >= 0:
                d, rho = apex_offset(u, slots, beyond, image, planes, tri, i, x0, e1, e2), -beyond[tri, i, i]
                d1, d2, s = dot(d, a1), dot(d, a2), dot(d, n)
                away = l1 * (i11 * d1 + i12 * d2) + l2 * (i12 * d1 + i22 * d2)
                dd = (dot(d, d) + 2.0 * s * s / (2.0 * rho - away)) / (1.0 + rho)
                c = SHARED / (1.0 + rho)
                m11 += c * l1 * (l1 * dd - 2.0 * d1)
                m22 += c * l2 * (l2 * dd - 2.0 * d2)
                m12 += c * (l1 * l2 * dd - l1 * d2 - l2 * d1)
                turn = s / (1.0 + rho - away)
            slope = slots[tri, 6 + i]
            if slope >= 0:
                turn += lever[tri, i] * u[slope, 0]
            k11 -= 2.0 * l1 * l1 * turn
            k22 -= 2.0 * l2 * l2 * turn
            k12 -= 4.0 * l1 * l2 * turn
        metric[tri, 0], metric[tri, 1], metric[tri, 2] = m11, m22, m12
        kappa[tri, 0], kappa[tri, 1], kappa[tri, 2] = k11, k22, k12


@njit(parallel=True, cache=True, error_model="numpy")
def shell_forces(u, slots, linear, area, beyond, lever, image, planes, result, force):
    """Fills force (m, 9, 3): forces of every triangle on its slots [N]; of an edge slope the first column.

    result : (m, 6) resultants N, M. With m = -2 M_ab l_a l_b of a side, p = c N_ab l_a l_b/(1 + rho) and the tilting
    q = m (n + t a^l)/F + p (2 r n + r^2 a^l) the force on its d is -c N_ab l_a a_b + p d + q, and on a_b
    N_ab (a_a - sum c l_a d) + (m t^2 + p r^2 s) A^bc l_c n - d^b q.
    """
    for tri in prange(slots.shape[0]):
        x0, e1, e2, a1, a2 = tangent_vectors(u, slots, linear, tri)
        i11, i22, i12, n = inverse_and_normal(a1, a2)
        size = area[tri]
        n11, n22, n12 = size * result[tri, 0], size * result[tri, 1], size * result[tri, 2]
        m11, m22, m12 = -2.0 * size * result[tri, 3], -2.0 * size * result[tri, 4], -4.0 * size * result[tri, 5]
        h1, h2 = plus(scaled(n11, a1), n12, a2), plus(scaled(n12, a1), n22, a2)
        f0 = f1 = f2 = (0.0, 0.0, 0.0)
        for i in range(3):
            l1, l2 = linear[tri, i, 0], linear[tri, i, 1]
            m, on_d = m11 * l1 * l1 + m22 * l2 * l2 + m12 * l1 * l2, (0.0, 0.0, 0.0)
            if slots[tri, 3 + i] >= 0:
                d, rho = apex_offset(u, slots, beyond, image, planes, tri, i, x0, e1, e2), -beyond[tri, i, i]
                low1, low2 = dot(d, a1), dot(d, a2)
                d1, d2 = i11 * low1 + i12 * low2, i12 * low1 + i22 * low2
                up1, up2 = i11 * l1 + i12 * l2, i12 * l1 + i22 * l2
                c, s, away = SHARED / (1.0 + rho), dot(d, n), l1 * d1 + l2 * d2
                below, r = 1.0 / (1.0 + rho - away), s / (2.0 * rho - away)
                p1, p2, t = c * (n11 * l1 + n12 * l2), c * (n12 * l1 + n22 * l2), s * below
                p = (p1 * l1 + p2 * l2) / (1.0 + rho)
                raised, tipped, nodded = m * below + 2.0 * p * r, m * below * t + p * r * r, m * t * t + p * r * r * s
                tilt = plus(plus(scaled(raised, n), tipped * up1, a1), tipped * up2, a2)
                on_d = plus(plus(plus(tilt, -p1, a1), -p2, a2), p, d)
                h1 = plus(plus(plus(h1, -p1, d), nodded * up1, n), -d1, tilt)
                h2 = plus(plus(plus(h2, -p2, d), nodded * up2, n), -d2, tilt)
                f0 = plus(f0, -beyond[tri, i, 0], on_d)
                f1 = plus(f1, -beyond[tri, i, 1], on_d)
                f2 = plus(f2, -beyond[tri, i, 2], on_d)
                if image[tri, i] >= 0:
                    normal = planes[image[tri, i], 0], planes[image[tri, i], 1], planes[image[tri, i], 2]
                    on_d = plus(on_d, -2.0 * dot(normal, on_d), normal)
            force[tri, 3 + i, 0], force[tri, 3 + i, 1], force[tri, 3 + i, 2] = on_d
            force[tri, 6 + i, 0], force[tri, 6 + i, 1], force[tri, 6 + i, 2] = m * lever[tri, i], 0.0, 0.0
        f0 = plus(plus(f0, linear[tri, 0, 0], h1), linear[tri, 0, 1], h2)
        f1 = plus(plus(f1, linear[tri, 1, 0], h1), linear[tri, 1, 1], h2)
        f2 = plus(plus(f2, linear[tri, 2, 0], h1), linear[tri, 2, 1], h2)
        force[tri, 0, 0], force[tri, 0, 1], force[tri, 0, 2] = f0
        force[tri, 1, 0], force[tri, 1, 1], force[tri, 1, 2] = f1
        force[tri, 2, 0], force[tri, 2, 1], force[tri, 2, 2] = f2
