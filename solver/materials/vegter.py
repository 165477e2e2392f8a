"""Yield locus of Vegter, interpolated between measured points (Vegter and van den Boogaard, IJP 22 (2006) 557-580).

In principal stresses s1 >= |s2| with the first axis at the angle phi to the rolling direction, the locus runs through
four points, each with the normal its test gives:

    shear         S = (fs, -fs)    normal (1, -1)
    uniaxial      U = (fu, 0)      normal (1, -w), w = r/(1 + r)
    plane strain  P = (p1, p2)     normal (1, 0)
    equibiaxial   E = (fb, fb)     normal ((1 + rb) + (1 - rb) cos 2 phi, (1 + rb) - (1 - rb) cos 2 phi)

Between two points A and C it is a quadratic Bezier curve (1 - u)^2 A + 2 u (1 - u) B + u^2 C, whose hinge B is where
the two tangents meet. fs, fu, w, p1 and p2 follow cosine series in 2 phi through their values at equally spaced
directions from 0 to 90 degrees. States with s1 + s2 < 0 are those of the opposite stress.

Symbols: psi = 2 phi; F(s1, s2, psi) equivalent stress, s = F X(u, psi); N normal to dX/du.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError
from ..kernels import INNER, POINT
from .dispatch import POINTS

N_DIRECTIONS = 9  # at most
POLE = 1e-5  # s1 - s2 over s1 + s2 below which the gradient is interpolated to the equibiaxial one


@dataclass(frozen=True)
class Vegter:
    """From tests in equally spaced directions from 0 to 90 degrees to the rolling direction, such as 0, 45, 90.

    Stresses are relative to the hardening curve's.
    uniaxial, r : yield stress and r-value of each direction
    plane_strain : major stress in plane strain of each direction
    shear : of each direction, the same at phi and 90 - phi degrees
    biaxial, rb : equibiaxial yield stress, and its ratio of strains de22/de11
    plane_strain_ratio : minor to major stress in plane strain, one number or one for each direction
    """

    uniaxial: tuple
    r: tuple
    plane_strain: tuple
    shear: tuple
    biaxial: float
    rb: float
    plane_strain_ratio: float | tuple = 0.5

    def __post_init__(self):
        count = len(self.uniaxial)
        if not 2 <= count <= N_DIRECTIONS:
            raise SceneError(f"Vegter uniaxial: found {count} directions, expected 2 up to {N_DIRECTIONS}")
        for name in ("r", "plane_strain", "shear", "uniaxial"):
            values = np.asarray(getattr(self, name), dtype=float)
            if values.shape != (count,):
                raise SceneError(
                    f"Vegter {name}: found {len(np.atleast_1d(values))} values, expected {count}, as uniaxial"
                )
            if not (np.isfinite(values).all() and (values > 0.0).all()):
                raise SceneError(f"Vegter {name}: found {tuple(values)}, expected numbers above 0")
        for name in ("biaxial", "rb"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise SceneError(f"Vegter {name}: found {value!r}, expected a number above 0")
        shear = np.asarray(self.shear, dtype=float)
        if not np.allclose(shear, shear[::-1], rtol=1e-9):
            raise SceneError(f"Vegter shear: found {tuple(shear)}, expected the same at phi and 90 - phi degrees")
        ratio = np.atleast_1d(np.asarray(self.plane_strain_ratio, dtype=float))
        if ratio.shape not in ((1,), (count,)) or not ((ratio > 0.0) & (ratio < 1.0)).all():
            raise SceneError(f"Vegter plane_strain_ratio: found {self.plane_strain_ratio!r}, expected above 0, below 1")

    def series(self):
        """Coefficients of the cosine series of fs, fu, w, p1, p2: (5, n)."""
        r, major = np.asarray(self.r, dtype=float), np.asarray(self.plane_strain, dtype=float)
        minor = major * np.asarray(self.plane_strain_ratio, dtype=float)
        values = np.array([self.shear, self.uniaxial, r / (1.0 + r), major, minor], dtype=float)
        k = np.arange(values.shape[1])
        cosines = np.cos(np.outer(k, k) * np.pi / (len(k) - 1))
        return np.linalg.solve(cosines, values.T).T

    def data(self):
        """Numbers for the kernels."""
        return VegterData(np.ascontiguousarray(self.series()), float(self.biaxial), float(self.rb))


class VegterData(NamedTuple):
    """series : (5, n)"""

    series: np.ndarray
    fb: float
    rb: float


@njit(**POINT)
def sum_series(series, c, s):
    """A cosine series at psi, given cos psi and sin psi, with its first two derivatives."""
    value, first, second = series[0], 0.0, 0.0
    ck, sk = 1.0, 0.0
    for k in range(1, series.shape[0]):
        ck, sk = ck * c - sk * s, sk * c + ck * s
        value += series[k] * ck
        first -= k * series[k] * sk
        second -= k * k * series[k] * ck
    return value, first, second


@njit(**POINT)
def meet(a1, a2, c1, c2, at_a, at_c):
    """Point whose products with the normals a and c are at_a and at_c."""
    d = a1 * c2 - a2 * c1
    return (at_a * c2 - at_c * a2) / d, (a1 * at_c - c1 * at_a) / d


@njit(**POINT)
def blend(u, a, b, c):
    """Bezier curve."""
    return (1.0 - u) * (1.0 - u) * a + 2.0 * u * (1.0 - u) * b + u * u * c


@njit(**POINT)
def blend_slope(u, a, b, c):
    """Its derivative with respect to u."""
    return 2.0 * ((1.0 - u) * (b - a) + u * (c - b))


@njit(**INNER)
def vegter_principal(data, s1, s2, c, s):
    """F and its derivatives F1 F2 Fp F11 F12 F22 F1p F2p Fpp, p for psi, at s1 >= |s2|."""
    rb, fb = data.rb, data.fb
    # A and C: point and normal of either end, with derivatives with respect to psi (d) and again (e).
    a1 = a2 = a1d = a2d = a1e = a2e = 0.0
    n1, n2, n1d, n2d, n1e, n2e = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    m1, m2, m1d, m2d, m1e, m2e = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    c1 = c2 = c1d = c2d = c1e = c2e = 0.0
    p1, p1d, p1e = sum_series(data.series[3], c, s)
    p2, p2d, p2e = sum_series(data.series[4], c, s)
    if s2 * p1 > s1 * p2:  # plane strain to equibiaxial
        a1, a1d, a1e, a2, a2d, a2e = p1, p1d, p1e, p2, p2d, p2e
        c1 = c2 = fb
        m1, m1d, m1e = (1.0 + rb) + (1.0 - rb) * c, -(1.0 - rb) * s, -(1.0 - rb) * c
        m2, m2d, m2e = (1.0 + rb) - (1.0 - rb) * c, (1.0 - rb) * s, (1.0 - rb) * c
    else:
        w, wd, we = sum_series(data.series[2], c, s)
        fu, fud, fue = sum_series(data.series[1], c, s)
        if s2 > 0.0:  # uniaxial to plane strain
            a1, a1d, a1e = fu, fud, fue
            n2, n2d, n2e = -w, -wd, -we
            c1, c1d, c1e, c2, c2d, c2e = p1, p1d, p1e, p2, p2d, p2e
        else:  # shear to uniaxial
            a1, a1d, a1e = sum_series(data.series[0], c, s)
            a2, a2d, a2e = -a1, -a1d, -a1e
            n2 = -1.0
            c1, c1d, c1e = fu, fud, fue
            m2, m2d, m2e = -w, -wd, -we
    # Hinge, and its derivatives from those of the two tangents' equations.
    b1, b2 = meet(n1, n2, m1, m2, n1 * a1 + n2 * a2, m1 * c1 + m2 * c2)
    at_a = n1d * (a1 - b1) + n2d * (a2 - b2) + n1 * a1d + n2 * a2d
    at_c = m1d * (c1 - b1) + m2d * (c2 - b2) + m1 * c1d + m2 * c2d
    b1d, b2d = meet(n1, n2, m1, m2, at_a, at_c)
    at_a = n1e * (a1 - b1) + n2e * (a2 - b2) + n1 * a1e + n2 * a2e
    at_a += 2.0 * (n1d * (a1d - b1d) + n2d * (a2d - b2d))
    at_c = m1e * (c1 - b1) + m2e * (c2 - b2) + m1 * c1e + m2 * c2e
    at_c += 2.0 * (m1d * (c1d - b1d) + m2d * (c2d - b2d))
    b1e, b2e = meet(n1, n2, m1, m2, at_a, at_c)
    # Where the ray of the stress meets the curve.
    cross_a, cross_b, cross_c = a1 * s2 - a2 * s1, b1 * s2 - b2 * s1, c1 * s2 - c2 * s1
    below = cross_a - cross_b + sqrt(max(cross_b * cross_b - cross_a * cross_c, 0.0))
    u = cross_a / below
    x1, x2 = blend(u, a1, b1, c1), blend(u, a2, b2, c2)
    x1d, x2d = blend(u, a1d, b1d, c1d), blend(u, a2d, b2d, c2d)
    x1e, x2e = blend(u, a1e, b1e, c1e), blend(u, a2e, b2e, c2e)
    x1u, x2u = blend_slope(u, a1, b1, c1), blend_slope(u, a2, b2, c2)
    x1ud, x2ud = blend_slope(u, a1d, b1d, c1d), blend_slope(u, a2d, b2d, c2d)
    x1uu, x2uu = 2.0 * (a1 - 2.0 * b1 + c1), 2.0 * (a2 - 2.0 * b2 + c2)
    # s = F X: multiply d s = dF X + F X_u du + F X_psi dpsi by N, then by M normal to X.
    nx = x2u * x1 - x1u * x2
    g1, g2 = x2u / nx, -x1u / nx
    f = g1 * s1 + g2 * s2
    kappa = g1 * x1d + g2 * x2d
    mx = x1 * x2u - x2 * x1u
    u1, u2 = -x2 / (f * mx), x1 / (f * mx)
    up = -(x1 * x2d - x2 * x1d) / mx
    nu_x = x2uu * x1 - x1uu * x2
    nd_x = x2ud * x1 - x1ud * x2
    g1u, g2u = x2uu / nx - g1 * nu_x / nx, -x1uu / nx - g2 * nu_x / nx
    nxd = nd_x + x2u * x1d - x1u * x2d
    g1d, g2d = x2ud / nx - g1 * nxd / nx, -x1ud / nx - g2 * nxd / nx
    kappa_u = (x2uu * x1d - x1uu * x2d) / nx + g1 * x1ud + g2 * x2ud - kappa * nu_x / nx
    kappa_d = (x2ud * x1d - x1ud * x2d) / nx + g1 * x1e + g2 * x2e - kappa * nxd / nx
    cross = 0.5 * (g1u * u2 + g2u * u1)
    fpp = f * kappa * kappa - f * (kappa_u * up + kappa_d)
    return f, g1, g2, -f * kappa, g1u * u1, cross, g2u * u2, g1u * up + g1d, g2u * up + g2d, fpp


@njit(**POINT)
def vegter_locus(data, x, n, h):
    """Point function of the general return map (`dispatch.locus`)."""
    sign = 1.0 if x[0] + x[1] >= 0.0 else -1.0
    a, b, c = sign * (x[0] + x[1]), sign * (x[0] - x[1]), 2.0 * sign * x[2]
    rho = sqrt(b * b + c * c)
    size = a + rho
    if not size > 0.0:
        n[:] = 0.0
        h[:] = 0.0
        return size
    near = rho < POLE * a
    cosine, sine = (b / rho, c / rho) if rho > 0.0 else (1.0, 0.0)
    # In units of s1, and at the edge of the cap around the equibiaxial state where it is inside.
    place = POLE * a if near else rho
    size *= 0.5
    a, place, rho = a / size, place / size, rho / size
    f, f1, f2, fp, f11, f12, f22, f1p, f2p, fpp = vegter_principal(
        data, 0.5 * (a + place), 0.5 * (a - place), cosine, sine
    )
    f_a, f_r = 0.5 * (f1 + f2), 0.5 * (f1 - f2)
    f_aa, f_ar = 0.25 * (f11 + 2.0 * f12 + f22), 0.25 * (f11 - f22)
    f_rr = 0.25 * (f11 - 2.0 * f12 + f22)
    f_ap, f_rp = 0.5 * (f1p + f2p) / place, 0.5 * (f1p - f2p) / place
    # From (rho, psi) to (B, C).
    f_b, f_c = f_r * cosine - fp / place * sine, f_r * sine + fp / place * cosine
    across = f_r / place + fpp / (place * place)
    mixed = f_rp - fp / (place * place)
    h_ab, h_ac = f_ar * cosine - f_ap * sine, f_ar * sine + f_ap * cosine
    cc, ss, cs = cosine * cosine, sine * sine, cosine * sine
    h_bb = f_rr * cc + across * ss - 2.0 * cs * mixed
    h_cc = f_rr * ss + across * cc + 2.0 * cs * mixed
    h_bc = (f_rr - across) * cs + (cc - ss) * mixed
    if near:
        pole_a, pole_b = 0.5 / data.fb, 0.5 * (1.0 - data.rb) / ((1.0 + data.rb) * data.fb)
        share = rho / place
        f_a, f_b, f_c = pole_a + share * (f_a - pole_a), pole_b + share * (f_b - pole_b), share * f_c
        f = f_a * a + (f_b * cosine + f_c * sine) * rho
    n[0], n[1], n[2] = sign * (f_a + f_b), sign * (f_a - f_b), 2.0 * sign * f_c
    h[0, 0], h[1, 1] = (f_aa + 2.0 * h_ab + h_bb) / size, (f_aa - 2.0 * h_ab + h_bb) / size
    h[0, 1] = h[1, 0] = (f_aa - h_bb) / size
    h[0, 2] = h[2, 0] = 2.0 * (h_ac + h_bc) / size
    h[1, 2] = h[2, 1] = 2.0 * (h_ac - h_bc) / size
    h[2, 2] = 4.0 * h_cc / size
    return f * size


POINTS["locus", VegterData] = vegter_locus
