"""The whole run, on one screen: read it first.

A scene becomes constant arrays (`Sheet`) and two states, old and new. Each stage closes its tools on the sheet, then
marches: every increment moves the tools, projects the contact nodes on the exact faces, finds equilibrium, and is
recorded. An increment that does not converge is cut; when cutting ends, the last good state is saved.
"""

import logging
import time
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np

from .checkpoint import load_checkpoint, save_checkpoint
from .contact.drawbead import BeadRun
from .contact.drive import ToolRun, build_drive, pivot_of
from .contact.feet import feet_per_node
from .contact.friction import laws_of
from .contact.search import Neighbourhood
from .energy import Energy
from .errors import SceneError, StepFailed
from .implicit.method import Implicit
from .lay_in import lift_out
from .motion import place_tools
from .recording import Recorder
from .results import Progress, Results
from .scene import AXES
from .sheet import build_sheet
from .springback import fitted
from .state import State, new_contact, new_sheet

log = logging.getLogger("cadlink")


def form(scene, method=None, *, save=None, frames=40, watch=None, resume=False):
    """Form the blank.

    method : Implicit(), the default, or Explicit()
    save : path ending in .pvd (or a writer object with write(frame) and close()); a checkpoint goes beside it
    frames : number of frames per stage, at equal steps of the stroke
    watch : called with Progress after each increment
    resume : go on from the checkpoint beside `save`
    returns : Results. Raises SceneError, or StepFailed with the results so far in its `.results`.
    """
    method = method or Implicit()
    clock = time.perf_counter()
    sheet = build_sheet(scene.blank)
    old, new = (first_state(scene, sheet, method) for _ in range(2))
    driven = tuple(name for name, tool in scene.tools.items() if tool.force)
    travelled = tuple(stage.name for stage in scene.stages if any(tool.travels for tool in stage.tools))
    results = Results(plan=scene.plan(method), lifted=driven, travelled=travelled)
    recorder, energy = Recorder(scene, sheet), Energy()
    checkpoint = Path(save).parent / "checkpoint.h5" if isinstance(save, (str, Path)) else None
    first_stage, begun = load_checkpoint(checkpoint, scene, method, old, results, energy) if resume else (0, None)
    writer = open_writer(save, scene, resume)
    results.seconds["build"] = time.perf_counter() - clock
    here = first_stage, begun
    try:
        for k in range(first_stage, len(scene.stages)):
            stage = scene.stages[k]
            how = method.of(stage)
            if begun is None:
                begun = how.start(stage, sheet, close_tools(sheet, stage, old, results))
            here, stage = (k, begun), stage.closed(begun.placed)
            recorder.start(stage, begun, results)
            tools = tool_runs(scene, sheet, stage, how, begun.placed, old)
            stops = np.linspace(0.0, 1.0, frames + 1)[1:]
            if begun.fraction == -1.0:
                keep(recorder.frame(k, 0.0, old, results), results, writer)
            start = old.sheet.x.copy()
            for step in how.march(sheet, stage, tools, old, new, begun, stops):
                energy.add(step.work)
                results.notes += step.notes
                old.copy_from(new)
                if stage.is_springback and step.march.fraction == 1.0:
                    old.sheet.x[:] = fit_back(sheet, old.sheet.x, start)
                recorder.row(k, step, old, energy, results)
                here = k, step.march
                if step.march.fraction in stops and not step.march.settles:
                    keep(recorder.frame(k, step.march.fraction, old, results), results, writer)
                    save_checkpoint(checkpoint, scene, method, here, old, results, energy)
                if watch:
                    watch(progress(scene, k, step, results))
            begun = None
            results.count_searches(tools)
        results.finished = True
    except StepFailed as failure:
        failure.results = results
        raise
    except SceneError as error:
        # What was formed before a stage that cannot begin is not lost.
        if not results.history:
            raise
        raise StepFailed(str(error), results) from None
    finally:
        results.energy = energy.totals(scene.blank.share)
        results.seconds["total"] = time.perf_counter() - clock
        if not results.finished and here[1] is not None:
            if results.history:
                keep(recorder.frame(here[0], max(here[1].fraction, 0.0), old, results), results, writer)
            save_checkpoint(checkpoint, scene, method, here, old, results, energy)
        results.contact = recorder.budget.figures()
        if writer:
            writer.close()
    return results


