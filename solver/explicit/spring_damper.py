"""What stops a tool borne by springs from swinging on them, without resisting a steady movement.

    M, K   mass and spring stiffness on the tool's free coordinates (contact/drive.py), with K phi = M phi omega^2
    v, s   rates of the coordinates, and their slowly following mean

In each mode the force is -gamma omega (v - s) with ds/dt = beta omega (v - s): it tells a swing from a movement, and at
a steady v it fades. The mode's three roots, of p^3 + (beta + gamma) p^2 + p + beta with p in units of omega, fall
together at -1/sqrt(3), critical damping, for beta = 1/(3 sqrt 3) and gamma = 8/(3 sqrt 3).
"""

from math import sqrt

import numpy as np
from scipy.linalg import eigh

from ..contact.drive import spins, turn

BETA, GAMMA = 1.0 / (3.0 * sqrt(3.0)), 8.0 / (3.0 * sqrt(3.0))


def spring_stiffness(run, contact):
    """Stiffness (j, j) [N/mm] of a tool's springs on its free coordinates."""
    drive, axis = run.drive, run.axis
    if run.pivot is None:
        return np.array([[drive.stiffness]])
    omega, _ = spins(run, contact)
    pins = drive.pins @ turn(contact.tilt).T
    along = np.cross(omega[:, None, :], pins[None]) @ axis
    along[0] = 1.0
    return drive.stiffness / len(pins) * along @ along.T


class SpringDamper:
    """Of one tool. inertia : (j, j) tonne; rates : (j,) mm/s at the start"""

    def __init__(self, run, contact, inertia, rates):
        square, phi = eigh(spring_stiffness(run, contact), inertia)
        omega, pull = np.sqrt(np.maximum(square, 0.0)), inertia @ phi
        self.strength = GAMMA * pull * omega @ pull.T
        self.follow = BETA * phi * omega @ pull.T
        self.mean = rates.copy()
        self.work = 0.0  # taken so far [mJ]

    def force(self, rates, dt):
        """On the coordinates (j,) [N] over a step of dt, that they enter with these rates."""
        swing = rates - self.mean
        self.mean += dt * self.follow @ swing
        force = -self.strength @ swing
        self.work -= dt * float(force @ rates)
        return force
