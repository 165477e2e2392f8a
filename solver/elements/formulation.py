"""The sheet's elements as the solvers see them: membranes or shells, behind the same calls.

Both fill the metrics of their integration points, and turn the material's answer there into forces and stiffnesses on
slots, which `assembly.py` gathers. Points are numbered triangle by triangle, from the bottom layer to the top one.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .membrane import build_membranes, internal_forces, metrics, stiffnesses, unit_normals
from .patches import build_patches
from .section import layer_metrics, resultants, third_forms
from .shell import shell_forces, shell_strains
from .shell_stiffness import shell_stiffnesses
from .triangle_block import build_blocks


@dataclass(frozen=True)
class Membrane:
    """Triangles that carry no bending: the cheapest choice, for sheets under tension everywhere (theory.md 2)."""

    def build(self, mesh):
        """MembraneElements of a SheetMesh."""
        return MembraneElements(mesh)


@dataclass(frozen=True)
class Shell:
    """Triangles that bend, with the same nodal unknowns (theory_shell.md).

    layers : Gauss-Legendre points through the thickness; 7 for forming, 9 where springback counts
    """

    layers: int = 7

    def __post_init__(self):
        if not (isinstance(self.layers, (int, np.integer)) and self.layers >= 2):
            raise SceneError(f"shell layers: found {self.layers!r}, expected a whole number of 2 or more")

    def build(self, mesh):
        """ShellElements of a SheetMesh. Raises SceneError where the mesh is not one orientable surface."""
        return ShellElements(mesh, self.layers)


@dataclass(frozen=True)
class SheetMesh:
    """What elements are built from: points (n, 3) mm, cells (m, 3), thickness [mm], rolling direction, planes of
    symmetry {axis index: nodes}, clamped nodes, mesh size [mm]."""

    points: np.ndarray
    cells: np.ndarray
    thickness: float
    rolling: tuple
    planes: dict
    clamped: np.ndarray
    size: float


class MembraneElements:
    """Constant-strain membranes with torsion stabilisation. slots (m, 3): the nodes of each triangle."""

    n_translations, n_slopes = 3, 0
    weight = np.ones(1)  # of the layers, sums to 1

    def __init__(self, mesh):
        self.triangles = build_membranes(mesh.points, mesh.cells, mesh.thickness, mesh.rolling)
        self.slots = self.triangles.cells
        self.point_volume = self.triangles.volume
        self.normal, self.torsion = np.empty((len(mesh.cells), 3)), 0.0

    def begin(self, sheet, material, method, ratio=None):
        """Freeze what an increment takes from its start: the normals."""
        self.torsion = float(method.torsion * material.initial_yield_stress)
        unit_normals(sheet.x, self.slots, self.normal)

    def strain(self, sheet):
        """Fill the metric of every point."""
        metrics(sheet.x, self.slots, self.triangles.gradients, sheet.metric)

    def forces(self, sheet, slot_force):
        """Fill the forces of every slot (m, 3, 3) [N]."""
        t = self.triangles
        internal_forces(
            sheet.x, t.cells, t.gradients, t.volume, sheet.second_stress, self.normal, self.torsion, slot_force
        )

    def stiffness(self, sheet, stiffness):
        """Fill the stiffness of every triangle (m, 9, 9) [N/mm]."""
        t = self.triangles
        stiffnesses(
            sheet.x, t.cells, t.gradients, t.volume, sheet.second_stress, sheet.tangent, self.normal, self.torsion,
            stiffness,
        )  # fmt: skip

    def stabilisation_work(self, old, new):
        """Work that the torsion stabilisation takes over an accepted increment [mJ]: its energy is quadratic in the
        rotations out of the plane at the increment's start."""
        t = self.triangles
        rotation = np.einsum("mic,mia,mc->ma", new.x[t.cells], t.gradients, self.normal)
        return float(0.5 * self.torsion * t.volume @ np.sum(rotation**2, axis=1))

    def section(self, sheet):
        """What only a shell has: nothing."""
        return {}

    def layer_tangents(self, sheet, layer):
        """Tangent vectors of a layer now, (m, 2, 3)."""
        t = self.triangles
        return np.einsum("mic,mia->mac", sheet.x[t.cells], t.gradients)


