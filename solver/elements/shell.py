"""Shell triangle with translations only: mean-metric membrane, curvature from mid-side gradients, edge slopes
(theory_shell.md 3 to 5 and 8).

Symbols: x_I patch nodes, I = 0..5; L_I,a linear gradients (I < 3); G^i_aI mid-side gradients; nu^i outward normal of
side i and h_i its altitude; v = 11, 22, 2*12. g^i_a = G^i_aI x_I; n unit normal, a^c dual tangent vectors; E membrane
Green strain; kappa curvature change (a fibre at z > 0 along n stretches by z kappa); lam thickness ratio and A inverse
metric, both fixed over the increment; with Z = z lam the strain of a fibre is E(Z) = E + Z kappa + Z^2/2 c, c = k A k
the third fundamental form of the curvature k (kappa is k less its initial value, and c likewise), so that a section
bent to a circle has the strain ln(1 + Z k) exactly. J_vw = dc_v/dk_w. N, M resultants per unit initial length.

Curvature k_v = T_vi (r_i + phi_i), T_vi = -2/h_i (nu_1^2, nu_2^2, 2 nu_1 nu_2)^i, from the slopes of the sides:
r = s/f, s = g_nu . n, f = g_nu . a^nu, g_nu = nu_a g_a. Where the surface turns by theta between two equal triangles
r = tan(theta/2), which grows with any fold; s alone is sin(theta)/2, whose moment vanishes as the fold closes. For
small turns f = 1, and k_v = C_vI x_I . n of theory_shell.md 3.

Along a side both of its triangles have the same gradient, so that g^i_a = a_a + nu^i_a q^i with one vector q^i, the
change of the gradient across it, s = q . n and f = 1 + q . a^nu: strains and forces need no more, and stay scalars.
"""

from math import sqrt

import numpy as np
from numba import njit, prange

from .vectors import cross, dot, plus, scaled

DOFS = 21  # 6 patch nodes of 3 translations, 3 edge slopes


@njit(forceinline=True)
def patch_positions(u, slots, mirror, level, xp):
    """Fills xp (6, 3) with the current places of a triangle's nodes and of the apices across its sides."""
    for i in range(3):
        node, apex = slots[i], slots[3 + i]
        for c in range(3):
            xp[i, c] = u[node, c]
            xp[3 + i, c] = u[apex, c] if apex >= 0 else 0.0
        away = mirror[i, 0] * xp[3 + i, 0] + mirror[i, 1] * xp[3 + i, 1] + mirror[i, 2] * xp[3 + i, 2] - level[i]
        for c in range(3):
            xp[3 + i, c] -= 2.0 * mirror[i, c] * away


@njit(forceinline=True)
def surface_frame(xp, linear, dual, n):
    """Fills dual (2, 3), the dual tangent vectors a^c, and n (3,), the unit normal of one triangle."""
    a = np.empty((2, 3))
    for b in range(2):
        for c in range(3):
            a[b, c] = xp[0, c] * linear[0, b] + xp[1, c] * linear[1, b] + xp[2, c] * linear[2, b]
    for c in range(3):
        c1, c2 = (c + 1) % 3, (c + 2) % 3
        n[c] = a[0, c1] * a[1, c2] - a[0, c2] * a[1, c1]
    size = sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
    for c in range(3):
        n[c] /= size
    for c in range(3):
        c1, c2 = (c + 1) % 3, (c + 2) % 3
        dual[0, c] = (a[1, c1] * n[c2] - a[1, c2] * n[c1]) / size
        dual[1, c] = (n[c1] * a[0, c2] - n[c2] * a[0, c1]) / size


@njit(forceinline=True)
def mid_side_operators(linear, change, side, gradient):
    """Fills gradient (3, 2, 6): G^i_aI of one triangle."""
    for i in range(3):
        for a in range(2):
            for k in range(3):
                gradient[i, a, k] = linear[k, a] + side[i, a] * change[i, k]
                gradient[i, a, 3 + k] = 0.0
            gradient[i, a, 3 + i] = side[i, a] * change[i, 3]


@njit(forceinline=True)
def side_gradients(xp, gradient, g):
    """Fills g (3, 2, 3): mid-side gradients g^i_a of one triangle."""
    for i in range(3):
        for a in range(2):
            for c in range(3):
                total = gradient[i, a, 3 + i] * xp[3 + i, c]
                for k in range(3):
                    total += gradient[i, a, k] * xp[k, c]
                g[i, a, c] = total


