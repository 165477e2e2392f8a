"""Forces on the sheet and on force-driven tools at a trial state, and their exact tangent.

Unknowns: node positions x and the free coordinates of every tool that carries a load (contact/drive.py). With Kc the
stiffness of its contact, A = - d residual / d unknowns has the blocks K (nodes), -Kc v (column of a coordinate that
moves the tool by v), -v^T Kc (its row) and v^T sum Kc v, and what turning adds.
"""

from typing import NamedTuple

import numpy as np

from ..contact.drawbead import build_beads, uplifts
from ..contact.drive import balance, borders, carried, to_space, to_tool
from ..contact.feet import sort_feet
from ..contact.flattening import flow_of, give_way
from ..contact.node_on_tool import OPEN, contact_forces
from ..contact.normal_law import no_flow
from ..contact.put_back import LANDING, foresee, put_back
from ..elements.assembly import gather_blocks, gather_forces
from ..loads import Loads
from ..scene import AXES
from ..springback import least_supports
from .inertia import Motion

NO_STIFFNESS = np.empty((0, 0, 0))


class Tangent(NamedTuple):
    """blocks (n_blocks, 3, 3); column, row (n, 3, k) and corner (k, k) of the tools' k free coordinates."""

    blocks: np.ndarray
    column: np.ndarray
    row: np.ndarray
    corner: np.ndarray


