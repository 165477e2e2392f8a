"""The shell against published large-deflection problems, on one-diagonal lattices and on unstructured meshes."""

import time
from types import SimpleNamespace

import numpy as np
from scipy.interpolate import CubicSpline

from solver import Blank, Implicit, Newton, Scene, Shell, Stage, StepFailed, form
from solver.elements.patches import neighbours
from solver.materials.law import Law, strains

from .arc_length import follow
from .shell_limits import limit_rows
from .shell_problems import PROBLEMS

TIGHT = Implicit(Newton(residual=1e-6, correction=1e-6))  # the element's error alone is left
STEPS = 25  # along a path, at least: none moves a node farther than this part of the largest displacement


class LinearElastic(Law):
    """T = D H, linear in logarithmic strain."""

    def __init__(self, young, poisson):
        self.young, self.poisson, self.name = young, poisson, "elastic"
        self.initial_yield_stress = 1e-3 * young  # a scale for tolerances only

    def stiffness(self):
        """D of plane stress (3, 3) [MPa]."""
        nu = self.poisson
        unit = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 - 0.5 * nu]])
        return self.young / (1.0 - nu**2) * unit

    def respond(self, strain, old, new, dt):
        """Plane-stress elasticity."""
        nu, stiffness = self.poisson, self.stiffness()
        new.stress[:] = strain @ stiffness
        new.thickness_strain[:] = -nu / (1.0 - nu) * (strain[:, 0] + strain[:, 1]) if nu else 0.0
        return np.broadcast_to(stiffness, (len(strain), 3, 3))


class SaintVenantKirchhoff(LinearElastic):
    """S = D E, linear in Green strain, of a sheet that keeps its thickness: the smooth shell's."""

    def update(self, metric, old, new, tangent=True, dt=None):
        """Second Piola-Kirchhoff stress, and its constant tangent."""
        strains(metric, new.strain)
        green = np.column_stack([0.5 * (metric[:, :2] - 1.0), metric[:, 2]])
        stiffness = self.stiffness()
        new.second_stress[:] = green @ stiffness
        new.stress[:] = new.second_stress  # fields of a result; nothing of the shell's is read from them
        new.thickness_strain[:] = 0.0
        if tangent:
            new.tangent[:] = stiffness


def lattice(case, refinement):
    """One-diagonal lattice on the case's parameter rectangle: relative coordinates (n,), (n,) and cells (m, 3)."""
    ns, nt = case.cells[refinement]
    s, t = np.meshgrid(np.linspace(0.0, 1.0, ns + 1), np.linspace(0.0, 1.0, nt + 1), indexing="ij")
    a = (np.arange(ns)[:, None] * (nt + 1) + np.arange(nt)).ravel()
    b, c, d = a + nt + 1, a + nt + 2, a + 1
    return s.ravel(), t.ravel(), np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)


def unstructured(case, refinement):
    """The same from gmsh, with sides of about the same length."""
    from cadlink import Rectangle, mesh_blank

    # Arc lengths from a fine polyline, so that triangles are as round on the surface as in the plane.
    line = np.linspace(0.0, 1.0, 200)
    middle = np.full(200, 0.5)
    a, b = (
        np.linalg.norm(np.diff(case.shape(u * case.size[0], v * case.size[1]), axis=0), axis=1).sum()
        for u, v in ((line, middle), (middle, line))
    )
    mesh = mesh_blank(
        Rectangle(a, b, center=(0.5 * a, 0.5 * b)), a / case.cells[refinement][0], arrangement="unstructured"
    )
    return mesh.points[:, 0] / a, mesh.points[:, 1] / b, open_corners(np.array(mesh.cells))


