"""Who can touch a tool: nodes far from it are skipped until they can have come near.

The signed distance to a tool changes by no more than the node moves (it is 1-Lipschitz). A distance known at one
place therefore bounds it from below at any other, and only nodes whose bound lets them touch are projected.
"""

import numpy as np
from numba import njit


@njit(cache=True)
def take_rows(table, rows, taken):
    """Fills taken (k, c) with these rows (k,) of a table (n, c)."""
    for k in range(len(rows)):
        for c in range(table.shape[1]):
            taken[k, c] = table[rows[k], c]


@njit(cache=True)
def put_rows(points, distance, seed, rows, place, last, seeds):
    """Writes points (k, 3), distance (k,), seed (k, c) into these rows of place (n, 3), last (n,), seeds (n, c)."""
    for k in range(len(rows)):
        row = rows[k]
        last[row] = distance[k]
        for c in range(3):
            place[row, c] = points[k, c]
        for c in range(seeds.shape[1]):
            seeds[row, c] = seed[k, c]


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
        if self.seed is None:
            return None
        found = np.empty((len(nodes), *self.seed.shape[1:]), dtype=self.seed.dtype)
        width = self.seed[0].size
        take_rows(self.seed.reshape(-1, width), nodes, found.reshape(-1, width))
        return found

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
        width = self.seed[0].size
        put_rows(
            points, hit.distance, hit.seed.reshape(-1, width), nodes, self.place, self.distance,
            self.seed.reshape(-1, width),
        )  # fmt: skip
        return hit
