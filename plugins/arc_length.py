"""The equilibrium path of a sheet under dead loads, past limit points and snap-backs: Crisfield's arc length.

Each step keeps |du| = s over all unknowns u while the load factor f is free (M. A. Crisfield, Computers and Structures
13 (1981) 55-62). With v = K^-1 F the movement per load factor and r = K^-1 (f F - internal), an iteration adds
r + df v, df from a df^2 + b df + c = 0, the root that goes on in the direction of the step. Where the loaded nodes
never come back, their movement e.du = s along the load, e = F/|F|, is a simpler length: it does not follow wrinkles
that form and turn over elsewhere, and df = (s - e.(du + r))/(e.v).
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from solver.errors import StepFailed
from solver.form import first_state
from solver.implicit.equilibrium import Equilibrium
from solver.implicit.method import Newton
from solver.implicit.sparse import SparseSolver
from solver.sheet import build_sheet

SWIFT, GROW, CUT = 6, 1.5, 0.4  # iterations at which a step is about right; its growth below and cut on failure
SMALLEST = 1e-6  # step, relative to the first


class WholeSheet:
    """Length of a step: |du| over all unknowns."""

    def size(self, moved):
        """Length of a movement (n, 3)."""
        return np.linalg.norm(moved)

    def turns_back(self, v, onward):
        """Whether a rising load turns the path back. onward : (n, 3), the step before"""
        return np.sum(v * onward) < 0.0

    def change(self, moved, r, v, size):
        """Change of the load factor that keeps |moved + r + change v| = size and turns the step least, or None."""
        ahead = moved + r
        a, b, c = np.sum(v * v), 2.0 * np.sum(ahead * v), np.sum(ahead * ahead) - size**2
        under = b * b - 4.0 * a * c
        if under < 0.0:
            return None
        both = [(-b + sign * sqrt(under)) / (2.0 * a) for sign in (1.0, -1.0)]
        return max(both, key=lambda change: np.sum(moved * (ahead + change * v)))


@dataclass
class LoadedNodes:
    """Length of a step: the movement of the loaded nodes along the load. along : (n, 3), of length 1"""

    along: np.ndarray

    def size(self, moved):
        """Length of a movement (n, 3)."""
        return abs(np.sum(self.along * moved))

    def turns_back(self, v, onward):
        """Whether a rising load turns the path back."""
        return np.sum(self.along * v) < 0.0

    def change(self, moved, r, v, size):
        """Change of the load factor that moves the loaded nodes by size."""
        return (size - np.sum(self.along * (moved + r))) / np.sum(self.along * v)


def follow(scene, method, farthest, *, loaded=False, last=1.0, first=0.02, n_steps=400):
    """Points of the path from no load to `last` times the load of the scene's first stage, which has forces only.

    farthest : largest movement of a node that a step sets out for [mm]; loaded : measure steps by the loaded nodes
    alone; first : load factor of the first step
    yields (load factor, node positions (n, 3) mm, iterations). Raises StepFailed.
    """
    sheet = build_sheet(scene.blank)
    old, new = (first_state(scene, sheet, method) for _ in range(2))
    equilibrium = Equilibrium(sheet, scene.stages[0], [], method, old)
    solver = SparseSolver(sheet.pattern.block_row, sheet.pattern.block_column, ~equilibrium.fixed)
    equilibrium.begin(old, new)
    equilibrium.evaluate(old, new, 1.0)
    load = np.where(equilibrium.fixed, 0.0, new.sheet.external)
    length = LoadedNodes(load / np.linalg.norm(load)) if loaded else WholeSheet()
    onward, factor, size = np.zeros_like(load), 0.0, None
    yield 0.0, old.sheet.x.copy(), 0
    for _ in range(n_steps):
        new.copy_from(old)
        equilibrium.begin(old, new)
        equilibrium.evaluate(old, new, 0.0)
        solver.factorize(equilibrium.tangent().blocks)
        v = solver.solve(load)
        if size is None:
            smallest, size = SMALLEST * first * length.size(v), first * length.size(v)
        size = min(size, farthest / np.abs(v).max() * length.size(v))
        ahead = -1.0 if length.turns_back(v, onward) else 1.0
        while True:
            step = ahead * size / length.size(v)
            reached = factor + step >= last
            found = correct(
                equilibrium, solver, old, new, load, factor, min(step, last - factor), v,
                None if reached else size, length,
            )  # fmt: skip
            if found and (reached or found[0] < last):
                break
            size *= CUT
            if size < smallest:
                raise StepFailed(f"arc length: no equilibrium beyond {factor:.4f} of the load; refine the mesh")
        factor, iterations = found
        onward = new.sheet.u - old.sheet.u
        size = length.size(onward) * min(GROW, sqrt(SWIFT / max(iterations, 1)))
        old.copy_from(new)
        yield factor, old.sheet.x.copy(), iterations
        if factor >= last:
            return
    raise StepFailed(f"arc length: {factor:.4f} of the load after {n_steps} steps; allow larger ones")


def correct(equilibrium, solver, old, new, load, factor, step, v, size, length):
    """Bring new into equilibrium at the distance `size` of old, or at the load factor + step where size is None, from
    the prediction v step. Returns (load factor, iterations), or None where it does not converge."""
    newton = Newton(residual=1e-6, correction=1e-6)
    new.copy_from(old)
    new.sheet.u += step * v
    factor += step
    error = np.inf
    for iteration in range(1, newton.iterations):
        equilibrium.evaluate(old, new, 0.0)
        residual = np.where(equilibrium.fixed, 0.0, factor * load - new.sheet.internal)
        before, error = error, np.linalg.norm(residual) / max(np.linalg.norm(new.sheet.internal), np.linalg.norm(load))
        if not np.isfinite(error) or (iteration > 6 and error > before):
            return None
        if error <= newton.residual:
            return factor, iteration
        try:
            solver.factorize(equilibrium.tangent().blocks)
        except RuntimeError:
            return None
        r = solver.solve(residual)
        change = 0.0
        if size is not None:
            v = solver.solve(load)
            change = length.change(new.sheet.u - old.sheet.u, r, v, size)
            if change is None:
                return None
        new.sheet.u += r + change * v
        factor += change
    return None
