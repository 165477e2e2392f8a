"""Alphas of Yld2000-2d from eight tests: four yield stresses and four ratios of strains."""

import numpy as np

from ..errors import SceneError
from .yield_locus import gradients

ANGLES = np.radians([0.0, 45.0, 90.0])


def fit_alphas(stresses, ratios, a):
    """(8,) alphas. stresses : s0, s45, s90, sb relative to the hardening curve's; ratios : r0, r45, r90, rb.

    Raises SceneError where the numbers are no such tests, or no alphas meet them.
    """
    from scipy.optimize import least_squares

    from .yld2000 import Yld2000

    names = ("s0", "s45", "s90", "sb", "r0", "r45", "r90", "rb")
    for name, value in zip(names, (*stresses, *ratios)):
        if not (np.isfinite(value) and value > 0.0):
            raise SceneError(f"Yld2000 {name}: found {value!r}, expected a number above 0")
    c, s = np.cos(ANGLES), np.sin(ANGLES)
    uniaxial = np.column_stack([c * c, s * s, c * s]) * np.asarray(stresses[:3])[:, None]
    tests = np.vstack([uniaxial, [stresses[3], stresses[3], 0.0]])
    r = np.asarray(ratios[:3])

    def misfit(alphas):
        phi, n, _ = gradients(Yld2000(tuple(alphas), a), tests)
        # Strain across the direction of tension, and r/(1+r) times the strain along it.
        across = n[:3, 0] * s * s + n[:3, 1] * c * c - n[:3, 2] * c * s
        along = n[:3, 0] * c * c + n[:3, 1] * s * s + n[:3, 2] * c * s
        return np.concatenate([phi - 1.0, across + r / (1.0 + r) * along, [n[3, 1] - ratios[3] * n[3, 0]]])

    found = least_squares(misfit, np.ones(8), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=400)
    for start in (0.9, 1.1):
        if np.abs(found.fun).max() > 1e-9:
            found = least_squares(misfit, np.full(8, start), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=400)
    if np.abs(found.fun).max() > 1e-9:
        worst = names[int(np.argmax(np.abs(found.fun)))]
        raise SceneError(f"Yld2000: no alphas meet these tests with a = {a:g}; {worst} is the farthest off")
    # Last digits by Newton.
    alphas = found.x
    for _ in range(3):
        jacobian = np.empty((8, 8))
        for j in range(8):
            step = np.eye(8)[j] * 1e-6
            jacobian[:, j] = (misfit(alphas + step) - misfit(alphas - step)) / 2e-6
        alphas = alphas - np.linalg.solve(jacobian, misfit(alphas))
    return tuple(float(alpha) for alpha in alphas)
