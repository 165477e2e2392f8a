"""What stops a tool borne by springs from swinging on them, without resisting the movement the stage asks of it.

    M, K   mass and spring stiffness on the tool's free coordinates (contact/drive.py), with K phi = M phi omega^2
    v, s   rates of the coordinates, and what of them follows the stage
    p      rate at which the stage goes on [1/s]

Tools follow the stage: slowly, v would be p times a slope that changes little. The slope is the least squares' one of
the past that fades with beta omega, a/b with da/dt = beta omega (v p - a), db/dt = beta omega (p^2 - b), and s = p a/b.
In each mode the damper's force is -gamma omega (v - s): nothing however the stage speeds up and slows down, and all of
gamma omega v where it stands. At a steady p the mode's three roots, of x^3 + (beta + gamma) x^2 + x + beta in units
of omega, fall together at -1/sqrt(3), critical damping, for beta = 1/(3 sqrt 3) and gamma = 8/(3 sqrt 3).
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
    """Of one tool. inertia : (j, j) tonne"""

    def __init__(self, run, contact, inertia):
        square, phi = eigh(spring_stiffness(run, contact), inertia)
        self.omega, self.modes = np.sqrt(np.maximum(square, 0.0)), inertia @ phi
        self.a, self.b = np.zeros(len(square)), np.zeros(len(square))
        self.work = 0.0  # taken so far [mJ]

    def memory(self):
        """What it goes on with, (j, j + 4): modes, omega, a, b, and the work taken."""
        return np.column_stack([self.modes, self.omega, self.a, self.b, np.full(len(self.a), self.work)])

    def recall(self, memory):
        """Go on with what `memory` gave."""
        j = len(memory)
        self.modes, (self.omega, self.a, self.b, work) = memory[:, :j].copy(), memory[:, j:].T.copy()
        self.work = float(work[0])

    def force(self, rates, progress, dt):
        """On the coordinates (j,) [N] over a step of dt, that they enter with these rates. progress : of the stage"""
        v, fade = self.modes.T @ rates, BETA * dt * self.omega
        self.a += fade * (v * progress - self.a)
        self.b += fade * (progress * progress - self.b)
        follows = np.divide(progress * self.a, self.b, out=np.zeros_like(v), where=self.b > 0.0)
        force = -self.modes @ (GAMMA * self.omega * (v - follows))
        self.work -= dt * float(force @ rates)
        return force
