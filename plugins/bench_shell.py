"""The shell against published large-deflection problems, on one-diagonal lattices and on unstructured meshes."""

import time
from types import SimpleNamespace

import numpy as np

from solver import Blank, Implicit, Scene, Shell, Stage, StepFailed, form
from solver.materials.law import Law

from .shell_problems import PROBLEMS


class LinearElastic(Law):
    """T = D H, linear in logarithmic strain."""

    def __init__(self, young, poisson):
        self.young, self.poisson, self.name = young, poisson, "elastic"
        self.initial_yield_stress = 1e-3 * young  # a scale for tolerances only

    def respond(self, strain, old, new, dt):
        """Plane-stress elasticity."""
        c, nu = self.young / (1.0 - self.poisson**2), self.poisson
        stiffness = c * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 - 0.5 * nu]])
        new.stress[:] = strain @ stiffness
        new.thickness_strain[:] = -nu / (1.0 - nu) * (strain[:, 0] + strain[:, 1]) if nu else 0.0
        return np.broadcast_to(stiffness, (len(strain), 3, 3))


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
    return mesh.points[:, 0] / a, mesh.points[:, 1] / b, np.asarray(mesh.cells)


MESHES = {"lattice": lattice, "unstructured": unstructured}


def build(case, kind, refinement):
    """Scene of a case."""
    s, t, cells = MESHES[kind](case, refinement)
    mesh = SimpleNamespace(
        points=case.shape(s * case.size[0], t * case.size[1]),
        cells=cells,
        groups={name: np.flatnonzero(condition(s, t)) for name, condition in case.groups.items()},
    )
    blank = Blank(
        mesh, case.thickness, LinearElastic(case.young, case.poisson), Shell(2), rolling=(0.3, 0.9, 0.2),
        fixed=case.fixed, clamped=case.clamped,
    )  # fmt: skip
    return Scene(blank, [Stage(**case.loads)], name=case.title)


def measure(name, kind, refinement):
    """Run one problem. Returns a row: problem, mesh, nodes, {probe: (found, reference, error)}, iterations, seconds."""
    case = PROBLEMS[name]
    scene = build(case, kind, refinement)
    started = time.perf_counter()
    results = form(scene, Implicit(), frames=40 if case.reaction else 1)
    seconds = time.perf_counter() - started
    moved = results.frames[-1].points - scene.blank.mesh.points
    found = {}
    for probe, (group, axis, sign) in case.probes.items():
        found[probe] = sign * float(moved[scene.blank.nodes_of(group)[0], axis])
    values = {k: (v, case.reference[k], v / case.reference[k] - 1.0) for k, v in found.items()}
    if case.reaction:
        group, axis, load = case.reaction
        path = np.append(0.0, results.history["stroke"]) * abs(case.loads["moved"][group]["xyz".index(axis)])
        force = np.append(0.0, results.history[f"reaction_{group}_{axis}"]) / load
        off = [float(np.interp(place, path, force)) - share for place, share in case.curve]
        worst = int(np.argmax(np.abs(off)))
        values["P, worst"] = (case.curve[worst][1] + off[worst], case.curve[worst][1], off[worst])
        values["P, end"] = (case.curve[-1][1] + off[-1], case.curve[-1][1], off[-1] / case.curve[-1][1])
    return {
        "problem": name, "mesh": kind, "nodes": len(scene.blank.mesh.points), "values": values,
        "iterations": int(np.sum(results.history["iterations"])), "seconds": seconds,
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
                    yield {"problem": name, "mesh": kind, "refinement": refinement, "failed": str(failure)}


def line_of(row):
    """A row as texts: problem, mesh, nodes, errors in per cent, Newton iterations, seconds."""
    if "failed" in row:
        return [row["problem"], row["mesh"], "", row["failed"], "", ""]
    errors = ", ".join(f"{probe} {100.0 * error:+.2f}" for probe, (_, _, error) in row["values"].items())
    return [row["problem"], row["mesh"], str(row["nodes"]), errors, str(row["iterations"]), f"{row['seconds']:.1f}"]


HEADER = ["problem", "mesh", "nodes", "error [%]", "iterations", "s"]


def plot(done, png):
    """Draw the largest error of each run against the number of nodes. done : rows; png : path"""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig, axes = plt.subplots(1, 2, figsize=(12, 4.6), sharey=True, layout="constrained")
    for axis, kind in zip(axes, MESHES):
        for k, name in enumerate(PROBLEMS):
            mine = [row for row in done if row["problem"] == name and row["mesh"] == kind and "failed" not in row]
            nodes = [row["nodes"] for row in mine]
            error = [100.0 * max(abs(e) for _, _, e in row["values"].values()) for row in mine]
            axis.loglog(nodes, error, "o-", color=f"C{k}", label=name, markersize=4)
        reach = np.array([30.0, 3000.0])
        axis.loglog(reach, 600.0 / reach, "--", color="0.6", label="second order")
        axis.set(title=kind, xlabel="nodes", ylim=(0.05, 50.0))
        axis.grid(alpha=0.3, which="both")
    axes[0].set_ylabel("largest error [%]")
    fig.legend(*axes[1].get_legend_handles_labels(), fontsize=8, loc="outside right center")
    fig.savefig(png, dpi=130)
    plt.close(fig)
