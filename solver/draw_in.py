"""Draw-in: how far the rim has moved towards the blank's centre along a direction."""

import numpy as np

from .errors import SceneError


class RimGauge:
    """Measures where a ray from the blank's centre meets the rim, in the blank's initial plane.

    The rim is the mesh group "rim"; without one, every side that belongs to one triangle only.
    """

    def __init__(self, sheet, direction, name):
        blank, points = sheet.blank, sheet.points
        normal = sheet.triangles.axes[:, 2].mean(axis=0)
        # A blank that is not quite flat may lean to one side, but not out of its planes of symmetry.
        normal[["xyz".index(axis) for axis in blank.symmetry_planes]] = 0.0
        normal /= np.linalg.norm(normal)
        along = np.asarray(direction, dtype=float)
        along = along - (along @ normal) * normal
        if np.linalg.norm(along) < 1e-6 * np.linalg.norm(direction):
            raise SceneError(f"draw-in {name!r}: direction {tuple(direction)} leaves the blank's plane")
        self.along = along / np.linalg.norm(along)
        self.across = np.cross(normal, self.along)
        self.centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        for axis in blank.symmetry_planes:
            self.centre["xyz".index(axis)] = 0.0
        self.sides = rim_sides(blank, sheet.triangles.cells)
        self.tolerance = 1e-9 * np.ptp(points, axis=0).max()
        self.start = self.radius(points)
        if not np.isfinite(self.start):
            raise SceneError(f"draw-in {name!r}: the ray along {tuple(direction)} from the centre misses the rim")

    def radius(self, x):
        """Distance from the centre to the rim along the ray [mm]; nan where it misses. x : (n, 3)"""
        u, v = (x - self.centre) @ self.along, (x - self.centre) @ self.across
        (ua, va), (ub, vb) = ((u[i], v[i]) for i in self.sides.T)
        crossing = (np.minimum(va, vb) <= self.tolerance) & (np.maximum(va, vb) >= -self.tolerance)
        level = crossing & (np.abs(vb - va) <= self.tolerance)
        weight = np.clip(np.divide(-va, vb - va, out=np.zeros_like(va), where=crossing & ~level), 0.0, 1.0)
        at = np.where(level, np.maximum(ua, ub), ua + weight * (ub - ua))
        ahead = at[crossing & (at >= 0.0)]
        return float(ahead.max()) if len(ahead) else np.nan

    def read(self, x):
        """Draw-in now [mm], positive towards the centre."""
        return self.start - self.radius(x)


def rim_sides(blank, cells):
    """Sides (k, 2) of the blank's outer edge."""
    sides = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    sides, count = np.unique(sides, axis=0, return_counts=True)
    sides = sides[count == 1]
    if "rim" in blank.mesh.groups:
        on_rim = np.isin(sides, blank.nodes_of("rim")).all(axis=1)
        planes = [np.isin(sides, blank.nodes_of(f"symmetry_{a}")).all(axis=1) for a in blank.symmetry_planes]
        sides = sides[on_rim & ~np.any(planes, axis=0)] if planes else sides[on_rim]
    return sides
