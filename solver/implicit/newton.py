"""Newton's method on one increment: exact tangent, line search, augmentation of the contact forces."""

from dataclasses import dataclass, field

import numpy as np

from ..contact.drive import coordinates, move_tools
from ..contact.node_on_tool import OPEN

LINE_SEARCHES = 4
ACCEPT = 0.8  # share of the starting energy slope below which a step is taken as it is
AUGMENTATIONS = 10
LONGEST = 0.1  # movement of a node in one iteration, relative to the mesh size


@dataclass
class Outcome:
    """How an increment went. residuals: relative out-of-balance force of every iteration."""

    converged: bool = False
    iterations: int = 0
    augmentations: int = 0
    residuals: list = field(default_factory=list)
    reason: str = ""


def correction(solver, tangent, residual, balance, softest):
    """Movement of the nodes (n, 3) and of the tools that carry loads (k,) that the tangent asks for.

    Tools are eliminated by bordering. softest : least stiffness of a tool that touches nothing yet [N/mm]
    """
    solver.factorize(tangent.blocks)
    if not len(balance):
        return solver.solve(residual), balance
    answers = solver.solve(np.concatenate([residual[:, :, None], tangent.column], axis=2))
    free, coupled = answers[:, :, 0], answers[:, :, 1:]
    softer = np.diag(np.maximum(softest - np.diagonal(tangent.corner), 0.0))
    schur = tangent.corner + softer - np.einsum("ncj,nck->jk", tangent.row, coupled)
    tools = np.linalg.solve(schur, balance - np.einsum("ncj,nc->j", tangent.row, free))
    return free - coupled @ tools, tools


def solve_increment(equilibrium, solver, old, new, fraction, method, scale_floor):
    """Bring new into equilibrium, starting from the positions and travels it holds. Returns Outcome."""
    out = Outcome()
    thickness = equilibrium.sheet.blank.thickness
    for out.augmentations in range(AUGMENTATIONS + 1):
        iterate(equilibrium, solver, old, new, fraction, method, scale_floor, out)
        if not out.converged or deepest(new) <= method.penetration * thickness:
            return out
        for contact in new.tools.values():
            for foot in contact.feet:
                foot.multiplier[:] = foot.normal_force
        out.converged = False
    out.reason = f"overlap of {deepest(new):.1e} mm after {AUGMENTATIONS} augmentations"
    return out


def deepest(state):
    """Largest overlap [mm] of a node and the one tool it touches, at whichever foot.

    A node pinched between two tools is left out: there the overlap is the sheet's own squeeze, which no multiplier
    can take away from two rigid tools.
    """
    alone = np.sum([contact.touching for contact in state.tools.values()], axis=0) == 1
    feet = [foot for contact in state.tools.values() for foot in contact.feet]
    return max((-foot.gap[alone & (foot.status != OPEN)].min(initial=0.0) for foot in feet), default=0.0)


def iterate(equilibrium, solver, old, new, fraction, method, scale_floor, out):
    """Newton iterations at fixed multipliers; fills out."""
    newton, size = method.newton, equilibrium.sheet.size
    softest = 1e-3 * equilibrium.sheet.contact_stiffness * equilibrium.sheet.area.sum()
    residual, balance, scale = equilibrium.evaluate(old, new, fraction, first=True)
    error = relative(residual, balance, scale, scale_floor)
    last_step = np.inf
    for _ in range(newton.iterations):
        out.residuals.append(error)
        if not np.isfinite(error):
            out.reason = "the residual is not a number"
            return
        try:
            dx, dw = correction(solver, equilibrium.tangent(), residual, balance, softest)
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
        start = new.sheet.u.copy(), coordinates(equilibrium.driven, new)
        slope = np.sum(dx * residual) + dw @ balance
        error_before = error
        step = 1.0

        def at(step, start=start, dx=dx, dw=dw):
            new.sheet.u[:] = start[0] + step * dx
            move_tools(equilibrium.driven, new, start[1] + step * dw)
            return equilibrium.evaluate(old, new, fraction)

        residual, balance, scale = at(step)
        error = relative(residual, balance, scale, scale_floor)
        best = (error, step)
        tried = (0.0, slope)
        for _ in range(LINE_SEARCHES):
            energy = np.sum(dx * residual) + dw @ balance
            if error < error_before or abs(energy) <= ACCEPT * abs(slope) or error <= newton.residual:
                break
            # Secant on the energy slope, kept between a tenth and the whole of the last step.
            secant = step - energy * (step - tried[0]) / (energy - tried[1]) if energy != tried[1] else 0.5 * step
            tried = (step, energy)
            step = float(np.clip(secant, 0.1 * step, 0.7 * step))
            residual, balance, scale = at(step)
            error = relative(residual, balance, scale, scale_floor)
            best = min(best, (error, step))
        if best[1] != step:
            residual, balance, scale = at(best[1])
            error, step = best
        # The next correction, if the residual's fall goes on: what the movement still lacks.
        moved = step * np.abs(dx).max()
        lacking = moved * min(1.0, error / max(error_before, 1e-300)) if step == cap == 1.0 else moved
        if error <= newton.residual and lacking <= newton.correction * size:
            out.residuals.append(error)
            out.converged = True
            return
        last_step = moved
    out.reason = f"residual {error:.1e} of {newton.residual:.0e}, last movement {last_step:.1e} mm"


def relative(residual, balance, scale, floor):
    """Out-of-balance force relative to the forces in play."""
    return float(np.hypot(np.linalg.norm(residual), np.linalg.norm(balance)) / max(scale, floor))