def open_corners(cells):
    """Cells (m, 3) in which no node belongs to one triangle alone: the side facing such a corner is turned to it.

    A load there would rest on four triangles of the whole shell; that node gives way more than its mesh size says.
    """
    across, apex = neighbours(cells)
    alone = np.bincount(cells.ravel())[cells] == 1
    turned = np.zeros(len(cells), dtype=bool)  # two corners may face each other: one turn opens both
    for tri, i in zip(*np.nonzero(alone & (across >= 0)), strict=True):
        if turned[tri] or turned[across[tri, i]]:
            continue
        turned[[tri, across[tri, i]]] = True
        corner, start, end = cells[tri, [i, (i + 1) % 3, (i + 2) % 3]]
        far = cells[across[tri, i], apex[tri, i]]
        cells[tri], cells[across[tri, i]] = (corner, start, far), (corner, far, end)
    return cells


MESHES = {"lattice": lattice, "unstructured": unstructured}


def build(case, kind, refinement):
    """Scene of a case."""
    s, t, cells = MESHES[kind](case, refinement)
    mesh = SimpleNamespace(
        points=case.shape(s * case.size[0], t * case.size[1]),
        cells=cells,
        groups={name: np.flatnonzero(condition(s, t)) for name, condition in case.groups.items()},
    )
    law = LinearElastic if case.smooth is None else SaintVenantKirchhoff
    blank = Blank(
        mesh, case.thickness, law(case.young, case.poisson), Shell(2), rolling=(0.3, 0.9, 0.2),
        fixed=case.fixed, clamped=case.clamped,
    )  # fmt: skip
    return Scene(blank, [Stage(**case.loads)], name=case.title)


def path_of(case, scene):
    """Load and displacements of the probes, (n, 1 + n_probes), and Newton iterations: moments turn with the sheet and
    take the product's own march, dead loads the arc length."""
    start = scene.blank.mesh.points
    if "moments" in case.loads:
        results = form(scene, TIGHT, frames=1)
        places, iterations = (
            [(0.0, start), (1.0, results.frames[-1].points)],
            int(np.sum(results.history["iterations"])),
        )
    else:
        farthest = np.abs(case.curve[:, 1:]).max() / STEPS
        steps = list(follow(scene, TIGHT, farthest, loaded=case.wrinkles, last=case.curve[-1, 0]))
        places, iterations = [step[:2] for step in steps], sum(step[2] for step in steps)
    node = [(scene.blank.nodes_of(group)[0], axis, sign) for group, axis, sign in case.probes.values()]
    path = [[load, *(sign * (x[n, axis] - start[n, axis]) for n, axis, sign in node)] for load, x in places]
    return np.array(path), iterations


def distances(path, curve):
    """Farthest distance of a published row to the path found, for each probe, with loads relative to the largest of the
    rows and displacements to the probe's largest: the error of the load or of the displacement where the curve is flat
    or steep, and defined where it snaps, too."""
    scale = np.abs(curve).max(axis=0)
    path, curve = path / scale, curve / scale
    if len(path) > 3:
        place = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        path = CubicSpline(place, path)(np.linspace(0.0, place[-1], 200 * len(path)))
        rows = curve
    else:
        rows = curve[-1:]
    away = [
        max(np.hypot(path[:, 0] - row[0], path[:, k] - row[k]).min() for row in rows) for k in range(1, curve.shape[1])
    ]
    return np.array(away)


def measure(name, kind, refinement):
    """Run one problem. Returns a row: problem, mesh, cells along s, nodes, values {probe: (found, published, error)} at
    the full load, off {probe: distance of the curves}, error: the largest of them, smooth {probe: (error at the full
    load, distance of the curves)} against the splines where there are such, iterations, seconds of CPU time."""
    case = PROBLEMS[name]
    scene = build(case, kind, refinement)
    started = time.process_time()
    path, iterations = path_of(case, scene)
    seconds = time.process_time() - started
    ends = zip(path[-1, 1:].tolist(), case.curve[-1, 1:].tolist(), strict=True)
    values = {probe: (v, r, v / r - 1.0) for probe, (v, r) in zip(case.probes, ends, strict=True)}
    off = dict(zip(case.probes, distances(path, case.curve).tolist(), strict=True))
    smooth = {}
    if case.smooth is not None:
        last = path[-1, 1:] / case.smooth[-1, 1:] - 1.0
        smooth = dict(zip(case.probes, zip(last.tolist(), distances(path, case.smooth).tolist(), strict=True)))
    return {
        "problem": name, "mesh": kind, "cells": case.cells[refinement][0], "nodes": len(scene.blank.mesh.points),
        "values": values, "off": off,
        "smooth": smooth,
        "error": max(*off.values(), *(abs(e) for _, _, e in values.values())),
        "iterations": iterations, "seconds": seconds,
    }  # fmt: skip