@njit(forceinline=True)
def side_slope(g, side, dual, n, away):
    """Slope tan(theta/2) of the surface across a side, from the plane of the triangle with the duals a^c and normal n.

    g : (2, 3) mid-side gradient; side : (2,) outward normal nu; fills away (3,) = g_nu. Returns s = g_nu . n and
    f = g_nu . a^nu; the slope is s/f.
    """
    s = f = 0.0
    for c in range(3):
        away[c] = side[0] * g[0, c] + side[1] * g[1, c]
        s += away[c] * n[c]
        f += away[c] * (side[0] * dual[0, c] + side[1] * dual[1, c])
    return s, f


@njit(forceinline=True)
def node_place(u, slots, tri, k):
    """Place of a node of a triangle."""
    node = slots[tri, k]
    return u[node, 0], u[node, 1], u[node, 2]


@njit(forceinline=True)
def is_mirrored(slots, tri, i):
    """Whether a side sees the image of the triangle's own node."""
    return slots[tri, 3 + i] == slots[tri, i]


@njit(forceinline=True)
def apex_place(u, slots, mirror, level, tri, i):
    """Place of the apex across a side; 0 across a free one."""
    if slots[tri, 3 + i] < 0:
        return 0.0, 0.0, 0.0
    x = node_place(u, slots, tri, 3 + i)
    if not is_mirrored(slots, tri, i):
        return x
    m = (mirror[tri, i, 0], mirror[tri, i, 1], mirror[tri, i, 2])
    return plus(x, -2.0 * (dot(m, x) - level[tri, i]), m)


@njit(forceinline=True)
def tangent_vectors(x0, x1, x2, linear, tri):
    """a_1 and a_2 of a triangle with nodes at x0, x1, x2."""
    a1 = plus(plus(scaled(linear[tri, 0, 0], x0), linear[tri, 1, 0], x1), linear[tri, 2, 0], x2)
    a2 = plus(plus(scaled(linear[tri, 0, 1], x0), linear[tri, 1, 1], x1), linear[tri, 2, 1], x2)
    return a1, a2


@njit(forceinline=True)
def side_change(x0, x1, x2, apex, change, tri, i):
    """q of a side, from the triangle's nodes and the apex across."""
    own = plus(plus(scaled(change[tri, i, 0], x0), change[tri, i, 1], x1), change[tri, i, 2], x2)
    return plus(own, change[tri, i, 3], apex)


@njit(forceinline=True)
def inverse_and_normal(a1, a2):
    """A11, A22, A12 of the inverse metric, and the unit normal."""
    across = cross(a1, a2)
    d = 1.0 / dot(across, across)
    return dot(a2, a2) * d, dot(a1, a1) * d, -dot(a1, a2) * d, scaled(sqrt(d), across)


@njit(parallel=True, cache=True, error_model="numpy")
def shell_strains(u, slots, linear, change, side, turn, edge, mirror, level, metric, kappa):
    """Mean metric and curvature of every triangle.

    u : (n + k, 3) node places, then edge slopes in the first column
    fills metric (m, 3) = C11 C22 C12 and kappa (m, 3) = [11, 22, 2*12] [1/mm]
    """
    for tri in prange(slots.shape[0]):
        x0, x1, x2 = node_place(u, slots, tri, 0), node_place(u, slots, tri, 1), node_place(u, slots, tri, 2)
        a1, a2 = tangent_vectors(x0, x1, x2, linear, tri)
        i11, i22, i12, n = inverse_and_normal(a1, a2)
        m11 = m22 = m12 = k11 = k22 = k12 = 0.0
        for i in range(3):
            q = side_change(x0, x1, x2, apex_place(u, slots, mirror, level, tri, i), change, tri, i)
            n1, n2 = side[tri, i, 0], side[tri, i, 1]
            q1, q2, qq = dot(q, a1), dot(q, a2), dot(q, q)
            m11 += 2.0 * n1 * q1 + n1 * n1 * qq
            m22 += 2.0 * n2 * q2 + n2 * n2 * qq
            m12 += n1 * q2 + n2 * q1 + n1 * n2 * qq
            r = dot(q, n) / (1.0 + n1 * (i11 * q1 + i12 * q2) + n2 * (i12 * q1 + i22 * q2))
            slope = slots[tri, 6 + i]
            phi = u[slope, 0] if slope >= 0 else 0.0
            k11 += turn[tri, 0, i] * r + edge[tri, 0, i] * phi
            k22 += turn[tri, 1, i] * r + edge[tri, 1, i] * phi
            k12 += turn[tri, 2, i] * r + edge[tri, 2, i] * phi
        metric[tri, 0] = dot(a1, a1) + m11 / 3.0
        metric[tri, 1] = dot(a2, a2) + m22 / 3.0
        metric[tri, 2] = dot(a1, a2) + m12 / 3.0
        kappa[tri, 0], kappa[tri, 1], kappa[tri, 2] = k11, k22, k12


