"""Supports for a sheet that no tool holds: the fewest that stop it from floating away, and carry no force.

Springback is a stage without tools: what they left unbalanced fades (`loads.py`), on supports that only take up the
rigid motions left free by symmetry and by the blank's own ones.
"""

import numpy as np
from scipy.linalg import null_space, qr

LOOSE = 1e-6  # singular value of the supports' hold on a rigid motion below which it is free


def least_supports(x, fixed, planes, clamped):
    """Unknowns (node, axis) to hold besides fixed (n, 3) bool, as two arrays.

    x : (n, 3) mm; planes : axes of the planes of symmetry, out of which the sheet cannot turn; clamped : whether an
    edge is. Chosen by pivoting: the unknowns that hold the free rigid motions best.
    """
    away = x - x.mean(axis=0)
    away /= np.abs(away).max()
    motions = np.zeros((*x.shape, 6))
    motions[:, range(3), range(3)] = 1.0
    for axis in range(3):
        motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], away)
    turns = [np.eye(6)[3 + axis] for plane in planes for axis in range(3) if axis != plane]
    held = np.vstack([motions[fixed], *turns, *(np.eye(6) if clamped else [])])
    free = null_space(held, rcond=LOOSE) if len(held) else np.eye(6)
    if free.shape[1] == 0:
        return np.zeros((2, 0), dtype=np.int64)
    left = np.where(fixed[:, :, None], 0.0, motions @ free).reshape(-1, free.shape[1])
    order = qr(left.T, mode="economic", pivoting=True)[-1]
    return np.stack(np.divmod(order[: free.shape[1]], 3))
