"""Through the thickness of a shell: metrics of the layers, resultants of their stresses, and their stiffness
(theory_shell.md 8).

Symbols: v = 11, 22, 2*12; k curvature now, kappa = k less its initial value (a fibre at z > 0 along the normal
stretches by z kappa); lam thickness ratio and A inverse metric, both fixed over the increment. With Z = z lam the
strain of a fibre is E(Z) = E + Z kappa + Z^2/2 c, c = k A k the third fundamental form (less its initial value, too),
so that a section bent to a circle has the strain ln(1 + Z k) exactly. J_vw = dc_v/dk_w. N, M resultants per unit
initial length.
"""

from numba import njit, prange

from ..kernels import POINT


@njit(**POINT)
def mixed(k1, k2, k3, a11, a22, a12):
    """A k as 11, 12, 21, 22, from a curvature [11, 22, 2*12] and an inverse metric A."""
    k12 = 0.5 * k3
    return a11 * k1 + a12 * k12, a11 * k12 + a12 * k2, a12 * k1 + a22 * k12, a12 * k12 + a22 * k2


@njit(**POINT)
def third_form(k1, k2, k3, a11, a22, a12):
    """[c11, c22, 2 c12] of c = k A k, k = [11, 22, 2*12]."""
    b11, b12, b21, b22 = mixed(k1, k2, k3, a11, a22, a12)
    return k1 * b11 + 0.5 * k3 * b21, 0.5 * k3 * b12 + k2 * b22, 2.0 * k1 * b12 + k3 * b22


@njit(parallel=True, cache=True)
def third_forms(kappa, inverse, form):
    """Fills form (m, 3) = c of every triangle. kappa : (m, 3); inverse : (m, 3) A11 A22 A12"""
    for tri in prange(kappa.shape[0]):
        form[tri, 0], form[tri, 1], form[tri, 2] = third_form(
            kappa[tri, 0], kappa[tri, 1], kappa[tri, 2], inverse[tri, 0], inverse[tri, 1], inverse[tri, 2]
        )


@njit(**POINT)
def third_form_row(c1, c2, c3, b11, b12, b21, b22):
    """Row c (3,) times H = J/2, where A k = b."""
    return c1 * b11 + c3 * b12, c2 * b22 + c3 * b21, 0.5 * (c1 * b21 + c2 * b12 + c3 * (b11 + b22))


@njit(**POINT)
def fibres(metric, k, metric0, k0, form0, inverse):
    """What gives the metric of every fibre of a triangle relative to its initial shape, flat + Z (bend + Z curl): three
    times C11 C22 C12. metric, k, metric0, k0, form0, inverse : of three numbers each, as in `layer_metrics`"""
    c1, c2, c3 = third_form(k[0], k[1], k[2], inverse[0], inverse[1], inverse[2])
    # Twice the strain is in the metric, but the metric's shear is half of the strain's.
    flat = 1.0 + metric[0] - metric0[0], 1.0 + metric[1] - metric0[1], metric[2] - metric0[2]
    bend = 2.0 * (k[0] - k0[0]), 2.0 * (k[1] - k0[1]), k[2] - k0[2]
    return flat, bend, (c1 - form0[0], c2 - form0[1], 0.5 * (c3 - form0[2]))


@njit(parallel=True, cache=True, error_model="numpy")
def layer_metrics(metric, kappa, metric0, kappa0, form0, inverse, height, stretch, layers):
    """Fills layers (m n_layers, 3): the metric C11 C22 C12 of each layer, relative to the initial shape.

    metric, kappa : (m, 3) now; metric0, kappa0, form0 : (m, 3) initially; inverse : (m, 3) A11 A22 A12;
    height : (n_layers,) above the mid-surface in the initial thickness [mm]; stretch : (m,) thickness ratio
    """
    n_layers = height.shape[0]
    for tri in prange(metric.shape[0]):
        flat, bend, curl = fibres(metric[tri], kappa[tri], metric0[tri], kappa0[tri], form0[tri], inverse[tri])
        for layer in range(n_layers):
            z, p = height[layer] * stretch[tri], tri * n_layers + layer
            for c in range(3):
                layers[p, c] = flat[c] + z * (bend[c] + z * curl[c])


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
        row1, row2, row3 = third_form_row(second1, second2, second3, b11, b12, b21, b22)
        result[tri, 3], result[tri, 4], result[tri, 5] = moment1 + row1, moment2 + row2, moment3 + row3


@njit(**POINT)
def section_stiffness(s, ds_de, first, kappa, inverse, tri, height, weight, stretch, thickness, power, d):
    """Fills d (6, 6): derivative of the resultants with respect to [E, k] of one triangle; power : (5, 3, 3) room.

    With C_p = sum of w Z^p C over the layers, C the symmetric part of dS/dE, and H = J/2: D_ee = C_0,
    D_ek = C_1 + C_2 H, D_kk = C_2 + C_3 H + H' (C_3 + C_4 H) + sum of w Z^2/2 S_v d2c_v/dk2.
    """
    power[:] = 0.0
    s1 = s2 = s3 = 0.0
    for layer in range(height.shape[0]):
        w, z, p = weight[layer] * thickness, height[layer] * stretch[tri], first + layer
        s1, s2, s3 = s1 + w * z * z * s[p, 0], s2 + w * z * z * s[p, 1], s3 + w * z * z * s[p, 2]
        for v in range(3):
            for u in range(v, 3):
                c = 0.5 * w * (ds_de[p, v, u] + ds_de[p, u, v])
                for k in range(5):
                    power[k, v, u] += c
                    c *= z
    for k in range(5):
        for v in range(3):
            for u in range(v):
                power[k, v, u] = power[k, u, v]
    a11, a22, a12 = inverse[tri, 0], inverse[tri, 1], inverse[tri, 2]
    b11, b12, b21, b22 = mixed(kappa[tri, 0], kappa[tri, 1], kappa[tri, 2], a11, a22, a12)
    for v in range(3):
        row2 = third_form_row(power[2, v, 0], power[2, v, 1], power[2, v, 2], b11, b12, b21, b22)
        row3 = third_form_row(power[3, v, 0], power[3, v, 1], power[3, v, 2], b11, b12, b21, b22)
        row4 = third_form_row(power[4, v, 0], power[4, v, 1], power[4, v, 2], b11, b12, b21, b22)
        for u in range(3):
            d[v, u], d[v, 3 + u] = power[0, v, u], power[1, v, u] + row2[u]
            d[3 + v, 3 + u] = power[2, v, u] + row3[u]
            power[3, v, u] += row4[u]
    for u in range(3):
        column = third_form_row(power[3, 0, u], power[3, 1, u], power[3, 2, u], b11, b12, b21, b22)
        for v in range(3):
            d[3 + v, 3 + u] += column[v]
            d[3 + u, v] = d[v, 3 + u]
    # The third form's second derivative.
    d[3, 3] += s1 * a11
    d[4, 4] += s2 * a22
    d[5, 5] += 0.25 * (s1 * a22 + s2 * a11) + 0.5 * s3 * a12
    d[3, 4] += s3 * a12
    d[3, 5] += 0.5 * (s1 * a12 + s3 * a11)
    d[4, 5] += 0.5 * (s2 * a12 + s3 * a22)
    d[4, 3], d[5, 3], d[5, 4] = d[3, 4], d[3, 5], d[4, 5]
