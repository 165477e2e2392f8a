"""Newton's method on one increment: exact tangent, line search, augmentation of the contact forces."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..contact.drive import coordinates, move_tools
from ..contact.node_on_tool import OPEN

LINE_SEARCHES = 4
ACCEPT = 0.8  # share of the starting energy slope below which a step is taken as it is
AUGMENTATIONS = 10
UPHILL = 3  # corrections against the residual: no stable equilibrium is near
BUCKLING = 3e-5, 1e-2  # residuals that tell of that, and not of a contact that opens and closes
STALL = 8  # iterations in which the residual has to halve
LONGEST = 0.1  # movement of a node in one iteration, relative to the mesh size


@dataclass
class Outcome:
    """How an increment went. residuals: relative out-of-balance force of every iteration; dynamic: it had inertia;
    snaps: corrections kept going against the residual, as where the sheet buckles."""

    converged: bool = False
    snaps: bool = False
    iterations: int = 0
    dynamic: bool = False
    augmentations: int = 0
    residuals: list = field(default_factory=list)
    reason: str = ""


def solve_increment(equilibrium, solver, old, new, fraction, method, scale_floor):
    """Bring new into equilibrium, starting from the positions and travels it holds. Returns Outcome."""
    out = Outcome()
    thickness = equilibrium.sheet.blank.thickness
    for out.augmentations in range(AUGMENTATIONS + 1):
        iterate(equilibrium, solver, old, new, fraction, method, scale_floor, out)
        if not out.converged or deepest(new) <= method.penetration * thickness:
            return out
        augment(equilibrium, new)
        out.converged = False
    out.reason = f"overlap of {deepest(new):.1e} mm after {AUGMENTATIONS} augmentations"
    return out


def augment(equilibrium, new):
    """Multipliers take over the forces of nodes that touch one tool, which go back onto its face with the force they
    have."""
    still = np.zeros_like(new.sheet.u), 0.0 * coordinates(equilibrium.driven, new)
    foreseen, alone = equilibrium.foresee(*still), on_one_tool(new)
    for contact in new.tools.values():
        for foot in contact.feet:
            foot.multiplier[alone] = foot.normal_force[alone]
    equilibrium.put_back(new, foreseen, 0.0)


def on_one_tool(state):
    """Whether a node touches one tool, (n,). One pinched between two is none of augmentation's: there the overlap is
    the sheet's own squeeze, which no multiplier can take away from two rigid tools."""
    return np.sum([contact.touching for contact in state.tools.values()], axis=0) == 1


def deepest(state):
    """Largest overlap [mm] of a node and the one tool it touches, at whichever foot."""
    alone = on_one_tool(state)
    feet = [foot for contact in state.tools.values() for foot in contact.feet]
    return max((-foot.gap[alone & (foot.status != OPEN)].min(initial=0.0) for foot in feet), default=0.0)


def iterate(equilibrium, solver, old, new, fraction, method, scale_floor, out):
    """Newton iterations at fixed multipliers; fills out."""
    newton, size = method.newton, equilibrium.sheet.size
    softest = least_stiffnesses(equilibrium.driven, equilibrium.skin, size)
    if equilibrium.motion.stiffness:
        softest = 0.0 * softest  # inertia carries a tool that nothing else does

    def trial(first=False):
        residual, balance, scale = equilibrium.evaluate(old, new, fraction, first)
        return Trial(residual, balance, relative(residual, balance, scale, scale_floor))

    here, moved, uphill, begun = trial(first=not out.residuals), np.inf, 0, len(out.residuals)
    least = 0.0 if equilibrium.snapped else BUCKLING[0]
    for _ in range(newton.iterations):
        out.residuals.append(here.error)
        if not np.isfinite(here.error):
            out.reason = "the residual is not a number"
            return
        try:
            dx, dw = correction(solver, equilibrium.tangent(), here, softest)
        except (RuntimeError, np.linalg.LinAlgError):
            out.reason = "the tangent is singular"
            return
        out.iterations += 1
        # No node moves by more than a part of an element at once.
        longest = max(np.abs(dx).max(), np.abs(dw).max(initial=0.0))
        if not np.isfinite(longest):
            out.reason = "the correction is not a number"
            return
        cap = min(1.0, LONGEST * size / longest) if longest > 0.0 else 1.0
        dx, dw = cap * dx, cap * dw
        uphill += least < here.error < BUCKLING[1] and here.along(dx, dw) < 0.0
        if uphill > UPHILL:
            out.snaps, out.reason = True, "the sheet snaps"
            return
        before = here
        here, step = line_search(trial, before, Path(equilibrium, new, dx, dw), newton.residual)
        if stalls(out.residuals[begun:], here.error):
            out.residuals.append(here.error)
            out.converged = here.error <= max(newton.enough, newton.residual)
            out.reason = f"the residual stays at {here.error:.1e}"
            return
        # The next correction, if the residual's fall goes on: what the movement still lacks.
        moved = step * np.abs(dx).max()
        lacking = moved * min(1.0, here.error / max(before.error, 1e-300)) if step == cap == 1.0 else moved
        if here.error <= newton.residual and lacking <= newton.correction * size:
            out.residuals.append(here.error)
            out.converged = True
            return
    out.reason = f"residual {here.error:.1e} of {newton.residual:.0e}, last movement {moved:.1e} mm"


