"""What a projection takes and gives back, whatever is projected on."""

from typing import NamedTuple

import numpy as np


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


def checked_points(points, width=3):
    """points as a contiguous (n, width) float array. Raises ValueError for another shape and for what is not finite."""
    points = np.ascontiguousarray(points, float)
    if points.ndim != 2 or points.shape[1] != width:
        raise ValueError(f"points must be (n, {width}), found {points.shape}")
    if not np.isfinite(points).all():
        raise ValueError("points must be finite, found nan or inf")
    return points


def checked_seed(seed, n, columns, blank):
    """seed as a contiguous (n, columns) float array, full of `blank` where it is None. Raises ValueError."""
    if seed is None:
        return np.full((n, columns), blank)
    if np.shape(seed) != (n, columns):
        raise ValueError(f"seed must be ({n}, {columns}) for {n} points, found {np.shape(seed)}")
    return np.ascontiguousarray(seed, float)


def empty_projection(n, columns):
    """Projection of n points yet to be filled, with seeds of some columns."""
    return Projection(
        np.empty(n),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 2)),
        np.empty((n, 3)),
        np.empty(n, np.int64),
        np.empty((n, columns)),
    )