@njit(forceinline=True)
def mixed(k1, k2, k3, a11, a22, a12):
    """A k as 11, 12, 21, 22, from a curvature [11, 22, 2*12] and an inverse metric A."""
    k12 = 0.5 * k3
    return a11 * k1 + a12 * k12, a11 * k12 + a12 * k2, a12 * k1 + a22 * k12, a12 * k12 + a22 * k2


@njit(forceinline=True)
def third_form(k1, k2, k3, a11, a22, a12):
    """[c11, c22, 2 c12] of c = k A k, k = [11, 22, 2*12]."""
    b11, b12, b21, b22 = mixed(k1, k2, k3, a11, a22, a12)
    return k1 * b11 + 0.5 * k3 * b21, 0.5 * k3 * b12 + k2 * b22, 2.0 * k1 * b12 + k3 * b22


@njit(forceinline=True)
def third_form_slope(k, a, j):
    """Fills j (3, 3) = dc_v/dk_w. k : (3,) [11, 22, 2*12]; a : (3,) A11, A22, A12"""
    b11, b12, b21, b22 = mixed(k[0], k[1], k[2], a[0], a[1], a[2])
    j[0, 0], j[0, 1], j[0, 2] = 2.0 * b11, 0.0, b21
    j[1, 0], j[1, 1], j[1, 2] = 0.0, 2.0 * b22, b12
    j[2, 0], j[2, 1], j[2, 2] = 2.0 * b12, 2.0 * b21, b11 + b22


@njit(parallel=True, cache=True)
def third_forms(kappa, inverse, form):
    """Fills form (m, 3) = c of every triangle. kappa : (m, 3); inverse : (m, 3) A11 A22 A12"""
    for tri in prange(kappa.shape[0]):
        form[tri, 0], form[tri, 1], form[tri, 2] = third_form(
            kappa[tri, 0], kappa[tri, 1], kappa[tri, 2], inverse[tri, 0], inverse[tri, 1], inverse[tri, 2]
        )


@njit(parallel=True, cache=True, error_model="numpy")
def layer_metrics(metric, kappa, metric0, kappa0, form0, inverse, height, stretch, layers):
    """Fills layers (m n_layers, 3): the metric C11 C22 C12 of each layer, relative to the initial shape.

    metric, kappa : (m, 3) now; metric0, kappa0, form0 : (m, 3) initially; inverse : (m, 3) A11 A22 A12;
    height : (n_layers,) above the mid-surface in the initial thickness [mm]; stretch : (m,) thickness ratio
    """
    n_layers = height.shape[0]
    for tri in prange(metric.shape[0]):
        k1, k2, k3 = kappa[tri, 0], kappa[tri, 1], kappa[tri, 2]
        c1, c2, c3 = third_form(k1, k2, k3, inverse[tri, 0], inverse[tri, 1], inverse[tri, 2])
        # Twice the strain is in the metric, but the metric's shear is half of the strain's.
        flat1, flat2 = 1.0 + metric[tri, 0] - metric0[tri, 0], 1.0 + metric[tri, 1] - metric0[tri, 1]
        flat3 = metric[tri, 2] - metric0[tri, 2]
        bend1, bend2, bend3 = 2.0 * (k1 - kappa0[tri, 0]), 2.0 * (k2 - kappa0[tri, 1]), k3 - kappa0[tri, 2]
        curl1, curl2, curl3 = c1 - form0[tri, 0], c2 - form0[tri, 1], 0.5 * (c3 - form0[tri, 2])
        for layer in range(n_layers):
            z = height[layer] * stretch[tri]
            p = tri * n_layers + layer
            layers[p, 0] = flat1 + z * (bend1 + z * curl1)
            layers[p, 1] = flat2 + z * (bend2 + z * curl2)
            layers[p, 2] = flat3 + z * (bend3 + z * curl3)


