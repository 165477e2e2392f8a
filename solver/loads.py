"""What loads the sheet besides tools: pressure, forces on groups, moments along edges, weight, and the relief of forces
that were in balance before the stage and no longer are.

Loads rise in proportion to the stage's fraction f from those at its start, 0..1. What the last stage's tools, supports
and loads left unbalanced, and what this stage's weight adds, is relieved over f = -1..0 with every tool of this stage
at rest: gravity then acts in full from f = 0 on.
"""

import numpy as np

from .elements.assembly import gather_forces
from .elements.edge_moment import EdgeMoment
from .elements.pressure import pressure_forces
from .errors import SceneError


class Loads:
    """Loads of one stage of one sheet."""

    def __init__(self, sheet, stage):
        self.sheet, self.pressure = sheet, stage.pressure
        self.nodal = np.zeros(sheet.points.shape)
        for group, force in stage.forces.items():
            nodes = sheet.blank.nodes_of(group)
            share = edge_shares(sheet, nodes)
            self.nodal[nodes] += share[:, None] * np.asarray(force, dtype=float)
        self.moments = []
        for group, moment in stage.moments.items():
            edge = EdgeMoment(sheet, sheet.blank.nodes_of(group)) if sheet.elements.n_slopes else None
            if edge is None or not len(edge.cells):
                raise SceneError(
                    f"stage {stage.name!r} moments {group!r}: found no free edge of a shell there, expected one"
                )
            self.moments.append((edge, float(moment)))
        self.weight = weight(sheet, stage.gravity) if stage.gravity is not None else None
        self.relief = None
        self.slot_load = np.empty((len(sheet.triangles.cells), 3, 3))

    def apply(self, sheet, fraction, stiffness):
        """Fill sheet.external (n + k, 3) [N] at a fraction; subtract the derivative of loads that follow the sheet from
        the triangles' stiffness (m, d, d), left out where that is empty."""
        external, rise = sheet.external, max(fraction, 0.0)
        external[:] = 0.0
        n = len(sheet.x)
        if self.pressure != 0.0 and rise > 0.0:
            pressure_forces(sheet.x, self.sheet.triangles.cells, rise * self.pressure, self.slot_load, stiffness)
            gather_forces(self.slot_load, *self.sheet.corners, external[:n])
        external[:n] += rise * self.nodal
        if self.weight is not None:
            external[:n] += self.weight
        if self.relief is not None and fraction < 0.0:
            external += fraction * self.relief
        for edge, moment in self.moments:
            edge.add(sheet.x, rise * moment, external)
            if len(stiffness):
                edge.subtract_tangent(sheet.x, rise * moment, stiffness)


def weight(sheet, gravity):
    """Weight of the sheet at its nodes (n, 3) [N]; gravity : (3,) mm/s^2"""
    mass = np.zeros(len(sheet.points))
    triangles = sheet.triangles
    third = sheet.blank.material.density * triangles.volume / 3.0
    np.add.at(mass, triangles.cells.ravel(), np.repeat(third, 3))
    return mass[:, None] * np.asarray(gravity, dtype=float)


def edge_shares(sheet, nodes):
    """Share of each node in a force on the group: by the length of the edge sides between them, or even where there are
    none. Sums to 1."""
    place = np.full(len(sheet.points), -1)
    place[nodes] = np.arange(len(nodes))
    sides = np.sort(sheet.triangles.cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    sides, count = np.unique(sides, axis=0, return_counts=True)
    sides = place[sides[count == 1]]
    sides = sides[(sides >= 0).all(axis=1)]
    if not len(sides):
        return np.full(len(nodes), 1.0 / len(nodes))
    points = sheet.points[nodes]
    length = np.linalg.norm(points[sides[:, 1]] - points[sides[:, 0]], axis=1)
    share = np.zeros(len(nodes))
    np.add.at(share, sides.ravel(), np.repeat(0.5 * length, 2))
    return share / share.sum()
