"""The explicit solver on this machine: time, memory and operations of a step per triangle from small to large sheets,
on one thread and two; the share of contact in a square cup; and a whole problem, time against error.

The sheets are planar-Hill lattices stretched at a steady rate, so that nearly every point flows in every step: the
costliest state there is. Times are medians of the process's CPU time, and of the clock, over turns that all sizes take
one after the other. They come with the ratio to a leading open explicit code, of which 1.3 to 1.4 us per element and
step are told for a one-point quadrilateral shell, contact included, on this kind of machine; two triangles stand for
one quadrilateral.

Two limits of the machine are measured in the same run, both of one core. Memory: the time in which a copy of a large
array reads and writes as many bytes as the step's arrays hold. Arithmetic: the time in which vectors of fused
multiply-adds in registers, which count as two, do as many operations as the step's kernels (operation_count.py). The
second is beyond any code that also divides, takes roots and reads memory; its share says how far.
"""

import time
from types import SimpleNamespace

import numba
import numpy as np

import solver
from cadlink import Rectangle, mesh_blank
from solver.explicit.dynamics import Dynamics
from solver.explicit.march import start_march
from solver.explicit.pinch import Pinch
from solver.sheet import build_sheet
from solver.state import State, new_sheet

from .bench_elements import STEEL
from .cup_problem import cup_scene
from .stretch_problems import PUNCHES, punch_errors, punch_scene

YARDSTICK = 1350.0  # ns per quadrilateral and step
STRETCH_YARDSTICK = 9.0, 21.0  # s of one core, of 480 quadrilaterals and 16,000 to 31,000 steps
ELEMENTS = {"membrane": solver.Membrane(), "shell, 5 layers": solver.Shell(5), "shell, 7 layers": solver.Shell(7)}
SIZES = (5_000, 20_000, 100_000, 500_000)
STRETCH_SIZES = (5.0, 3.5)  # mm
RATE, WARM = 5e-4, 10  # strain of a step, steps until the points flow
ROUNDS, BATCH = 7, 100_000  # turns, and triangles stepped in one, at least


def rows(largest=100_000):
    """Rows of element, triangles, threads, ns per triangle and step, bytes and operations per triangle, limits."""
    from .operation_count import counted_apart

    threads = numba.get_num_threads()
    most = min(2, threads)
    operations = {name: sum(kernels.values()) for name, kernels in counted_apart().items()}
    try:
        sizes = [size for size in SIZES if size <= largest]
        found = [
            row
            for name, element in ELEMENTS.items()
            for n_threads in range(1, most + 1)
            for row in time_sheets(name, element, sizes, n_threads)
        ]
    finally:
        numba.set_num_threads(threads)
    smallest = {(row["element"], row["threads"]): row["ns"] for row in reversed(found)}
    for row in found:
        done = operations[row["element"]]
        row |= {
            "operations": done,
            "arithmetic_ns": 1e9 * done / row["operations_per_s"],
            "to_smallest": row["ns"] / smallest[row["element"], row["threads"]],
        }
    return found


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


