"""What a yield locus says of a sheet: yield stresses and r-values in every direction, normals, convexity."""

import warnings

import numpy as np
from numba import njit

from . import hill90, quadratic, vegter, yld2000
from .dispatch import locus

LOCI = (quadratic.Quadratic, vegter.Vegter, yld2000.Yld2000, hill90.Hill90)


@njit(cache=True)
def evaluate(data, stress, phi, gradient, curvature):
    """Fills phi (n,), gradient (n, 3), curvature (n, 3, 3) of a locus at stress (n, 3)."""
    for p in range(stress.shape[0]):
        phi[p] = locus(data, stress[p], gradient[p], curvature[p])


def gradients(of, stress):
    """Equivalent stress (n,), its gradient (n, 3) and second derivative (n, 3, 3) at stress (n, 3) [11, 22, 12]."""
    stress = np.ascontiguousarray(np.atleast_2d(stress), dtype=float)
    n = len(stress)
    phi, gradient, curvature = np.empty(n), np.empty((n, 3)), np.empty((n, 3, 3))
    evaluate(of.data(), stress, phi, gradient, curvature)
    return phi, gradient, curvature


def uniaxial(of, angles):
    """Yield stress relative to the hardening curve's and r-value, (n,) each, in tension at angles [rad] to the rolling
    direction."""
    c, s = np.cos(angles), np.sin(angles)
    phi, n, _ = gradients(of, np.column_stack([c * c, s * s, c * s]))
    across = n[:, 0] * s * s + n[:, 1] * c * c - n[:, 2] * c * s
    return 1.0 / phi, -across / (n[:, 0] + n[:, 1])


def equibiaxial(of):
    """Yield stress relative to the hardening curve's, and ratio of strains de22/de11."""
    phi, n, _ = gradients(of, [[1.0, 1.0, 0.0]])
    return float(1.0 / phi[0]), float(n[0, 1] / n[0, 0])


def plane_strain(of, angle=0.0):
    """Major and minor stress, relative to the hardening curve's, that flow without strain across an angle [rad]."""
    from scipy.optimize import brentq

    c, s = np.cos(angle), np.sin(angle)

    def stress(ratio):
        return np.array([[c * c + ratio * s * s, s * s + ratio * c * c, (1.0 - ratio) * c * s]])

    def across(ratio):
        n = gradients(of, stress(ratio))[1][0]
        return n[0] * s * s + n[1] * c * c - n[2] * c * s

    ratio = brentq(across, -0.99, 0.9999, xtol=1e-15)
    major = 1.0 / gradients(of, stress(ratio))[0][0]
    return float(major), float(ratio * major)


def convexity(of, n_around=72, n_polar=46):
    """Smallest principal curvature of a locus over its largest, and the stress (3,) it is found at: negative where
    the locus is not convex. The stresses sampled cover the half sphere s11, s22, sqrt(2) s12."""
    polar, around = np.meshgrid(np.linspace(0.0, np.pi / 2, n_polar), np.linspace(0.0, 2 * np.pi, n_around, False))
    around = around + 0.013  # off the axes, where some loci change from one formula to the next
    stress = np.column_stack([
        (np.sin(polar) * np.cos(around)).ravel(),
        (np.sin(polar) * np.sin(around)).ravel(),
        (np.cos(polar) * np.sqrt(0.5)).ravel(),
    ])  # fmt: skip
    phi, _, curvature = gradients(of, stress)
    # A Hessian of degree -1: on the locus itself, in the metric of the sphere.
    scale = np.array([1.0, 1.0, np.sqrt(0.5)])
    bent = curvature * phi[:, None, None] * scale[:, None] * scale
    if not np.isfinite(bent).all():
        return -np.inf, stress[~np.isfinite(bent).all(axis=(1, 2))][0]
    eigenvalues = np.linalg.eigvalsh(bent)
    k = int(np.argmin(eigenvalues[:, 0]))
    return float(eigenvalues[k, 0] / eigenvalues.max()), stress[k] / phi[k]


def warn_unless_convex(of):
    """One warning where a locus is not convex."""
    if isinstance(of, yld2000.Yld2000):  # convex by construction
        return
    least, where = convexity(of)
    if least < -1e-6:
        at = ", ".join(f"{component:.3f}" for component in where)
        warnings.warn(
            f"yield locus {of} is not convex: its curvature is negative near the stress [{at}] (11, 22, 12, relative"
            " to the hardening curve); results there may jump. Check its parameters",
            stacklevel=3,
        )
