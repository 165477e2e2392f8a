"""The blank as constant arrays: operators, pattern, supports. Built once per run."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .elements.assembly import Corners, build_corners, build_pattern, gather_thickness
from .elements.formulation import MembraneElements, SheetMesh, ShellElements
from .materials.through_thickness import flow_pressure
from .scene import AXES, Blank


@dataclass(frozen=True)
class Sheet:
    """points (n, 3) initial nodes [mm]; elements: membranes or shells; corners: of the triangles' own nodes; area (n,)
    tributary area of each node [mm^2]; held (n + k, 3) bool, unknowns, n nodes and then k edge slopes, that symmetry,
    supports or clamps keep in place; size: median side of the triangles [mm]."""

    blank: Blank
    points: np.ndarray
    elements: MembraneElements | ShellElements
    corners: Corners
    area: np.ndarray
    held: np.ndarray
    size: float

    @cached_property
    def pattern(self):
        """Pattern of the unknowns: what an implicit stage needs."""
        e = self.elements
        return build_pattern(e.slots, len(self.points) + e.n_slopes, e.n_translations)

    @property
    def triangles(self):
        """The triangles in their initial shape."""
        return self.elements.triangles

    @property
    def contact_stiffness(self):
        """Scale of the contact stiffness, E t / size^2 [MPa/mm]."""
        return self.blank.material.young * self.blank.thickness / self.size**2

    @cached_property
    def flow_pressure(self):
        """Pressure through the thickness under which the metal flows: equivalent plastic strains (k,), pressures (k,)
        [MPa]."""
        return flow_pressure(self.blank.material)

    def middle(self, values):
        """Values of the points (p, ...) at the triangles' mid-surface, (m, ...)."""
        layers = values.reshape(len(self.triangles.cells), -1, *values.shape[1:])
        n = layers.shape[1]
        return 0.5 * (layers[:, (n - 1) // 2] + layers[:, n // 2])

    def thickness(self, thickness_strain):
        """Current thickness of the triangles (m,) [mm]. thickness_strain : (p,)"""
        mean = thickness_strain.reshape(len(self.triangles.cells), -1) @ self.elements.weight
        return self.blank.thickness * np.exp(mean)

    def nodal_thickness(self, state):
        """Thickness that the tools find at the nodes now, (n,) [mm]. state : SheetState"""
        nodal = np.empty(len(self.points))
        gather_thickness(self.thickness(state.thickness_strain), self.triangles.area, *self.corners, nodal)
        return nodal - state.flattened


def build_sheet(blank):
    """Sheet of a blank. Raises SceneError where its mesh is not a surface or its material cannot be prepared."""
    points = np.array(blank.mesh.points, dtype=float, order="C")
    cells = np.ascontiguousarray(blank.mesh.cells, dtype=np.int64)
    planes = {AXES.index(axis): blank.nodes_of(f"symmetry_{axis}") for axis in blank.symmetry_planes}
    clamped = np.concatenate([np.zeros(0, dtype=np.int64), *(blank.nodes_of(group) for group in blank.clamped)])
    held = np.zeros(points.shape, dtype=bool)
    for axis, nodes in planes.items():
        held[nodes, axis] = True
    for group, axes in blank.fixed.items():
        held[np.ix_(blank.nodes_of(group), [AXES.index(axis) for axis in axes])] = True
    held[clamped] = True
    corners = build_corners(cells, len(points))
    elements = blank.element.build(
        SheetMesh(points, cells, blank.thickness, tuple(blank.rolling), planes, clamped, blank.mesh_size)
    )
    slopes = np.tile([False, True, True], (elements.n_slopes, 1))
    area = np.zeros(len(points))
    np.add.at(area, cells.ravel(), np.repeat(elements.triangles.area / 3.0, 3))
    blank.material.prepare()
    held = np.vstack([held, slopes])
    return Sheet(blank, points, elements, corners, area, held, blank.mesh_size)
