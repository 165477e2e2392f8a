"""Forces on the sheet and on force-driven tools at a trial state, and their exact tangent.

Unknowns: node positions x and the travel w of every tool driven by a force. With F the contact forces on the sheet,
A = - d residual / d unknowns has the blocks K (nodes), -Kc a (column of a tool with axis a), -a^T Kc
(its row) and a^T sum Kc a.
"""

from typing import NamedTuple

import numpy as np

from ..contact.node_on_tool import OPEN, contact_forces
from ..contact.search import Neighbourhood
from ..elements.assembly import gather_blocks, gather_forces
from ..elements.membrane import (
    internal_forces,
    metrics,
    smooth_normals,
    stiffnesses,
    torsion_moduli,
    vector_areas,
)
from ..elements.pressure import pressure_forces


class ToolRun(NamedTuple):
    """A tool in its stage: press is the sign of its axis that leads to the sheet; mu, kn (n,), kt (n,)
    friction and stiffnesses [N/mm]; load [N] of the modelled share where a force drives it, else 0."""

    tool: object
    axis: np.ndarray
    start: float
    press: float
    load: float
    kn: np.ndarray
    kt: np.ndarray
    neighbourhood: Neighbourhood


class Tangent(NamedTuple):
    """blocks (n_blocks, 3, 3); column, row (n, 3, k) and corner (k,) of the k force-driven tools."""

    blocks: np.ndarray
    column: np.ndarray
    row: np.ndarray
    corner: np.ndarray