def time_sheets(name, element, sizes, n_threads):
    """A row for each size. The sheets take turns, so that what else the machine does meets all of them."""
    numba.set_num_threads(n_threads)
    sheets = [stretched(element, size) for size in sizes]
    for dynamics in sheets:
        for _ in range(WARM):
            dynamics.step(0.0, dynamics.limit, dynamics.limit)
    before = [dynamics.state.sheet.equivalent.copy() for dynamics in sheets]
    times = np.empty((ROUNDS, len(sheets), 2))
    for k in range(ROUNDS):
        for dynamics, spent in zip(sheets, times[k], strict=True):
            m, dt = len(dynamics.sheet.triangles.cells), dynamics.limit
            steps = max(1, BATCH // m)
            start = time.process_time(), time.perf_counter()
            for _ in range(steps):
                dynamics.step(0.0, dt, dt, keeps=False)
            spent[:] = time.process_time() - start[0], time.perf_counter() - start[1]
            spent *= 1e9 / (steps * m)
    return [
        row_of(name, n_threads, dynamics, past, *ns)
        for dynamics, past, ns in zip(sheets, before, np.median(times, axis=0), strict=True)
    ]


def row_of(name, n_threads, dynamics, before, ns, clock):
    """One row. before : equivalent strains where the timing began; ns, clock : per triangle and step"""
    m = len(dynamics.sheet.triangles.cells)
    dynamics.step(0.0, dynamics.limit, dynamics.limit)
    touched, held = bytes_of(dynamics)
    return {
        "element": name,
        "triangles": m,
        "threads": n_threads,
        "ns": float(ns),
        "clock_ns": float(clock),
        "updates_per_s": 1e9 / float(ns),
        "flowing": float((dynamics.state.sheet.equivalent > before).mean()),
        "bytes": held / m,
        "memory_ns": 1e9 * touched / copy_speed() / m,
        "operations_per_s": arithmetic_speed(),
        "yardstick": float(2.0 * ns / YARDSTICK),
    }


def bytes_of(dynamics):
    """Bytes of the arrays a step reads and writes, and of all arrays held."""
    sheet, elements = dynamics.state.sheet, dynamics.sheet.elements

    def bytes_in(values):
        return sum(a.nbytes for a in values if isinstance(a, np.ndarray))

    operators = sum(bytes_in(x) for x in (elements.triangles, getattr(elements, "blocks", ()), vars(elements).values()))
    own = bytes_in(vars(dynamics).values()) + bytes_in(vars(dynamics.passes).values())
    nodal = bytes_in((sheet.u, sheet.internal, sheet.external))
    return nodal + operators + own, bytes_in(sheet.arrays().values()) + operators + own


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


@numba.njit(fastmath={"contract"})
def multiply_add(x, y, rounds):
    """`CHAINS` recurrences v = 1 + x v of `LONG` steps for each number, side by side, with nothing read or written
    between: what one waits for another fills."""
    for _ in range(rounds):
        for i in range(x.shape[0]):
            t = x[i]
            a, b, c, d = t, t + 1.0, t + 2.0, t + 3.0
            for _ in range(LONG):
                a, b, c, d = 1.0 + t * a, 1.0 + t * b, 1.0 + t * c, 1.0 + t * d
            y[i] = a + b + c + d


CHAINS, LONG = 4, 16


def arithmetic_speed():
    """Operations per second of one core that does nothing but multiply and add."""
    x, rounds = np.linspace(0.0, 0.5, 1024), 100
    y = np.empty_like(x)
    multiply_add(x, y, 1)
    times = []
    for _ in range(5):
        start = time.thread_time()
        multiply_add(x, y, rounds)
        times.append(time.thread_time() - start)
    return 2.0 * CHAINS * LONG * rounds * len(x) / min(times)


def stretch_rows(sizes=STRETCH_SIZES, problem="friction 0.17", travel=30.0, method=None):
    """Rows of a quarter of a disc stretched by a hemispherical punch, on one thread: CPU time of the run after a short
    one has compiled everything, and errors against a converged axisymmetric membrane: the largest of the force relative
    to the largest force, and of the thickness strain."""
    threads, found, method = numba.get_num_threads(), [], method or solver.Explicit()
    reference = PUNCHES[problem]
    try:
        numba.set_num_threads(1)
        for name in ("membrane", "shell, 5 layers"):
            brief = punch_scene(reference, max(sizes), ELEMENTS[name], 0.1)
            solver.form(brief, solver.Explicit(waves=0.1, drift=1e6), frames=1)
            for size in sizes:
                scene = punch_scene(reference, size, ELEMENTS[name], travel)
                start = time.process_time()
                results = solver.form(scene, method, frames=round(travel / 5.0))
                seconds = time.process_time() - start
                errors = punch_errors(reference, scene, results)
                largest = max(reference.force.values())
                # As the tools stop kinetic energy is gone, as they start there is no other.
                under_way = np.array(results.history["stroke"]) >= 0.25 * travel
                m, steps = len(scene.blank.mesh.cells), int(np.sum(results.history["iterations"]))
                found.append(
                    {
                        "element": name,
                        "size": size,
                        "triangles": m,
                        "steps": steps,
                        "seconds": seconds,
                        "ns": 1e9 * seconds / steps / m,
                        "force_error": max(abs(off) * reference.force[h] / largest for h, (off, _) in errors.items()),
                        "strain_error": max((off for _, off in errors.values() if off is not None), default=None),
                        "kinetic_share": float(np.max(np.array(results.history["kinetic_share"])[under_way])),
                        "imbalance_share": results.energy["imbalance"] / results.energy["external"],
                        "yardstick": tuple(seconds / other for other in STRETCH_YARDSTICK),
                    }
                )
    finally:
        numba.set_num_threads(threads)
    return found


def cup_shares(size=2.5, travel=20.0, waves=4.0):
    """The square cup in steel, explicitly and fast, to a depth: steps, and the share of contact in their CPU time."""
    from solver.explicit import dynamics

    scene, _ = cup_scene("steel", size, travel)
    clock = SimpleNamespace(contact=0.0, step=0.0)

    def timed(function, name):
        def work(*arguments):
            start = time.thread_time()
            try:
                return function(*arguments)
            finally:
                setattr(clock, name, getattr(clock, name) + time.thread_time() - start)

        return work

    touch, give, step = dynamics.touch_tools, Pinch.give_way, Dynamics.step
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        solver.form(scene, solver.Explicit(waves=0.1 * waves), frames=1)  # compiles, pinched metal's flow too
        dynamics.touch_tools, Pinch.give_way = timed(touch, "contact"), timed(give, "contact")
        Dynamics.step = timed(step, "step")
        results = solver.form(scene, solver.Explicit(waves=waves), frames=1)
    finally:
        dynamics.touch_tools, Pinch.give_way, Dynamics.step = touch, give, step
        numba.set_num_threads(threads)
    m, steps = len(scene.blank.mesh.cells), int(np.sum(results.history["iterations"]))
    return {
        "triangles": m,
        "steps": steps,
        "ns": 1e9 * clock.step / steps / m,
        "contact_share": clock.contact / clock.step,
        "projected_share": results.searches["projected"] / results.searches["asked"],
        "kinetic_share": float(np.interp(0.5 * travel, results.history["stroke"], results.history["kinetic_share"])),
        "imbalance_share": results.energy["imbalance"] / results.energy["external"],
    }


HEADER = [
    "element", "triangles", "threads", "CPU ns/step", "clock ns", "x smallest", "million updates/s", "bytes",
    "memory limit ns", "operations", "arithmetic limit ns", "x yardstick, 2 for 1",
]  # fmt: skip


def line_of(row):
    """A row as texts."""
    return [
        row["element"],
        f"{row['triangles']}",
        f"{row['threads']}",
        f"{row['ns']:.0f}",
        f"{row['clock_ns']:.0f}",
        f"{row['to_smallest']:.2f}",
        f"{1e-6 * row['updates_per_s']:.2f}",
        f"{row['bytes']:.0f}",
        f"{row['memory_ns']:.0f}, {100 * row['memory_ns'] / row['ns']:.0f} %",
        f"{row['operations']:.0f}",
        f"{row['arithmetic_ns']:.0f}, {100 * row['arithmetic_ns'] / row['ns']:.0f} %",
        f"{row['yardstick']:.2f}",
    ]


STRETCH_HEADER = [
    "punch stretch, mm", "triangles", "steps", "CPU s", "ns/step", "force error", "strain error", "kinetic",
    "imbalance", "x yardstick",
]  # fmt: skip


def stretch_line(row):
    """A row of the stretched disc as texts."""
    strain = row["strain_error"]
    return [
        f"{row['element']} {row['size']:g}",
        f"{row['triangles']}",
        f"{row['steps']}",
        f"{row['seconds']:.1f}",
        f"{row['ns']:.0f}",
        f"{100 * row['force_error']:.2f} %",
        "" if strain is None else f"{strain:.4f}",
        f"{row['kinetic_share']:.1e}",
        f"{row['imbalance_share']:.1e}",
        " to ".join(f"{ratio:.2f}" for ratio in reversed(row["yardstick"])),
    ]


CUP_HEADER = [
    "square cup, triangles",
    "steps",
    "ns/step",
    "contact",
    "nodes projected",
    "kinetic, half-way",
    "imbalance",
]


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
