"""The implicit march through one stage: predict, solve, accept or cut back, grow."""

import logging
from typing import NamedTuple

import numpy as np

from ..elements.formulation import Membrane
from ..energy import work_of
from ..errors import StepFailed
from .damping import LIGHT, RESORT, Damper, dissipated
from .equilibrium import Equilibrium
from .newton import Outcome, solve_increment
from .sparse import SparseSolver

log = logging.getLogger("cadlink")
GROW, SHRINK, CUT = 1.5, 0.7, 0.3
NEGLIGIBLE = 1e-5  # unbalanced force at a stage's start, relative to the least scale of forces
RELIEF = 0.25  # first increment of what is relieved before a stage


class March(NamedTuple):
    """Where a stage stands. fraction : of the stage, 0..1; before that, -1..0, what the last stage left unbalanced is
    relieved; width : of the next increment; rate : (n + k, 3) and rates {tool: mm}, movement per fraction of the last
    increment, for the prediction; placed : {tool: (travel at the stage's start [mm], sign of the axis that leads to
    the sheet)}; relief : (n + k, 3) N unbalanced at the stage's start, None before it is known; damping : resistance in
    the next increment [N/mm^3], None where it has none (damping.py)."""

    fraction: float
    width: float
    rate: np.ndarray
    rates: dict
    placed: dict
    relief: np.ndarray | None = None
    damping: float | None = None


class Accepted(NamedTuple):
    """An increment that converged: the march after it, how Newton went, cut-backs before it, and the work of
    everything in it, {name: mJ}; notes: none."""

    march: March
    outcome: Outcome
    n_cut_backs: int
    work: dict
    notes: tuple = ()


def widths(stage, sheet, increments):
    """First and largest increment as fractions of the stage."""
    length = stage.path
    if length == 0.0:
        return 0.01, 0.05
    return (
        min(increments.first * sheet.blank.thickness / length, 0.1),
        min(increments.largest * sheet.size / length, 0.1),
    )


def start_march(stage, sheet, method, placed):
    """A stage not yet begun."""
    return March(-1.0, RELIEF, np.zeros(sheet.held.shape), {tool.name: 0.0 for tool in stage.tools}, placed)


def march(sheet, stage, tools, old, new, begun, method, stops):
    """Run a stage from `begun` on; yields Accepted after each increment, with the state in `old`.

    tools : ToolRuns; stops : rising fractions that increments end at exactly. Raises StepFailed.
    """
    equilibrium = Equilibrium(sheet, stage, tools, method, old)
    solver = SparseSolver(sheet.pattern.block_row, sheet.pattern.block_column, ~equilibrium.fixed)
    first, largest = widths(stage, sheet, method.increments)
    floor = 1e-3 * sheet.blank.material.initial_yield_stress * sheet.blank.thickness * sheet.size
    place = begun
    if place.relief is None:
        relief = equilibrium.unbalanced(old)
        place = place._replace(relief=relief)
        if np.linalg.norm(relief) <= NEGLIGIBLE * floor:
            # Nothing to relieve: tools that press find their balance in one go, without any the stage starts at once.
            place = place._replace(width=1.0) if equilibrium.driven else place._replace(fraction=0.0, width=first)
    equilibrium.loads.relief = place.relief
    end = 0.0 if stage.is_springback else 1.0
    damper, dragged, cuts = Damper(sheet), 0.0, 0
    if place.width == 0.0 and place.damping is None:
        # Resumed where damping was given up: the sheet is still on its way.
        place = place._replace(damping=damper.start())
    while place.fraction < end or place.damping is not None:
        relieving = place.fraction < 0.0
        least = 0.1 * RELIEF if relieving else first
        width, fraction = target(place, stops)
        equilibrium.damping, equilibrium.snapped = place.damping or 0.0, damper.known
        new.copy_from(old)
        predict(sheet, stage, tools, place, fraction, old, new)
        equilibrium.begin(old, new, max(fraction, 0.0) - max(place.fraction, 0.0))
        outcome = solve_increment(equilibrium, solver, old, new, fraction, method, floor)
        trail = " ".join(f"{r:.1e}" for r in outcome.residuals)
        if not outcome.converged:
            cuts += 1
            log.info("cut back at %.4f + %.2e: %s; residuals %s", place.fraction, width, outcome.reason, trail)
            place = retreat(place, width, least, damper, outcome.snaps)
            if place.damping == np.inf:
                raise failure(stage, sheet, place, f"{outcome.reason}, also with damping")
            continue
        log.info("fraction %.4f: %d iterations, residuals %s", fraction, outcome.iterations, trail)
        work = work_of(sheet, old, new, tools)
        rubbed = equilibrium.lost_in_beads(old, new)
        work["friction"] += rubbed
        work["external"] += rubbed
        lost, dragged = dissipated(dragged, place.damping, sheet, equilibrium.driven, old, new)
        # work_of takes sheet and tools to be in equilibrium: what the resistance holds comes from outside too.
        work["damping"] += lost
        work["external"] += lost
        largest_now = RELIEF if relieving else largest
        if place.damping is None or width > 0.0:
            place = onward(place, width, outcome.iterations, old, new, first, largest_now, method)
        if place.damping is not None:
            held = np.linalg.norm(dragged) > LIGHT * np.linalg.norm(new.sheet.internal)
            place = ease(place, outcome, damper, held or fraction in (0.0, end) or fraction in stops, least)
        place = place._replace(fraction=1.0 if fraction == end and place.damping is None else fraction)
        yield Accepted(place, outcome, cuts, work)
        if place.damping == np.inf:
            raise failure(stage, sheet, place, f"the sheet still moves after {damper.steps} damped steps")


