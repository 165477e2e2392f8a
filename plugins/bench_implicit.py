"""The implicit solver on this machine: time against error on four meshes, where the time goes, and how Newton went.

Two problems: a disc stretched by a hemispherical punch, whose error is the largest of its force and of its thickness
strain against a converged axisymmetric membrane, and the square cup, whose errors are those of draw-in, forces and
thickness against its own finest mesh, and for one mesh against increments of half the length; the measured draw-in
stands beside. Runs take one thread; times are the CPU time of the run after a small one has compiled everything.

The yardstick of the stretching: a well-known open implicit code takes 60 s of one core on this kind of machine with 120
axisymmetric quadratic elements (about 600 iterations), and 220 to 400 s in three dimensions with 224 to 480 shells or
bricks.
"""

import numba
import numpy as np

import solver
from solver.contact.search import Neighbourhood
from solver.elements.formulation import MembraneElements, ShellElements
from solver.implicit.equilibrium import Equilibrium
from solver.implicit.sparse import SparseSolver
from solver.materials.material import Material

from .cup_problem import DRAW_INS, cup_scene, differences
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
CUP_SIZES = (5.0, 3.75, 2.5, 1.875)  # mm
USUAL = solver.Increments()
ELEMENTS = {"membrane": solver.Membrane(), "shell": solver.Shell(5)}


def run(scene, frames, increments=USUAL):
    """Results and {part: CPU time [s]} of a scene on one thread."""
    watch, threads = Stopwatch(), numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        with watch.over(PARTS):
            try:
                return solver.form(scene, solver.Implicit(increments=increments), frames=frames), watch.seconds
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


def cup_rows(sizes=CUP_SIZES, travel=15.0, material="aluminium"):
    """Rows of the square cup: draw-in, what it is off by from measurement, and what all is off by from the last mesh.

    One row more, of the mesh before the last, has increments of half the length and is held against that mesh's own.
    """
    run(cup_scene(material, max(sizes), 0.5)[0], 1)  # compiles
    runs = []
    for size, increments in [*((size, USUAL) for size in sizes), (sizes[-2], None)]:
        scene, measured = cup_scene(material, size, travel)
        halved = increments is None
        results, seconds = run(scene, 1, halves(runs[-2][0], travel) if halved else increments)
        draw_in = {name: results.at(name, travel) for name in DRAW_INS}
        off = {name: draw_in[name] / measured[name] - 1.0 for name in measured} if results.finished else {}
        row = figures(f"square cup, {material}", "shell", size, scene, results, seconds)
        runs.append((row | draw_in | {"measured_off": off, "halved": halved}, scene, results))
    finest, usual = runs[len(sizes) - 1], runs[len(sizes) - 2]
    found = []
    for row, scene, results in runs:
        # The error of a mesh against a finer one; what halving does, against the same mesh.
        held = differences(*usual[1:], scene, results) if row["halved"] else differences(scene, results, *finest[1:])
        found.append(row | held)
    return found


def halves(row, travel):
    """Increments no longer than half the mean of those that a row has taken."""
    return solver.Increments(0.5 * USUAL.first, 0.5 * travel / (row["increments"] * row["size"]))


SHARED = ["triangles", "s", *PARTS, "increments", "per mm", "iterations", "per increment"]
HEADER = ["hemispherical punch, mm", *SHARED, "force error", "strain error", "x yardstick"]
CUP_HEADER = [
    "square cup, mm",
    *SHARED,
    "DX",
    "DD",
    "DX, DD off",
    "punch force off",
    "holder force off",
    "thickness off",
]
CUP_HEADER += ["to measured DX, DD"]


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
    off = [row[f"{name}_error"] for name in ("draw_in", "force", "holder", "thickness")]
    return [
        f"{row['element']} {row['size']:g}" + (", half increments" if row["halved"] else ""),
        *shared_texts(row),
        f"{row['draw_in_DX']:.2f}",
        f"{row['draw_in_DD']:.2f}",
        *(f"{100 * error:.1f} %" for error in off),
        ", ".join(f"{100 * off:+.1f} %" for off in row["measured_off"].values()),
    ]
