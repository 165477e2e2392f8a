"""Who can touch a tool: nodes far from it are skipped until they can have come near.

The signed distance to a tool changes by no more than the node moves (it is 1-Lipschitz). A distance known at one
place therefore bounds it from below at any other, and only nodes whose bound lets them touch are projected.
"""

from typing import NamedTuple

import numpy as np
from numba import njit


class Hit(NamedTuple):
    """How n points lie to a tool: fields of what its surface's `project` returns."""

    distance: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    direction: np.ndarray
    face: np.ndarray
    seed: np.ndarray


class Neighbourhood:
    """Distances of the nodes to one tool, remembered in the tool's frame, and the seeds of its search.

    place : (n, 3) where each node was projected last, in the tool's frame
    hit : Hit of all nodes there, None before the first; what it says of nodes never projected is void
    distance : (n,) of it, -inf of those nodes
    """

    def __init__(self, surface, n_nodes):
        self.surface, self.in_place = surface, hasattr(surface, "follow")
        self.place = np.zeros((n_nodes, 3))
        self.distance = np.full(n_nodes, -np.inf)
        self.hit = None
        self.n_projected = self.n_asked = 0

    def project(self, points, reach):
        """Exact projection of the nodes that may lie closer than their reach.

        points : (n, 3) in the tool's frame; reach : (n,) mm
        returns : node ids (k,), Hit of those nodes
        """
        near = np.empty(len(points), dtype=np.int64)
        near = near[: self.look(np.ascontiguousarray(points), np.zeros(3), reach, near)]
        return near, rows_of(self.hit, near)

    def look(self, points, shift, reach, near):
        """Projects the nodes that may lie closer than their reach into `hit`, in place if the surface can. Fills near
        (n,) with them, in order, and returns how many they are.

        points : (m, 3), the first n rows are nodes; shift : (3,) mm, how far the tool has been carried; reach : (n,) mm
        """
        if self.in_place and self.hit is not None:
            count = self.surface.follow(points, shift, reach, self.place, self.hit, near)
        else:
            count = wake(points, shift, reach, self.place, self.distance, near)
            if count or self.hit is None:
                self.search(near[:count])
        self.n_asked += len(reach)
        self.n_projected += count
        return count

    def search(self, nodes):
        """Project these nodes (k,) from where `place` says they are now."""
        found = self.surface.project(self.place[nodes], None if self.hit is None else self.hit.seed[nodes])
        found = [getattr(found, name) for name in Hit._fields]
        if self.hit is None:
            n = len(self.place)
            self.hit = Hit(*(np.zeros((n, *values.shape[1:]), values.dtype) for values in found))
            self.hit.distance[:] = -np.inf
            self.distance = self.hit.distance
        for mine, new in zip(self.hit, found):
            mine[nodes] = new


@njit(cache=True)
def wake(points, shift, reach, place, distance, near):
    """Fills near with the nodes that may lie closer to the tool than their reach, and their rows of place with where
    they are now. Returns how many. What is not a number is near nothing. See Neighbourhood.look"""
    count = 0
    for node in range(reach.shape[0]):
        x, y, z = points[node, 0] - shift[0], points[node, 1] - shift[1], points[node, 2] - shift[2]
        slack = distance[node] - reach[node]
        moved = (x - place[node, 0]) ** 2 + (y - place[node, 1]) ** 2 + (z - place[node, 2]) ** 2
        if not moved < np.inf or (slack > 0.0 and moved < slack * slack):
            continue
        place[node, 0], place[node, 1], place[node, 2] = x, y, z
        near[count] = node
        count += 1
    return count


def rows_of(hit, rows):
    """Hit of some points of a Hit or Projection."""
    return Hit(*(getattr(hit, name)[rows] for name in Hit._fields))