class ShellElements:
    """Layered shell triangles on patches. slots (m, 9): own nodes, apices across the sides, edge slopes."""

    n_translations = 6

    def __init__(self, mesh, n_layers):
        self.triangles = build_membranes(mesh.points, mesh.cells, mesh.thickness, mesh.rolling)
        self.patches = build_patches(mesh.points, self.triangles, mesh.size, mesh.planes, mesh.clamped)
        self.blocks = build_blocks(self.triangles.gradients, self.patches)
        self.slots, self.n_slopes = self.patches.slots, self.patches.n_slopes
        self.thickness = float(mesh.thickness)
        place, weight = np.polynomial.legendre.leggauss(n_layers)
        self.height, self.weight = 0.5 * place * mesh.thickness, 0.5 * weight
        m = len(mesh.cells)
        self.point_volume = np.repeat(self.triangles.volume, n_layers) * np.tile(self.weight, m)
        self.stretch = np.ones(m)
        self.metric, self.curvature, self.resultants = np.empty((m, 3)), np.empty((m, 3)), np.empty((m, 6))
        start = np.vstack([mesh.points, np.zeros((self.n_slopes, 3))])
        self._kinematics(start)
        self.metric0, self.curvature0, self.form0 = self.metric.copy(), self.curvature.copy(), np.empty((m, 3))
        self.inverse = inverse_metric(self.metric)
        third_forms(self.curvature0, self.inverse, self.form0)

    def begin(self, sheet, material, method, ratio=None):
        """Freeze the thickness ratio and the inverse metric of an increment, those of its start.
        ratio : (m,), where the state's points do not tell it"""
        self.stretch[:] = self._thickness_ratio(sheet) if ratio is None else ratio
        self._kinematics(sheet.u)
        self.inverse = inverse_metric(self.metric)

    def strain(self, sheet):
        """Fill the metric of every layer."""
        self._kinematics(sheet.u)
        layer_metrics(
            self.metric, self.curvature, self.metric0, self.curvature0, self.form0, self.inverse, self.height,
            self.stretch, sheet.metric,
        )  # fmt: skip

    def forces(self, sheet, slot_force):
        """Fill the forces of every slot (m, 9, 3) [N]."""
        resultants(
            sheet.second_stress, self.curvature, self.inverse, self.height, self.weight, self.stretch, self.thickness,
            self.resultants,
        )  # fmt: skip
        shell_forces(sheet.u, self.blocks, self.triangles.area, self.resultants, slot_force)

    def stiffness(self, sheet, stiffness):
        """Fill the stiffness of every triangle (m, 21, 21) [N/mm], of the state whose forces were asked for last."""
        t, p = self.triangles, self.patches
        shell_stiffnesses(
            sheet.u, p.slots, t.gradients, t.area, p.beyond, p.lever, p.image, p.planes, self.curvature, self.inverse,
            self.resultants, sheet.second_stress, sheet.tangent, self.height, self.weight, self.stretch,
            self.thickness, stiffness,
        )  # fmt: skip

    def stabilisation_work(self, old, new):
        """Nothing: a shell needs no stabilisation."""
        return 0.0

    def section(self, sheet):
        """Change of curvature (m, 3) [11, 22, 2*12] 1/mm, normal force (m, 3) [11, 22, 12] N/mm and moment (m, 3) N per
        unit initial length, in rolling axes; a positive curvature stretches the face that the normals leave."""
        self._kinematics(sheet.u)
        found = np.empty_like(self.resultants)
        resultants(
            sheet.second_stress, self.curvature, inverse_metric(self.metric), self.height, self.weight,
            self._thickness_ratio(sheet), self.thickness, found,
        )  # fmt: skip
        change = self.curvature - self.curvature0
        return {"curvature": change, "section_force": found[:, :3], "section_moment": found[:, 3:]}

    def layer_tangents(self, sheet, layer):
        """Tangent vectors of a layer now, (m, 2, 3): a_a + z lam kappa_ab a^b."""
        t = self.triangles
        self._kinematics(sheet.u)
        middle = np.einsum("mic,mia->mac", sheet.x[t.cells], t.gradients)
        metric = np.einsum("mac,mbc->mab", middle, middle)
        dual = np.linalg.solve(metric, middle)
        bent = np.empty((len(middle), 2, 2))
        change = self.curvature - self.curvature0
        bent[:, 0, 0], bent[:, 1, 1], bent[:, 0, 1] = change[:, 0], change[:, 1], 0.5 * change[:, 2]
        bent[:, 1, 0] = bent[:, 0, 1]
        return middle + (self.height[layer] * self._thickness_ratio(sheet))[:, None, None] * np.einsum(
            "mab,mbc->mac", bent, dual
        )

    def _thickness_ratio(self, sheet):
        return np.exp(sheet.thickness_strain.reshape(-1, len(self.weight)) @ self.weight)

    def _kinematics(self, u):
        shell_strains(u, self.blocks, self.metric, self.curvature)


def inverse_metric(metric):
    """A11, A22, A12 of the inverse of metrics (m, 3) C11 C22 C12."""
    determinant = metric[:, 0] * metric[:, 1] - metric[:, 2] ** 2
    return np.column_stack([metric[:, 1], metric[:, 0], -metric[:, 2]]) / determinant[:, None]
