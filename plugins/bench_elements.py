"""Time per element and step on one core, of membranes and shells, and with each material law.

The sheet is a lattice, stretched and bent, that takes a step in which most points flow. Times are the least of several
repeats; ratios are to the membrane of the same table without tangent, in the same run.
"""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

import solver
from cadlink import Rectangle, mesh_blank
from solver.implicit.method import Implicit
from solver.sheet import build_sheet
from solver.state import SheetState, new_sheet

from .bench_materials import LAWS as HARDENINGS
from .bench_materials import LOCI

ELEMENTS = {
    "membrane": solver.Membrane(),
    "shell, 5 layers": solver.Shell(5),
    "shell, 7 layers": solver.Shell(7),
    "shell, 9 layers": solver.Shell(9),
}
CHABOCHE = solver.Chaboche(solver.Swift(300.0, 0.01, 0.2), ((8000.0, 50.0), (1000.0, 0.0)))
LAWS = {
    "von Mises": (solver.VonMises(), HARDENINGS["isotropic"]),
    **{name: (locus, HARDENINGS["isotropic"]) for name, locus in LOCI.items()},
    "Hill48, Chaboche": (LOCI["Hill48"], CHABOCHE),
    "Hill48, Yoshida-Uemori": (LOCI["Hill48"], HARDENINGS["Yoshida-Uemori"]),
    "Hill48, two surfaces": (LOCI["Hill48"], HARDENINGS["two surfaces"]),
}
STEEL = solver.Material(206000.0, 0.3, *LAWS["planar Hill"])


@dataclass
class Step:
    """A sheet of one kind of element before and after a step. old, new : SheetState without a material's answer"""

    elements: Any
    old: SheetState
    new: SheetState


def step_of(element, n_side):
    """Step of a sheet of n_side x n_side squares of 1 mm."""
    mesh = mesh_blank(Rectangle(n_side, n_side), 1.0, arrangement="structured")
    sheet = build_sheet(solver.Blank(mesh, 0.8, STEEL, element))
    elements, n = sheet.elements, len(sheet.points)
    states = [new_sheet(sheet.points, elements.n_slopes, len(elements.point_volume)) for _ in range(3)]
    before, old, new = states
    rng = np.random.default_rng(0)
    for state, scale in ((old, 1.0), (new, 1.1)):
        x, y = sheet.points[:, 0], sheet.points[:, 1]
        state.x[:] = sheet.points * [1.0 + 0.05 * scale, 1.0 - 0.02 * scale, 1.0]
        state.x[:, 2] = scale * np.sin(0.2 * x) * np.cos(0.15 * y)
        state.x[:] += 0.002 * scale * rng.standard_normal((n, 3))
    elements.begin(before, STEEL, Implicit())
    elements.strain(old)
    STEEL.update(old.metric, before, old, tangent=False)
    elements.begin(old, STEEL, Implicit())
    elements.strain(new)
    STEEL.update(new.metric, old, new)
    return Step(elements, old, new)


def one_core(work):
    """What work returns, run on one thread."""
    import numba

    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        return work()
    finally:
        numba.set_num_threads(threads)


def rows(n_side=60, repeats=7):
    """Rows of element, ns of strain, material and forces, their sum, the sum with the tangent, and ratios."""

    def measured():
        return [{"element": name, **time_element(step_of(e, n_side), repeats)} for name, e in ELEMENTS.items()]

    found = one_core(measured)
    for row in found:
        row["ratio"] = row["explicit"] / found[0]["explicit"]
    return found


def law_rows(laws=None, n_side=30, repeats=5):
    """Rows of law, share of the 7-layer shell's points that flow, ns of a step of each element in all, without
    tangent, and their ratios to the membrane's.

    laws : names, all of LAWS by default
    """
    return one_core(lambda: list(_law_rows(laws or LAWS, n_side, repeats)))


def _law_rows(laws, n_side, repeats):
    steps = {name: step_of(element, n_side) for name, element in ELEMENTS.items()}
    around = {name: time_around(step, repeats) for name, step in steps.items()}
    for law in laws:
        material = solver.Material(206000.0, 0.3, *LAWS[law])
        material.prepare()
        row = {"law": law}
        for name, step in steps.items():
            before, old, new = (material.new_state(len(step.old.metric)) for _ in range(3))
            material.update(step.old.metric, before, old, tangent=False)

            def update(material=material, metric=step.new.metric, old=old, new=new):
                material.update(metric, old, new, tangent=False)

            row[name] = 1e9 * least_time(update, repeats) / len(step.elements.slots) + around[name]
            row[f"flowing, {name}"] = float((new.equivalent > old.equivalent).mean())
        row |= {f"ratio, {name}": row[name] / row["membrane"] for name in ELEMENTS}
        yield row


def time_around(step, repeats):
    """ns per element of what an element does around the material: strain and forces."""
    m, k = step.elements.slots.shape
    force = np.empty((m, k, 3))
    strain = least_time(lambda: step.elements.strain(step.new), repeats)
    return 1e9 * (strain + least_time(lambda: step.elements.forces(step.new, force), repeats)) / m


def time_element(step, repeats):
    """One row of `rows`, without its name and ratio."""
    elements, old, new = step.elements, step.old, step.new
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
    return {"triangles": m, "flowing": float((new.equivalent > old.equivalent).mean()), **took}


def least_time(work, repeats):
    """Seconds of the fastest of some repeats, after one to compile."""
    work()
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return min(times)


HEADER = ["element", "strain", "material", "forces", "sum", "x membrane", "sum with tangent", "flowing"]


def line_of(row):
    """A row of `rows` as texts, ns per element."""
    return [
        row["element"],
        *(f"{row[key]:.0f}" for key in ("strain", "material", "forces", "explicit")),
        f"{row['ratio']:.1f}",
        f"{row['implicit']:.0f}",
        f"{100 * row['flowing']:.0f} %",
    ]


LAW_HEADER = ["law", *ELEMENTS, "flowing"]


def law_line(row):
    """A row of `law_rows` as texts: ns per element, and times the membrane's."""
    cells = [f"{row[name]:.0f}" + (f"  x {row[f'ratio, {name}']:.1f}" if k else "") for k, name in enumerate(ELEMENTS)]
    return [row["law"], *cells, f"{100 * row['flowing, shell, 7 layers']:.0f} %"]
