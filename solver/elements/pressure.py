"""Pressure that follows the sheet: nodal forces and their exact tangent.

Each triangle takes p times its current vector area, a third at each node:
f_I = -p/6 (x_2 - x_1) x (x_3 - x_1), against the triangle's normal.
"""

import numpy as np
from numba import njit, prange


@njit(parallel=True, cache=True)
def pressure_forces(x, cells, pressure, force, stiffness):
    """Fills force (m, 3, 3) with the nodal forces of a pressure [N] and subtracts their derivative from
    stiffness (m, d, d), whose first nine unknowns are the nodes' [N/mm], where that is not
    empty. pressure : MPa, x : (n, 3)."""
    wanted = stiffness.shape[0] > 0
    for tri in prange(cells.shape[0]):
        n1, n2, n3 = cells[tri]
        u, v = np.empty(3), np.empty(3)
        for c in range(3):
            u[c], v[c] = x[n2, c] - x[n1, c], x[n3, c] - x[n1, c]
        for c in range(3):
            c1, c2 = (c + 1) % 3, (c + 2) % 3
            area = u[c1] * v[c2] - u[c2] * v[c1]
            for i in range(3):
                force[tri, i, c] = -pressure / 6.0 * area
                if not wanted:
                    continue
                # Derivative of the cross product's component c with respect to u and v.
                for d, du, dv in ((c1, v[c2], -u[c2]), (c2, -v[c1], u[c1])):
                    stiffness[tri, 3 * i + c, 3 + d] += pressure / 6.0 * du
                    stiffness[tri, 3 * i + c, 6 + d] += pressure / 6.0 * dv
                    stiffness[tri, 3 * i + c, d] -= pressure / 6.0 * (du + dv)
