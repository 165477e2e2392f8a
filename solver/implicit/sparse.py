"""The sparse solve, behind one small interface: `factorize(blocks)` once per tangent, then `solve(right side)`.

PARDISO of the MKL where `pypardiso` is installed (the extra `pardiso`), by its symmetric path where the matrix is
symmetric. Else SuperLU on the matrix in nested-dissection order (METIS, on the graph of nodes; where pymetis is
missing, SuperLU's own minimum degree). The pattern, the ordering and the place of every entry are found once.
"""

from functools import cache

import numpy as np
from numba import get_num_threads
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

SYMMETRIC = 1e-10  # difference from the transposed matrix, relative to the largest entry


class SparseSolver:
    """Solves with a 3 x 3 block matrix restricted to its free unknowns.

    row, column : (n_blocks,) node of each block, sorted by row; free : (n_nodes, 3) bool
    """

    def __init__(self, row, column, free):
        kind = Pardiso if find_pardiso() else SuperLU
        order = kind.order(row, column, len(free))
        unknowns = (3 * order[:, None] + np.arange(3)).ravel()
        self.unknowns = unknowns[free.ravel()[unknowns]]
        place = np.full(free.size, -1)
        place[self.unknowns] = np.arange(len(self.unknowns))
        rows = place[(3 * row[:, None, None] + np.arange(3)[None, :, None]) + np.zeros((1, 1, 3), int)].ravel()
        columns = place[(3 * column[:, None, None] + np.arange(3)[None, None, :]) + np.zeros((1, 3, 1), int)].ravel()
        kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        n = len(self.unknowns)
        pattern = kind.form((np.arange(1.0, len(kept) + 1.0), (rows[kept], columns[kept])), shape=(n, n))
        pattern.sort_indices()
        self.entry = kept[pattern.data.astype(np.int64) - 1]
        self.matrix = pattern
        self.factors = kind(pattern)

    def factorize(self, blocks):
        """blocks : (n_blocks, 3, 3). Raises RuntimeError where the matrix is singular."""
        self.matrix.data[:] = blocks.ravel()[self.entry]
        self.factors.renew(self.matrix)

    def solve(self, right):
        """right : (n_nodes, 3) or (n_nodes, 3, k). Returns the same shape, 0 at fixed unknowns."""
        flat = right.reshape(right.shape[0] * 3, -1)
        answer = np.zeros_like(flat)
        answer[self.unknowns] = self.factors.solve(flat[self.unknowns])
        return answer.reshape(right.shape)


class SuperLU:
    """Factors of an unsymmetric matrix whose pattern is symmetric. pattern : csc_matrix in its order of elimination"""

    form = csc_matrix

    def __init__(self, pattern):
        self.ordering = "NATURAL" if find_metis() else "MMD_AT_PLUS_A"
        self.factors = None

    @staticmethod
    def order(row, column, n_nodes):
        """Order of elimination of the nodes of a block pattern (row, column)."""
        metis = find_metis()
        if metis is None:
            return np.arange(n_nodes)
        off = row != column
        first = np.searchsorted(row[off], np.arange(n_nodes + 1))
        return np.asarray(metis.nested_dissection(metis.CSRAdjacency(first, column[off]))[0])

    def renew(self, matrix):
        """Factorize. Raises RuntimeError where the matrix is singular."""
        options = {"SymmetricMode": True}
        self.factors = splu(matrix, permc_spec=self.ordering, diag_pivot_thresh=0.01, options=options)

    def solve(self, right):
        """right : (n, k)"""
        return self.factors.solve(np.ascontiguousarray(right))


class Pardiso:
    """The same by PARDISO, whose analysis serves every matrix of a pattern (csr_matrix)."""

    form = csr_matrix
    STRUCTURALLY_SYMMETRIC, SYMMETRIC_INDEFINITE = 1, -2  # types of matrices
    ANALYSE, FACTORIZE, SOLVE, RELEASE = 11, 22, 33, -1  # phases

    def __init__(self, pattern):
        n = pattern.shape[0]
        rows = np.repeat(np.arange(n), np.diff(pattern.indptr))
        # Where each entry's mirror image is, and the entries of the upper triangle.
        self.mirror = np.lexsort((rows, pattern.indices))
        self.upper = np.flatnonzero(pattern.indices >= rows)
        first = np.searchsorted(rows[self.upper], np.arange(n + 1))
        self.half = csr_matrix((pattern.data[self.upper], pattern.indices[self.upper], first), shape=pattern.shape)
        self.whole, self.callers = pattern, {}
        self.matrix = self.caller = None

    @staticmethod
    def order(row, column, n_nodes):
        """Left to PARDISO."""
        return np.arange(n_nodes)

    def renew(self, matrix):
        """Factorize. Raises RuntimeError where the matrix is singular."""
        mirrored = matrix.data[self.mirror]
        if np.abs(matrix.data - mirrored).max() <= SYMMETRIC * np.abs(matrix.data).max():
            self.half.data[:] = 0.5 * (matrix.data + mirrored)[self.upper]
            self.matrix, kind = self.half, self.SYMMETRIC_INDEFINITE
        else:
            self.matrix, kind = matrix, self.STRUCTURALLY_SYMMETRIC
        if kind not in self.callers:
            self.callers[kind] = self._analyse(kind)
        self.caller = self.callers[kind]
        self._call(self.FACTORIZE, np.zeros((matrix.shape[0], 1)))
        perturbed = self.caller.get_iparm(14)
        if perturbed:
            raise RuntimeError(f"{perturbed} pivots are zero")

    def solve(self, right):
        """right : (n, k)"""
        return self._call(self.SOLVE, np.asfortranarray(right))

    def _analyse(self, kind):
        self.caller = caller = find_pardiso()(mtype=kind)  # pyright: ignore[reportOptionalCall]
        for number, value in {1: 1, 2: 2, 8: 2, 10: 13 if kind > 0 else 8, 11: 0, 13: 0}.items():
            # No defaults; METIS; two steps of refinement at most; least pivots 1e-13, 1e-8; no scaling, no matching.
            caller.set_iparm(number, value)
        caller.libmkl.MKL_Set_Num_Threads(get_num_threads())
        self._call(self.ANALYSE, np.zeros((self.matrix.shape[0], 1)))
        return caller

    def _call(self, phase, right):
        self.caller.set_phase(phase)
        return self.caller._call_pardiso(self.matrix, right)

    def __del__(self):
        for caller in self.callers.values():
            self.caller = caller
            self._call(self.RELEASE, np.zeros((self.matrix.shape[0], 1)))


@cache
def find_metis():
    """pymetis, or None."""
    try:
        import pymetis
    except ImportError:
        return None
    return pymetis


@cache
def find_pardiso():
    """pypardiso's solver class, or None where it or the MKL is missing."""
    try:
        from pypardiso import PyPardisoSolver  # pyright: ignore[reportMissingImports]

        PyPardisoSolver()
    except ImportError:
        return None
    return PyPardisoSolver