@njit(parallel=True, cache=True, error_model="numpy")
def resultants(s, kappa, inverse, height, weight, stretch, thickness, result):
    """Fills result (m, 6): normal forces N and moments M per unit initial length [N/mm, N].

    s : (m n_layers, 3) second Piola-Kirchhoff stress; weight : (n_layers,), sums to 1
    """
    n_layers = height.shape[0]
    for tri in prange(result.shape[0]):
        force1 = force2 = force3 = moment1 = moment2 = moment3 = second1 = second2 = second3 = 0.0
        for layer in range(n_layers):
            w, z, p = weight[layer] * thickness, height[layer] * stretch[tri], tri * n_layers + layer
            s1, s2, s3 = w * s[p, 0], w * s[p, 1], w * s[p, 2]
            force1, force2, force3 = force1 + s1, force2 + s2, force3 + s3
            s1, s2, s3 = z * s1, z * s2, z * s3
            moment1, moment2, moment3 = moment1 + s1, moment2 + s2, moment3 + s3
            second1, second2, second3 = second1 + z * s1, second2 + z * s2, second3 + z * s3
        b11, b12, b21, b22 = mixed(
            kappa[tri, 0], kappa[tri, 1], kappa[tri, 2], inverse[tri, 0], inverse[tri, 1], inverse[tri, 2]
        )
        result[tri, 0], result[tri, 1], result[tri, 2] = force1, force2, force3
        result[tri, 3] = moment1 + second1 * b11 + second3 * b12
        result[tri, 4] = moment2 + second2 * b22 + second3 * b21
        result[tri, 5] = moment3 + 0.5 * (second1 * b21 + second2 * b12 + second3 * (b11 + b22))


@njit(forceinline=True)
def slope_variation(i, g, side, gradient, linear, dual, n, away, dr):
    """Fills dr (4, 3): derivative of the slope s/f of side i with respect to the triangle's nodes and the apex across.
    Returns s and f."""
    s, f = side_slope(g, side, dual, n, away)
    r = s / f
    b1 = b2 = d1 = d2 = 0.0
    for c in range(3):
        b1 += away[c] * dual[0, c]
        b2 += away[c] * dual[1, c]
        up = side[0] * dual[0, c] + side[1] * dual[1, c]
        d1 += up * dual[0, c]
        d2 += up * dual[1, c]
    for k in range(4):
        patch = k if k < 3 else 3 + i
        g_k = side[0] * gradient[0, patch] + side[1] * gradient[1, patch]
        turned = lifted = 0.0
        if k < 3:
            turned = b1 * linear[k, 0] + b2 * linear[k, 1]
            lifted = d1 * linear[k, 0] + d2 * linear[k, 1]
        for c in range(3):
            up = side[0] * dual[0, c] + side[1] * dual[1, c]
            dr[k, c] = ((g_k - turned - r * s * lifted) * n[c] - r * (g_k - turned) * up) / f
    return s, f


