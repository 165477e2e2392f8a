"""What a sheet between two tools gives way to them, in explicit steps: elastically and for good (theory.md 6).

Symbols, of a node: p force that presses it from both sides, on the mean of the last steps; K stiffness with which two
tools meet it; kn, h stiffness and depth of one of its skins and F flow force (contact/normal_law.py).

Two tools leave the sheet less room than its thickness, by q = e + p/K, where e is what contact takes it to be thinner.
Squeezed so, it bears b(q): the implicit solver's law, but for its setting in where the tools touch, 2 h later. Where p
is more than b, e grows, where it is less, e falls: between rigid tools q stays and p follows, of a tool that is driven
p stays and q follows. What presses beyond F makes the sheet thinner for good instead.
"""

import numpy as np

from ..contact.flattening import flow_of
from ..contact.normal_law import force_of
from .laws import PENALTY

LEAST_FLOW = 0.25  # of the initial yield stress, on a node's initial area: no pinched node flows below
MOST_FLAT = 0.5  # of the thickness: the run ends with the next record
YIELDING, STEPS = 0.5, 20  # part of the way that a node gives at once, and how many steps press before it does


class Pinch:
    """The pinched nodes of one sheet in one stage.

    tools : ToolContacts; mass (n,) [tonne]; skin : h [mm]; step : stable one [s]
    """

    def __init__(self, sheet, state, tools, mass, skin, step):
        self.sheet, self.state, self.tools, self.mass = sheet, state, tools, mass[: len(sheet.points)]
        self.skin = skin
        self.span, self.count = 0.0, 0  # time [s] and steps over which the tools have counted what presses
        self.squeeze = state.squeeze - state.sheet.flattened  # q [mm]
        self.elastic = np.zeros(len(self.squeeze))  # e [mm]
        if self.may_pinch:
            self.elastic = np.maximum(self.squeeze - self.borne(self.squeeze) / self.stiffness(step), 0.0)

    @property
    def may_pinch(self):
        """Whether there are two tools."""
        return len(self.tools) > 1

    def stiffness(self, step):
        """K (n,) [N/mm]. step : [s]"""
        tool = self.tools[0]
        return self.mass * (0.5 * tool.parameter if tool.law == PENALTY else 1.0 / step**2)

    def borne(self, squeeze):
        """b (n,) [N]. squeeze : (n,) [mm]"""
        kn = self.tools[0].run.kn
        return force_of(kn * (0.5 * squeeze - self.skin), kn * self.skin)

    def give_way(self, half_thickness, dt, dtm):
        """Count a step in which tools have pressed; after some of them, let nodes give way to what did.

        half_thickness : (n,) in contact [mm]; dt : the step [s], which may be far below the stable one; dtm : between
        the middles of the last two [s]
        """
        if not self.may_pinch:
            return
        self.span += dtm
        self.count += 1
        if self.count < STEPS:
            return
        sheet, state, stiffness = self.sheet, self.state.sheet, self.stiffness(dt)
        pressed = np.sort([tool.pressing for tool in self.tools], axis=0)[-2] / self.span
        bears, flows = self.borne(self.elastic + pressed / stiffness), False
        hard = pressed > LEAST_FLOW * sheet.blank.material.initial_yield_stress * sheet.area
        if hard.any():
            most = flow_of(sheet, state, half_thickness + 0.5 * self.elastic).force
            most[~hard] = np.inf
            flows = np.minimum(pressed, bears) > most
            bears = np.minimum(bears, most)
        gives = YIELDING * (pressed - bears) / stiffness
        self.elastic = np.maximum(self.elastic + np.where(flows, 0.0, gives), 0.0)
        state.flattened += np.where(flows, gives, 0.0)
        np.minimum(state.flattened, MOST_FLAT * sheet.blank.thickness, out=state.flattened)
        self.squeeze = self.elastic + pressed / stiffness
        for tool in self.tools:
            tool.pressing[:] = 0.0
        self.span, self.count = 0.0, 0

    def memory(self):
        """What the stage goes on with beside the state, {name: array}."""
        found = {"elastic": self.elastic.copy(), "squeeze": self.squeeze.copy()}
        found["pinch"] = np.array([self.span, self.count])
        return found | {f"pressing {tool.run.tool.name}": tool.pressing.copy() for tool in self.tools}

    def recall(self, memory):
        """Go on with what `memory` gave."""
        self.elastic, self.squeeze = memory["elastic"].copy(), memory["squeeze"].copy()
        self.span, self.count = float(memory["pinch"][0]), int(memory["pinch"][1])
        for tool in self.tools:
            tool.pressing[:] = memory[f"pressing {tool.run.tool.name}"]
