"""Strips one element wide for tests with exact answers: flat between plates, or round a bar."""

from types import SimpleNamespace

import numpy as np

from solver import Blank, Material, Membrane, Scene, Stage, Tool, Voce, VonMises
from tests.solver.lattice import Bar, Plane

ELASTIC = Material(206000.0, 0.0, VonMises(), Voce(5000.0, 0.0, 1.0), "never yields")


def strip_mesh(path, width):
    """Triangles of a strip along a path (n, 3) in the plane y = 0; groups back, front, all."""
    n = len(path)
    both = np.repeat(np.asarray(path, float)[:, None], 2, axis=1)
    both[:, 1, 1] += width
    a = 2 * np.arange(n - 1)
    cells = np.concatenate([np.column_stack([a, a + 2, a + 1]), np.column_stack([a + 1, a + 2, a + 3])])
    groups = {"back": np.array([0, 1]), "front": np.array([2 * n - 2, 2 * n - 1]), "all": np.arange(2 * n)}
    return SimpleNamespace(points=both.reshape(-1, 3), cells=cells, groups=groups)


def flat_strip(length, width, n):
    """A flat strip of n elements along x from the origin."""
    return strip_mesh(np.column_stack([np.linspace(0.0, length, n + 1), np.zeros(n + 1), np.zeros(n + 1)]), width)


def pressed_strip(friction, force=5000.0, travel=0.5, thickness=1.0, holder=None, die=None, **stage):
    """A strip of 50 mm x 10 mm between a plate and a holder that presses with a force, pulled along x."""
    mesh = flat_strip(50.0, 10.0, 10)
    blank = Blank(mesh, thickness, ELASTIC, Membrane(), fixed={"all": "y"})
    half = 0.5 * thickness
    duty = holder if holder is not None else {"force": force}
    tools = [
        Tool("DIE", die or Plane((0.0, 0.0, -half), (0.0, 0.0, 1.0)), friction),
        Tool("HOLDER", Plane((0.0, 0.0, half), (0.0, 0.0, -1.0)), friction, **duty),
    ]
    return Scene(blank, [Stage(tools, moved={"front": (travel, None, None)}, **stage)])


def capstan(friction, tension=200.0, radius=10.0, thickness=0.2, width=2.0, angle=0.5 * np.pi, n=60, **stage):
    """A strip round a bar, drawn against a back tension [N] that rises over the stage; and the radius of its middle."""
    bend = radius + 0.5 * thickness
    size = bend * angle / n
    # One element straight before the bend and one after it: node by node along the path.
    s = (np.arange(n + 3) - 1.0) * size
    phi = np.clip(s / bend, 0.0, angle)
    along = np.stack([np.cos(phi), 0.0 * phi, -np.sin(phi)], axis=1)
    round_bar = bend * np.stack([np.sin(phi), 0.0 * phi, np.cos(phi)], axis=1)
    path = round_bar + (s - bend * phi)[:, None] * along
    mesh = strip_mesh(path, width)
    out = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    blank = Blank(mesh, thickness, ELASTIC, Membrane(), fixed={"all": "y"})
    bar = Tool("BAR", Bar((0.0, 0.0, 0.0), radius), friction)
    pull = Stage(
        [bar], forces={"back": (-tension, 0.0, 0.0)}, moved={"front": tuple(0.3 * size * out)}, **stage
    )  # fmt: skip
    return Scene(blank, [pull]), bend