@njit(forceinline=True)
def slope_second(i, side, gradient, linear, dual, n, away, r, f, dr, steps, hessian):
    """Fills hessian (12, 12): second derivative of a side's slope r = s/f; dr : (4, 3) its first.

    With b_c = g.a^c, up = a^nu: d2r = (d2s - r d2f - dr df - df dr)/f,
    d2s = 2 dg.dn - s dn.dn - 2 b_c dn.da_c, d2f = 2 dg.dup - 2 b_c dup.da_c + s (2 a^{nu c} dn.da_c - 2 dup.dn), with
    n.d2n = -dn.dn and a_c.d2n = -2 dn.da_c from n.n = 1 and n.a_c = 0, and likewise for the dual vectors.
    steps : (3, 3, 12) room for dn, d(up) and dg - b_c da_c, up = a^nu
    """
    dn, dup, dg = steps[0], steps[1], steps[2]
    b1 = b2 = d1 = d2 = 0.0
    s = r * f
    for c in range(3):
        b1 += away[c] * dual[0, c]
        b2 += away[c] * dual[1, c]
        up = side[0] * dual[0, c] + side[1] * dual[1, c]
        d1 += up * dual[0, c]
        d2 += up * dual[1, c]
    for k in range(4):
        patch = k if k < 3 else 3 + i
        l1, l2 = (linear[k, 0], linear[k, 1]) if k < 3 else (0.0, 0.0)
        free = side[0] * gradient[0, patch] + side[1] * gradient[1, patch] - b1 * l1 - b2 * l2
        for e in range(3):
            up_e = side[0] * dual[0, e] + side[1] * dual[1, e]
            for c in range(3):
                tilt = dual[0, c] * l1 + dual[1, c] * l2
                dn[c, 3 * k + e] = -tilt * n[e]
                dup[c, 3 * k + e] = -tilt * up_e + (d1 * l1 + d2 * l2) * n[c] * n[e]
                dg[c, 3 * k + e] = free if c == e else 0.0
    for p in range(12):
        kp, ep = p // 3, p % 3
        lift_p = d1 * linear[kp, 0] + d2 * linear[kp, 1] if kp < 3 else 0.0
        for q in range(p, 12):
            kq, eq = q // 3, q % 3
            lift_q = d1 * linear[kq, 0] + d2 * linear[kq, 1] if kq < 3 else 0.0
            second_s = second_f = 0.0
            for c in range(3):
                second_s += dg[c, p] * dn[c, q] + dg[c, q] * dn[c, p] - s * dn[c, p] * dn[c, q]
                second_f += dg[c, p] * dup[c, q] + dg[c, q] * dup[c, p]
                second_f -= s * (dup[c, p] * dn[c, q] + dup[c, q] * dn[c, p])
            second_f += s * (dn[eq, p] * lift_q + dn[ep, q] * lift_p)
            hessian[p, q] = second_s - r * second_f
    # First derivative of f.
    df = np.empty(12)
    for k in range(4):
        l1, l2 = (linear[k, 0], linear[k, 1]) if k < 3 else (0.0, 0.0)
        for e in range(3):
            up_e = side[0] * dual[0, e] + side[1] * dual[1, e]
            df[3 * k + e] = dg[e, 3 * k + e] * up_e + s * (d1 * l1 + d2 * l2) * n[e]
    for p in range(12):
        for q in range(p, 12):
            cross = dr[p // 3, p % 3] * df[q] + dr[q // 3, q % 3] * df[p]
            hessian[p, q] = (hessian[p, q] - cross) / f


@njit(parallel=True, cache=True, error_model="numpy")
def shell_forces(u, slots, linear, area, change, side, turn, edge, mirror, level, result, force):
    """Fills force (m, 9, 3): forces of every triangle on its slots [N]; of an edge slope the first column.

    result : (m, 6) resultants. With p_a = N_ab nu_b/3 and m = M_v T_v/f of a side, the force on its q is
    p_a g_a + m (n - r a^nu), and on a_a p_a q - m (q^a + r s A^a_nu) n + m r q^a a^nu, q^a = q . a^a.
    """
    for tri in prange(slots.shape[0]):
        x0, x1, x2 = node_place(u, slots, tri, 0), node_place(u, slots, tri, 1), node_place(u, slots, tri, 2)
        a1, a2 = tangent_vectors(x0, x1, x2, linear, tri)
        i11, i22, i12, n = inverse_and_normal(a1, a2)
        size = area[tri]
        n11, n22, n12 = size * result[tri, 0], size * result[tri, 1], size * result[tri, 2]
        m11, m22, m12 = size * result[tri, 3], size * result[tri, 4], size * result[tri, 5]
        # Forces on a_1, a_2, and on the nodes through q.
        h1, h2 = plus(scaled(n11, a1), n12, a2), plus(scaled(n12, a1), n22, a2)
        f0 = f1 = f2 = (0.0, 0.0, 0.0)
        for i in range(3):
            q = side_change(x0, x1, x2, apex_place(u, slots, mirror, level, tri, i), change, tri, i)
            nu1, nu2 = side[tri, i, 0], side[tri, i, 1]
            low1, low2 = dot(q, a1), dot(q, a2)
            q1, q2 = i11 * low1 + i12 * low2, i12 * low1 + i22 * low2
            up1, up2 = i11 * nu1 + i12 * nu2, i12 * nu1 + i22 * nu2
            up = plus(scaled(up1, a1), up2, a2)
            s, f = dot(q, n), 1.0 + nu1 * q1 + nu2 * q2
            r, m = s / f, (m11 * turn[tri, 0, i] + m22 * turn[tri, 1, i] + m12 * turn[tri, 2, i]) / f
            p1, p2 = (n11 * nu1 + n12 * nu2) / 3.0, (n12 * nu1 + n22 * nu2) / 3.0
            on_q = plus(plus(plus(scaled(p1, a1), p2, a2), p1 * nu1 + p2 * nu2, q), m, plus(n, -r, up))
            h1 = plus(plus(plus(h1, p1, q), -m * (q1 + r * s * up1), n), m * r * q1, up)
            h2 = plus(plus(plus(h2, p2, q), -m * (q2 + r * s * up2), n), m * r * q2, up)
            f0, f1, f2 = (
                plus(f0, change[tri, i, 0], on_q),
                plus(f1, change[tri, i, 1], on_q),
                plus(f2, change[tri, i, 2], on_q),
            )
            across = scaled(change[tri, i, 3], on_q)
            if is_mirrored(slots, tri, i):
                normal = (mirror[tri, i, 0], mirror[tri, i, 1], mirror[tri, i, 2])
                across = plus(across, -2.0 * dot(normal, across), normal)
            force[tri, 3 + i, 0], force[tri, 3 + i, 1], force[tri, 3 + i, 2] = across
            force[tri, 6 + i, 0] = m11 * edge[tri, 0, i] + m22 * edge[tri, 1, i] + m12 * edge[tri, 2, i]
            force[tri, 6 + i, 1] = force[tri, 6 + i, 2] = 0.0
        f0 = plus(plus(f0, linear[tri, 0, 0], h1), linear[tri, 0, 1], h2)
        f1 = plus(plus(f1, linear[tri, 1, 0], h1), linear[tri, 1, 1], h2)
        f2 = plus(plus(f2, linear[tri, 2, 0], h1), linear[tri, 2, 1], h2)
        force[tri, 0, 0], force[tri, 0, 1], force[tri, 0, 2] = f0
        force[tri, 1, 0], force[tri, 1, 1], force[tri, 1, 2] = f1
        force[tri, 2, 0], force[tri, 2, 1], force[tri, 2, 2] = f2


@njit(forceinline=True)
def section_stiffness(s, ds_de, first, k, a, height, weight, stretch, thickness, d):
    """Fills d (6, 6): derivative of the resultants with respect to [E, kappa] of one triangle."""
    j, lever, through = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    s1 = s2 = s3 = 0.0
    third_form_slope(k, a, j)
    for v in range(6):
        for w in range(6):
            d[v, w] = 0.0
    for layer in range(height.shape[0]):
        wt = weight[layer] * thickness
        z = height[layer] * stretch
        c = ds_de[first + layer]
        s1 += 0.5 * z * z * wt * s[first + layer, 0]
        s2 += 0.5 * z * z * wt * s[first + layer, 1]
        s3 += 0.5 * z * z * wt * s[first + layer, 2]
        for v in range(3):
            for w in range(3):
                lever[v, w] = 0.5 * z * z * j[v, w]
            lever[v, v] += z
        for v in range(3):
            for w in range(3):
                d[v, w] += wt * c[v, w]
                total = c[v, 0] * lever[0, w] + c[v, 1] * lever[1, w] + c[v, 2] * lever[2, w]
                through[v, w] = wt * total
                d[v, 3 + w] += through[v, w]
        for v in range(3):
            for w in range(3):
                total = lever[0, v] * through[0, w] + lever[1, v] * through[1, w] + lever[2, v] * through[2, w]
                d[3 + v, 3 + w] += total
    # The third form's second derivative.
    d[3, 3] += 2.0 * s1 * a[0]
    d[4, 4] += 2.0 * s2 * a[1]
    d[5, 5] += 0.5 * (s1 * a[1] + s2 * a[0]) + s3 * a[2]
    d[3, 4] += 2.0 * s3 * a[2]
    d[3, 5] += s1 * a[2] + s3 * a[0]
    d[4, 5] += s2 * a[2] + s3 * a[1]
    d[4, 3], d[5, 3], d[5, 4] = d[3, 4], d[3, 5], d[4, 5]
    for v in range(3):
        for w in range(3):
            d[3 + v, w] = d[w, 3 + v]


@njit(parallel=True, cache=True)
def shell_stiffnesses(
    u, slots, linear, area, change, side, turn, edge, mirror, level, kappa, inverse, result, s, ds_de, height, weight,
    stretch, thickness, stiffness,
):  # fmt: skip
    """Fills stiffness (m, 21, 21): derivative of the forces [N/mm]; unknowns 3 I + c for patch node I, 18 + i for the
    slope of side i.

    kappa, inverse : (m, 3); result : (m, 6); s : (m n_layers, 3); ds_de : (m n_layers, 3, 3) derivative of S with
    respect to [E11, E22, 2 E12]
    """
    n_layers = height.shape[0]
    for tri in prange(slots.shape[0]):
        xp, g, away = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        dual, n, dr = np.empty((2, 3)), np.empty(3), np.empty((3, 4, 3))
        hessian, steps = np.empty((12, 12)), np.empty((3, 3, 12))
        slope, f = np.empty(3), np.empty(3)
        d, b, db = np.empty((6, 6)), np.zeros((6, 21)), np.empty((6, 21))
        lin, grad, k_tri = linear[tri], np.empty((3, 2, 6)), stiffness[tri]
        mid_side_operators(lin, change[tri], side[tri], grad)
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, lin, dual, n)
        side_gradients(xp, grad, g)
        section_stiffness(
            s, ds_de, tri * n_layers, kappa[tri], inverse[tri], height, weight, stretch[tri], thickness, d
        )
        r = result[tri]
        # Strains from the unknowns.
        for i in range(3):
            for a in range(4):
                k = a if a < 3 else 3 + i
                g1, g2 = grad[i, 0, k] / 3.0, grad[i, 1, k] / 3.0
                for c in range(3):
                    b[0, 3 * k + c] += g1 * g[i, 0, c]
                    b[1, 3 * k + c] += g2 * g[i, 1, c]
                    b[2, 3 * k + c] += g1 * g[i, 1, c] + g2 * g[i, 0, c]
            for v in range(3):
                b[3 + v, 18 + i] = edge[tri, v, i]
        for i in range(3):
            s_i, f[i] = slope_variation(i, g[i], side[tri, i], grad[i], lin, dual, n, away[i], dr[i])
            slope[i] = s_i / f[i]
            for a in range(4):
                k = a if a < 3 else 3 + i
                for v in range(3):
                    for c in range(3):
                        b[3 + v, 3 * k + c] += turn[tri, v, i] * dr[i, a, c]
        for v in range(6):
            for p in range(DOFS):
                total = 0.0
                for w in range(6):
                    total += d[v, w] * b[w, p]
                db[v, p] = area[tri] * total
        for p in range(DOFS):
            for q in range(p, DOFS):
                total = 0.0
                for v in range(6):
                    total += b[v, p] * db[v, q]
                k_tri[p, q] = total
        # Turning normal forces.
        for p in range(6):
            for q in range(p, 6):
                turning = 0.0
                for i in range(3):
                    g1p, g2p, g1q, g2q = grad[i, 0, p], grad[i, 1, p], grad[i, 0, q], grad[i, 1, q]
                    turning += r[0] * g1p * g1q + r[1] * g2p * g2q + r[2] * (g1p * g2q + g2p * g1q)
                for c in range(3):
                    k_tri[3 * p + c, 3 * q + c] += area[tri] / 3.0 * turning
        # Turning moments.
        for i in range(3):
            moment = r[3] * turn[tri, 0, i] + r[4] * turn[tri, 1, i] + r[5] * turn[tri, 2, i]
            slope_second(i, side[tri, i], grad[i], lin, dual, n, away[i], slope[i], f[i], dr[i], steps, hessian)
            for p in range(12):
                to = p if p < 9 else 9 + 3 * i + p - 9
                for q in range(p, 12):
                    on = q if q < 9 else 9 + 3 * i + q - 9
                    k_tri[to, on] += area[tri] * moment * hessian[p, q]
        for p in range(DOFS):
            for q in range(p):
                k_tri[p, q] = k_tri[q, p]
        # A mirror image moves as its original, reflected.
        for i in range(3):
            n1, n2, n3 = mirror[tri, i]
            if n1 != 0.0 or n2 != 0.0 or n3 != 0.0:
                o = 9 + 3 * i
                for p in range(DOFS):
                    back = 2.0 * (n1 * k_tri[o, p] + n2 * k_tri[o + 1, p] + n3 * k_tri[o + 2, p])
                    k_tri[o, p] -= back * n1
                    k_tri[o + 1, p] -= back * n2
                    k_tri[o + 2, p] -= back * n3
                for p in range(DOFS):
                    back = 2.0 * (n1 * k_tri[p, o] + n2 * k_tri[p, o + 1] + n3 * k_tri[p, o + 2])
                    k_tri[p, o] -= back * n1
                    k_tri[p, o + 1] -= back * n2
                    k_tri[p, o + 2] -= back * n3
