"""Lumped masses: of nodes, of edge slopes, and what is added to triangles that would hold up all others, or a target.

A triangle gives a third of rho t A to each of its nodes. An edge slope phi is relative to its triangles, so its
inertia adds nothing to rigid motions: I = K_phi (h/c)^2, K_phi its elastic stiffness, h the smallest altitude and
c = sqrt(E/(rho (1 - nu^2))) the plate's wave speed (theory_shell.md 11).
"""

from math import sqrt

import numpy as np
from numba import njit, prange

from ..elements.vectors import cross, dot, minus


@njit(parallel=True, cache=True, error_model="numpy")
def fill_altitudes(x, cells, height):
    """Fills height (m,)."""
    for tri in prange(len(cells)):
        i, j, k = cells[tri]
        p, q, r = (x[i, 0], x[i, 1], x[i, 2]), (x[j, 0], x[j, 1], x[j, 2]), (x[k, 0], x[k, 1], x[k, 2])
        a, b, c = minus(q, p), minus(r, p), minus(r, q)
        twice = cross(a, b)
        height[tri] = sqrt(dot(twice, twice) / max(dot(a, a), dot(b, b), dot(c, c)))


def altitudes(x, cells):
    """Smallest altitude of each triangle (m,) [mm]."""
    height = np.empty(len(cells))
    fill_altitudes(x, cells, height)
    return height


def wave_times(sheet, h, density):
    """Time (m,) [s] in which a plate wave crosses each triangle. h : altitudes (m,) [mm]; density : (m,)"""
    material = sheet.blank.material
    return h * np.sqrt(density * (1.0 - material.poisson**2) / material.young)


def wave_steps(sheet, x, density, thickness):
    """The same, shortened where a thick shell bends faster (theory_shell.md 11). thickness : (m,)"""
    h = altitudes(x, sheet.triangles.cells)
    steps = wave_times(sheet, h, density)
    if sheet.elements.n_translations > 3:
        steps *= np.where(thickness > 0.5 * h, np.minimum(1.0, h / (thickness * np.sqrt(1.2))), 1.0)
    return steps


def scaled_density(sheet, density, share):
    """Density of each triangle (m,): raised where its step is short, until `share` of the blank's mass is added.

    No triangle is raised beyond the step of the median; where the mass allowed does not do, all are raised to the
    longest common step it does for.
    """
    volume = sheet.triangles.volume
    steps = wave_steps(sheet, sheet.points, density, np.full(len(volume), sheet.blank.thickness))
    target = np.median(steps)
    allowed = share * volume.sum()
    if np.sum(volume * np.maximum((target / steps) ** 2 - 1.0, 0.0)) > allowed:
        # Added mass is a rising, piecewise quadratic function of the common step: find its piece.
        order = np.argsort(steps)
        s, v = steps[order], volume[order]
        upto, slope = np.cumsum(v), np.cumsum(v / s**2)
        reached = np.sqrt((allowed + upto) / slope)
        target = reached[np.argmax(np.append(reached[:-1] <= s[1:], True))]
    return density * np.maximum((target / steps) ** 2, 1.0)


def lengthened(sheet, density, factor):
    """Density of each triangle (m,): raised where its step is less than `factor` times the shortest."""
    steps = wave_steps(sheet, sheet.points, density, np.full(len(density), sheet.blank.thickness))
    return density * np.maximum((factor * steps.min() / steps) ** 2, 1.0)


def lumped_masses(sheet, density):
    """Mass of each unknown's row (n + k,) [tonne]. density : (m,) of the triangles"""
    triangles, elements = sheet.triangles, sheet.elements
    mass = np.zeros(len(sheet.held))
    np.add.at(mass, triangles.cells.ravel(), np.repeat(density * triangles.volume / 3.0, 3))
    if elements.n_slopes:
        material, t = sheet.blank.material, sheet.blank.thickness
        bending = material.young * t**3 / (12.0 * (1.0 - material.poisson**2))
        # A slope bends its triangle across its side alone, by -2 lever/altitude^2.
        turn = 2.0 * elements.patches.lever * np.sum(triangles.gradients**2, axis=2)
        stiffness = bending * triangles.area[:, None] * turn**2
        period = wave_times(sheet, altitudes(sheet.points, triangles.cells), density)
        rows = elements.slots[:, 6:]
        there = rows >= 0
        total, longest = np.zeros(len(mass)), np.zeros(len(mass))
        np.add.at(total, rows[there], stiffness[there])
        np.maximum.at(longest, rows[there], np.repeat(period[:, None], 3, axis=1)[there])
        slopes = slice(len(sheet.points), None)
        mass[slopes] = total[slopes] * longest[slopes] ** 2
    return mass
