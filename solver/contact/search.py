"""Who can touch a tool: nodes far from it are skipped until they can have come near.

The signed distance to a tool changes by no more than the node moves (it is 1-Lipschitz). A distance known at one
place therefore bounds it from below at any other, and only nodes whose bound lets them touch are projected.
"""

import numpy as np


class Neighbourhood:
    """Distances of the nodes to one tool, remembered in the tool's frame, and the seeds of its search."""

    def __init__(self, surface, n_nodes):
        self.surface = surface
        self.place = np.zeros((n_nodes, 3))
        self.distance = np.full(n_nodes, -np.inf)
        self.seed = None
        self.n_projected = self.n_asked = 0

    def seeds(self, nodes):
        """Where the last searches of these nodes ended, or None before the first."""
        return None if self.seed is None else self.seed[nodes]

    def project(self, points, reach):
        """Exact projection of the nodes that may lie closer than their reach.

        points : (n, 3) in the tool's frame; reach : (n,) mm
        returns : node ids (k,), Projection of those nodes
        """
        bound = self.distance - np.linalg.norm(points - self.place, axis=1)
        near = np.flatnonzero(bound <= reach)
        self.n_asked += len(points)
        self.n_projected += len(near)
        return near, self.project_these(near, points[near])

    def project_these(self, nodes, points):
        """Exact projection of these nodes, remembered. nodes : (k,); points : (k, 3) in the tool's frame"""
        hit = self.surface.project(points, self.seeds(nodes))
        if self.seed is None:
            self.seed = np.zeros((len(self.distance), *hit.seed.shape[1:]), dtype=hit.seed.dtype)
        self.place[nodes] = points
        self.distance[nodes] = hit.distance
        self.seed[nodes] = hit.seed
        return hit
