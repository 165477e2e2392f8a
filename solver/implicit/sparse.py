"""The sparse solve, behind one small interface: `factorize(blocks)` once per tangent, then `solve(right side)`.

SuperLU on the matrix in nested-dissection order (METIS, on the graph of nodes; where pymetis is missing, SuperLU's own
minimum degree). The pattern, the ordering and the place of every entry are found once.
"""

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu


def nested_dissection(row, column, n_nodes):
    """Order of elimination of the nodes of a block pattern (row, column), or None without pymetis."""
    try:
        import pymetis
    except ImportError:
        return None
    off = row != column
    first = np.searchsorted(row[off], np.arange(n_nodes + 1))
    order, _ = pymetis.nested_dissection(pymetis.CSRAdjacency(first, column[off]))
    return np.asarray(order)


class SparseSolver:
    """Solves with a 3 x 3 block matrix restricted to its free unknowns.

    row, column : (n_blocks,) node of each block, sorted by row; free : (n_nodes, 3) bool
    """

    def __init__(self, row, column, free):
        n_nodes = len(free)
        order = nested_dissection(row, column, n_nodes)
        self.ordering = "MMD_AT_PLUS_A" if order is None else "NATURAL"
        nodes = np.arange(n_nodes) if order is None else order
        unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
        self.unknowns = unknowns[free.ravel()[unknowns]]
        place = np.full(3 * n_nodes, -1)
        place[self.unknowns] = np.arange(len(self.unknowns))
        rows = place[(3 * row[:, None, None] + np.arange(3)[None, :, None]) + np.zeros((1, 1, 3), int)].ravel()
        columns = place[(3 * column[:, None, None] + np.arange(3)[None, None, :]) + np.zeros((1, 3, 1), int)].ravel()
        kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        n = len(self.unknowns)
        pattern = csc_matrix((np.arange(1.0, len(kept) + 1.0), (rows[kept], columns[kept])), shape=(n, n))
        self.entry = kept[pattern.data.astype(np.int64) - 1]
        self.indices, self.indptr, self.shape = pattern.indices, pattern.indptr, pattern.shape
        self.factor = None

    def factorize(self, blocks):
        """blocks : (n_blocks, 3, 3). Raises RuntimeError where the matrix is singular."""
        matrix = csc_matrix((blocks.ravel()[self.entry], self.indices, self.indptr), shape=self.shape)
        options = {"SymmetricMode": True}
        self.factor = splu(matrix, permc_spec=self.ordering, diag_pivot_thresh=0.01, options=options)

    def solve(self, right):
        """right : (n_nodes, 3) or (n_nodes, 3, k). Returns the same shape, 0 at fixed unknowns."""
        flat = right.reshape(right.shape[0] * 3, -1)
        answer = np.zeros_like(flat)
        answer[self.unknowns] = self.factor.solve(np.ascontiguousarray(flat[self.unknowns]))
        return answer.reshape(right.shape)
