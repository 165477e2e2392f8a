"""Time per element and step on one core, of membranes and shells: strain, material, forces, and the tangent.

The sheet is a planar-Hill lattice, stretched and bent so that most points flow. Times are the least of several repeats;
ratios are to the membrane without tangent, in the same run.
"""

import time

import numpy as np

import solver
from cadlink import Rectangle, mesh_blank
from solver.implicit.method import Implicit
from solver.sheet import build_sheet
from solver.state import new_sheet

ELEMENTS = {
    "membrane": solver.Membrane(),
    "shell, 5 layers": solver.Shell(5),
    "shell, 7 layers": solver.Shell(7),
    "shell, 9 layers": solver.Shell(9),
}
STEEL = solver.Material(206000.0, 0.3, solver.PlanarHill(1.77), solver.Swift(565.32, 0.007117, 0.2589))


def rows(n_side=60, repeats=7):
    """Rows of element, ns of strain, material and forces, their sum, the sum with the tangent, and ratios."""
    import numba

    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        found = [time_element(name, element, n_side, repeats) for name, element in ELEMENTS.items()]
    finally:
        numba.set_num_threads(threads)
    for row in found:
        row["ratio"] = row["explicit"] / found[0]["explicit"]
    return found


def time_element(name, element, n_side, repeats):
    """One row, without its ratio."""
    mesh = mesh_blank(Rectangle(n_side, n_side), 1.0, arrangement="structured")
    sheet = build_sheet(solver.Blank(mesh, 0.8, STEEL, element))
    elements, n = sheet.elements, len(sheet.points)
    old, new = (new_sheet(sheet.points, elements.n_slopes, len(elements.point_volume)) for _ in range(2))
    rng = np.random.default_rng(0)
    for state, scale in ((old, 1.0), (new, 1.1)):
        x, y = sheet.points[:, 0], sheet.points[:, 1]
        state.x[:] = sheet.points * [1.0 + 0.05 * scale, 1.0 - 0.02 * scale, 1.0]
        state.x[:, 2] = scale * np.sin(0.2 * x) * np.cos(0.15 * y)
        state.x[:] += 0.002 * scale * rng.standard_normal((n, 3))
    before = new_sheet(sheet.points, elements.n_slopes, len(elements.point_volume))
    elements.begin(before, before, STEEL, Implicit())
    elements.strain(old)
    STEEL.update(old.metric, before, old, tangent=False)
    elements.begin(old, new, STEEL, Implicit())
    m, k = elements.slots.shape
    size = k + 2 * elements.n_translations
    force, stiffness = np.empty((m, k, 3)), np.empty((m, size, size))
    stages = {
        "strain": lambda: elements.strain(new),
        "material": lambda: STEEL.update(new.metric, old, new, tangent=False),
        "forces": lambda: elements.forces(new, force),
        "material with tangent": lambda: STEEL.update(new.metric, old, new, tangent=True),
        "stiffness": lambda: elements.stiffness(new, stiffness),
    }
    took = {stage: 1e9 * least_time(work, repeats) / m for stage, work in stages.items()}
    took["explicit"] = took["strain"] + took["material"] + took["forces"]
    took["implicit"] = took["strain"] + took["material with tangent"] + took["forces"] + took["stiffness"]
    flowing = float((new.equivalent > old.equivalent).mean())
    return {"element": name, "triangles": m, "flowing": flowing, **took}


def least_time(work, repeats):
    """Seconds of the fastest of some repeats, after one to compile."""
    work()
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return min(times)


HEADER = ["element", "strain", "material", "forces", "sum", "x membrane", "sum with tangent"]


def line_of(row):
    """A row as texts, ns per element."""
    return [
        row["element"],
        *(f"{row[key]:.0f}" for key in ("strain", "material", "forces", "explicit")),
        f"{row['ratio']:.1f}",
        f"{row['implicit']:.0f}",
    ]