def correction(solver, tangent, here, softest):
    """Movement of the unknowns (n + k, 3) and of the tools that carry loads (j,), eliminated by bordering, that the
    forces out of balance ask for. softest : (j,) least stiffness of a tool under its load [N/mm]"""
    solver.factorize(tangent.blocks)
    free = solver.solve(here.residual)
    if not len(softest):
        return free, here.balance
    coupled = solver.solve(tangent.column)
    softer = np.diag(np.maximum(softest - np.diagonal(tangent.corner), 0.0))
    schur = tangent.corner + softer - np.einsum("ncj,nck->jk", tangent.row, coupled)
    tools = np.linalg.solve(schur, here.balance - np.einsum("ncj,nc->j", tangent.row, free))
    return free - coupled @ tools, tools


def stalls(residuals, last):
    """Whether the residual has not halved in the last iterations, as where a node comes and goes."""
    return len(residuals) > STALL and min([*residuals[-STALL + 1 :], last]) > 0.5 * min(residuals[: -STALL + 1])


class Trial(NamedTuple):
    """Out-of-balance forces at trial positions: of the unknowns (n + k, 3), of the driven tools (j,), and their size
    relative to the forces in play."""

    residual: np.ndarray
    balance: np.ndarray
    error: float

    def along(self, dx, dw):
        """Work of the forces over a movement of unknowns and tools [mJ]."""
        return float(np.sum(dx * self.residual) + dw @ self.balance)


class Path:
    """Positions and coordinates of the driven tools along a correction, from where a state has them; nodes that touch
    stay on their tools."""

    def __init__(self, equilibrium, state, dx, dw):
        self.equilibrium, self.state, self.dx, self.dw = equilibrium, state, dx, dw
        self.start = state.sheet.u.copy(), coordinates(equilibrium.driven, state)
        self.foreseen = equilibrium.foresee(dx, dw)

    def go(self, step):
        """Move to a part of the correction."""
        self.state.sheet.u[:] = self.start[0] + step * self.dx
        move_tools(self.equilibrium.driven, self.state, self.start[1] + step * self.dw)
        self.equilibrium.put_back(self.state, self.foreseen, step)


def line_search(trial, before, path, enough):
    """Go along a correction as far as it helps. Returns (Trial there, part of the correction taken).

    The whole correction is taken where the residual falls or the work along it fades; else secants of that work say how
    far to go. enough : relative residual that needs no search
    """
    slope = before.along(path.dx, path.dw)
    step, tried, best = 1.0, (0.0, slope), None
    for search in range(LINE_SEARCHES + 1):
        path.go(step)
        here = trial()
        best = min(best or (here.error, step), (here.error, step))
        work = here.along(path.dx, path.dw)
        if here.error < before.error or abs(work) <= ACCEPT * abs(slope) or here.error <= enough:
            break
        if search < LINE_SEARCHES:
            # Secant on the work, kept between a tenth and the whole of the last step.
            secant = step - work * (step - tried[0]) / (work - tried[1]) if work != tried[1] else 0.5 * step
            tried = (step, work)
            step = float(np.clip(secant, 0.1 * step, 0.7 * step))
    if best[1] != step:
        step = best[1]
        path.go(step)
        here = trial()
    return here, step


def least_stiffnesses(driven, skin, size):
    """Stiffness (k,) [N/mm] of driven tools that one node alone holds up, one element off the axis they tilt about: the
    slope of the rounded contact law where its force is the tool's load. Under the load no tool is softer, so that the
    exact tangent is kept where it matters."""
    found = []
    for run in driven:
        stiffness, drive = float(run.kn.min()), run.drive
        load = max(drive.load, drive.stiffness * skin)
        guided = stiffness * min(1.0, np.sqrt(load / (stiffness * skin)))
        found += [guided, *[guided * min(1.0, size / drive.lever) ** 2] * len(drive.axes)]
    return np.array(found)


def relative(residual, balance, scale, floor):
    """Out-of-balance force relative to the forces in play."""
    return float(np.hypot(np.linalg.norm(residual), np.linalg.norm(balance)) / max(scale, floor))
