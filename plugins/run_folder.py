"""A run in its folder: result.pvd, frames and tools, history.csv, summary.json, run.log, checkpoint.h5."""

import logging
import signal
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from solver.errors import SceneError, StepFailed

from . import report
from .check_scene import tool_starts
from .scene_file import SceneFile, SceneFileError

FILES = ("result.pvd", "history.csv", "summary.json", "run.log", "checkpoint.h5")
log = logging.getLogger("cadlink")


class Stopped(StepFailed):
    """The user asked a run to stop; its results go as far as it came."""


def run_in_folder(path, folder, resume=False, console=None):
    """Forms what a scene file describes and leaves everything in a folder.

    console : rich.Console for progress and messages; None is standard error
    returns : the summary, as in summary.json. Where the run stopped early its "finished" is False and its
        "message" says why; its "interrupted" is True where the user stopped it.
    Raises SceneFileError for wrong input, OSError where the folder cannot be written.
    """
    import solver

    console = console or Console(stderr=True)
    scene_file = SceneFile.read(path)
    folder = Path(folder)
    if resume and not (folder / "checkpoint.h5").exists():
        raise SceneFileError(
            f"{folder / 'checkpoint.h5'}: no such file, expected a run that stopped; leave --resume out"
        )
    with console.status("reading the STEP file, meshing the blank"):
        scene = scene_file.build()
        tool_starts(scene_file, scene)  # a wrong scene leaves an earlier run's files alone
    folder.mkdir(parents=True, exist_ok=True)
    if not resume:
        for name in FILES[1:]:
            (folder / name).unlink(missing_ok=True)

    message = None
    with (
        logged_to(folder / "run.log"),
        stop_on_interrupt(console) as wanted,
        ProgressLine(console, scene) as line,
    ):

        def watch(progress):
            line.show(progress)
            if wanted():
                raise Stopped("stopped by the user")

        log.info("%s: %s", scene_file.path, scene.name)
        try:
            save = str(folder / "result.pvd")
            frames = scene_file.keys.output.frames
            results = solver.form(scene, scene_file.method, save=save, frames=frames, watch=watch, resume=resume)
        except StepFailed as stop:
            if stop.results is None:
                raise
            results, message = stop.results, str(stop)
            log.error("%s", stop)
        except SceneError as error:
            raise SceneFileError(f"{scene_file.path}: {error}") from error
        except Exception:
            log.exception("unexpected error")
            raise
        summary = report.summarize(scene_file, scene, results, message)
        summary["interrupted"] = wanted()
        report.write_history(folder, results.history)
        report.write_summary(folder, summary)
        log.info("finished" if results.finished else "stopped early")
    return summary


@contextmanager
def logged_to(path):
    """Everything the solver logs goes to this file meanwhile."""
    handler = logging.FileHandler(path, encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)-7s %(message)s"))
    level, propagate = log.level, log.propagate
    log.addHandler(handler)
    log.setLevel(logging.DEBUG)
    log.propagate = False
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)
        log.propagate = propagate
        handler.close()


@contextmanager
def stop_on_interrupt(console):
    """The first Ctrl-C lets the increment end, the second stops at once. Yields a function: stop wanted?"""
    wanted = []

    def interrupt(number, frame):
        if wanted:
            raise KeyboardInterrupt
        wanted.append(number)
        console.print("stopping after this increment; Ctrl-C again stops at once")

    try:
        before = signal.signal(signal.SIGINT, interrupt)
    except ValueError:  # not in the main thread: whoever runs us catches Ctrl-C
        yield lambda: False
        return
    try:
        yield lambda: bool(wanted)
    finally:
        signal.signal(signal.SIGINT, before)


class ProgressLine:
    """A bar with stroke, increment, iterations, contacts, remaining time; plain lines without a terminal."""

    STEPS = 10  # plain lines in a run

    def __init__(self, console, scene):
        self.console, self.scene = console, scene
        total = sum(stage.stroke for stage in scene.stages)
        travels = any(tool.travels for stage in scene.stages for tool in stage.tools)
        self.goal = ("" if np.isinf(total) else f" of {total:g}") + (" mm" if travels else " (load)")
        self.printed = -1
        self.bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(None),
            TextColumn("{task.fields[text]}", markup=False),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )

    def __enter__(self):
        mesh = self.scene.blank.mesh
        self.console.print(
            f"{self.scene.name}: {len(mesh.cells)} triangles, {len(mesh.points)} nodes "
            "(a first run compiles its kernels for up to a minute)",
            markup=False,
            highlight=False,
            soft_wrap=True,
        )
        self.bar.start()
        self.task = self.bar.add_task("closing the tools", total=1.0, text="")
        return self

    def __exit__(self, *error):
        self.bar.stop()

    def show(self, progress):
        """After each increment. progress : solver.Progress."""
        text = (
            f"{progress.stroke:.2f}{self.goal}, increment {progress.increment}, "
            f"{progress.iterations} iterations, {progress.n_contacts} contact nodes"
        )
        if progress.n_cut_backs:
            text += f", {progress.n_cut_backs} cut back"
        stage = progress.stage
        self.bar.update(self.task, description=stage, completed=progress.fraction, text=text)
        step = int(progress.fraction * self.STEPS + 1e-9)
        if not self.console.is_terminal and step > self.printed:
            self.printed = step
            print(f"{stage}: {text}", file=self.console.file or sys.stderr, flush=True)
