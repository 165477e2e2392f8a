"""What loads the sheet besides tools: pressure, forces on groups, forces and moments along lines, weight, and the
relief of forces that were in balance before the stage and no longer are.

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
            length = line_lengths(sheet, nodes)
            share = length / length.sum() if length.any() else np.full(len(nodes), 1.0 / len(nodes))
            self.nodal[nodes] += share[:, None] * np.asarray(force, dtype=float)
        for group, force in stage.line_loads.items():
            nodes = sheet.blank.nodes_of(group)
            length = line_lengths(sheet, nodes)
            if not length.any():
                raise SceneError(
                    f"stage {stage.name!r} line_loads {group!r}: found no line there, expected an edge or a row of "
                    "nodes joined by sides of triangles"
                )
            self.nodal[nodes] += length[:, None] * np.asarray(force, dtype=float)
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


def line_lengths(sheet, nodes):
    """Length (k,) [mm] of the line through some nodes (k,) that belongs to each, half of each of its sides: the initial
    sheet's edge between them, or where they have none a row of nodes inside it. All 0 where they are no line."""
    cells = sheet.triangles.cells
    place = np.full(len(sheet.points), -1)
    place[nodes] = np.arange(len(nodes))
    sides = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    sides, first, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    within = np.zeros(len(sides), dtype=bool)  # side of a triangle of which all nodes are in the group: of an area
    within[first.reshape(-1, 3)[(place[cells] >= 0).all(axis=1)]] = True
    joined = (place[sides] >= 0).all(axis=1)
    edge = joined & (count == 1)
    sides = place[sides[edge if edge.any() else joined & ~within]]
    points = sheet.points[nodes]
    length = np.zeros(len(nodes))
    np.add.at(length, sides.ravel(), np.repeat(0.5 * np.linalg.norm(np.diff(points[sides], axis=1)[:, 0], axis=1), 2))
    return length
