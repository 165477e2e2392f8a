"""The blank as constant arrays: operators, pattern, supports. Built once per run."""

from dataclasses import dataclass

import numpy as np

from .elements.assembly import Pattern, build_pattern, gather_thickness
from .elements.membrane import Membranes, build_membranes
from .scene import AXES, Blank


@dataclass(frozen=True)
class Sheet:
    """points (n, 3) initial nodes [mm]; area (n,) tributary area of each node [mm^2]; held (n, 3) bool,
    unknowns that symmetry or the blank's `fixed` groups keep in place; mirrored (n, 3) bool, those of symmetry
    alone; size: median side of the triangles [mm]."""

    blank: Blank
    points: np.ndarray
    membranes: Membranes
    pattern: Pattern
    area: np.ndarray
    held: np.ndarray
    mirrored: np.ndarray
    size: float

    @property
    def contact_stiffness(self):
        """Scale of the contact stiffness, E t / size^2 [MPa/mm]."""
        return self.blank.material.young * self.blank.thickness / self.size**2

    def nodal_thickness(self, thickness_strain):
        """Current thickness at the nodes (n,) [mm]. thickness_strain : (m,)"""
        thickness = self.blank.thickness * np.exp(thickness_strain)
        nodal = np.empty(len(self.points))
        gather_thickness(thickness, self.membranes.area, self.pattern.node_first, self.pattern.node_slot, nodal)
        return nodal


def build_sheet(blank):
    """Sheet of a blank. Raises SceneError where its material cannot be prepared."""
    points = np.array(blank.mesh.points, dtype=float, order="C")
    cells = np.asarray(blank.mesh.cells, dtype=np.int64)
    membranes = build_membranes(points, cells, blank.thickness, blank.rolling)
    area = np.zeros(len(points))
    np.add.at(area, cells.ravel(), np.repeat(membranes.area / 3.0, 3))
    held = np.zeros(points.shape, dtype=bool)
    for axis in blank.symmetry_planes:
        held[blank.nodes_of(f"symmetry_{axis}"), AXES.index(axis)] = True
    mirrored = held.copy()
    for group, axes in blank.fixed.items():
        held[np.ix_(blank.nodes_of(group), [AXES.index(axis) for axis in axes])] = True
    pattern = build_pattern(cells, len(points))
    blank.material.prepare()
    return Sheet(blank, points, membranes, pattern, area, held, mirrored, blank.mesh_size)
