"""The implicit march through one stage: predict, solve, accept or cut back, grow."""

import logging
from typing import NamedTuple

import numpy as np

from ..contact.flattening import pressed_flat
from ..elements.formulation import Membrane
from ..energy import work_of
from ..errors import StepFailed
from .equilibrium import Equilibrium
from .inertia import LIGHT, PATIENCE, RESORT, SLACKEN, Inertia, Motion
from .newton import Outcome, solve_increment
from .sparse import SparseSolver

log = logging.getLogger("cadlink")
GROW, SHRINK, CUT = 1.5, 0.7, 0.3
DYNAMIC = 6  # iterations of an increment with inertia that does not grow
CREEP = 0.1  # width of an increment with inertia, relative to the first, that is no progress
FAR = 0.1  # by which nodes may outrun the tools in it, relative to the mesh size
NEGLIGIBLE = 1e-5  # unbalanced force at a stage's start, relative to the least scale of forces
RELIEF = 0.25  # first increment of what is relieved before a stage


class March(NamedTuple):
    """Where a stage stands. fraction : of the stage, 0..1; before that, -1..0, what the last stage left unbalanced is
    relieved; width : of the next increment; rate : (n + k, 3) and rates {tool: mm}, movement per fraction of the last
    increment, for the prediction; placed : {tool: (travel at the stage's start [mm], sign of the axis that leads to
    the sheet)}; relief : (n + k, 3) N unbalanced at the stage's start, None before it is known; mass : of the sheet in
    the next increment [N/mm^3], None where it has none (inertia.py); settles : tools stand until it is at rest;
    memory : {name: array} of what an explicit stage goes on with beside the state."""

    fraction: float
    width: float
    rate: np.ndarray
    rates: dict
    placed: dict
    relief: np.ndarray | None = None
    mass: float | None = None
    settles: bool = False
    memory: dict | None = None


class Accepted(NamedTuple):
    """An increment that converged: the march after it, how Newton went, cut-backs before it, and the work of
    everything in it, {name: mJ}; notes: none."""

    march: March
    outcome: Outcome
    n_cut_backs: int
    work: dict
    notes: tuple = ()


class Widths(NamedTuple):
    """First and largest increment as fractions of the stage; way : that nodes may outrun the tools by in one, and path
    of the fastest tool [mm]; swift, slow : see method.py."""

    first: float
    largest: float
    way: float
    path: float
    swift: int
    slow: int


def widths(stage, sheet, increments):
    """Widths of a stage's increments."""
    first, largest, path = 0.01, 0.05, stage.path
    if path > 0.0:
        first = min(increments.first * sheet.blank.thickness / path, 0.1)
        largest = min(increments.largest * sheet.size / path, 0.1)
    return Widths(first, largest, FAR * sheet.size, path, increments.swift, increments.slow)


def start_march(stage, sheet, method, placed):
    """A stage not yet begun."""
    return March(-1.0, RELIEF, np.zeros(sheet.held.shape), {tool.name: 0.0 for tool in stage.tools}, placed)


def march(sheet, stage, tools, old, new, begun, method, stops):
    """Run a stage from `begun` on; yields Accepted after each increment, with the state in `old`.

    tools : ToolRuns; stops : rising fractions that increments end at exactly. Raises StepFailed.
    """
    equilibrium = Equilibrium(sheet, stage, tools, method, old)
    solver = SparseSolver(sheet.pattern.block_row, sheet.pattern.block_column, ~equilibrium.fixed)
    limits = widths(stage, sheet, method.increments)
    floor = 1e-3 * sheet.blank.material.initial_yield_stress * sheet.blank.thickness * sheet.size
    place = begun
    if place.relief is None:
        relief = equilibrium.unbalanced(old)
        place = place._replace(relief=relief)
        if np.linalg.norm(relief) <= NEGLIGIBLE * floor:
            # Nothing to relieve: tools that press find their balance in one go, without any the stage starts at once.
            presses = bool(equilibrium.driven)
            place = place._replace(width=1.0) if presses else place._replace(fraction=0.0, width=limits.first)
    equilibrium.loads.relief = place.relief
    end = 0.0 if stage.is_springback else 1.0
    inertia, pushed, cuts, astray, rested, failed = Inertia(sheet), 0.0, 0, 0, place.fraction, False
    while place.fraction < end or place.settles:
        relieving = place.fraction < 0.0
        least = 0.1 * RELIEF if relieving else limits.first
        width, fraction = target(place, stops)
        motion = Motion(sheet, equilibrium.driven, place.mass, width, place.rate, place.rates)
        equilibrium.motion, equilibrium.snapped = motion, inertia.known
        equilibrium.puts_back = not failed  # what has not helped is left out of the next attempt
        new.copy_from(old)
        predict(sheet, stage, tools, place, fraction, old, new)
        equilibrium.begin(old, new, max(fraction, 0.0) - max(place.fraction, 0.0))
        outcome = solve_increment(equilibrium, solver, old, new, fraction, method, floor)
        trail = " ".join(f"{r:.1e}" for r in outcome.residuals)
        outcome.dynamic, failed = place.mass is not None, not outcome.converged
        if failed:
            cuts += 1
            log.info("cut back at %.4f + %.2e: %s; residuals %s", place.fraction, width, outcome.reason, trail)
            place = retreat(place, width, least, inertia, outcome.snaps)
            flat = pressed_flat(sheet, new) if place.mass is not None else ""
            if flat or place.mass == np.inf:
                raise failure(stage, sheet, place, flat or f"{outcome.reason}, also with inertia")
            continue
        kind = f"{width:.1e} with inertia" if outcome.dynamic else "static"
        log.info("fraction %.4f (%s): %d iterations, residuals %s", fraction, kind, outcome.iterations, trail)
        equilibrium.flatten(new)
        work = work_of(sheet, old, new, tools)
        rubbed = equilibrium.lost_in_beads(old, new)
        work["friction"] += rubbed
        work["external"] += rubbed
        before, pushed = pushed, motion.forces(old, new)
        lost = motion.work(before, pushed, old, new)
        # work_of takes sheet and tools to be in equilibrium: what inertia holds comes from outside too.
        work["damping"] += lost
        work["external"] += lost
        light = np.linalg.norm(pushed) <= LIGHT * np.linalg.norm(new.sheet.internal)
        stands = place.settles or fraction <= 0.0 or width < CREEP * least
        astray = astray + 1 if outcome.dynamic and stands else 0
        rested = rested if outcome.dynamic else fraction
        place = onward(place, width, fraction, outcome, old, new, limits)
        place = come_to_rest(place, width, inertia, light, fraction in (0.0, end), limits.first)
        if fraction == end and not place.settles:
            place = place._replace(fraction=1.0)  # springback ends with what is relieved
        yield Accepted(place, outcome, cuts, work)
        if flat := pressed_flat(sheet, new):
            raise failure(stage, sheet, place, flat)
        if astray > PATIENCE:
            reason = f"the sheet finds no rest since {100 * max(rested, 0.0):.2f} %, and steps no longer lead on"
            raise failure(stage, sheet, place, reason)