class BenchError(ValueError):
    """A problem that does not exist. One line."""


def checked(names):
    """The problems asked for, all where none is. Raises BenchError."""
    for name in names:
        if name not in PROBLEMS:
            raise BenchError(f"bench shell: found problem {name!r}, expected some of {', '.join(PROBLEMS)}")
    return names or tuple(PROBLEMS)


def rows(names=None, refinements=(0, 1, 2)):
    """Run problems on both kinds of mesh; yields the rows of `measure`, or one with "failed" and the reason."""
    for name in names or PROBLEMS:
        for kind in MESHES:
            for refinement in refinements:
                try:
                    yield measure(name, kind, refinement)
                except StepFailed as failure:
                    cells = PROBLEMS[name].cells[refinement][0]
                    yield {"problem": name, "mesh": kind, "cells": cells, "failed": str(failure)}


def line_of(row):
    """A row as texts: problem, mesh, nodes, errors in per cent, Newton iterations, seconds."""
    if "failed" in row:
        return [row["problem"], row["mesh"], "", f"{row['cells']} cells a side: {row['failed']}", "", "", "", ""]
    errors = ", ".join(f"{probe} {100.0 * error:+.2f}" for probe, (_, _, error) in row["values"].items())
    off = f"{100.0 * max(row['off'].values()):.2f}"
    smooth = ", ".join(f"{probe} {100.0 * error:+.2f}" for probe, (error, _) in row["smooth"].items())
    if smooth:
        smooth += f"; curve {100.0 * max(away for _, away in row['smooth'].values()):.2f}"
    return [
        row["problem"],
        row["mesh"],
        str(row["nodes"]),
        errors,
        off,
        smooth,
        str(row["iterations"]),
        f"{row['seconds']:.1f}",
    ]


HEADER = ["problem", "mesh", "nodes", "at full load [%]", "curve [%]", "from splines [%]", "iterations", "CPU s"]


def plot(done, png):
    """Draw the error of each run against the number of nodes: the largest one against the published rows, and the
    largest at the full load against the limit of the meshes. done : rows; png : path"""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    largest = {}  # {(problem, mesh): largest error at the full load against the limit, of each refinement}
    for row in limit_rows(done):
        for kind, errors in row["errors"].items():
            key = row["problem"], kind
            largest[key] = np.maximum(largest.get(key, 0.0), np.abs(errors))
    fig, axes = plt.subplots(2, 2, figsize=(12, 8.5), sharex=True, sharey=True, layout="constrained")
    for column, kind in enumerate(MESHES):
        for k, name in enumerate(PROBLEMS):
            mine = [row for row in done if row["problem"] == name and row["mesh"] == kind and "failed" not in row]
            nodes = [row["nodes"] for row in mine]
            errors = [row["error"] for row in mine], largest.get((name, kind), [])
            for axis, error in zip(axes[:, column], errors, strict=True):
                done_with = nodes[len(nodes) - len(error) :]
                axis.loglog(done_with, 100.0 * np.array(error), "o-", color=f"C{k}", label=name, markersize=4)
        for axis, what in zip(
            axes[:, column], ("from the published rows", "from the limit, at the full load"), strict=True
        ):
            reach = np.array([30.0, 5000.0])
            axis.loglog(reach, 600.0 / reach, "--", color="0.6", label="second order")
            axis.set(title=f"{kind}: {what}", ylim=(0.005, 50.0))
            axis.grid(alpha=0.3, which="both")
        axes[1, column].set_xlabel("nodes")
    for axis in axes[:, 0]:
        axis.set_ylabel("largest error [%]")
    fig.legend(*axes[0, 1].get_legend_handles_labels(), fontsize=8, loc="outside right center")
    fig.savefig(png, dpi=110)
    plt.close(fig)