class Equilibrium:
    """One stage of one sheet: residual and tangent of any trial state."""

    def __init__(self, sheet, stage, tools, method, old):
        self.sheet, self.stage, self.tools = sheet, stage, tools
        self.driven = [run for run in tools if run.drive is not None]
        self.pressed = {run.tool.name: bool(old.tools[run.tool.name].touching.any()) for run in self.driven}
        self.method = method
        n, elements = len(sheet.points), sheet.elements
        m, k = elements.slots.shape
        size = k + 2 * elements.n_translations
        self.skin = method.skin * sheet.blank.thickness
        self.half_thickness, self.flow, self.flow_area = np.empty(n), no_flow(n), np.empty(n)
        self.pinched = np.zeros(n, dtype=bool)  # at some time of the increment
        self.loads = Loads(sheet, stage)
        self.beads, self.uplifts = build_beads(stage, sheet, method), {}
        self.slot_force, self.stiffness = np.empty((m, k, 3)), np.empty((m, size, size))
        self.contact = np.empty((n, 3))
        self.motion, self.snapped = Motion(sheet, self.driven), False  # see inertia.py; whether there was any
        self.puts_back = True  # nodes onto the faces after each correction
        self.contact_blocks = {run.tool.name: np.empty((n, 3, 3)) for run in tools}
        self.foot_blocks = np.empty((n, 3, 3))
        self.blocks = np.empty((len(sheet.pattern.block_row), 3, 3))
        self.fixed = sheet.held.copy()
        for group, movement in stage.movements.items():
            for axis, distance in enumerate(movement):
                if distance is not None:
                    self.fixed[sheet.blank.nodes_of(group), axis] = True
        if stage.is_springback:
            planes = [AXES.index(axis) for axis in sheet.blank.symmetry_planes]
            self.fixed[tuple(least_supports(old.sheet.x, self.fixed[:n], planes, bool(sheet.blank.clamped)))] = True

    def unbalanced(self, old):
        """Forces that are no longer in balance where a stage starts, (n + k, 3) [N]: those in the sheet without the
        tools, supports and loads of the stage before, and its weight in this one."""
        residual = -old.sheet.internal
        for run in self.tools:
            residual[: len(old.sheet.x)] += old.tools[run.tool.name].push
        if self.loads.weight is not None:
            residual[: len(old.sheet.x)] += self.loads.weight
        residual[self.fixed] = 0.0
        return residual

    def begin(self, old, new, width=0.0):
        """Finish the prediction and freeze what an increment takes from its start. width : of it, as a fraction of the
        stage; 0 keeps the time of the last one"""
        self.half_thickness = 0.5 * self.sheet.nodal_thickness(old.sheet)
        if len(self.tools) > 1:
            self.flow = flow_of(self.sheet, old.sheet, self.half_thickness)
            self.flow_area, self.pinched = self.flow.area.copy(), old.pinched
        for run in self.tools:
            if run.laws is not None:
                # The sheet's volume is constant.
                run.laws.area[:] = 0.5 * self.sheet.area * self.sheet.blank.thickness / self.half_thickness
                if width > 0.0:
                    run.laws.lapse[0] = width * self.stage.seconds
        for run in self.beads:
            run.begin(old.sheet.x)
        self.uplifts = uplifts(self.beads, old.sheet.x)
        # A sheet that stands still is left where it is: its first correction, elastic, says which way it gives.
        if np.any(new.sheet.u != old.sheet.u):
            self.follow_tools(old, new)
        self.sheet.elements.begin(old.sheet, self.sheet.blank.material, self.method)

    def pressing(self, run, fraction):
        """A driven tool with the load it bears: one that meets the sheet in this stage presses harder and harder
        before it."""
        if fraction >= 0.0 or self.pressed[run.tool.name]:
            return run
        return run._replace(drive=run.drive._replace(load=(1.0 + fraction) * run.drive.load))

    def follow_tools(self, old, new):
        """Put predicted nodes on the tools of prescribed motion, along the exact curvature and with the thickness of
        now: those that touch back to the gap they had; others that would overlap to where a small force begins, if
        they come from farther away."""
        touching = np.any([contact.touching for contact in old.tools.values()], axis=0)
        for run in self.tools:
            before = old.tools[run.tool.name]
            if run.drive is not None:
                continue
            place = to_tool(run, new.tools[run.tool.name], new.sheet.x)
            held = before.touching
            ajar = (1.0 - LANDING) * self.skin
            nodes, hit = run.neighbourhood.project(place, np.where(held, np.inf, self.half_thickness + ajar))
            way = (place - to_tool(run, before, old.sheet.x))[nodes]
            left = hit.distance - self.half_thickness[nodes] - np.einsum("nc,nc->n", hit.normal, way)
            hit = to_space(run, new.tools[run.tool.name], hit)
            gap = hit.distance - self.half_thickness[nodes]
            kept = np.min([np.where(foot.status != OPEN, foot.gap, np.inf)[nodes] for foot in before.feet], axis=0)
            lands = np.maximum(gap, np.clip(left, 0.0, ajar))
            wanted = np.where(held[nodes], kept, np.where(touching[nodes], gap, lands))
            new.sheet.x[nodes] += np.where(self.fixed[nodes], 0.0, (wanted - gap)[:, None] * hit.normal)

    def foresee(self, dx, dw):
        """What a correction of the unknowns (n + k, 3) and driven tools (j,) does to the contact forces."""
        return foresee(self.tools, self.state, self.skin, dx[: len(self.sheet.points)], dw)

    def put_back(self, new, foreseen, step):
        """Put the nodes on the tools after a part of a correction; see contact/put_back.py."""
        if not self.puts_back:
            return
        put_back(self.tools, new, foreseen, step, self.half_thickness, self.skin, self.fixed[: len(self.sheet.points)])

    def evaluate(self, old, new, fraction, first=False):
        """Fill new from its positions and tool travels at a fraction of the stage. Returns the residuals: unknowns
        (n + k, 3), 0 where fixed, driven tools (j,), and the scale of the forces in play, all [N].

        The first evaluation of an increment remembers who touched: those nodes enter the tangent even where the
        sheet has thinned away from the tool meanwhile.
        """
        self.first, self.old, self.state, self.fraction = first, old, new, fraction
        elements, material, sheet = self.sheet.elements, self.sheet.blank.material, new.sheet
        n = len(sheet.x)
        elements.strain(sheet)
        material.update(sheet.metric, old.sheet, sheet)
        elements.forces(sheet, self.slot_force)
        gather_forces(self.slot_force, *self.sheet.pattern.rows, sheet.internal)
        self._load(NO_STIFFNESS)
        self.contact[:] = 0.0
        if len(self.tools) > 1:
            self.pinched = self.pinched | new.pinched
            self.flow.area[:] = np.where(self.pinched, self.flow_area, np.inf)
        for run in self.tools:
            self._touch(run, old, new)
        residual = sheet.external - sheet.internal
        residual[:n] += self.contact
        residual[:n] -= self.motion.on_nodes(old, new)
        scale = max(np.linalg.norm(f) for f in (sheet.internal, sheet.external, self.contact))
        residual[self.fixed] = 0.0
        unborne = [balance(self.pressing(run, fraction), new, self.uplifts.get(run.tool.name)) for run in self.driven]
        unborne = np.concatenate([*unborne, np.zeros(0)]) - self.motion.on_tools(old, new)
        return residual, unborne, scale

    def _load(self, stiffness):
        """Fill the external forces, and add what loads that follow the sheet have to the triangles' stiffness."""
        sheet = self.state.sheet
        self.loads.apply(sheet, self.fraction, stiffness)
        for run in self.beads:
            before, now = (state.beads[run.bead.name] for state in (self.old, self.state))
            run.pull(before, now, self.old.sheet.x, sheet.x, sheet.external[: len(sheet.x)], stiffness)

    def _touch(self, run, old, new):
        before, after = old.tools[run.tool.name], new.tools[run.tool.name]
        blocks = self.contact_blocks[run.tool.name]
        blocks[:] = 0.0
        slack = np.divide(np.max([foot.multiplier for foot in after.feet], axis=0), run.kn)
        reach = self.half_thickness + slack + self.skin
        points = to_tool(run, after, new.sheet.x)
        near, hit = run.neighbourhood.project(points, np.where(self.first & before.touching, np.inf, reach))
        feet = [(near, to_space(run, after, hit))]
        if after.further:
            # What touched before is still looked for a little farther off.
            reach = np.where(self.first & before.touching, 2.0 * reach, reach)
            feet = sort_feet(run.tool.surface, points[near], near, hit, reach[near], before)
        # The sheet's places at the increment's start, carried along with the tool.
        x_old, turned = carried(run, before, after, old.sheet.x)
        contact_before = self.contact.sum(axis=0)
        for foot, earlier, now in zip(feet, before.feet, after.feet):
            now.gap[:] = run.neighbourhood.distance - self.half_thickness if now is after else np.inf
            now.normal_force[:], now.friction_force[:], now.status[:] = 0.0, 0.0, OPEN
            self._press(run, foot, earlier, now, x_old, turned, new.sheet.x, blocks)
        after.force[:] = contact_before - self.contact.sum(axis=0)

    def _press(self, run, foot, before, after, x_old, turned, x, blocks):
        """Adds forces and stiffnesses of the nodes' contact at one of their feet, foot : (node ids, Projection)."""
        nodes, hit = foot
        self.foot_blocks[:] = 0.0
        friction, normal = before.friction_force, before.normal
        if turned is not None:
            friction, normal = friction @ turned.T, normal @ turned.T
        contact_forces(
            nodes, hit.distance, hit.normal, hit.curvature, hit.direction, hit.face, self.half_thickness, self.skin,
            self.first, after.multiplier, run.kn, run.kt, self.flow, run.tool.mu, run.laws, friction, normal,
            before.status, x, x_old, self.contact, self.foot_blocks, after.normal_force, after.friction_force,
            after.normal, after.gap, after.status,
        )  # fmt: skip
        blocks += self.foot_blocks

    def flatten(self, new):
        """Let what pinched nodes have given way under their flow force be for good."""
        if self.pinched.any():
            new.sheet.flattened += give_way(new.tools.values(), self.flow, self.tools[0].kn, self.skin)

    def lost_in_beads(self, old, new):
        """Work that drawbeads take over an increment [mJ]."""
        states = ((run, old.beads[run.bead.name], new.beads[run.bead.name]) for run in self.beads)
        return sum(run.work(before, after, old.sheet.x, new.sheet.x) for run, before, after in states)

    def tangent(self):
        """Tangent of the state evaluated last."""
        pattern = self.sheet.pattern
        self.sheet.elements.stiffness(self.state.sheet, self.stiffness)
        self._load(self.stiffness)
        n_slots = self.slot_force.shape[1]
        gather_blocks(
            self.stiffness, n_slots, pattern.n_translations, pattern.block_first, pattern.block_slot, self.blocks
        )
        n = len(self.sheet.points)
        for blocks in self.contact_blocks.values():
            self.blocks[pattern.diagonal[:n]] += blocks
        self.blocks[pattern.diagonal[:n]] += (self.motion.stiffness * self.sheet.area)[:, None, None] * np.eye(3)
        k = sum(1 + len(run.drive.axes) for run in self.driven)
        column, row, corner = np.zeros((*self.fixed.shape, k)), np.zeros((*self.fixed.shape, k)), np.zeros((k, k))
        first = 0
        for run in self.driven:
            own = slice(first, first + 1 + len(run.drive.axes))
            first = own.stop
            name = run.tool.name
            parts = borders(
                self.pressing(run, self.fraction), self.state, self.contact_blocks[name], self.uplifts.get(name)
            )
            column[:n, :, own], row[:n, :, own], corner[own, own] = parts
        corner += self.motion.stiffness * self.sheet.area.sum() * np.eye(k)
        column[self.fixed] = row[self.fixed] = 0.0
        return Tangent(self.blocks, column, row, corner)
