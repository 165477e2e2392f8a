"""The explicit march through one stage: step by step (`dynamics.py`), and a record now and then.

A stage is prepared over fractions -1..0 of its own: what the last one left unbalanced fades, and tools that press come
to bear. Then the tools travel, 0..1, as `pacing.py` says. Records come at equal steps of the stroke; forces in them
are means over the time since the last one.
"""

import logging
from typing import NamedTuple

import numpy as np

from ..contact.flattening import pressed_flat
from ..energy import NAMES
from ..errors import StepFailed
from ..implicit.increments import March
from .dynamics import Dynamics

log = logging.getLogger("cadlink")
RECORDS = 200  # of a stage, about
LOOKS = 50  # at the stable step in a stage, and more where triangles shrink: a look costs some 20 steps
CREEP = 1e-3  # change of the step from one to the next
LONGER = 0.02  # part by which steps to a stop may exceed the stable step (`safety` of the limit) as it shrinks


class Steps(NamedTuple):
    """How the steps since the last record went."""

    iterations: int
    residuals: list
    dynamic: bool = False  # as an exception


class Recorded(NamedTuple):
    """What the march yields: see implicit Accepted. work : {name: mJ} since the last record; notes : what the stage
    chose by itself, with its first record."""

    march: March
    outcome: Steps
    n_cut_backs: int
    work: dict
    notes: tuple


def start_march(stage, sheet, placed):
    """A stage not yet begun, its sheet at rest."""
    return March(-1.0, 0.0, np.zeros(sheet.held.shape), {tool.name: 0.0 for tool in stage.tools}, placed)


def march(sheet, stage, tools, old, new, begun, method, stops):
    """Run a stage from `begun` on; yields Recorded, with the state in `new` and the one recorded before in `old`.

    tools : ToolRuns; stops : rising fractions that are met exactly. Raises StepFailed.
    """
    new.copy_from(old)
    dynamics = Dynamics(sheet, stage, tools, new, method, begun)
    pacing = dynamics.pacing
    relief = begun.relief if begun.relief is not None else dynamics.unbalanced()
    presses = any(run.drive is not None for run in tools)
    place = begun._replace(relief=relief)
    relieves = dynamics.relieve(relief)
    # Springback is over once what was in balance has faded; what relaxes is then brought to rest.
    end = 0.0 if stage.is_springback else 1.0
    relaxation = dynamics.relaxation
    if place.fraction == -1.0 and not (relieves or presses or dynamics.overlap.any()):
        place = place._replace(fraction=0.0, settles=end == 0.0)
    time = pacing.time(place.fraction)
    notes = dynamics.notes(pacing.time(end) - time)
    log.info("%s", "; ".join(notes))
    dt = place.width if place.width > 0.0 else dynamics.limit
    balance = Balance(sheet, method)
    recorded, look, steps = time, time if begun.memory is None else float(begun.memory["pace"][5]), 0
    while place.fraction < end or place.settles:
        if place.settles:
            target = due = np.inf
        else:
            target = 0.0 if time < 0.0 else pacing.time(stops[np.searchsorted(stops, place.fraction + 1e-9)])
            due = min(target, pacing.time(record_after(place.fraction)))
        while time < due:
            if time - look > pacing.duration / LOOKS or dynamics.overdue():
                dynamics.look()
                look = time
            shortest = dynamics.shortest()
            before, dt = dt, min(max(shortest, (1.0 - CREEP) * dt), (1.0 + CREEP) * dt)
            # Equal steps up to the next stop, and no sudden change: a node pinched between tools would feel it.
            ahead = np.inf
            if target < np.inf:
                ahead = steps_ahead(target - time, before, dt, (1.0 + LONGER) * shortest)
                dt = (target - time) / ahead
            after = target if ahead == 1 else time + dt
            dynamics.step(time, dt, before, place.settles or after >= due)
            time = after
            steps += 1
            told = dynamics.relax(dt, before)
            if not np.isfinite(dynamics.kinetic + dynamics.work["internal"]):
                raise StepFailed(
                    f"stage {stage.name!r} at {100 * place.fraction:.2f} %: not-a-number velocities or stresses after "
                    f"{dynamics.count} steps of {dt:.2e} s; lower safety below {method.safety:g}"
                )
            if told and place.settles:
                break
        fraction = time / pacing.preparation if time < 0.0 else pacing.fraction(time)
        if place.settles:
            fraction = end
        elif time == target:
            fraction = 0.0 if time == 0.0 else stops[np.searchsorted(stops, place.fraction + 1e-9)]
        work = dynamics.record(time - recorded)
        drift = balance.add(work)
        if drift > method.drift:
            raise StepFailed(
                f"stage {stage.name!r} at {100 * fraction:.2f} %: energy drifts by {100 * drift:.1f} % of the work "
                f"done, limit {100 * method.drift:g} %; lower safety below {method.safety:g}"
            )
        if flat := pressed_flat(sheet, new):
            raise StepFailed(f"stage {stage.name!r} at {100 * max(fraction, 0.0):.2f} %: {flat}; lower the load")
        settles = relaxation is not None and fraction == end and not (place.settles and relaxation.at_rest)
        if settles and relaxation.elapsed > relaxation.patience:
            raise StepFailed(
                f"stage {stage.name!r}: the sheet still moves after {dynamics.count} steps of dynamic relaxation; "
                "support it, or give it Explicit(relax=False)"
            )
        if relaxation is not None and fraction == end and not settles:
            notes += (relaxation.note(stage, dynamics.count, balance.sums["damping"] / sheet.blank.share),)
        if fraction == end and not settles:
            notes += dynamics.damped_springs()
        place = place._replace(
            fraction=1.0 if fraction == end and not settles else float(fraction),
            settles=settles,
            width=dt,
            rate=dynamics.v.copy(),
            rates={tool.run.tool.name: tool.rates.tolist() for tool in dynamics.tools},
            memory=dynamics.memory(look),
        )
        outcome = Steps(steps, [drift])
        recorded, steps = time, 0
        yield Recorded(place, outcome, 0, work, notes)
        notes = ()


def steps_ahead(left, before, wanted, longest):
    """Number of equal steps over a time left [s]: of the wanted length at most, but as many as there were to be with
    the step before while they are no longer than the longest. As the stable step shrinks, one more would halve the last
    two."""
    planned = max(round(left / before), 1)
    needed = max(int(np.ceil(left / wanted - 1e-6)), 1)
    return planned if planned < needed and left / planned <= longest else needed


def record_after(fraction):
    """The next fraction at which a record is due."""
    k = np.floor(fraction * RECORDS + 1e-9) + 1.0
    return min(float(k / RECORDS), 1.0)


class Balance:
    """Sums of work over the stage, and their drift."""

    def __init__(self, sheet, method):
        material = sheet.blank.material
        volume = sheet.triangles.volume.sum()
        # Below a hundredth of what the whole sheet can store elastically a share says nothing.
        self.floor = 0.01 * material.initial_yield_stress**2 / material.young * volume
        self.sums = dict.fromkeys(NAMES, 0.0)

    def add(self, work):
        """Energy not accounted for so far, relative to the work done."""
        for name, value in work.items():
            self.sums[name] += value
        s = self.sums
        rest = s["external"] - sum(s[name] for name in NAMES if name != "external")
        return abs(rest) / max(abs(s["external"]), abs(s["internal"]), self.floor)