def first_state(scene, sheet, method):
    """The flat blank, and tools and drawbeads that touch nothing."""
    n_nodes, elements = len(sheet.points), sheet.elements
    tangents = any(method.of(stage).needs_tangents for stage in scene.stages)
    n_history = scene.blank.material.n_history
    flat = new_sheet(sheet.points, elements.n_slopes, len(elements.point_volume), n_history, tangents)
    feet = {name: feet_per_node(tool.surface, scene.blank.thickness) for name, tool in scene.tools.items()}
    beads = {name: BeadRun(bead, sheet, 0.0).new_state() for name, bead in scene.drawbeads.items()}
    return State(flat, {name: new_contact(n_nodes, n_feet) for name, n_feet in feet.items()}, beads)


def close_tools(sheet, stage, state, results):
    """Lay a formed part into the stage's fixed tools, move the others until they touch it, and let go of those of the
    stage before.

    returns : {tool: (travel, side it presses from)}
    """
    present = {tool.name for tool in stage.tools}
    half = 0.5 * sheet.nodal_thickness(state.sheet)
    x, touching = state.sheet.x, {n: state.tools[n].travel[0] for n in present if state.tools[n].touching.any()}
    formed = not np.array_equal(x, sheet.points)
    shift, told = lift_out(stage, x, half, sheet.held[: len(x)], touching) if formed else (0.0, "")
    placed = place_tools(stage, x + shift, half, touching)
    # Nothing changes before all have found their place.
    if told:
        x += shift
        results.notes.append(told)
        log.info("%s", told)
    for name, contact in state.tools.items():
        if name not in present:
            contact.release()
    for bead in state.beads.values():
        bead.traction[:], bead.lift[:] = 0.0, 0.0
    for name, (travel, _) in placed.items():
        state.tools[name].travel[0] = travel
        if name not in touching:
            state.tools[name].rest[0] = travel
        log.info("tool %s starts at %.4f mm along its axis", name, travel)
    return placed


def fit_back(sheet, x, before):
    """A part after springback (n, 3), moved as a rigid body to where it fits best what it was before."""
    planes = [AXES.index(axis) for axis in sheet.blank.symmetry_planes]
    return fitted(x, before, sheet.area, sheet.held[: len(x)], planes, bool(sheet.blank.clamped))


def tool_runs(scene, sheet, stage, method, placed, state):
    """The stage's tools with what the solver needs of them, in the stage's order."""
    stiffness = sheet.contact_stiffness * sheet.area
    kn, kt = method.penalty * stiffness, method.stick * stiffness
    n_nodes, runs = len(sheet.points), {}
    # Those that others ride on come first.
    for tool in sorted(stage.tools, key=lambda tool: tool.rides_on is not None):
        tilted = tool.tilts or bool(state.tools[tool.name].tilt.any())
        pivot = pivot_of(tool, sheet) if tilted else None
        runs[tool.name] = ToolRun(
            tool, tool.unit_axis, *placed[tool.name], build_drive(tool, sheet, kn, runs.get(tool.rides_on)), kn, kt,
            Neighbourhood(tool.surface, n_nodes), laws_of(tool.friction, n_nodes), pivot,
        )  # fmt: skip
    return [runs[tool.name] for tool in stage.tools]


def keep(frame, results, writer):
    """Store a frame and write it."""
    results.frames.append(frame)
    if writer:
        writer.write(frame)


def progress(scene, k, step, results):
    """Progress of the whole run."""
    history = results.history
    return Progress(
        stage=scene.stages[k].name,
        increment=history["increment"][-1],
        fraction=(k + max(step.march.fraction, 0.0)) / len(scene.stages),
        stroke=history["stroke"][-1],
        iterations=step.outcome.iterations,
        n_contacts=history["n_contacts"][-1],
        n_cut_backs=step.n_cut_backs,
    )


def open_writer(save, scene, resume):
    """The writer of a path, found by its suffix among the installed `cadlink.writers`; a writer object as it is."""
    if save is None or hasattr(save, "write"):
        return save
    suffix = Path(save).suffix
    found = {entry.name: entry for entry in entry_points(group="cadlink.writers")}
    if suffix[1:] not in found:
        raise SceneError(f"save={str(save)!r}: no writer for {suffix!r}; there are {sorted('.' + k for k in found)}")
    return found[suffix[1:]].load()(Path(save), scene, resume=resume)