def target(place, stops):
    """Width of the next increment and the fraction it ends at: no further than a stop, and no sliver before one."""
    if place.width == 0.0:
        return 0.0, place.fraction
    ahead = 0.0 if place.fraction < 0.0 else stops[np.searchsorted(stops, place.fraction + 1e-9)]
    if place.fraction + 1.2 * place.width >= ahead:
        return ahead - place.fraction, ahead
    return place.width, place.fraction + place.width


def retreat(place, width, least, damper, snaps):
    """The march after an increment that did not converge: a shorter one, then a damped one, then shorter ones with more
    damping; without end (inf) where that does not help either."""
    if place.damping is not None:
        return place._replace(damping=damper.after_failure(place.damping), width=CUT * width)
    shortest = np.inf if snaps and damper.known else RESORT * least
    if CUT * width >= shortest and place.fraction >= 0.0:
        return place._replace(width=CUT * width)
    log.info("no equilibrium nearby: damped increments")
    # The resistance holds back what moves with the tools, too: that takes a short step, but where no tool travels.
    return place._replace(damping=damper.start(), width=least if place.fraction >= 0.0 else max(CUT * width, least))


def ease(place, outcome, damper, waits, least):
    """The march after a damped increment: less damping in the next one, which goes on with the stroke unless it waits:
    for the resistance to become light, and at stops for equilibrium without any."""
    damping = damper.after_success(place.damping, outcome.iterations)
    if waits and damping is not None:
        return place._replace(damping=damping, width=0.0, rate=0.0 * place.rate, rates=dict.fromkeys(place.rates, 0.0))
    return place._replace(damping=damping, width=place.width or CUT * least)


def onward(place, width, iterations, old, new, first, largest, method):
    """The march after an accepted increment: its rates, and the width of the next one."""
    if place.fraction < 0.0:
        rate, rates = np.zeros_like(place.rate), dict.fromkeys(place.rates, 0.0)
    else:
        rate = (new.sheet.u - old.sheet.u) / width
        rates = {k: float(c.travel[0] - old.tools[k].travel[0]) / width for k, c in new.tools.items()}
    if place.fraction < 0.0 <= place.fraction + 1.0000001 * width:
        return place._replace(width=first, rate=rate, rates=rates)
    scale = GROW if iterations <= method.increments.swift else SHRINK if iterations > method.increments.slow else 1.0
    # A stop that shortened this increment does not shorten the next.
    wider = max(scale * width, place.width if scale >= 1.0 else 0.0)
    return place._replace(width=min(wider, largest), rate=rate, rates=rates)


def failure(stage, sheet, place, reason):
    """StepFailed of a stage that does not come on: where, why, and what a user can do."""
    shell = "; a membrane does not resist compression, a shell does"
    remedy = "refine the mesh or lower the load" + (shell if isinstance(sheet.blank.element, Membrane) else "")
    return StepFailed(f"stage {stage.name!r} at {100 * max(place.fraction, 0.0):.2f} %: {reason}; {remedy}")


def predict(sheet, stage, tools, place, fraction, old, new):
    """Move the tools, the prescribed nodes, and the rest of the sheet as it moved last."""
    width = max(fraction, 0.0) - max(place.fraction, 0.0)
    shift = width * place.rate
    stroke = max((abs(tool.travel) for tool in stage.tools if tool.travel is not None), default=0.0)
    farthest = width * stroke
    if farthest > 0.0:
        # A node that snapped over in the last increment will not do so again: none outruns the tools.
        length = np.linalg.norm(shift, axis=1)[:, None]
        shift *= farthest / np.maximum(length, farthest)
    new.sheet.u[:] = old.sheet.u + shift
    for group, movement in stage.movements.items():
        nodes = sheet.blank.nodes_of(group)
        for axis, distance in enumerate(movement):
            if distance is not None:
                new.sheet.x[nodes, axis] = old.sheet.x[nodes, axis] + width * distance
    for run in tools:
        travel = old.tools[run.tool.name].travel[0]
        if run.tool.travel is not None:
            travel = run.start + max(fraction, 0.0) * run.tool.travel
        elif run.drive is not None:
            travel += width * place.rates[run.tool.name]
        new.tools[run.tool.name].travel[0] = travel
