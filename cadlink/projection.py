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
    seed       (n, ..) to be passed back with the same points after a small move; as wide as the surface needs it:
               8 on planes, cylinders, cones, spheres and tori, 30 on a skin that has patches
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
    """Projection of n points yet to be filled, with seeds of some columns.

    All fields lie in one block: freed and asked for again it stays the same memory, where several would be given
    back to the system and cleared anew in every call (50 ns a point).
    """
    widths = (1, 3, 3, 2, 3, 1, columns)
    block, fields, start = np.empty(n * sum(widths)), [], 0
    for width in widths:
        fields.append(block[start : start + n * width].reshape((n, width) if width > 1 else n))
        start += n * width
    fields[5] = fields[5].view(np.int64)
    return Projection(*fields)
