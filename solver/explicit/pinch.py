"""What a sheet between two tools gives way to them, in explicit steps: elastically and for good (theory.md 6).

Symbols, of a node: p force that presses it from both sides, on the mean of the last steps; K stiffness with which two
tools meet it; kn, h stiffness and depth of one of its skins and F flow force (contact/normal_law.py).

Two tools leave the sheet less room than its thickness, by q = e + p/K, where e is what contact takes it to be thinner.
Squeezed so, it bears b(q): the implicit solver's law, but for its setting in where the tools touch, 2 h later. Where p
is more than b, e grows, where it is less, e falls: between rigid tools q stays and p follows, of a tool that is driven
p stays and q follows. What presses beyond F makes the sheet thinner for good instead.
"""

import numpy as np
from numba import njit

from ..contact.flattening import flow_of
from ..contact.normal_law import elastic_force, force_of
from .laws import PENALTY

LEAST_FLOW = 0.25  # of the initial yield stress, on a node's initial area: no pinched node flows below
MOST_FLAT = 0.5  # of the thickness: the run ends with the next record
YIELDING, STEPS = 0.5, 20  # part of the way that a node gives at once, and how many steps press before it does


@njit(cache=True)
def pressed_between(pressing, pressed):
    """Fills pressed (n,) with what presses nodes from both sides: the second largest of pressing (k, n), of k tools,
    which begin to count anew."""
    for node in range(pressing.shape[1]):
        first = second = 0.0
        for tool in range(pressing.shape[0]):
            one = pressing[tool, node]
            pressing[tool, node] = 0.0
            first, second = max(first, one), max(second, min(first, one))
        pressed[node] = second


@njit(cache=True)
def yield_to(pressed, stiffness, most, kn, skin, flattest, elastic, flattened, squeeze):
    """Lets nodes give way to what presses them. All arrays (n,).

    pressed : p [N]; stiffness : K; most : F, inf where there is none [N]; kn; skin : h; flattest [mm]
    changes elastic : e, flattened [mm]; fills squeeze : q [mm]
    """
    for node in range(pressed.shape[0]):
        p, k, e = pressed[node], stiffness[node], elastic[node]
        if p > 0.0 or e > 0.0:
            band = kn[node] * skin
            bears = elastic_force(kn[node] * (0.5 * (e + p / k) - skin), band, False)[0]
            gives = YIELDING * (p - min(bears, most[node])) / k
            if min(p, bears) > most[node]:
                flattened[node] = min(flattened[node] + gives, flattest)
            else:
                elastic[node] = e = max(e + gives, 0.0)
        squeeze[node] = e + p / k


class Pinch:
    """The pinched nodes of one sheet in one stage.

    tools : ToolContacts; mass (n,) [tonne]; skin : h [mm]; step : stable one [s]
    """

    def __init__(self, sheet, state, tools, mass, skin, step):
        self.sheet, self.state, self.tools, self.mass = sheet, state, tools, mass[: len(sheet.points)]
        self.skin = skin
        self.span, self.count = 0.0, 0  # time [s] and steps over which the tools have counted what presses
        self.squeeze = state.squeeze - state.sheet.flattened  # q [mm]
        n = len(self.squeeze)
        self.elastic, self.pressed = np.zeros(n), np.zeros(n)  # e [mm], p [N]
        self.unyielding = np.full(n, np.inf)
        self.pressing = np.zeros((len(tools), n))
        for tool, row in zip(tools, self.pressing, strict=True):
            tool.pressing = row
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
        sheet, state, most = self.sheet, self.state.sheet, self.unyielding
        pressed_between(self.pressing, self.pressed)
        self.pressed /= self.span
        hard = self.pressed > LEAST_FLOW * sheet.blank.material.initial_yield_stress * sheet.area
        if hard.any():
            most = np.where(hard, flow_of(sheet, state, half_thickness + 0.5 * self.elastic).force, most)
        yield_to(
            self.pressed, self.stiffness(dt), most, self.tools[0].run.kn, self.skin,
            MOST_FLAT * sheet.blank.thickness, self.elastic, state.flattened, self.squeeze,
        )  # fmt: skip
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
