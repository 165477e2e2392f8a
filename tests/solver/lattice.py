"""Small meshes and rigid surfaces in closed form for the solver's tests."""

from types import SimpleNamespace

import numpy as np


def square(n, length, distort=0.0, seed=0):
    """Triangles on [0, length]^2, n x n cells of one diagonal, inner nodes shifted by up to distort cells."""
    line = np.linspace(0.0, length, n + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    inner = ((points[:, :2] > 0.0) & (points[:, :2] < length)).all(axis=1)
    shift = np.random.default_rng(seed).uniform(-distort, distort, (len(points), 2)) * length / n
    points[inner, :2] += shift[inner]
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    b, c, d = a + n + 1, a + n + 2, a + 1
    cells = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    groups = {
        "symmetry_x": np.flatnonzero(points[:, 0] == 0.0),
        "symmetry_y": np.flatnonzero(points[:, 1] == 0.0),
        "right": np.flatnonzero(points[:, 0] == length),
        "top": np.flatnonzero(points[:, 1] == length),
        "all": np.arange(len(points)),
    }
    return SimpleNamespace(points=points, cells=cells, groups=groups)


class Plane:
    """A half-space below a plane."""

    def __init__(self, point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0)):
        self.at, self.n = np.asarray(point, float), np.asarray(normal, float) / np.linalg.norm(normal)

    def project(self, points, seed=None):
        distance = (points - self.at) @ self.n
        helper = np.eye(3)[np.argmin(np.abs(self.n))]
        e1 = np.cross(self.n, helper)
        n = len(points)
        return SimpleNamespace(
            distance=distance,
            point=points - distance[:, None] * self.n,
            normal=np.tile(self.n, (n, 1)),
            curvature=np.zeros((n, 2)),
            direction=np.tile(e1 / np.linalg.norm(e1), (n, 1)),
            face=np.zeros(n, int),
            seed=np.zeros(n, int),
        )


class Ball:
    """A sphere, solid inside."""

    def __init__(self, centre, radius):
        self.centre, self.radius = np.asarray(centre, float), radius

    def project(self, points, seed=None):
        away = points - self.centre
        size = np.linalg.norm(away, axis=1)
        normal = away / size[:, None]
        helper = np.where(np.abs(normal[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
        e1 = np.cross(normal, helper)
        n = len(points)
        return SimpleNamespace(
            distance=size - self.radius,
            point=self.centre + self.radius * normal,
            normal=normal,
            curvature=np.full((n, 2), 1.0 / self.radius),
            direction=e1 / np.linalg.norm(e1, axis=1)[:, None],
            face=np.zeros(n, int),
            seed=np.zeros(n, int),
        )


class Bar:
    """A solid cylinder along y."""

    def __init__(self, centre, radius):
        self.centre, self.radius = np.asarray(centre, float), radius

    def project(self, points, seed=None):
        away = (points - self.centre) * [1.0, 0.0, 1.0]
        size = np.linalg.norm(away, axis=1)
        normal = away / size[:, None]
        n = len(points)
        return SimpleNamespace(
            distance=size - self.radius,
            point=points - (size - self.radius)[:, None] * normal,
            normal=normal,
            curvature=np.tile([1.0 / self.radius, 0.0], (n, 1)),
            direction=np.cross([0.0, 1.0, 0.0], normal),
            face=np.zeros(n, int),
            seed=np.zeros(n, int),
        )


class Corner:
    """A quarter-space along y, solid on the sides (sx, sz) of the point (x, z) its faces meet at; a rounded edge."""

    def __init__(self, at, radius, sides):
        self.radius, self.sides = radius, np.asarray(sides, float)
        self.centre = np.asarray(at, float) + radius * self.sides

    def project(self, points, seed=None):
        # Off the core, a sharp quarter-space that the radius grows round.
        away = -(points[:, [0, 2]] - self.centre) * self.sides
        out = np.maximum(away, 0.0)
        inside = ~out.any(axis=1)
        size = np.where(inside, away.max(axis=1), np.linalg.norm(out, axis=1))
        outward = np.where(inside[:, None], np.eye(2)[away.argmax(axis=1)], out / np.where(inside, 1.0, size)[:, None])
        normal = np.zeros((len(points), 3))
        normal[:, [0, 2]] = -outward * self.sides
        rounded = (away > 0.0).all(axis=1)
        n = len(points)
        return SimpleNamespace(
            distance=size - self.radius,
            point=points - (size - self.radius)[:, None] * normal,
            normal=normal,
            curvature=np.where(rounded, 1.0 / self.radius, 0.0)[:, None] * [1.0, 0.0],
            direction=np.cross([0.0, 1.0, 0.0], normal),
            face=np.zeros(n, int),
            seed=np.zeros(n, int),
        )