def target(place, stops):
    """Width of the next increment and the fraction it ends at: no further than a stop, and no sliver before one."""
    if place.settles:
        return place.width, place.fraction
    ahead = 0.0 if place.fraction < 0.0 else stops[np.searchsorted(stops, place.fraction + 1e-9)]
    if place.fraction + 1.2 * place.width >= ahead:
        return ahead - place.fraction, ahead
    return place.width, place.fraction + place.width


def retreat(place, width, least, inertia, snaps):
    """The march after an increment that did not converge: a shorter one; one with inertia where none is short enough;
    with more of it where that does not help either, and without end (inf) in the end."""
    if place.mass is None:
        at_once = place.settles or snaps and inertia.known
        shortest = np.inf if at_once else least if place.fraction < 0.0 else RESORT * least
        if CUT * width >= shortest:
            return place._replace(width=CUT * width)
        log.info("no equilibrium nearby: increments with inertia")
        return place._replace(mass=inertia.first(), width=max(CUT * width, least))
    if CUT * width >= RESORT * least:
        return place._replace(width=CUT * width)
    return place._replace(mass=inertia.after_failure(place.mass), width=least)


def onward(place, width, fraction, outcome, old, new, limits):
    """The march after an accepted increment: where it is, its rates, and the width of the next one."""
    rate = (new.sheet.u - old.sheet.u) / width
    rates = {k: float(c.travel[0] - old.tools[k].travel[0]) / width for k, c in new.tools.items()}
    if fraction <= 0.0 and place.mass is None:
        rate, rates = 0.0 * rate, dict.fromkeys(rates, 0.0)
    scale = GROW if outcome.iterations <= limits.swift else SHRINK if outcome.iterations > limits.slow else 1.0
    if place.mass is not None:
        # A sheet on its way to elsewhere goes there in short steps of a few iterations.
        ahead = np.abs(new.sheet.x - old.sheet.x).max() - width * limits.path
        scale = np.clip(min(DYNAMIC / outcome.iterations, limits.way / max(ahead, 1e-6 * limits.way)), SHRINK, GROW)
    # A stop that shortened this increment does not shorten the next.
    wider = max(scale * width, place.width if scale >= 1.0 else 0.0)
    largest = RELIEF if place.fraction < 0.0 else limits.largest
    return place._replace(fraction=fraction, width=min(wider, largest), rate=rate, rates=rates)


def come_to_rest(place, width, inertia, light, stands, first):
    """The march after an increment with or without inertia: less of it in the next one, and where the tools stand, rest
    before they go on. width : of this increment; light : inertia was small in it"""
    if place.mass is None:
        return place._replace(settles=False, width=first) if stands else place
    mass = inertia.after_success(place.mass, light)
    if not stands:
        return place._replace(mass=mass)
    # What stands still loses its speed from step to step, so that a tool does not fly off the sheet.
    rest, rests = 0.0 * place.rate, dict.fromkeys(place.rates, 0.0)
    mass = None if light else mass or place.mass
    return place._replace(mass=mass, settles=True, width=SLACKEN * width, rate=rest, rates=rests)


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
    if farthest > 0.0 and place.mass is not None:
        # A node that snapped over in the last increment will not do so again: none outruns the tools. (Without inertia
        # it may: the crests of a flange that wrinkles rise faster than the punch comes down, for as long as it does.)
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
