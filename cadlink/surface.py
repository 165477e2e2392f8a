"""The exact skin of a tool: closest points, normals and curvatures of trimmed CAD faces."""

from typing import NamedTuple

import numpy as np

from cadlink.closest import project_points
from cadlink.pick import pick_faces
from cadlink.skin import build_skin


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
    seed       (n, 3) to be passed back with the same points after a small move
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
        if seed is None:
            seed = np.full((n, 3), -1.0)
        elif np.shape(seed) != (n, 3):
            raise ValueError(f"seed must be ({n}, 3) for {n} points, found {np.shape(seed)}")
        hit = Projection(
            np.empty(n),
            np.empty((n, 3)),
            np.empty((n, 3)),
            np.empty((n, 2)),
            np.empty((n, 3)),
            np.empty(n, np.int64),
            np.empty((n, 3)),
        )
        if n:
            project_points(self.skin, points, np.ascontiguousarray(seed, float), *hit)
        return hit
