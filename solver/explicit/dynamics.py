"""The sheet and its tools in explicit steps, and one step: move the tools, predict, meet the tools, strain, material,
forces.
"""

import numpy as np

from ..contact.drawbead import build_beads, uplifts
from ..contact.drive import load_on, to_tool
from ..elements.assembly import gather_thickness
from ..energy import NAMES
from ..implicit.increments import NEGLIGIBLE
from ..loads import Loads
from ..scene import AXES
from ..springback import least_supports
from .central_differences import account, n_chunks, predict
from .contact import ToolContact, in_order, touch_tools
from .laws import law_of
from .mass import lengthened, lumped_masses, scaled_density, wave_steps
from .pacing import pace
from .pinch import Pinch
from .relaxation import Relaxation
from .sheet_pass import build_pass
from .spring_damper import SpringDamper
from .stable_step import StableStep

NARROWED, APART = 0.95, 200  # of the step, from which a new look is worth it; steps from one look to the next
HELD = 1.3  # step over that of the sheet without supports, from which they are what makes it so long
AIMS = 3  # times that mass is added for a target step, which no triangle alone decides
BEGIN = 20  # steps for which the elements keep thickness ratio and inverse metric
TOOL_MASS = 4.0  # of a tool driven by a force, over the sheet's: it bounces on it in 12 steps
SLIGHT = 1e-3  # overlap at a stage's start, relative to the thickness, that contact takes away at once
STOP = 0.05  # stiffness of a tool's stop or of a drawbead, relative to the mass it meets over the square of the step


