"""Shell triangle with translations only: metric shared with the neighbours, curvature from the turns across the sides,
edge slopes (theory_shell.md 3 to 5 and 8).

Symbols: x_I patch nodes, I = 0..5; L_I,a linear gradients (I < 3); G^i_aI those of the triangle across side i,
unfolded; nu^i outward normal of side i, h_i its altitude and h'_i that of the triangle across; v = 11, 22, 2*12.
a_c = L_I,c x_I and g^i_a = G^i_aI x_I tangent vectors here and across; n unit normal, a^c dual tangents; E membrane
Green strain; kappa curvature change (a fibre at z > 0 along n stretches by z kappa); lam thickness ratio and A inverse
metric, both fixed over the increment; with Z = z lam the strain of a fibre is E(Z) = E + Z kappa + Z^2/2 c, c = k A k
the third fundamental form of the curvature k (kappa is k less its initial value, and c likewise), so that a section
bent to a circle has the strain ln(1 + Z k) exactly. J_vw = dc_v/dk_w. N, M resultants per unit initial length.

Metric C_ab = w a_a.a_b + sum_i w_i g^i_a.g^i_b: a weighted mean of the metrics of four flat triangles. In the plane
it is the mean of the mid-side strains of theory_shell.md 3 with a part of the triangle's own, but folding about the
sides does not change it. (The metric of the mean gradient at a side is smaller than the mean of the two metrics by
sin(theta/2)^2 where the surface turns by theta: coarse curved meshes locked.)

Curvature k_v = T_vi (r_i + phi_i), T_vi = -2/h_i (nu_1^2, nu_2^2, 2 nu_1 nu_2)^i, from the slopes of the sides:
r = s/f, s = g_nu . n, f = h/h' + g_nu . a^nu, g_nu = nu_a g_a. Where the surface turns by theta between two equal
triangles r = tan(theta/2), which grows with any fold; sin(theta)/2 has a moment that vanishes as the fold closes. For
small turns k_v = C_vI x_I . n of theory_shell.md 3.
"""

from math import sqrt

import numpy as np
from numba import njit, prange

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
def surface_frame(xp, linear, a, dual, n):
    """Fills a (2, 3), the tangent vectors of one triangle, dual (2, 3), the dual ones, and n (3,), its unit normal."""
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
def side_gradients(xp, gradient, g):
    """Fills g (3, 2, 3): gradients g^i_a of the triangles across the sides."""
    for i in range(3):
        for a in range(2):
            for c in range(3):
                total = gradient[i, a, 3 + i] * xp[3 + i, c]
                for k in range(3):
                    total += gradient[i, a, k] * xp[k, c]
                g[i, a, c] = total


@njit(forceinline=True)
def side_slope(g, side, ratio, dual, n, away):
    """Slope tan(theta/2) of the surface across a side, from the plane of the triangle with the duals a^c and normal n.

    g : (2, 3) gradient across; side : (2,) outward normal nu; ratio : h/h'; fills away (3,) = g_nu. Returns
    s = g_nu . n and f = h/h' + g_nu . a^nu; the slope is s/f.
    """
    s, f = 0.0, ratio
    for c in range(3):
        away[c] = side[0] * g[0, c] + side[1] * g[1, c]
        s += away[c] * n[c]
        f += away[c] * (side[0] * dual[0, c] + side[1] * dual[1, c])
    return s, f


@njit(parallel=True, cache=True)
def shell_strains(u, slots, linear, gradient, share, side, ratio, turn, edge, mirror, level, metric, kappa):
    """Mean metric and curvature of every triangle.

    u : (n + k, 3) node places, then edge slopes in the first column
    fills metric (m, 3) = C11 C22 C12 and kappa (m, 3) = [11, 22, 2*12] [1/mm]
    """
    for tri in prange(slots.shape[0]):
        xp, g, away = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        own, dual, n = np.empty((2, 3)), np.empty((2, 3)), np.empty(3)
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, linear[tri], own, dual, n)
        side_gradients(xp, gradient[tri], g)
        m11 = m22 = m12 = 0.0
        for i in range(4):
            a = g[i] if i < 3 else own
            for c in range(3):
                m11 += share[tri, i] * a[0, c] * a[0, c]
                m22 += share[tri, i] * a[1, c] * a[1, c]
                m12 += share[tri, i] * a[0, c] * a[1, c]
        metric[tri, 0], metric[tri, 1], metric[tri, 2] = m11, m22, m12
        for v in range(3):
            kappa[tri, v] = 0.0
        for i in range(3):
            s, f = side_slope(g[i], side[tri, i], ratio[tri, i], dual, n, away[0])
            slope = slots[tri, 6 + i]
            for v in range(3):
                kappa[tri, v] += turn[tri, v, i] * s / f
                if slope >= 0:
                    kappa[tri, v] += edge[tri, v, i] * u[slope, 0]


