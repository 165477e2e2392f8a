"""Shell triangle with translations only: mean-metric membrane, curvature from mid-side gradients, edge slopes
(theory_shell.md 3 to 5 and 8).

Symbols: x_I patch nodes, I = 0..5; L_I,a linear gradients (I < 3); G^i_aI mid-side gradients; C_vI second-derivative
operator; Q_vi edge-slope operator; v = 11, 22, 2*12. g^i_a = G^i_aI x_I; h_v = C_vI x_I; n unit normal, a^c dual
tangent vectors; E membrane Green strain; kappa curvature change (a fibre at z > 0 along n stretches by z kappa);
lam thickness ratio and A inverse metric, both fixed over the increment; with Z = z lam the strain of a fibre is
E(Z) = E + Z kappa + Z^2/2 c, c = k A k the third fundamental form of the curvature k (kappa is k less its initial
value, and c likewise), so that a section bent to a circle has the strain ln(1 + Z k) exactly. J_vw = dc_v/dk_w.
N, M resultants per unit initial length; beta_vI = C_vI - (h_v . a^c) L_Ic, so that
d kappa_v = beta_vI n . dx_I + Q_vi dphi_i.
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
def second_derivatives(xp, bend, h):
    """Fills h (3, 3): h_v of one triangle."""
    for v in range(3):
        for c in range(3):
            total = 0.0
            for k in range(6):
                total += bend[v, k] * xp[k, c]
            h[v, c] = total


@njit(parallel=True, cache=True)
def shell_strains(u, slots, linear, gradient, bend, edge, mirror, level, metric, kappa):
    """Mean metric and curvature of every triangle.

    u : (n + k, 3) node places, then edge slopes in the first column
    fills metric (m, 3) = C11 C22 C12 and kappa (m, 3) = [11, 22, 2*12] [1/mm]
    """
    for tri in prange(slots.shape[0]):
        xp, g, h = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        dual, n = np.empty((2, 3)), np.empty(3)
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, linear[tri], dual, n)
        side_gradients(xp, gradient[tri], g)
        second_derivatives(xp, bend[tri], h)
        m11 = m22 = m12 = 0.0
        for i in range(3):
            for c in range(3):
                m11 += g[i, 0, c] * g[i, 0, c]
                m22 += g[i, 1, c] * g[i, 1, c]
                m12 += g[i, 0, c] * g[i, 1, c]
        metric[tri, 0], metric[tri, 1], metric[tri, 2] = m11 / 3.0, m22 / 3.0, m12 / 3.0
        for v in range(3):
            total = h[v, 0] * n[0] + h[v, 1] * n[1] + h[v, 2] * n[2]
            for i in range(3):
                slope = slots[tri, 6 + i]
                if slope >= 0:
                    total += edge[tri, v, i] * u[slope, 0]
            kappa[tri, v] = total


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
def curvature_variation(h, dual, linear, bend, beta):
    """Fills beta (3, 6): d kappa_v = beta_vI n . dx_I."""
    for v in range(3):
        g1 = h[v, 0] * dual[0, 0] + h[v, 1] * dual[0, 1] + h[v, 2] * dual[0, 2]
        g2 = h[v, 0] * dual[1, 0] + h[v, 1] * dual[1, 1] + h[v, 2] * dual[1, 2]
        for k in range(3):
            beta[v, k] = bend[v, k] - g1 * linear[k, 0] - g2 * linear[k, 1]
            beta[v, 3 + k] = bend[v, 3 + k]


@njit(parallel=True, cache=True)
def shell_forces(u, slots, linear, area, gradient, bend, edge, mirror, level, result, force):
    """Fills force (m, 9, 3): forces of every triangle on its slots [N]; of an edge slope the first column.

    result : (m, 6) resultants
    """
    for tri in prange(slots.shape[0]):
        xp, g, h = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        dual, n, beta = np.empty((2, 3)), np.empty(3), np.empty((3, 6))
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, linear[tri], dual, n)
        side_gradients(xp, gradient[tri], g)
        second_derivatives(xp, bend[tri], h)
        curvature_variation(h, dual, linear[tri], bend[tri], beta)
        r = result[tri]
        third = area[tri] / 3.0
        for k in range(6):
            moment = area[tri] * (r[3] * beta[0, k] + r[4] * beta[1, k] + r[5] * beta[2, k])
            for c in range(3):
                force[tri, k, c] = moment * n[c]
        for i in range(3):
            for a in range(4):
                k = a if a < 3 else 3 + i
                w1 = third * (r[0] * gradient[tri, i, 0, k] + r[2] * gradient[tri, i, 1, k])
                w2 = third * (r[1] * gradient[tri, i, 1, k] + r[2] * gradient[tri, i, 0, k])
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
    u, slots, linear, area, gradient, bend, edge, mirror, level, kappa, inverse, result, s, ds_de, height, weight,
    stretch, thickness, stiffness,
):  # fmt: skip
    """Fills stiffness (m, 21, 21): derivative of the forces [N/mm]; unknowns 3 I + c for patch node I, 18 + i for the
    slope of side i.

    kappa, inverse : (m, 3); result : (m, 6); s : (m n_layers, 3); ds_de : (m n_layers, 3, 3) derivative of S with
    respect to [E11, E22, 2 E12]
    """
    n_layers = height.shape[0]
    for tri in prange(slots.shape[0]):
        xp, g, h = np.empty((6, 3)), np.empty((3, 2, 3)), np.empty((3, 3))
        dual, n, beta = np.empty((2, 3)), np.empty(3), np.empty((3, 6))
        d, b, db = np.empty((6, 6)), np.zeros((6, 21)), np.empty((6, 21))
        lin, grad, k_tri = linear[tri], gradient[tri], stiffness[tri]
        patch_positions(u, slots[tri], mirror[tri], level[tri], xp)
        surface_frame(xp, lin, dual, n)
        side_gradients(xp, grad, g)
        second_derivatives(xp, bend[tri], h)
        curvature_variation(h, dual, lin, bend[tri], beta)
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
        for v in range(3):
            for k in range(6):
                for c in range(3):
                    b[3 + v, 3 * k + c] = beta[v, k] * n[c]
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
        # Turning normal forces and moments.
        lift = 0.0
        for v in range(3):
            lift += r[3 + v] * (h[v, 0] * n[0] + h[v, 1] * n[1] + h[v, 2] * n[2])
        d11 = d12 = d22 = 0.0
        for c in range(3):
            d11 += dual[0, c] * dual[0, c]
            d12 += dual[0, c] * dual[1, c]
            d22 += dual[1, c] * dual[1, c]
        for p in range(6):
            moment_p = r[3] * beta[0, p] + r[4] * beta[1, p] + r[5] * beta[2, p]
            for q in range(p, 6):
                moment_q = r[3] * beta[0, q] + r[4] * beta[1, q] + r[5] * beta[2, q]
                turning = 0.0
                for i in range(3):
                    g1p, g2p, g1q, g2q = grad[i, 0, p], grad[i, 1, p], grad[i, 0, q], grad[i, 1, q]
                    turning += r[0] * g1p * g1q + r[1] * g2p * g2q + r[2] * (g1p * g2q + g2p * g1q)
                turning *= area[tri] / 3.0
                lp1 = lp2 = lq1 = lq2 = 0.0
                if p < 3:
                    lp1, lp2 = lin[p, 0], lin[p, 1]
                if q < 3:
                    lq1, lq2 = lin[q, 0], lin[q, 1]
                nn = lift * (d11 * lp1 * lq1 + d12 * (lp1 * lq2 + lp2 * lq1) + d22 * lp2 * lq2)
                for c in range(3):
                    for e in range(3):
                        value = moment_p * (lq1 * dual[0, c] + lq2 * dual[1, c]) * n[e]
                        value += moment_q * (lp1 * dual[0, e] + lp2 * dual[1, e]) * n[c]
                        value += nn * n[c] * n[e]
                        value = -area[tri] * value
                        if c == e:
                            value += turning
                        if 3 * p + c <= 3 * q + e:
                            k_tri[3 * p + c, 3 * q + e] += value
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