class Equilibrium:
    """One stage of one sheet: residual and tangent of any trial state."""

    def __init__(self, sheet, stage, tools, method):
        self.sheet, self.stage, self.tools = sheet, stage, tools
        self.driven = [run for run in tools if run.load > 0.0]
        n, m = len(sheet.points), len(sheet.membranes.cells)
        self.torsion = method.torsion * sheet.blank.material.initial_yield_stress
        self.compression = method.compression
        self.smooth = method.smooth
        self.skin = method.skin * sheet.blank.thickness
        self.normal, self.modulus = np.empty((m, 3)), np.empty((m, 3))
        self.half_thickness = np.empty(n)
        self.slot_load = np.empty((m, 3, 3))
        self.slot_force, self.stiffness = np.empty((m, 3, 3)), np.empty((m, 3, 3, 3, 3))
        self.contact = np.empty((n, 3))
        self.contact_blocks = {run.tool.name: np.empty((n, 3, 3)) for run in tools}
        self.blocks = np.empty((len(sheet.pattern.block_row), 3, 3))
        self.fixed = sheet.held.copy()
        for group, movement in stage.moved.items():
            for axis, distance in enumerate(movement):
                if distance is not None:
                    self.fixed[sheet.blank.nodes_of(group), axis] = True

    def begin(self, old, new):
        """Finish the prediction and freeze what an increment takes from its start: torsion moduli and thickness from
        the old state, the smooth normals from the new one's predicted positions."""
        self.half_thickness = 0.5 * self.sheet.nodal_thickness(old.sheet.thickness_strain)
        self.follow_tools(old, new)
        cells = self.sheet.membranes.cells
        torsion_moduli(old.sheet.second_stress, self.torsion, self.compression, self.modulus)
        vector_areas(new.sheet.x, cells, self.slot_force)
        nodal = np.empty_like(new.sheet.x)
        gather_forces(self.slot_force, self.sheet.pattern.node_first, self.sheet.pattern.node_slot, nodal)
        nodal[self.sheet.mirrored] = 0.0
        smooth_normals(nodal, self.slot_force, cells, self.smooth, self.normal)

    def follow_tools(self, old, new):
        """Put the predicted nodes that touch a tool of prescribed motion back to the gap they had: along its exact
        curvature, and with the thickness of now."""
        for run in self.tools:
            before = old.tools[run.tool.name]
            nodes = np.flatnonzero(before.status != OPEN)
            if run.load > 0.0 or not len(nodes):
                continue
            place = new.sheet.x[nodes] - new.tools[run.tool.name].travel * run.axis
            hit = run.tool.surface.project(place, run.neighbourhood.seeds(nodes))
            lift = (self.half_thickness[nodes] + before.gap[nodes] - hit.distance)[:, None] * hit.normal
            new.sheet.x[nodes] += np.where(self.fixed[nodes], 0.0, lift)

    def evaluate(self, old, new, pressure, first=False):
        """Fill new from its positions and tool travels. Returns the residuals: nodes (n, 3), 0 where fixed,
        driven tools (k,), and the scale of the forces in play, all [N].

        The first evaluation of an increment remembers who touched: those nodes enter the tangent even where the
        sheet has thinned away from the tool meanwhile.
        """
        self.first = first
        membranes, material, sheet = self.sheet.membranes, self.sheet.blank.material, new.sheet
        pattern = self.sheet.pattern
        cells, gradients, volume = membranes.cells, membranes.gradients, membranes.volume
        metrics(sheet.x, cells, gradients, sheet.metric)
        material.update(sheet.metric, old.sheet, sheet)
        internal_forces(
            sheet.x, cells, gradients, volume, sheet.second_stress, self.normal, self.modulus,
            self.slot_force,
        )  # fmt: skip
        stiffnesses(
            sheet.x, cells, gradients, volume, sheet.second_stress, sheet.tangent, self.normal, self.modulus,
            self.stiffness,
        )  # fmt: skip
        gather_forces(self.slot_force, pattern.node_first, pattern.node_slot, sheet.internal)
        if pressure != 0.0:
            pressure_forces(sheet.x, cells, pressure, self.slot_load, self.stiffness)
            gather_forces(self.slot_load, pattern.node_first, pattern.node_slot, sheet.external)
        self.contact[:] = 0.0
        for run in self.tools:
            self._touch(run, old, new)
        residual = sheet.external + self.contact - sheet.internal
        scale = max(np.linalg.norm(f) for f in (sheet.internal, sheet.external, self.contact))
        residual[self.fixed] = 0.0
        balance = [run.press * run.load + new.tools[run.tool.name].force @ run.axis for run in self.driven]
        return residual, np.array(balance), scale

    def torsion_work(self, old, new):
        """Work that the torsion stabilisation takes over an accepted increment [mJ]: its energy is quadratic in the
        rotations out of the smooth surface."""
        membranes = self.sheet.membranes
        energy = []
        for x in (old.sheet.x, new.sheet.x):
            tangents = np.einsum("mic,mia->mac", x[membranes.cells], membranes.gradients)
            g1, g2 = np.einsum("mac,mc->am", tangents, self.normal)
            m11, m22, m12 = self.modulus.T
            energy.append(0.5 * membranes.volume @ (m11 * g1**2 + m22 * g2**2 + 2.0 * m12 * g1 * g2))
        return float(energy[1] - energy[0])

    def _touch(self, run, old, new):
        before, after = old.tools[run.tool.name], new.tools[run.tool.name]
        blocks = self.contact_blocks[run.tool.name]
        blocks[:] = 0.0
        after.normal_force[:], after.friction_force[:], after.status[:] = 0.0, 0.0, OPEN
        slack = np.divide(after.multiplier, run.kn)
        reach = self.half_thickness + slack + self.skin
        if self.first:
            reach[before.status != OPEN] = np.inf
        near, hit = run.neighbourhood.project(new.sheet.x - after.travel * run.axis, reach)
        after.gap[:] = run.neighbourhood.distance - self.half_thickness
        before_contact = self.contact.sum(axis=0)
        contact_forces(
            near, hit.distance, hit.normal, hit.curvature, hit.direction, self.half_thickness, self.skin, self.first,
            after.multiplier, run.kn, run.kt, run.tool.mu, before.friction_force, before.normal, before.status,
            new.sheet.x, old.sheet.x, (after.travel - before.travel) * run.axis,
            self.contact, blocks, after.normal_force, after.friction_force, after.normal, after.gap, after.status,
        )  # fmt: skip
        after.force[:] = before_contact - self.contact.sum(axis=0)

    def tangent(self):
        """Tangent of the state evaluated last."""
        pattern = self.sheet.pattern
        gather_blocks(self.stiffness, pattern.block_first, pattern.block_slot, self.blocks)
        for blocks in self.contact_blocks.values():
            self.blocks[pattern.diagonal] += blocks
        n, k = len(self.sheet.points), len(self.driven)
        column, row, corner = np.zeros((n, 3, k)), np.zeros((n, 3, k)), np.zeros(k)
        for j, run in enumerate(self.driven):
            blocks = self.contact_blocks[run.tool.name]
            column[:, :, j] = -blocks @ run.axis
            row[:, :, j] = -np.einsum("ncd,c->nd", blocks, run.axis)
            corner[j] = run.axis @ blocks.sum(axis=0) @ run.axis
        column[self.fixed] = row[self.fixed] = 0.0
        return Tangent(self.blocks, column, row, corner)
