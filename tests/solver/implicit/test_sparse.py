import numpy as np
import pytest

from solver.elements.assembly import build_pattern, gather_blocks, gather_forces
from solver.implicit import sparse
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


@pytest.fixture(params=["metis", "minimum degree", "pardiso"])
def way(request, monkeypatch):
    """Every way to solve, whatever is installed here."""
    if request.param == "pardiso":
        if sparse.find_pardiso() is None:
            pytest.skip("the extra `pardiso` is not installed")
        return
    monkeypatch.setattr(sparse, "find_pardiso", lambda: None)
    if request.param == "minimum degree":
        monkeypatch.setattr(sparse, "find_metis", lambda: None)


@pytest.mark.parametrize("symmetric", [False, True])
def test_solves_the_free_unknowns_again_and_again(system, way, symmetric):
    mesh, stiffness = system
    if symmetric:
        stiffness = stiffness + stiffness.transpose(0, 3, 4, 1, 2)
    n = len(mesh.points)
    pattern = build_pattern(mesh.cells, n)
    blocks = np.empty((len(pattern.block_row), 3, 3))
    rng = np.random.default_rng(1)
    free = rng.uniform(size=(n, 3)) > 0.2
    solver = sparse.SparseSolver(pattern.block_row, pattern.block_column, free)
    keep = free.ravel()
    for factor in (1.0, -3.0):
        gather_blocks(factor * stiffness.reshape(-1, 9, 9), 3, 3, pattern.block_first, pattern.block_slot, blocks)
        solver.factorize(blocks)
        for columns in (1, 2):
            right = rng.standard_normal((n, 3, columns))
            answer = solver.solve(right).reshape(3 * n, columns)
            matrix = factor * dense(mesh, stiffness)[np.ix_(keep, keep)]
            assert answer[keep] == pytest.approx(np.linalg.solve(matrix, right.reshape(3 * n, -1)[keep]), abs=1e-12)
            assert not answer[~keep].any()


def test_a_matrix_may_turn_symmetric_and_back(system, way):
    mesh, stiffness = system
    n = len(mesh.points)
    pattern = build_pattern(mesh.cells, n)
    solver = sparse.SparseSolver(pattern.block_row, pattern.block_column, np.ones((n, 3), bool))
    right = np.random.default_rng(2).standard_normal((n, 3))
    blocks = np.empty((len(pattern.block_row), 3, 3))
    mean = 0.5 * (stiffness + stiffness.transpose(0, 3, 4, 1, 2))
    for k in (stiffness, mean, stiffness):
        gather_blocks(k.reshape(-1, 9, 9), 3, 3, pattern.block_first, pattern.block_slot, blocks)
        solver.factorize(blocks)
        assert solver.solve(right).ravel() == pytest.approx(np.linalg.solve(dense(mesh, k), right.ravel()), abs=1e-12)


def test_a_singular_matrix_is_told(system, way):
    mesh, stiffness = system
    n = len(mesh.points)
    pattern = build_pattern(mesh.cells, n)
    solver = sparse.SparseSolver(pattern.block_row, pattern.block_column, np.ones((n, 3), bool))
    with pytest.raises(RuntimeError):
        solver.factorize(np.zeros((len(pattern.block_row), 3, 3)))


def test_nodal_forces_are_summed_over_the_triangles(system):
    mesh, _ = system
    pattern = build_pattern(mesh.cells, len(mesh.points))
    slots = np.random.default_rng(0).standard_normal((len(mesh.cells), 3, 3))
    force = np.empty((len(mesh.points), 3))
    gather_forces(slots, *pattern.rows, force)
    expected = np.zeros_like(force)
    np.add.at(expected, mesh.cells.ravel(), slots.reshape(-1, 3))
    assert force == pytest.approx(expected, abs=1e-13)