class Dynamics:
    """One stage of one sheet: everything a step needs, allocated once.

    state : State that the steps change in place
    """

    def __init__(self, sheet, stage, tools, state, method, begun):
        self.sheet, self.method, self.state, self.stage = sheet, method, state, stage
        material, elements = sheet.blank.material, sheet.elements
        n, m = len(sheet.points), len(sheet.triangles.cells)
        self.fixed = sheet.held.copy()
        self.movement = np.zeros(self.fixed.shape)
        for group, movement in stage.movements.items():
            for axis, distance in enumerate(movement):
                if distance is not None:
                    nodes = sheet.blank.nodes_of(group)
                    self.fixed[nodes, axis], self.movement[nodes, axis] = True, distance
        relaxes = method.relaxes(stage)
        if relaxes and stage.is_springback:
            planes = [AXES.index(axis) for axis in sheet.blank.symmetry_planes]
            loose = least_supports(state.sheet.x, self.fixed[:n], planes, bool(sheet.blank.clamped))
            self.fixed[tuple(loose)] = True
        plain = np.full(m, material.density)
        self.pacing = pace(sheet, method)
        self.damping = method.damping * method.waves / self.pacing.duration
        plastic = state.sheet.plastic
        self.passes, self.half = build_pass(sheet, state.sheet), np.empty(n)
        self.passes.thickness[:] = sheet.thickness(-plastic[:, 0] - plastic[:, 1])
        elements.begin(state.sheet, material, method)
        # Where rest is all that counts mass is free: no triangle need hold up the median.
        self.weigh(scaled_density(sheet, plain, np.inf if relaxes else method.scaled))
        wanted = self.pacing.duration / method.steps if method.steps else 0.0
        for _ in range(AIMS):
            if self.limit >= wanted:
                break
            self.weigh(lengthened(sheet, self.density, wanted / self.limit))
        self.added_mass = float(self.density @ sheet.triangles.volume / (plain @ sheet.triangles.volume) - 1.0)
        self.wave, self.shrunk = self.fastest(), 1.0
        self.first_limit, memory = self.limit, begun.memory or {}
        if memory:
            self.density = memory["density"]
            self.mass = lumped_masses(sheet, self.density)
            self.first_limit = float(memory["pace"][0])
        self.loads = Loads(sheet, stage)
        self.beads = build_beads(stage, sheet, method)
        self.bead_force, self.x_before = np.zeros((n, 3)), state.sheet.x.copy()
        self.has_loads = bool(stage.pressure or stage.forces or stage.line_loads or stage.moments or stage.drawbeads)
        self.has_loads = self.has_loads or stage.gravity is not None
        state.sheet.external[:] = 0.0
        free = (~self.fixed[:n]).astype(float)
        law, inertia = law_of(method.contact, self.first_limit), TOOL_MASS * float(self.mass[:n].sum())
        # A stop is a spring no stiffer than the tool's mass can carry in a step.
        solid = STOP * inertia / self.first_limit**2
        runs = [r if r.drive is None else r._replace(drive=r.drive._replace(solid=solid)) for r in in_order(tools)]
        contacts = (state.tools[run.tool.name] for run in runs)
        self.tools = [
            ToolContact(run, contact, law, self.mass, free, state.sheet.x, TOOL_MASS)
            for run, contact in zip(runs, contacts, strict=True)
        ]
        # A tool that pressed in the stage before goes on pressing.
        fresh = begun.fraction == -1.0
        self.loaded = {run.tool.name: fresh and bool(state.tools[run.tool.name].touching.any()) for run in tools}
        for tool in self.tools:
            tool.rates[:] = begun.rates[tool.run.tool.name]
            if tool.run.laws is not None:
                # Tools move faster here than in the press: friction is that of the stage's own speed.
                tool.run.laws.lapse[0] = stage.seconds / self.pacing.duration
        self.dampers = {
            tool.run.tool.name: SpringDamper(tool.run, tool.contact, tool.inertia)
            for tool in self.tools
            if tool.run.drive is not None and tool.run.drive.stiffness > 0.0
        }
        self.pinch = Pinch(sheet, state, self.tools, self.mass, method.skin * sheet.blank.thickness, self.limit)
        self.gather_half()
        self.measure_areas()
        self.overlap = self.measure_overlap()
        self.v, self.v_new, self.u_new = begun.rate.copy(), np.zeros(self.fixed.shape), np.zeros(self.fixed.shape)
        self.uplifts = {}
        self.sums = np.zeros((n_chunks(len(self.mass)), 3))
        self.no_tangents = np.zeros((0, 0, 0))
        self.work = dict.fromkeys(NAMES, 0.0)
        self.kinetic = self.kinetic_recorded = float(0.5 * np.sum(self.mass[:, None] * self.v**2))
        self.count = self.looked = self.begun = 0
        self.relaxation = None
        if relaxes:
            self.relaxation = Relaxation(sheet, self.mass, self.fixed, state.sheet.u, self.limit, self.pacing.duration)
            self.damping = 0.0
        if memory:
            self.recall(memory)

    def memory(self, look):
        """What the stage goes on with beside the state, {name: array}: the stable step and how it was found, what tools
        and dampers carry over from step to step. look : time of the last one [s]"""
        pace = self.first_limit, self.limit, self.wave, self.shrunk, self.count - self.looked, look, self.stable.looks
        found = {"pace": np.array(pace), "density": self.density, "mode": self.stable.vector, "root": self.stable.root}
        found["overlap"] = self.overlap
        found |= self.pinch.memory()
        for tool in self.tools:
            name = tool.run.tool.name
            found[f"bounce {name}"] = np.array([tool.reaction, tool.bounce, tool.bounce_before])
            found[f"inertia {name}"] = tool.inertia
            if name in self.dampers:
                found[f"springs {name}"] = self.dampers[name].memory()
        return found if self.relaxation is None else found | self.relaxation.memory()

    def recall(self, memory):
        """Go on with what `memory` gave."""
        _, self.limit, self.wave, self.shrunk, since, _, looks = memory["pace"].tolist()
        self.looked, self.overlap = -int(since), memory["overlap"]
        self.pinch.recall(memory)
        self.gather_half()
        self.measure_areas()
        self.stable.recall(memory["mode"], memory["root"], int(looks))
        for tool in self.tools:
            name = tool.run.tool.name
            tool.inertia = memory[f"inertia {name}"]
            tool.inverse = np.linalg.inv(tool.inertia)
            tool.reaction, tool.bounce, tool.bounce_before = memory[f"bounce {name}"]
            if name in self.dampers:
                self.dampers[name].recall(memory[f"springs {name}"])
        if self.relaxation is not None:
            self.relaxation.recall(memory)
            self.damping = self.relaxation.damping

    def weigh(self, density):
        """Give the triangles a density (m,), and find the stable step with it."""
        self.density, self.mass = density, lumped_masses(self.sheet, density)
        u, free = self.state.sheet.u, self.sheet.held.copy()
        self.stable = StableStep(self.sheet, self.passes, self.mass, self.fixed)
        self.limit = self.method.safety * self.stable.limit(u)
        # Supports may hold all the waves in the sheet's plane. What is left resists only once it has deflected, as
        # stiffly as the sheet without supports, whose highest frequency is never below.
        free[: len(self.sheet.points)] = False
        without = StableStep(self.sheet, self.passes, self.mass, free)
        limit = self.method.safety * without.limit(u)
        if self.limit > HELD * limit:
            self.stable, self.limit = without, limit

    def gather_half(self):
        """Half the thickness at the nodes, without the elastic part that strains in the sheet's plane give it."""
        gather_thickness(self.passes.thickness, self.sheet.triangles.area, *self.sheet.corners, self.half)
        self.half -= self.state.sheet.flattened
        self.half -= self.pinch.elastic
        self.half *= 0.5

    def measure_areas(self):
        """Area of the nodes now, for friction that depends on pressure: the sheet's volume is constant but for what is
        elastic."""
        for tool in self.tools:
            if tool.run.laws is not None:
                thickness = 2.0 * self.half + self.pinch.elastic
                tool.run.laws.area[:] = self.sheet.area * self.sheet.blank.thickness / thickness

    def measure_overlap(self):
        """How deep nodes lie in tools they do not touch yet (n,) [mm], as those of a part that has sprung back: the
        tools come home as the stage is prepared, for a node put back at once would be shot out."""
        found = np.zeros(len(self.half))
        for tool in self.tools:
            place = to_tool(tool.run, tool.contact, self.state.sheet.x)
            depth = self.half - tool.run.tool.surface.project(place).distance
            found = np.where(tool.contact.touching, found, np.maximum(found, depth))
        return np.where(found > SLIGHT * self.sheet.blank.thickness, found, 0.0)

    def fastest(self):
        """Least time in which a wave crosses a triangle now [s]."""
        return float(wave_steps(self.sheet, self.state.sheet.x, self.density, self.passes.thickness).min())

    def look(self):
        """Find the stable step anew."""
        self.limit = self.method.safety * self.stable.limit(self.state.sheet.u)
        self.wave, self.shrunk, self.looked = self.fastest(), 1.0, self.count

    def overdue(self):
        """Whether the fastest triangle has shrunk so much that the last look no longer tells the step."""
        return self.shrunk < NARROWED and self.count - self.looked >= APART

    def shortest(self):
        """Stable step now: the last look's, shortened as the fastest triangle has shrunk since."""
        if self.begun % BEGIN == 0:
            self.shrunk = min(1.0, self.fastest() / self.wave)
        return self.shrunk * self.limit

    def unbalanced(self):
        """Forces of the sheet that nothing of this stage answers, (n + k, 3) [N]."""
        residual, sheet = -self.state.sheet.internal, self.state.sheet
        for tool in self.tools:
            residual[: len(sheet.x)] += tool.contact.push
        if self.loads.weight is not None:
            residual[: len(sheet.x)] += self.loads.weight
        residual[self.fixed] = 0.0
        return residual

    def relieve(self, forces):
        """Let these forces (n + k, 3) [N] of the stage before fade over the preparation; whether there are any."""
        material = self.sheet.blank.material
        floor = 1e-3 * material.initial_yield_stress * self.sheet.blank.thickness * self.sheet.size
        there = bool(np.linalg.norm(forces) > NEGLIGIBLE * floor)
        if there:
            self.loads.relief, self.has_loads = forces, True
        return there

    def notes(self, left):
        """What this stage chose by itself. left : its time still to go [s]"""
        name, count = self.stage.name, left / self.limit
        found = [f"stage {name!r}: {left:.3g} s in about {count:.0f} steps of {self.limit:.2g} s"]
        if self.added_mass > 1e-6:
            found[0] += f", {100.0 * self.added_mass:.2g} % of mass added to its fastest triangles"
        for tool in self.tools:
            if tool.run.drive is not None:
                weight = f"{tool.run.tool.name} moves as a mass of {TOOL_MASS:g} times the sheet's"
                found.append(f"stage {name!r}: {weight}, damped critically where it bounces on it")
            if tool.run.tool.name in self.dampers:
                found[-1] += " and where it swings on its springs"
        return tuple(found)

    def damped_springs(self):
        """What the dampers of tools on springs have taken in this stage."""
        share, name = self.sheet.blank.share, self.stage.name
        return tuple(
            f"stage {name!r}: the damper of {tool}'s springs has taken {damper.work / share:.3g} mJ"
            for tool, damper in self.dampers.items()
        )

    def step(self, time, dt, dt_before, keeps=True):
        """From `time` to time + dt. keeps : whether strains and stresses in the state are brought up to date, as they
        have to be before a record"""
        sheet = self.state.sheet
        dtm = 0.5 * (dt + dt_before)
        start, end = self.pacing.fraction(time), self.pacing.fraction(time + dt)
        ready = self.pacing.readiness(time)
        if self.has_loads:
            fraction = start if time >= 0.0 else ready - 1.0
            self.loads.apply(sheet, fraction, self.no_tangents)
        if self.beads:
            self.pull_in_beads(sheet)
        # Tools move, the sheet is predicted and meets them.
        for tool in self.tools:
            run = tool.run
            if run.drive is not None:
                load = load_on(run, self.state, self.uplifts.get(run.tool.name))
                load = load if self.loaded[run.tool.name] else ready * load
                damper = self.dampers.get(run.tool.name)
                tool.be_driven(
                    load if damper is None else load + damper.force(tool.rates, (end - start) / dt, dtm), dt, dtm
                )
            elif run.tool.travel is not None:
                tool.travel_to(run.start + end * run.tool.travel, dt)
        predict(
            sheet.u, self.v, self.mass, sheet.external, sheet.internal, self.fixed, self.movement, end - start, dt, dtm,
            self.damping, self.u_new, self.v_new,
        )  # fmt: skip
        half = self.half if time >= 0.0 or not self.overlap.any() else self.half - (1.0 - ready) * self.overlap
        touch_tools(self.tools, sheet.u, self.v, half, dt, dtm, self.u_new, self.v_new, self.work)
        self.pinch.give_way(self.half, dt, dtm)
        account(self.v, self.v_new, self.mass, sheet.external, sheet.internal, self.fixed, dtm, self.damping, self.sums)
        if self.beads:
            path = 0.5 * dtm * (self.v + self.v_new)[: len(sheet.x)]
            rubbed = -float(np.sum(self.bead_force * path))
            self.work["friction"] += rubbed
            self.work["external"] += rubbed
        sheet.u, self.u_new = self.u_new, sheet.u
        self.v, self.v_new = self.v_new, self.v
        # Strain, material, forces.
        if self.begun % BEGIN == 0:
            ratio = self.passes.ratio if self.begun else None
            self.sheet.elements.begin(sheet, self.sheet.blank.material, self.method, ratio)
            self.measure_areas()
        self.work["internal"] += self.passes.step(sheet, keeps, (self.begun + 1) % BEGIN == 0)
        self.gather_half()
        kinetic, outside, damped = self.sums.sum(axis=0)
        self.kinetic = float(kinetic)
        self.work["external"] += outside
        self.work["damping"] += damped
        self.count += 1
        self.begun += 1

    def relax(self, dt, dt_before):
        """Damp the next steps as the last one tells; whether it told something."""
        if self.relaxation is None:
            return False
        tools = sum(0.5 * float(t.rates @ t.inertia @ t.rates) for t in self.tools if t.run.drive is not None)
        sheet, dtm = self.state.sheet, 0.5 * (dt + dt_before)
        told = self.relaxation.watch(self.u_new, self.v, self.v_new, sheet.external, dt, dtm, tools)
        self.damping = self.relaxation.damping
        return told

    def pull_in_beads(self, sheet):
        """Add what drawbeads do on the sheet to its loads; now and then they look where it is."""
        if self.begun % BEGIN == 0:
            for run in self.beads:
                run.begin(sheet.x)
                run.stiffness = min(run.stiffness, self.softest_bead(run))
            self.uplifts = uplifts(self.beads, sheet.x)
        self.bead_force[:] = 0.0
        for run in self.beads:
            held = self.state.beads[run.bead.name]
            run.pull(held, held, self.x_before, sheet.x, self.bead_force, self.no_tangents)
        sheet.external[: len(sheet.x)] += self.bead_force
        self.x_before[:] = sheet.x

    def softest_bead(self, run):
        """Stiffness of a bead that the nodes' masses can carry in a step [N/mm^2]."""
        on = run.triangle >= 0
        share = np.zeros(len(self.x_before))
        np.add.at(share, run.nodes[on].ravel(), (run.shares * run.lengths[:, None])[on].ravel())
        held = share > 0.0
        return STOP * float(np.min(self.mass[: len(share)][held] / share[held], initial=np.inf)) / self.limit**2

    def record(self, span):
        """Work since the last record, {name: mJ}; the contacts' states are finished. The elements begin anew, as they
        do where a run resumes from here. span : time since then [s]"""
        self.begun = 0
        self.measure_areas()
        for tool in self.tools:
            tool.record(self.half, self.pinch.squeeze, span)
        self.work["kinetic"] = self.kinetic - self.kinetic_recorded
        self.kinetic_recorded = self.kinetic
        done, self.work = self.work, dict.fromkeys(NAMES, 0.0)
        return done
