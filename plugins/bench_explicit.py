"""The explicit step on this machine: time and memory per triangle from small to large sheets, on one thread and two,
and the share of contact in a square cup.

The sheet is a planar-Hill lattice stretched at a steady rate, so that nearly every point flows in every step: the
costliest state there is. Times are medians over steps of the process's CPU time, and of the clock. They come with the
ratio to a leading open explicit code, of which 1.3 to 1.4 us per element and step are told for a one-point
quadrilateral shell, contact included, on this kind of machine; two triangles stand for one quadrilateral. The floor is
the time the step's arrays take to be read and written once, at the speed of a copy in the same run.
"""

import time
from types import SimpleNamespace

import numba
import numpy as np

import solver
from cadlink import Rectangle, mesh_blank
from solver.explicit.march import Dynamics, start_march
from solver.sheet import build_sheet
from solver.state import State, new_sheet

from .bench_elements import STEEL

YARDSTICK = 1350.0  # ns per quadrilateral and step
ELEMENTS = {"membrane": solver.Membrane(), "shell, 7 layers": solver.Shell(7)}
SIZES = (5_000, 20_000, 100_000, 500_000)
RATE, WARM = 5e-4, 10  # strain of a step, and steps until the points flow


def rows(largest=100_000):
    """Rows of element, triangles, threads, ns per triangle and step, its parts, bytes per triangle."""
    threads = numba.get_num_threads()
    most = min(2, threads)
    try:
        return [
            time_sheet(name, element, size, n_threads)
            for name, element in ELEMENTS.items()
            for size in SIZES
            if size <= largest
            for n_threads in range(1, most + 1)
        ]
    finally:
        numba.set_num_threads(threads)


def stretched(element, size):
    """Dynamics of a lattice of about so many triangles, every one of which soon flows."""
    side = int(np.sqrt(0.5 * size))
    mesh = mesh_blank(Rectangle(side, side), 1.0, arrangement="structured")
    sheet = build_sheet(solver.Blank(mesh, 0.8, STEEL, element))
    n_points = len(sheet.elements.point_volume)
    state = State(new_sheet(sheet.points, sheet.elements.n_slopes, n_points, tangents=False), {})
    stage = solver.Stage()
    dynamics = Dynamics(sheet, stage, [], state, solver.Explicit(), start_march(stage, sheet, {}))
    dynamics.has_loads = False
    dynamics.v[: len(sheet.points), 0] = RATE / dynamics.limit * sheet.points[:, 0]
    return dynamics


