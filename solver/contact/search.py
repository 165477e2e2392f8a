"""Who can touch a tool: nodes far from it are skipped until they can have come near.

The signed distance to a tool changes by no more than the node moves (it is 1-Lipschitz). A distance known at one
place therefore bounds it from below at any other, and only nodes whose bound lets them touch are projected.
"""

from typing import NamedTuple

import numpy as np


class Hit(NamedTuple):
    """Where n points are on a tool: the fields of what its surface's `project` returns."""

    distance: np.ndarray
    point: np.ndarray
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
        bound = self.distance - np.linalg.norm(points - self.place, axis=1)
        near = np.flatnonzero(bound <= reach)
        self.n_asked += len(points)
        self.place[near] = points[near]
        self.follow(near)
        return near, rows_of(self.hit, near)

    def follow(self, nodes):
        """Project these nodes (k,) from where `place` says they are now, into `hit`; in place if the surface can."""
        self.n_projected += len(nodes)
        if self.in_place and self.hit is not None:
            self.surface.follow(nodes, self.place, self.hit)
            return
        found = self.surface.project(self.place[nodes], None if self.hit is None else self.hit.seed[nodes])
        found = [getattr(found, name) for name in Hit._fields]
        if self.hit is None:
            n = len(self.place)
            self.hit = Hit(*(np.zeros((n, *values.shape[1:]), values.dtype) for values in found))
            self.hit.distance[:] = -np.inf
            self.distance = self.hit.distance
        for mine, new in zip(self.hit, found):
            mine[nodes] = new


def rows_of(hit, rows):
    """Hit of some of its points."""
    return Hit(*(values[rows] for values in hit))
