"""Points or triangles taken together, so that every pass over them is one plain loop, which the compiler turns into
vector code.

A block is up to `BLOCK` of them. What passes hand on lies in one flat array w, field after field: w[H + p] is the first
component of H of point p, w[H + BLOCK + p] the second. The loops call nothing that is not inlined and look nothing up;
the rare point that needs more is done by itself between two of them. One array, because between two the compiler would
have to rule out overlap. Arrays of the sheet come flat, 3 p + c for component c of point p: of rows (n, 3) the compiler
does not know that they lie 3 apart, and keeps its vector code for rows that lie 1 apart. On 25,000 planar-Hill points
of which most flow rows took 40 ns a point, flat arrays 23.
"""

from numba import njit

from .kernels import FUSED, FUSED_POINT, POINT

BLOCK = 64


@njit(**POINT)
def n_blocks(count):
    """Blocks of so many points or triangles."""
    return (count + BLOCK - 1) // BLOCK


@njit(**FUSED_POINT)
def vector(w, field, p):
    """Three fields of one point."""
    return w[field + p], w[field + BLOCK + p], w[field + 2 * BLOCK + p]


@njit(**FUSED_POINT)
def put(w, field, p, v):
    """Fills three fields of one point."""
    w[field + p], w[field + BLOCK + p], w[field + 2 * BLOCK + p] = v


@njit(**FUSED)
def copy(fields, source, at, target, to):
    """Copies some fields. A loop: numba's own assignment of slices compiles a second longer."""
    for i in range(fields * BLOCK):
        target[to + i] = source[at + i]


@njit(**FUSED)
def clear(fields, w, field):
    """Sets some fields to 0."""
    for i in range(fields * BLOCK):
        w[field + i] = 0.0


@njit(**FUSED)
def take(n, rows, w, field):
    """Fills three fields of n points from rows (3 n,)."""
    for p in range(n):
        put(w, field, p, (rows[3 * p], rows[3 * p + 1], rows[3 * p + 2]))


@njit(**FUSED)
def give(n, w, field, rows):
    """Fills rows (3 n,) from three fields of n points."""
    for p in range(n):
        rows[3 * p], rows[3 * p + 1], rows[3 * p + 2] = vector(w, field, p)
