"""What a sheet between two tools gives way to them, in explicit steps: elastically and for good (theory.md 6).

Symbols, of a node: p force that presses it from both sides, on the mean of the last steps; K stiffness with which two
tools meet it; kn, h stiffness and depth of one of its skins (contact/node_on_tool.py); F flow force (contact/flow.py).

Two tools leave the sheet less room than its thickness, by q = e + p/K, where e is what contact takes it to be thinner.
Squeezed so, it bears b(q): the implicit solver's law, but for its setting in where the tools touch, 2 h later. Where p
is more than b, e grows, where it is less, e falls: between rigid tools q stays and p follows, of a tool that is driven
p stays and q follows. What presses beyond F makes the sheet thinner for good instead.
"""

import numpy as np

from ..contact.flattening import flow_of
from ..contact.node_on_tool import force_of
from .laws import PENALTY

LEAST_FLOW = 0.25  # of the initial yield stress, on a node's initial area: no pinched node flows below
MOST_FLAT = 0.5  # of the thickness: the run ends with the next record
GIVING, YIELDING, STEPS = 0.2, 0.5, 20  # part of the way that a node gives, elastically and for good, in so many steps


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
        if self.there:
            self.elastic = np.maximum(self.squeeze - self.borne(self.squeeze) / self.stiffness(step), 0.0)

    @property
    def there(self):
        """Whether two tools may meet."""
        return len(self.tools) > 1

    def stiffness(self, step):
        """K (n,) [N/mm]."""
        tool = self.tools[0]
        return self.mass * (0.5 * tool.parameter if tool.law == PENALTY else 1.0 / step**2)

    def borne(self, squeeze):
        """b (n,) [N]."""
        kn = self.tools[0].run.kn
        return force_of(kn * (0.5 * squeeze - self.skin), kn * self.skin)

    def count_step(self, dtm):
        """A step more in which the tools pressed."""
        self.span += dtm
        self.count += 1

    def give_way(self, half_thickness, step):
        """Let nodes give way to what has pressed them in the last steps.

        half_thickness : (n,) in contact [mm]; step : the last one [s], which may be far below the stable one
        """
        if self.there and self.span > 0.0:
            sheet, state, stiffness = self.sheet, self.state.sheet, self.stiffness(step)
            pressed = np.sort([tool.pressing for tool in self.tools], axis=0)[-2] / self.span
            bears, flows = self.borne(self.elastic + pressed / stiffness), False
            hard = pressed > LEAST_FLOW * sheet.blank.material.initial_yield_stress * sheet.area
            if hard.any():
                most = flow_of(sheet, state, half_thickness + 0.5 * self.elastic).force
                most[~hard] = np.inf
                flows = np.minimum(pressed, bears) > most
                bears = np.minimum(bears, most)
            part = 1.0 - (1.0 - np.where(flows, YIELDING, GIVING)) ** (self.count / STEPS)
            gives = part * np.where(pressed > 0.0, (pressed - bears) / stiffness, -self.elastic)
            self.elastic = np.maximum(self.elastic + np.where(flows, 0.0, gives), 0.0)
            state.flattened += np.where(flows, gives, 0.0)
            np.minimum(state.flattened, MOST_FLAT * sheet.blank.thickness, out=state.flattened)
            self.squeeze = self.elastic + pressed / stiffness
        for tool in self.tools:
            tool.pressing[:] = 0.0
        self.span, self.count = 0.0, 0
