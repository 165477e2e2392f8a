"""The implicit solver on this machine: time against error on four meshes, where the time goes, and how Newton went.

Two problems: a disc stretched by a hemispherical punch, whose error is the largest of its force and of its thickness
strain against a converged axisymmetric membrane, and the square cup, whose error is that of its draw-in against its own
finest mesh; the measured draw-in stands beside. Runs take one thread; times are the CPU time of the run after a small
one has compiled everything.

The yardstick of the stretching: a well-known open implicit code takes 60 s of one core on this kind of machine with 120
axisymmetric quadratic elements (about 600 iterations), and 220 to 400 s in three dimensions with 224 to 480 shells or
bricks.
"""

from pathlib import Path

import numba
import numpy as np

import solver
from solver.contact.search import Neighbourhood
from solver.elements.formulation import MembraneElements, ShellElements
from solver.implicit.equilibrium import Equilibrium
from solver.implicit.sparse import SparseSolver
from solver.materials.material import Material

from .stopwatch import Stopwatch
from .stretch_problems import PUNCHES, punch_errors, punch_scene

YARDSTICK = 220.0  # s, the quickest three-dimensional run of the yardstick
PARTS = {
    "projection": [(Neighbourhood, "project")],
    "elements": [
        (Material, "update"),
        *((kind, name) for kind in (MembraneElements, ShellElements) for name in ("strain", "forces", "stiffness")),
    ],
    "contact": [(Equilibrium, name) for name in ("_touch", "follow_tools", "foresee", "put_back")],
    "assembly": [(Equilibrium, "evaluate"), (Equilibrium, "tangent")],
    "solution": [(SparseSolver, "__init__"), (SparseSolver, "factorize"), (SparseSolver, "solve")],
}
PUNCH_SIZES = (8.0, 5.0, 3.5, 2.5)  # mm
CUP_SIZES = (7.5, 5.0, 3.75, 2.5)  # mm
ELEMENTS = {"membrane": solver.Membrane(), "shell": solver.Shell(5)}


def run(scene, frames):
    """Results and {part: CPU time [s]} of a scene on one thread."""
    watch, threads = Stopwatch(), numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        with watch.over(PARTS):
            try:
                return solver.form(scene, solver.Implicit(), frames=frames), watch.seconds
            except solver.StepFailed as failure:
                return failure.results, watch.seconds
    finally:
        numba.set_num_threads(threads)


def figures(case, element, size, scene, results, seconds):
    """What rows of both problems have in common."""
    total, pace = sum(seconds.values()), results.pace()
    return {
        "case": case,
        "element": element,
        "size": size,
        "triangles": len(scene.blank.mesh.cells),
        "finished": results.finished,
        "seconds": total,
        "shares": {part: seconds.get(part, 0.0) / total for part in [*PARTS, "rest"]},
        "increments": len(results.history["iterations"]),
        "iterations": int(np.sum(results.history["iterations"])),
        **pace,
    }


def punch_rows(sizes=PUNCH_SIZES, problem="friction 0.17", travel=30.0):
    """Rows of the stretched disc, membranes and shells."""
    reference = PUNCHES[problem]
    found = []
    for name, element in ELEMENTS.items():
        run(punch_scene(reference, max(sizes), element, 1.0), 1)  # compiles
        for size in sizes:
            scene = punch_scene(reference, size, element, travel)
            results, seconds = run(scene, round(travel / 5.0))
            errors = punch_errors(reference, scene, results).values()
            row = figures("hemispherical punch", name, size, scene, results, seconds)
            found.append(
                row
                | {
                    "force_error": max((abs(force) for force, _ in errors), default=None),
                    "strain_error": max((strain for _, strain in errors if strain is not None), default=None),
                    "yardstick": YARDSTICK / row["seconds"],
                }
            )
    return found


def cup_rows(sizes=CUP_SIZES, travel=15.0):
    """Rows of the square cup in aluminium: draw-in, and what it is off by from the last mesh's and from measurement."""
    found = []
    run(cup(max(sizes), 0.5)[0], 1)  # compiles
    for size in sizes:
        scene, measured = cup(size, travel)
        results, seconds = run(scene, 1)
        draw_in = {name: results.at(name, travel) for name in ("draw_in_DX", "draw_in_DD")}
        row = figures("square cup", "shell", size, scene, results, seconds)
        off = {name: draw_in[name] / measured[name] - 1.0 for name in measured} if results.finished else {}
        found.append(row | draw_in | {"measured_off": off})
    finest = found[-1]
    for row in found:
        row["draw_in_error"] = max(abs(row[name] / finest[name] - 1.0) for name in ("draw_in_DX", "draw_in_DD"))
    return found


def cup(size, travel):
    """A quarter of the square cup from its scene file, and {draw-in: measured at that depth}."""
    from .scene_file import SceneFile

    path = Path(__file__).resolve().parents[1] / "examples" / "square_cup" / "aluminium.toml"
    file = SceneFile.read(path)
    blank = file.keys.blank.model_copy(update={"size": size})
    punch = file.keys.tools["PUNCH"].model_copy(update={"travel": -travel})
    keys = file.keys.model_copy(update={"blank": blank, "tools": file.keys.tools | {"PUNCH": punch}})
    measured = {row.quantity: row.measured for row in file.keys.compare.rows if row.stroke == travel}
    return SceneFile(path, keys).build(), {k: v for k, v in measured.items() if k in ("draw_in_DX", "draw_in_DD")}


SHARED = ["triangles", "s", *PARTS, "increments", "per mm", "iterations", "per increment"]
HEADER = ["hemispherical punch, mm", *SHARED, "force error", "strain error", "x yardstick"]
CUP_HEADER = ["square cup, mm", *SHARED, "DX", "DD", "to finest", "to measured DX, DD"]


def shared_texts(row):
    """The columns both tables have."""
    return [
        f"{row['triangles']}",
        f"{row['seconds']:.1f}" + ("" if row["finished"] else ", stopped"),
        *(f"{100 * row['shares'][part]:.0f} %" for part in PARTS),
        f"{row['increments']}",
        f"{row.get('increments_per_mm', np.nan):.2f}",
        f"{row['iterations']}",
        f"{row['iterations_per_increment']:.1f}",
    ]


def line_of(row):
    """A row of the stretched disc as texts."""
    force, strain = row["force_error"], row["strain_error"]
    return [
        f"{row['element']} {row['size']:g}",
        *shared_texts(row),
        "" if force is None else f"{100 * force:.2f} %",
        "" if strain is None else f"{strain:.4f}",
        f"{row['yardstick']:.0f}",
    ]


def cup_line(row):
    """A row of the cup as texts."""
    return [
        f"{row['element']} {row['size']:g}",
        *shared_texts(row),
        f"{row['draw_in_DX']:.2f}",
        f"{row['draw_in_DD']:.2f}",
        f"{100 * row['draw_in_error']:.1f} %",
        ", ".join(f"{100 * off:+.1f} %" for off in row["measured_off"].values()),
    ]
