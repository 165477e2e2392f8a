"""From places to forces, for all triangles of a sheet: strains, material, forces, thickness and work of the stresses.

Laws of this package go block by block, so that a triangle's numbers stay in the cache from its strain to its forces.
A law of a user's own takes whole arrays, and everything with it.
"""

from types import SimpleNamespace

import numpy as np

from ..elements.assembly import build_corners, gather_forces
from ..lanes import BLOCK
from ..materials.material import Material
from ..materials.quadratic import VonMises
from ..state import new_sheet
from .block_nodes import build_block_nodes
from .central_differences import n_chunks, through_thickness
from .held import KEPT, hold
from .membrane_pass import membrane_pass
from .shell_pass import shell_pass

FLAT = 1e-12  # metric and bending strain at the surface of a sheet that begins flat
NO_RATIO = np.empty(0)
HISTORY = ("strain", "plastic", "equivalent", "history", "stress")


def build_pass(sheet, state):
    """The pass of a Sheet in a SheetState."""
    return (InBlocks if isinstance(sheet.blank.material, Material) else ArrayByArray)(sheet, state)


class InBlocks:
    """Passes of a compiled law.

    thickness (m,) [mm], what the triangles would have unloaded; ratio (m,), what they have over the initial one
    """

    def __init__(self, sheet, state):
        self.sheet, elements, m = sheet, sheet.elements, len(sheet.triangles.cells)
        self.law = sheet.blank.material.compiled()
        self.held, self.past = hold(state, len(elements.weight))
        self.nodes, self.corners = build_block_nodes(elements.slots)
        self.force = np.empty((len(self.nodes.rows), 3))
        self.thickness, self.ratio, self.sums = np.empty(m), np.empty(m), np.empty(-(-m // BLOCK))
        self.trial = np.empty(m), NO_RATIO, np.empty(-(-m // BLOCK))
        self.kept = [getattr(state, name) for name in KEPT]
        self.bends = elements.n_translations > 3
        if self.bends:
            self.blocks = elements.blocks._replace(rows=self.nodes.local)
            self.start = elements.metric0, elements.curvature0, elements.form0
            # Nothing to read where all are flat.
            bent = sheet.blank.thickness * np.abs(elements.curvature0).max()
            if max(bent, np.abs(elements.metric0 - [1.0, 1.0, 0.0]).max()) < FLAT:
                self.start = tuple(a[:0] for a in self.start)

    def step(self, state, keeps, tells_ratio=True):
        """Fill the internal forces of a state from its places, the thickness and, where it `tells_ratio`, the ratio,
        and renew what the sheet remembers; strains and stresses of the state are filled where it `keeps` them. Returns
        the work of the stresses [mJ]."""
        self._run(state.u, True, keeps, self.thickness, self.ratio if tells_ratio else NO_RATIO, self.sums)
        gather_forces(self.force, *self.corners, state.internal)
        return float(self.sums.sum())

    def elastic_forces(self, u):
        """Internal forces (n + k, 3) at other places, if nothing yielded on the way there."""
        self._run(u, False, False, *self.trial)
        forces = np.empty_like(u)
        gather_forces(self.force, *self.corners, forces)
        return forces

    def _run(self, u, flows, keeps, thickness, ratio, sums):
        e, t, initial = self.sheet.elements, self.sheet.triangles, self.sheet.blank.thickness
        rest = *self.law, self.held, self.past, flows, keeps, *self.kept, self.nodes, self.force, thickness, ratio, sums
        if self.bends:
            shell_pass(
                u, self.blocks, t.area, *self.start, e.inverse, e.height, e.weight, e.stretch, initial, *rest
            )  # fmt: skip
        else:
            membrane_pass(u, t.cells, t.gradients, t.volume, e.normal, e.torsion, initial, *rest)


class ArrayByArray:
    """The same for a law that answers whole arrays."""

    def __init__(self, sheet, state):
        self.sheet, elements, m = sheet, sheet.elements, len(sheet.triangles.cells)
        law, self.state = sheet.blank.material, state
        endless = 1e3 * law.young
        self.elastic = Material(law.young, law.poisson, VonMises(), lambda ep: endless + 0.0 * ep, "elastic")
        self.past = {name: getattr(state, name).copy() for name in HISTORY}
        self.trial = new_sheet(sheet.points, elements.n_slopes, len(elements.point_volume), tangents=False)
        self.slot_force = np.empty((*elements.slots.shape, 3))
        self.corners = build_corners(elements.slots, len(state.u))
        self.thickness, self.sums = np.empty(m), np.empty(n_chunks(m))

    @property
    def ratio(self):
        """Thickness of the triangles over the initial one, (m,)."""
        weight = self.sheet.elements.weight
        return np.exp(self.state.thickness_strain.reshape(-1, len(weight)) @ weight)

    def step(self, state, keeps, tells_ratio=True):
        """See InBlocks."""
        sheet = self.sheet
        for name, past in self.past.items():
            past[:] = getattr(state, name)
        sheet.elements.strain(state)
        sheet.blank.material.update(state.metric, SimpleNamespace(**self.past), state, tangent=False)
        self._gather(state)
        through_thickness(
            self.past["stress"], state.stress, self.past["strain"], state.strain, state.plastic,
            sheet.elements.weight, sheet.triangles.volume, sheet.blank.thickness, self.thickness, self.sums,
        )  # fmt: skip
        return float(self.sums.sum())

    def elastic_forces(self, u):
        """See InBlocks."""
        self.trial.u[:] = u
        self.sheet.elements.strain(self.trial)
        self.elastic.update(self.trial.metric, self.state, self.trial, tangent=False)
        self._gather(self.trial)
        return self.trial.internal.copy()

    def _gather(self, state):
        self.sheet.elements.forces(state, self.slot_force)
        gather_forces(self.slot_force, *self.corners, state.internal)
