"""Elastic sheets in free motion, for tests of the explicit steps."""

import numpy as np

from solver import Blank, Explicit, Material, Membrane, Stage, VonMises
from solver.explicit.dynamics import Dynamics
from solver.explicit.march import start_march
from solver.sheet import build_sheet
from solver.state import State, new_sheet
from tests.solver.lattice import square


def elastic(poisson=0.3):
    """Steel that never yields."""
    return Material(206000.0, poisson, VonMises(), lambda ep: 1e8 + 0.0 * ep, "elastic")


def arch(n, m, radius, width):
    """A quarter of a ring about y, n sides along its arc and m across; its ends lie on planes of symmetry."""
    mesh = square(1, 1.0)
    angle, y = np.meshgrid(np.linspace(0.0, 0.5 * np.pi, n + 1), np.linspace(0.0, width, m + 1), indexing="ij")
    mesh.points = np.column_stack([radius * np.sin(angle.ravel()), y.ravel(), radius * np.cos(angle.ravel())])
    a = (np.arange(n)[:, None] * (m + 1) + np.arange(m)).ravel()
    b, c, d = a + m + 1, a + m + 2, a + 1
    mesh.cells = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    mesh.groups = {"symmetry_x": np.arange(m + 1), "symmetry_z": n * (m + 1) + np.arange(m + 1)}
    mesh.points[mesh.groups["symmetry_z"], 2] = 0.0
    return mesh


def motion(mesh, thickness, element=None, poisson=0.3, steps=0.0, **blank):
    """Dynamics of a sheet that nothing acts on; undamped. steps : target, see Explicit"""
    sheet = build_sheet(Blank(mesh, thickness, elastic(poisson), element or Membrane(), **blank))
    state = State(new_sheet(sheet.points, sheet.elements.n_slopes, len(sheet.elements.point_volume)), {})
    stage = Stage()
    dynamics = Dynamics(
        sheet, stage, [], state, Explicit(damping=0.0, scaled=0.0, steps=steps), start_march(stage, sheet, {})
    )
    dynamics.has_loads = False
    return dynamics


def swing(dynamics, shape, steps):
    """Amplitude of a mode shape (n, 3), by masses, over the steps of a motion that starts with its velocity at rest.
    Returns times and amplitudes."""
    n = len(shape)
    dt = dynamics.limit
    dynamics.v[:n] = shape
    mass = dynamics.mass[:n, None]
    start = dynamics.state.sheet.x.copy()
    times, amplitudes = dt * np.arange(1, steps + 1), []
    for _ in range(steps):
        dynamics.step(0.0, dt, dt)
        amplitudes.append(np.sum(mass * shape * (dynamics.state.sheet.x - start)) / np.sum(mass * shape**2))
    return times, np.array(amplitudes)


def frequency(times, amplitudes):
    """Angular frequency of a sine, from its first and last zero crossing."""
    k = np.flatnonzero(np.diff(np.sign(amplitudes)))
    crossing = times[k] - amplitudes[k] * (times[k + 1] - times[k]) / (amplitudes[k + 1] - amplitudes[k])
    return np.pi * (len(crossing) - 1) / (crossing[-1] - crossing[0])