def time_sheet(name, element, size, n_threads):
    """One row."""
    numba.set_num_threads(n_threads)
    dynamics = stretched(element, size)
    m, dt = len(dynamics.sheet.triangles.cells), dynamics.limit
    for _ in range(WARM):
        dynamics.step(0.0, dt, dt)
    before = dynamics.state.sheet.equivalent.copy()
    times = []
    for _ in range(min(max(7, 100_000 // m), 20)):
        start = time.process_time(), time.perf_counter()
        dynamics.step(0.0, dt, dt)
        times.append((time.process_time() - start[0], time.perf_counter() - start[1]))
    flowing = float((dynamics.state.sheet.equivalent > before).mean())
    ns, clock = 1e9 * np.median(times, axis=0) / m
    touched, held = bytes_of(dynamics)
    return {
        "element": name,
        "triangles": m,
        "threads": n_threads,
        "ns": float(ns),
        "clock_ns": float(clock),
        "updates_per_s": 1e9 / float(ns),
        "flowing": flowing,
        "bytes": held / m,
        "floor_ns": touched / copy_speed() / m * 1e9,
        "yardstick": float(2.0 * ns / YARDSTICK),
    }


def bytes_of(dynamics):
    """Bytes of the arrays a step reads and writes, and of all arrays held."""
    sheet, elements = dynamics.state.sheet, dynamics.sheet.elements
    state = sum(a.nbytes for a in sheet.arrays().values())
    past = sum(a.nbytes for a in vars(dynamics.past).values())
    operators = sum(
        a.nbytes
        for group in (elements.triangles, getattr(elements, "patches", ()), vars(elements).values())
        for a in group
        if isinstance(a, np.ndarray)
    )
    own = sum(a.nbytes for a in vars(dynamics).values() if isinstance(a, np.ndarray))
    trial = sum(a.nbytes for a in dynamics.stable.trial.arrays().values()) + dynamics.stable.slot_force.nbytes
    return state + past + operators + own, state + past + operators + own + trial


def copy_speed():
    """Bytes per second read and written by a copy of a large array on one thread."""
    source = np.ones(4_000_000)
    target = np.empty_like(source)
    times = []
    for _ in range(5):
        start = time.perf_counter()
        np.copyto(target, source)
        times.append(time.perf_counter() - start)
    return 2.0 * source.nbytes / min(times)


def cup_shares(size=2.5, travel=20.0, waves=4.0):
    """The square cup in steel, explicitly and fast, to a depth: steps, and the share of contact in their CPU time."""
    from solver.explicit.contact import ToolContact

    scene = cup(size, travel)
    clock = SimpleNamespace(contact=0.0, step=0.0)

    def timed(function, name):
        def work(*arguments):
            start = time.thread_time()
            try:
                return function(*arguments)
            finally:
                setattr(clock, name, getattr(clock, name) + time.thread_time() - start)

        return work

    meet, add, step = ToolContact.meet, ToolContact.work, Dynamics.step
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        solver.form(cup(size, 0.1), solver.Explicit(waves=0.1), frames=1)  # compiles
        ToolContact.meet, ToolContact.work = timed(meet, "contact"), timed(add, "contact")
        Dynamics.step = timed(step, "step")
        results = solver.form(scene, solver.Explicit(waves=waves), frames=1)
    finally:
        ToolContact.meet, ToolContact.work, Dynamics.step = meet, add, step
        numba.set_num_threads(threads)
    m, steps = len(scene.blank.mesh.cells), int(np.sum(results.history["iterations"]))
    return {
        "triangles": m,
        "steps": steps,
        "ns": 1e9 * clock.step / steps / m,
        "contact_share": clock.contact / clock.step,
        "projected_share": results.searches["projected"] / results.searches["asked"],
        "kinetic_share": results.history["kinetic_share"][-1],
        "imbalance_share": results.energy["imbalance"] / results.energy["external"],
    }


def cup(size, travel):
    """A quarter of the square cup from its STEP file."""
    from pathlib import Path

    from .scene_file import SceneFile

    path = Path(__file__).resolve().parents[1] / "examples" / "square_cup" / "steel.toml"
    file = SceneFile.read(path)
    blank = file.keys.blank.model_copy(update={"size": size})
    punch = file.keys.tools["PUNCH"].model_copy(update={"travel": -travel})
    keys = file.keys.model_copy(update={"blank": blank, "tools": file.keys.tools | {"PUNCH": punch}})
    return SceneFile(path, keys).build()


HEADER = [
    "element", "triangles", "threads", "CPU ns/step", "clock ns", "million updates/s", "bytes", "copy floor ns",
    "x yardstick, 2 for 1",
]  # fmt: skip


def line_of(row):
    """A row as texts."""
    return [
        row["element"],
        f"{row['triangles']}",
        f"{row['threads']}",
        f"{row['ns']:.0f}",
        f"{row['clock_ns']:.0f}",
        f"{1e-6 * row['updates_per_s']:.2f}",
        f"{row['bytes']:.0f}",
        f"{row['floor_ns']:.0f}",
        f"{row['yardstick']:.2f}",
    ]


CUP_HEADER = ["square cup, triangles", "steps", "ns/step", "contact", "nodes projected", "kinetic", "imbalance"]


def cup_line(row):
    """The cup's row as texts."""
    return [
        f"{row['triangles']}",
        f"{row['steps']}",
        f"{row['ns']:.0f}",
        f"{100 * row['contact_share']:.0f} %",
        f"{100 * row['projected_share']:.0f} %",
        f"{row['kinetic_share']:.1e}",
        f"{row['imbalance_share']:.1e}",
    ]
