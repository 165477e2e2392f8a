"""Newton's method ends quadratically in every example: on CAD faces or primitives, with membranes or shells, friction,
a blank-holder that carries a force, wrinkles."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plugins.cup_problem import cup_scene
from plugins.scene_file import SceneFile
from plugins.stretch_problems import PUNCHES, bulge_scene, punch_scene
from solver import Implicit, Newton, Shell, form
from tests.examples.test_strip_pull_out import strip

FOLDER = Path(__file__).resolve().parents[2] / "examples"
CLOSE, ROUND_OFF = 1e-2, 1e-5  # residuals between which a last correction starts; it ends at 1e-9 or so
STEEPNESS = 20.0  # of the square: as large as curvature of tools and materials makes it
TIGHT = Newton(residual=1e-8, correction=1e-6)


def shorter(scene, travel):
    """A scene whose punch goes so far [mm]."""
    tools = [replace(t, travel=-travel) if t.travel else t for t in scene.stages[0].tools]
    return replace(scene, stages=[replace(scene.stages[0], tools=tools)])


def pulled_strip():
    """Three elements on the bend, pulled by less than three."""
    scene = strip.strip_scene(3.0)
    return replace(scene, stages=[replace(scene.stages[0], moved={"front": (None, None, -6.0)})])


def suspension_cup(name):
    """5 mm of it: the holder presses a wavy rim flat, or rides on its waves."""
    return shorter(SceneFile.read(FOLDER / "coupelle" / f"{name}.toml").build(), 5.0)


EXAMPLES = {
    "strip": pulled_strip,
    "suspension cup": lambda: suspension_cup("full_force"),
    "suspension cup, a tenth": lambda: suspension_cup("tenth_force"),
    "square cup": lambda: cup_scene("aluminium", 5.0, 5.0)[0],
    "punch, membrane": lambda: punch_scene(PUNCHES["friction 0.17"], 5.0, travel=8.0),
    "punch, shell": lambda: punch_scene(PUNCHES["friction 0.17"], 5.0, Shell(5), travel=8.0),
    "bulge": lambda: bulge_scene(5.0, Shell(5), 6.0),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_tail_is_quadratic(name, caplog):
    with caplog.at_level(logging.INFO, logger="cadlink"):
        results = form(EXAMPLES[name](), Implicit(newton=TIGHT), frames=1)
    assert results.finished
    trails = [r.message.split("residuals")[1] for r in caplog.records if r.message.startswith("fraction")]
    squares = [last_square(np.array(trail.split(), float)) for trail in trails]
    # A node may land or leave in a last correction; in most none does.
    assert np.count_nonzero(np.array(squares) < STEEPNESS) > 0.5 * len(trails)


def last_square(residuals):
    """c / b^2 of the last correction, from b to c, that starts close and above round-off, inf without one.
    residuals : (k,)"""
    last = np.flatnonzero(residuals[:-1] > ROUND_OFF)[-1]
    b, c = residuals[last : last + 2]
    return c / b**2 if b < CLOSE else np.inf
