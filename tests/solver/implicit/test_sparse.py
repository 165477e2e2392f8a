import numpy as np
import pytest

from solver.elements.assembly import build_pattern, gather_blocks, gather_forces
from solver.implicit.sparse import SparseSolver
from tests.solver.lattice import square


@pytest.fixture
def system():
    """Random unsymmetric, diagonally strong element matrices on a small mesh."""
    mesh = square(4, 4.0)
    rng = np.random.default_rng(4)
    stiffness = rng.standard_normal((len(mesh.cells), 3, 3, 3, 3))
    for i in range(3):
        for c in range(3):
            stiffness[:, i, c, i, c] += 12.0
    return mesh, stiffness


def dense(mesh, stiffness):
    n = len(mesh.points)
    full = np.zeros((n, 3, n, 3))
    for tri, nodes in enumerate(mesh.cells):
        for i, a in enumerate(nodes):
            for j, b in enumerate(nodes):
                full[a, :, b, :] += stiffness[tri, i, :, j, :]
    return full.reshape(3 * n, 3 * n)


@pytest.mark.parametrize("with_metis", [True, False])
def test_solves_the_free_unknowns(system, with_metis, monkeypatch):
    mesh, stiffness = system
    if not with_metis:
        monkeypatch.setattr("solver.implicit.sparse.nested_dissection", lambda *_: None)
    n = len(mesh.points)
    pattern = build_pattern(mesh.cells, n)
    blocks = np.empty((len(pattern.block_row), 3, 3))
    gather_blocks(stiffness.reshape(-1, 9, 9), 3, 3, pattern.block_first, pattern.block_slot, blocks)
    rng = np.random.default_rng(1)
    free = rng.uniform(size=(n, 3)) > 0.2
    solver = SparseSolver(pattern.block_row, pattern.block_column, free)
    solver.factorize(blocks)
    right = rng.standard_normal((n, 3, 2))
    answer = solver.solve(right)
    keep = free.ravel()
    expected = np.linalg.solve(dense(mesh, stiffness)[np.ix_(keep, keep)], right.reshape(3 * n, 2)[keep])
    assert answer.reshape(3 * n, 2)[keep] == pytest.approx(expected, abs=1e-12)
    assert not answer.reshape(3 * n, 2)[~keep].any()


def test_nodal_forces_are_summed_over_the_triangles(system):
    mesh, _ = system
    pattern = build_pattern(mesh.cells, len(mesh.points))
    slots = np.random.default_rng(0).standard_normal((len(mesh.cells), 3, 3))
    force = np.empty((len(mesh.points), 3))
    gather_forces(slots, *pattern.rows, force)
    expected = np.zeros_like(force)
    np.add.at(expected, mesh.cells.ravel(), slots.reshape(-1, 3))
    assert force == pytest.approx(expected, abs=1e-13)