@njit(forceinline=True)
def third_form(k, a, c):
    """Fills c (3,) = [c11, c22, 2 c12] of c = k A k. k : (3,) [11, 22, 2*12]; a : (3,) A11, A22, A12"""
    k12 = 0.5 * k[2]
    c[0] = k[0] * k[0] * a[0] + 2.0 * k[0] * k12 * a[2] + k12 * k12 * a[1]
    c[1] = k12 * k12 * a[0] + 2.0 * k12 * k[1] * a[2] + k[1] * k[1] * a[1]
    c[2] = 2.0 * (k[0] * k12 * a[0] + (k[0] * k[1] + k12 * k12) * a[2] + k12 * k[1] * a[1])


@njit(forceinline=True)
def third_form_slope(k, a, j):
    """Fills j (3, 3) = dc_v/dk_w."""
    k12 = 0.5 * k[2]
    j[0, 0], j[0, 1], j[0, 2] = 2.0 * (k[0] * a[0] + k12 * a[2]), 0.0, k[0] * a[2] + k12 * a[1]
    j[1, 0], j[1, 1], j[1, 2] = 0.0, 2.0 * (k12 * a[2] + k[1] * a[1]), k12 * a[0] + k[1] * a[2]
    j[2, 0], j[2, 1] = 2.0 * (k12 * a[0] + k[1] * a[2]), 2.0 * (k[0] * a[2] + k12 * a[1])
    j[2, 2] = k[0] * a[0] + 2.0 * k12 * a[2] + k[1] * a[1]


@njit(parallel=True, cache=True)
def third_forms(kappa, inverse, form):
    """Fills form (m, 3) = c of every triangle. kappa : (m, 3); inverse : (m, 3) A11 A22 A12"""
    for tri in prange(kappa.shape[0]):
        third_form(kappa[tri], inverse[tri], form[tri])


@njit(parallel=True, cache=True)
def layer_metrics(metric, kappa, metric0, kappa0, form0, inverse, height, stretch, layers):
    """Fills layers (m n_layers, 3): the metric C11 C22 C12 of each layer, relative to the initial shape.

    metric, kappa : (m, 3) now; metric0, kappa0, form0 : (m, 3) initially; inverse : (m, 3) A11 A22 A12;
    height : (n_layers,) above the mid-surface in the initial thickness [mm]; stretch : (m,) thickness ratio
    """
    n_layers = height.shape[0]
    for tri in prange(metric.shape[0]):
        c = np.empty(3)
        third_form(kappa[tri], inverse[tri], c)
        for v in range(3):
            start = 1.0 if v < 2 else 0.0
            twice = 2.0 if v < 2 else 1.0  # of the strain in the metric
            flat = start + metric[tri, v] - metric0[tri, v]
            bend, curl = twice * (kappa[tri, v] - kappa0[tri, v]), 0.5 * twice * (c[v] - form0[tri, v])
            for layer in range(n_layers):
                z = height[layer] * stretch[tri]
                layers[tri * n_layers + layer, v] = flat + z * bend + z * z * curl


@njit(parallel=True, cache=True)
def resultants(s, kappa, inverse, height, weight, stretch, thickness, result):
    """Fills result (m, 6): normal forces N and moments M per unit initial length [N/mm, N].

    s : (m n_layers, 3) second Piola-Kirchhoff stress; weight : (n_layers,), sums to 1
    """
    n_layers = height.shape[0]
    for tri in prange(result.shape[0]):
        j, second = np.empty((3, 3)), np.zeros(3)
        for v in range(6):
            result[tri, v] = 0.0
        for layer in range(n_layers):
            w = weight[layer] * thickness
            z = height[layer] * stretch[tri]
            for v in range(3):
                stress = w * s[tri * n_layers + layer, v]
                result[tri, v] += stress
                result[tri, 3 + v] += z * stress
                second[v] += 0.5 * z * z * stress
        third_form_slope(kappa[tri], inverse[tri], j)
        for w in range(3):
            result[tri, 3 + w] += second[0] * j[0, w] + second[1] * j[1, w] + second[2] * j[2, w]


@njit(forceinline=True)
def slope_variation(i, g, side, ratio, gradient, linear, dual, n, away, dr):
    """Fills dr (4, 3): derivative of the slope s/f of side i with respect to the triangle's nodes and the apex across.
    Returns s and f."""
    s, f = side_slope(g, side, ratio, dual, n, away)
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


