"""What a sheet between two tools gives way to them, in explicit steps: elastically and for good (theory.md 6).

Symbols, of a node: p force that presses it from both sides, on the mean of the last steps; F its flow force
(contact/flattening.py), so that its metal bears b = min(p, F); K stiffness with which two tools meet it; kn that of one
of its skins (ToolRun).

Pressed between two tools the sheet is to become thinner by 2 b / kn, and that comes back. Of this the tools leave it
b / K by how they meet it; the rest, e = b (2/kn - 1/K), contact takes the sheet to be thinner. What presses beyond F
makes it thinner for good.
"""

import numpy as np

from ..contact.flattening import flow_of
from .laws import PENALTY

LEAST_FLOW = 0.25  # of the initial yield stress, on a node's initial area: no pinched node flows below
MOST_FLAT = 0.5  # of the thickness: the run ends with the next record
YIELDING = 0.2  # part of the way that a node gives at once: its neighbours may come to help


class Pinch:
    """The pinched nodes of one sheet in one stage.

    tools : ToolContacts; mass (n,) [tonne]; step : stable one [s]
    """

    def __init__(self, sheet, state, tools, mass, step):
        self.sheet, self.state, self.tools, self.mass = sheet, state, tools, mass[: len(sheet.points)]
        self.span = 0.0  # time over which the tools have counted what presses [s]
        self.squeeze = state.squeeze - state.sheet.flattened  # elastic part, 2 b / kn [mm]
        self.elastic = np.zeros(len(self.squeeze))  # e [mm]
        if self.there:
            stiffness, rest = self.stiffness(step)
            self.elastic += 0.5 * tools[0].run.kn * rest * self.squeeze

    @property
    def there(self):
        """Whether two tools may meet."""
        return len(self.tools) > 1

    def stiffness(self, step):
        """K (n,) [N/mm], and what is left of a skin's compliance to contact, e / b (n,) [mm/N]."""
        tool = self.tools[0]
        stiffness = self.mass / step**2
        if tool.law == PENALTY:
            stiffness *= 0.5 * tool.parameter
        return stiffness, np.maximum(2.0 / tool.run.kn - 1.0 / stiffness, 0.0)

    def give_way(self, half_thickness, step):
        """Let nodes give way to what has pressed them in the last steps. half_thickness : (n,) in contact [mm]"""
        if self.there and self.span > 0.0:
            sheet, state = self.sheet, self.state.sheet
            pressed = np.sort([tool.pressing for tool in self.tools], axis=0)[-2] / self.span
            stiffness, rest = self.stiffness(step)
            borne = pressed
            hard = pressed > LEAST_FLOW * sheet.blank.material.initial_yield_stress * sheet.area
            if hard.any():
                borne = np.minimum(pressed, flow_of(sheet, state, half_thickness + 0.5 * self.elastic).force)
                state.flattened += YIELDING * (pressed - borne) / stiffness
                np.minimum(state.flattened, MOST_FLAT * sheet.blank.thickness, out=state.flattened)
            # Between rigid tools e takes from p what it gives: no step of it goes beyond where both agree.
            self.elastic += YIELDING / (1.0 + stiffness * rest) * (borne * rest - self.elastic)
            self.squeeze = self.elastic + borne / stiffness
        for tool in self.tools:
            tool.pressing[:] = 0.0
        self.span = 0.0
