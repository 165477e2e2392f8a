"""Past a limit point: damped increments, the last resort.

Where a sheet snaps, such as a flange that buckles under a light blank-holder, no equilibrium lies near the last one and
no increment is small enough. There every node is given a resistance c A du to its movement du over an increment, A its
tributary area: one step of implicit Euler in viscous motion, which has a solution where c is large enough. A tool
driven by a force is held back like all nodes together, so that it does not fall where nothing carries it yet. The
resistance fades from step to step; the stroke goes on once it is light, and waits for equilibrium without any where a
frame is due.
What they dissipate stands in the energies, and the run says at which stroke they were needed.
"""

import numpy as np

from ..contact.drive import coordinates

RESORT = 0.03  # cuts of an increment below this part of the stage's first one are given up for damping
STIFFEST = 1e4  # times the first resistance
LIGHT = 1e-3  # resistance relative to the forces in the sheet: the stroke may go on
FADED = 1e-4  # of the first resistance: the next step does without
QUICK, SLOW = 4, 12  # iterations up to which the resistance fades fast, above which it stays
QUICK_FADE, FADE, FIRM = 0.03, 0.2, 5.0  # factors of the resistance after a quick step, another, and one that failed
REST = 3  # steps after a failure that do not fade
PATIENCE = 200  # damped steps in a row


class Damper:
    """Chooses the resistance c [N/mm^3] of damped steps, one after the other; None stands for no damping.

    known : the sheet has snapped in this stage, so that one that seems to do so again is damped at once
    """

    def __init__(self, sheet):
        # The bending stiffness of one element per area, E t^3 / size^4.
        self.first = sheet.contact_stiffness * (sheet.blank.thickness / sheet.size) ** 2
        self.rest = self.steps = 0
        self.known = False

    def start(self):
        """Resistance of the first damped step."""
        self.rest = self.steps = 0
        self.known = True
        return self.first

    def after_success(self, damping, iterations):
        """Resistance of the next step: None once equilibrium holds without, inf where the sheet moves on and on."""
        self.steps += 1
        if damping == 0.0:
            return None
        if self.steps >= PATIENCE:
            return float("inf")
        self.rest = max(0, self.rest - 1)
        if self.rest or iterations > SLOW:
            return damping
        faded = damping * (QUICK_FADE if iterations <= QUICK else FADE)
        return faded if faded > FADED * self.first else 0.0

    def after_failure(self, damping):
        """Resistance of the next try, inf where more would not help either."""
        self.steps += 1
        self.rest = REST
        firm = FIRM * max(damping, FADED * self.first)
        return firm if firm <= STIFFEST * self.first and self.steps < PATIENCE else float("inf")


def drag(damping, sheet, old, new):
    """Force of the resistance on the nodes at an increment's end, times -1, (n, 3) [N]."""
    return (damping or 0.0) * sheet.area[:, None] * (new.sheet.x - old.sheet.x)


def tool_drag(damping, sheet, driven, old, new):
    """The same on the coordinates of driven tools, (k,) [N]. driven : ToolRuns"""
    return (damping or 0.0) * sheet.area.sum() * (coordinates(driven, new) - coordinates(driven, old))


def dissipated(before, damping, sheet, driven, old, new):
    """Work the resistance takes over an increment [mJ], and its forces at the end, to be `before` of the next one."""
    forces = np.append(drag(damping, sheet, old, new), tool_drag(damping, sheet, driven, old, new))
    moved = np.append(new.sheet.x - old.sheet.x, coordinates(driven, new) - coordinates(driven, old))
    return 0.5 * float((before + forces) @ moved), forces
