"""Past a limit point: implicit dynamics, the last resort.

Where a sheet snaps, such as a flange that buckles under a light blank-holder, no equilibrium lies near the last one and
no increment is small enough. From there on the sheet has inertia, and increments are steps of backward Euler,

    f = - m A (v - v_old) / ds,   v = du / ds,

with A a node's tributary area, du its movement and ds the increment as a part of the stage, its unit of time. The
shorter the step, the more it steadies, by m A / ds^2, and a steady movement with the tools is not resisted at all.
m = s_y t / (16 L)^2: the stage lasts 16 crossings of the blank by a transverse wave at the yield stress, the pace
that explicit stages have too (explicit/pacing.py), so that the kinetic energy is a share 1/16^2 or so of the plastic
work. That carries over the snap, but a wrinkle that grows in a small part of the stroke would lag behind: from step
to step the mass fades to a thousandth, 500 crossings, and a step that fails is shortened, which steadies it all the
same. A tool driven by a force has the sheet's own mass. Where a stage ends, tools stand still until the sheet has
come to rest. What the method's own damping and the movement left at the end take stands in the energies, and the run
says at which stroke they were needed.
"""

import numpy as np

from ..contact.drive import coordinates
from ..pace import reach

CROSSINGS = 16.0  # of the blank by a wave in a stage
RESORT = 0.03  # cuts of an increment below this part of the stage's first one are given up
HEAVIER, HEAVIEST = 10.0, 3e3  # times the mass where shorter steps do not help, and at most
FADE, LEAST = 0.5, 1e-3  # of the mass after a step, and at least: that of a press at its usual speed
LIGHT = 1e-3  # inertia relative to the forces in the sheet: the next step does without
SLACKEN = 3.0  # growth of a step while tools stand still
PATIENCE = 200  # steps in a row of a sheet that moves while its tools do not


class Inertia:
    """The mass m [N/mm^3] that steps have, None for static ones, chosen from one to the next.

    known : the sheet has snapped in this stage, so that one that seems to do so again is given inertia at once
    """

    def __init__(self, sheet):
        blank = sheet.blank
        self.usual = blank.material.initial_yield_stress * blank.thickness / (CROSSINGS * reach(sheet)) ** 2
        self.known = False
        self.due, self.calm = 1, 0  # light steps in a row after which it may be left, and how many there were

    def first(self):
        """Mass [N/mm^3] where static steps have failed; it stays the longer, the more often they have."""
        self.due, self.calm = 2 * self.due if self.known else 1, 0
        self.known = True
        return self.usual

    def after_success(self, mass, light):
        """Mass of the next step [N/mm^3], None for a static one; light : inertia was small in this one."""
        self.calm = self.calm + 1 if light else 0
        if self.calm >= self.due:
            return None
        return mass / HEAVIER if mass > self.usual else max(mass * FADE, LEAST * self.usual)

    def after_failure(self, mass):
        """Mass [N/mm^3] where shorter steps have not helped, inf where nothing will."""
        self.calm = 0
        return HEAVIER * mass if mass < HEAVIEST * self.usual else np.inf


class Motion:
    """Inertia of one step: what holds back nodes and tools from any other movement than the one they had.

    mass : N/mm^3, None for a static step; lapse : its time as a part of the stage; rate (n + k, 3) of the sheet and
    rates {tool: mm} before, per stage
    """

    def __init__(self, sheet, driven, mass=None, lapse=1.0, rate=None, rates=None):
        self.sheet, self.driven, self.stiffness = sheet, driven, 0.0
        if mass is None:
            return
        self.stiffness = mass / lapse**2
        n = len(sheet.points)
        self.coasting = lapse * rate[:n]
        self.tools = np.concatenate(
            [np.append(lapse * rates[run.tool.name], np.zeros(len(run.drive.axes))) for run in driven] or [np.zeros(0)]
        )

    def on_nodes(self, old, new):
        """Force of inertia times -1, (n, 3) [N]."""
        if not self.stiffness:
            return 0.0 * new.sheet.x
        return self.stiffness * self.sheet.area[:, None] * (new.sheet.x - old.sheet.x - self.coasting)

    def on_tools(self, old, new):
        """The same on the coordinates of driven tools, (k,) [N]."""
        if not self.stiffness:
            return 0.0 * coordinates(self.driven, new)
        moved = coordinates(self.driven, new) - coordinates(self.driven, old)
        return self.stiffness * self.sheet.area.sum() * (moved - self.tools)

    def forces(self, old, new):
        """Both in one vector, (3 n + k,)."""
        return np.append(self.on_nodes(old, new), self.on_tools(old, new))

    def work(self, before, forces, old, new):
        """Work against it over the step [mJ]. before, forces : at its start and end"""
        moved = np.append(new.sheet.x - old.sheet.x, coordinates(self.driven, new) - coordinates(self.driven, old))
        return 0.5 * float((before + forces) @ moved)
