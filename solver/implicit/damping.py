"""Past a limit point: damped increments, the last resort.

Where a sheet snaps, such as a flange that buckles under a light blank-holder, no equilibrium lies near the last one and
no increment is small enough. There every node is given a resistance c A du to its movement du over an increment, A its
tributary area: one step of implicit Euler in viscous motion, which has a solution where c is large enough. One such
step goes on with the stroke; more at the same stroke let the resistance fade until equilibrium holds without any.
What they dissipate stands in the energies, and the run says at which stroke they were needed.
"""

RESORT = 0.03  # cuts of an increment below this part of the stage's first one are given up for damping
STIFFEST = 1e4  # times the first resistance
FADE, FIRM = 0.1, 10.0  # factors of the resistance after a step that converged, or did not
FADED = 1e-4  # of the first resistance: the next step does without
PATIENCE = 40  # damped increments in a row


def first_resistance(sheet):
    """Resistance c to start with [N/mm^3]: the bending stiffness of one element per area, E t^3 / size^4."""
    return sheet.contact_stiffness * (sheet.blank.thickness / sheet.size) ** 2


def faded(damping, sheet):
    """Resistance of the next step: None once equilibrium holds without."""
    if damping is None or damping == 0.0:
        return None
    weaker = FADE * damping
    return weaker if weaker > FADED * first_resistance(sheet) else 0.0


def firmer(damping, sheet):
    """Resistance of the next try, inf where more would not help either."""
    firm = max(FIRM * damping, FIRM * FADED * first_resistance(sheet))
    return firm if firm <= STIFFEST * first_resistance(sheet) else float("inf")


def drag(damping, sheet, old, new):
    """Force of the resistance on the nodes at an increment's end, times -1, (n, 3) [N]."""
    return (damping or 0.0) * sheet.area[:, None] * (new.sheet.x - old.sheet.x)
