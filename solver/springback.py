"""Supports for a sheet that no tool holds: the fewest that stop it from floating away, and carry no force.

Springback is a stage without tools: what they left unbalanced fades (`loads.py`), on supports that only take up the
rigid motions left free by symmetry and by the blank's own ones. Which nodes they hold says nothing about the part, so
that in the end it is moved as a rigid body to where it fits best what it was before.
"""

import numpy as np
from scipy.linalg import expm, null_space, qr

from .contact.drive import skew

ROUNDS = 20  # of the fit, each of which leaves the square of the turn still to make
LOOSE = 1e-6  # singular value of the supports' hold on a rigid motion below which it is free


def least_supports(x, fixed, planes, clamped):
    """Unknowns (node, axis) to hold besides fixed (n, 3) bool, as two arrays.

    x : (n, 3) mm; planes : axes of the planes of symmetry, out of which the sheet cannot turn; clamped : whether an
    edge is. Chosen by pivoting: the unknowns that hold the free rigid motions best.
    """
    motions, free = free_motions(x, fixed, planes, clamped)
    if free.shape[1] == 0:
        return np.zeros((2, 0), dtype=np.int64)
    left = np.where(fixed[:, :, None], 0.0, motions @ free).reshape(-1, free.shape[1])
    order = qr(left.T, mode="economic", pivoting=True)[-1]
    return np.stack(np.divmod(order[: free.shape[1]], 3))


def free_motions(x, fixed, planes, clamped):
    """Rigid motions of a sheet: movements of its nodes (n, 3, 6) by three shifts and three turns about the nodes' mean,
    a turn of 1 being one rad times the sheet's extent, and those that supports leave free (6, k), orthonormal. See
    least_supports."""
    away = x - x.mean(axis=0)
    away /= np.abs(away).max()
    motions = np.zeros((*x.shape, 6))
    motions[:, range(3), range(3)] = 1.0
    for axis in range(3):
        motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], away)
    turns = [np.eye(6)[3 + axis] for plane in planes for axis in range(3) if axis != plane]
    held = np.vstack([motions[fixed], *turns, *(np.eye(6) if clamped else [])])
    return motions, null_space(held, rcond=LOOSE) if len(held) else np.eye(6)


def fitted(x, before, weight, fixed, planes, clamped):
    """The sheet x (n, 3) moved as a rigid body, as far as supports let it, to lie nearest to `before` (n, 3) in the
    mean square. weight : (n,) of the nodes; others as in least_supports"""
    root = np.sqrt(weight)[:, None]
    for _ in range(ROUNDS):
        motions, free = free_motions(x, fixed, planes, clamped)
        if free.shape[1] == 0:
            break
        lanes = (root[:, :, None] * (motions @ free)).reshape(-1, free.shape[1])
        twist = free @ np.linalg.lstsq(lanes, (root * (before - x)).ravel(), rcond=None)[0]
        middle = x.mean(axis=0)
        size = np.abs(x - middle).max()
        # The screw of that twist: no support that leaves it free is moved, however far it goes.
        screw = np.zeros((4, 4))
        screw[:3, :3] = skew(twist[3:] / size)
        screw[:3, 3] = twist[:3]
        moved = expm(screw)
        x = middle + (x - middle) @ moved[:3, :3].T + moved[:3, 3]
        if np.abs(twist).max() < 1e-12 * size:
            break
    return x