@njit(parallel=True, cache=True)
def shell_forces(
    u, slots, linear, area, gradient, share, side, ratio, turn, edge, mirror, level, result, force,
):  # fmt: skip
    """Fills force (m, 9, 3): forces of every triangle on its slots [N]; of an edge slope the first column.

    result : (m, 6) resultants
    """
    for tri in prange(slots.shape[0]):
        xp, g, away = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        own, dual, n, dr = np.empty((2, 3)), np.empty((2, 3)), np.empty(3), np.empty((4, 3))
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, linear[tri], own, dual, n)
        side_gradients(xp, gradient[tri], g)
        r = result[tri]
        for k in range(3):
            part = area[tri] * share[tri, 3]
            w1 = part * (r[0] * linear[tri, k, 0] + r[2] * linear[tri, k, 1])
            w2 = part * (r[1] * linear[tri, k, 1] + r[2] * linear[tri, k, 0])
            for c in range(3):
                force[tri, k, c] = w1 * own[0, c] + w2 * own[1, c]
                force[tri, 3 + k, c] = 0.0
        for i in range(3):
            slope_variation(i, g[i], side[tri, i], ratio[tri, i], gradient[tri, i], linear[tri], dual, n, away[0], dr)
            part = area[tri] * share[tri, i]
            moment = r[3] * turn[tri, 0, i] + r[4] * turn[tri, 1, i] + r[5] * turn[tri, 2, i]
            for a in range(4):
                k = a if a < 3 else 3 + i
                for c in range(3):
                    force[tri, k, c] += area[tri] * moment * dr[a, c]
                w1 = part * (r[0] * gradient[tri, i, 0, k] + r[2] * gradient[tri, i, 1, k])
                w2 = part * (r[1] * gradient[tri, i, 1, k] + r[2] * gradient[tri, i, 0, k])
                for c in range(3):
                    force[tri, k, c] += w1 * g[i, 0, c] + w2 * g[i, 1, c]
        for i in range(3):
            back = 0.0
            for c in range(3):
                back += mirror[tri, i, c] * force[tri, 3 + i, c]
            for c in range(3):
                force[tri, 3 + i, c] -= 2.0 * back * mirror[tri, i, c]
                force[tri, 6 + i, c] = 0.0
            for v in range(3):
                force[tri, 6 + i, 0] += area[tri] * edge[tri, v, i] * r[3 + v]


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
    u, slots, linear, area, gradient, share, side, ratio, turn, edge, mirror, level, kappa, inverse, result, s, ds_de,
    height, weight, stretch, thickness, stiffness,
):  # fmt: skip
    """Fills stiffness (m, 21, 21): derivative of the forces [N/mm]; unknowns 3 I + c for patch node I, 18 + i for the
    slope of side i.

    kappa, inverse : (m, 3); result : (m, 6); s : (m n_layers, 3); ds_de : (m n_layers, 3, 3) derivative of S with
    respect to [E11, E22, 2 E12]
    """
    n_layers = height.shape[0]
    for tri in prange(slots.shape[0]):
        xp, g, away = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        own, dual, n, dr = np.empty((2, 3)), np.empty((2, 3)), np.empty(3), np.empty((3, 4, 3))
        hessian, steps = np.empty((12, 12)), np.empty((3, 3, 12))
        slope, f = np.empty(3), np.empty(3)
        d, b, db = np.empty((6, 6)), np.zeros((6, 21)), np.empty((6, 21))
        lin, grad, k_tri = linear[tri], gradient[tri], stiffness[tri]
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, lin, own, dual, n)
        side_gradients(xp, grad, g)
        section_stiffness(
            s, ds_de, tri * n_layers, kappa[tri], inverse[tri], height, weight, stretch[tri], thickness, d
        )
        r = result[tri]
        # Strains from the unknowns.
        for k in range(3):
            g1, g2 = share[tri, 3] * lin[k, 0], share[tri, 3] * lin[k, 1]
            for c in range(3):
                b[0, 3 * k + c] = g1 * own[0, c]
                b[1, 3 * k + c] = g2 * own[1, c]
                b[2, 3 * k + c] = g1 * own[1, c] + g2 * own[0, c]
        for i in range(3):
            for a in range(4):
                k = a if a < 3 else 3 + i
                g1, g2 = share[tri, i] * grad[i, 0, k], share[tri, i] * grad[i, 1, k]
                for c in range(3):
                    b[0, 3 * k + c] += g1 * g[i, 0, c]
                    b[1, 3 * k + c] += g2 * g[i, 1, c]
                    b[2, 3 * k + c] += g1 * g[i, 1, c] + g2 * g[i, 0, c]
            for v in range(3):
                b[3 + v, 18 + i] = edge[tri, v, i]
        for i in range(3):
            s_i, f[i] = slope_variation(i, g[i], side[tri, i], ratio[tri, i], grad[i], lin, dual, n, away[i], dr[i])
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
                    turning += share[tri, i] * (r[0] * g1p * g1q + r[1] * g2p * g2q + r[2] * (g1p * g2q + g2p * g1q))
                if q < 3:
                    g1p, g2p, g1q, g2q = lin[p, 0], lin[p, 1], lin[q, 0], lin[q, 1]
                    turning += share[tri, 3] * (r[0] * g1p * g1q + r[1] * g2p * g2q + r[2] * (g1p * g2q + g2p * g1q))
                for c in range(3):
                    k_tri[3 * p + c, 3 * q + c] += area[tri] * turning
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
