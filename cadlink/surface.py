"""The exact skin of a tool: closest points, normals and curvatures of trimmed CAD faces."""

import zlib
from typing import NamedTuple

import numpy as np

from cadlink.closest import COLUMNS, Hints, project_points
from cadlink.pick import pick_faces
from cadlink.skin import build_skin

CELLS = 4096  # of the grid of hints, about


class Projection(NamedTuple):
    """Closest points of n given points, lengths in mm.

    distance   (n,) signed: + outside the material, - inside; for an open shell + on the side its
               normals point to
    point      (n, 3) foot on the skin
    normal     (n, 3) unit, out of the material: the gradient of `distance`
    curvature  (n, 2) principal curvatures [1/mm], larger first, + where the tool bulges out;
               1e12 (or -1e12) stands for the bend of a sharp edge
    direction  (n, 3) unit, principal direction of curvature[:, 0]; the other one is
               cross(normal, direction)
    face       (n,) index of the face in the part (one of two at an edge)
    seed       (n, 8) to be passed back with the same points after a small move
    """

    distance: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    direction: np.ndarray
    face: np.ndarray
    seed: np.ndarray


class ToolSurface:
    """The trimmed skin of a part, normals out of the material.

    part : Part of an assembly read by `read_step`
    faces : numbers, names or colours of the faces to keep (pick.py), None for all

    Planes, cylinders, cones, spheres and tori are met in closed form; every other surface as the
    rational Bezier patches it is made of, by Newton from a tree of boxes. No facets anywhere.
    """

    def __init__(self, part, faces=None):
        if faces is not None:
            faces = pick_faces(part, faces)
        self.part = part
        self.skin = build_skin(part.record["skin"], faces)
        self.hints = None
        # Tells its own seeds from those of other surfaces.
        self.stamp = float(zlib.crc32(self.skin.items.tobytes() + self.skin.faces.tobytes()))

    def project(self, points, seed=None):
        """Closest points on the exact tool faces.

        points : (n, 3) mm, tool frame
        seed : what the last call returned for these points, or None; it shortens the search and
            changes nothing beyond round-off (between equally near feet it keeps the last one)
        returns : Projection; distance d, normal n and curvatures k satisfy grad d = n and
            hess d = sum k_i / (1 + k_i d) e_i e_i^T (theory 6)
        raises : ValueError for points or seeds of another shape or points that are not finite
        """
        points = np.ascontiguousarray(points, float)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points must be (n, 3), found {points.shape}")
        if not np.isfinite(points).all():
            raise ValueError("points must be finite, found nan or inf")
        n = len(points)
        if self.hints is None:
            self.hints = hint_grid(self)
        if seed is None:
            seed = np.zeros((n, COLUMNS))
        elif np.shape(seed) != (n, COLUMNS):
            raise ValueError(f"seed must be ({n}, {COLUMNS}) for {n} points, found {np.shape(seed)}")
        return project(self.skin, self.hints, self.stamp, points, np.ascontiguousarray(seed, float))


def project(skin, hints, stamp, points, seed):
    """Projection of checked points."""
    n = len(points)
    hit = Projection(
        np.empty(n),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 2)),
        np.empty((n, 3)),
        np.empty(n, np.int64),
        np.empty((n, COLUMNS)),
    )
    if n:
        project_points(skin, hints, stamp, points, seed, *hit)
    return hit


def hint_grid(surface):
    """The nearest item at the middle of each cell of a coarse grid round the skin: where searches begin."""
    low, high = surface.skin.items["low"].min(axis=0), surface.skin.items["high"].max(axis=0)
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    counts = np.maximum(1, np.round(size * (CELLS / size.prod()) ** (1.0 / 3.0))).astype(int)
    per_mm = counts / size
    middles = [low[c] + (np.arange(counts[c]) + 0.5) / per_mm[c] for c in range(3)]
    points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 3)
    nowhere = Hints(low, per_mm, np.full((1, 1, 1), -1))
    found = project(surface.skin, nowhere, surface.stamp, points, np.zeros((len(points), COLUMNS)))
    return Hints(low, per_mm, found.seed[:, 0].astype(np.int64).reshape(counts))
