"""Moments along a shell's edge: forces on the triangle behind each side and on the side's slope, and their tangent
(theory_shell.md 10).

The outward slope of a side is its triangle's rotation plus the edge slope phi; a moment m per unit initial length
works on both. With e = x_k - x_j along the side of initial length l, q = x_i - x_j and c = e x q:
F_I = -m l s_I c / (|e| |c|^2), s_i = -e.e, s_j = e.e - q.e, s_k = q.e. A positive m stretches the face that the
normals leave.
"""

import numpy as np


class EdgeMoment:
    """Free sides that carry a moment: tri (k,) their triangles, corners (k, 3) local and cells (k, 3) global numbers of
    nodes i (opposite to the side), j, k; rows (k,) of their edge slopes; length (k,) initial [mm]; size: scale of the
    slopes [mm]."""

    def __init__(self, sheet, nodes):
        triangles, slots = sheet.triangles, sheet.elements.slots
        on = np.zeros(len(sheet.points), dtype=bool)
        on[nodes] = True
        found = []
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            tri = np.flatnonzero((slots[:, 3 + i] < 0) & on[triangles.cells[:, j]] & on[triangles.cells[:, k]])
            found.append(np.column_stack([tri, np.tile([i, j, k], (len(tri), 1)), slots[tri, 6 + i]]))
        sides = np.concatenate(found)
        self.tri, self.corners, self.rows, self.size = sides[:, 0], sides[:, 1:4], sides[:, 4], sheet.size
        self.cells = np.take_along_axis(triangles.cells[self.tri], self.corners, axis=1)
        self.length = np.linalg.norm(sheet.points[self.cells[:, 2]] - sheet.points[self.cells[:, 1]], axis=1)

    def add(self, x, moment, external):
        """Add the forces of a moment [N] per unit length to external (n + k, 3) [N]."""
        np.add.at(external, self.cells.ravel(), self._forces(x, moment).reshape(-1, 3))
        external[self.rows, 0] -= moment * self.length / self.size

    def _forces(self, x, moment):
        e, q, c, scale = self._side(x)
        ee, qe = np.sum(e * e, axis=1), np.sum(q * e, axis=1)
        s = np.stack([-ee, ee - qe, qe], axis=1)
        return -moment * s[:, :, None] * (self.length / scale)[:, None, None] * c[:, None, :]

    def subtract_tangent(self, x, moment, stiffness):
        """Subtract the derivative of these forces from the triangles' stiffness (m, d, d) [N/mm]."""
        e, q, c, scale = self._side(x)
        ee, qe, cc = np.sum(e * e, axis=1), np.sum(q * e, axis=1), np.sum(c * c, axis=1)
        s = np.stack([-ee, ee - qe, qe], axis=1)
        for node in range(3):
            for d in range(3):
                unit = np.zeros(3)
                unit[d] = 1.0
                de = ((node == 2) - float(node == 1)) * unit
                dq = ((node == 0) - float(node == 1)) * unit
                de, dq = np.broadcast_to(de, e.shape), np.broadcast_to(dq, q.shape)
                dc = np.cross(de, q) + np.cross(e, dq)
                dee, dqe = 2.0 * np.sum(e * de, axis=1), np.sum(dq * e + q * de, axis=1)
                ds = np.stack([-dee, dee - dqe, dqe], axis=1)
                stretch = 0.5 * dee / ee + 2.0 * np.sum(c * dc, axis=1) / cc
                change = ds[:, :, None] * c[:, None] + s[:, :, None] * (dc - stretch[:, None] * c)[:, None]
                change *= moment * (self.length / scale)[:, None, None]
                for other in range(3):
                    for c_other in range(3):
                        place = self.tri, 3 * self.corners[:, other] + c_other, 3 * self.corners[:, node] + d
                        np.add.at(stiffness, place, change[:, other, c_other])

    def _side(self, x):
        i, j, k = self.cells.T
        e, q = x[k] - x[j], x[i] - x[j]
        c = np.cross(e, q)
        return e, q, c, np.linalg.norm(e, axis=1) * np.sum(c * c, axis=1)
