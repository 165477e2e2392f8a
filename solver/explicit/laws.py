"""What a wall does to a node that overlaps it, three ways: kinematic, touch and penalty (theory.md 10).

Symbols, along the wall's normal: d gap after the predicted step (penalty: before it), vn the gap's velocity as
predicted, `before` that of half a step ago. An answer is what velocity and place along the normal have to gain.
"""

from math import sqrt

from numba import njit

from ..contact.friction import coefficient, law_at
from .method import Kinematic, Penalty, Touch

KINEMATIC, TOUCH, PENALTY = 0, 1, 2
BY_PATH = -1.0  # energy lost in contact is the force's work along the node's path
GRIP = 0.1  # part of the normal that has to lie along free directions


def law_of(contact, dt):
    """Number of a law and its parameter. dt : stable step at the stage's start [s]"""
    if isinstance(contact, Penalty):
        return PENALTY, contact.stiffness / dt**2
    if isinstance(contact, Touch):
        return TOUCH, float(contact.restitution)
    assert isinstance(contact, Kinematic)
    return KINEMATIC, 0.0


@njit(forceinline=True)
def bounce(gap, approach, pull, dt, restitution):
    """A step divided at the instant of first touch.

    gap : at the step's start; approach : velocity of the gap then; pull : its acceleration, constant
    returns : gap at the end, velocity of the gap as `predict` goes on from it, velocity squared that the bounce took.
    A node that comes to rest on the tool within the step stays there.
    """
    # First root of gap + approach tau + pull tau^2 / 2; a node already overlapping touches at once.
    tau = 0.0
    if gap > 0.0:
        # gap at the end is negative, so there is one root within the step
        root = sqrt(max(approach * approach - 2.0 * pull * gap, 0.0))
        tau = min(max(2.0 * gap / (root - approach), 0.0), dt) if root > approach else dt
    left = dt - tau
    impact = min(approach + pull * tau, 0.0)
    back = -restitution * impact
    end = back * left + 0.5 * pull * left * left
    if end <= 0.0:
        return 0.0, -gap / dt, BY_PATH
    return end, back + pull * left - 0.5 * pull * dt, impact * impact - back * back


@njit(forceinline=True)
def answer(law, parameter, d, vn, before, dt, dtm):
    """Velocity and place that an overlapping node gains along the normal; velocity squared that a bounce took, or
    BY_PATH. parameter : restitution of a touch; stiffness of a penalty over the node's mass [1/s^2]"""
    if law == KINEMATIC:
        return -d / dt, -d, BY_PATH
    if law == PENALTY:
        gain = -d * parameter * dtm
        return gain, dt * gain, BY_PATH
    pull = (vn - before) / dtm
    end, after, taken = bounce(d - dt * vn, vn - 0.5 * dt * pull, pull, dt, parameter)
    return after - vn, end - d, taken


@njit(forceinline=True)
def velocity_at(w, x):
    """Velocity (3) of a tool at a point x (3,). w : (3, 3) velocity of its pivot, spin [rad/s], the pivot's place"""
    r1, r2, r3 = x[0] - w[2, 0], x[1] - w[2, 1], x[2] - w[2, 2]
    return (
        w[0, 0] + w[1, 1] * r3 - w[1, 2] * r2,
        w[0, 1] + w[1, 2] * r1 - w[1, 0] * r3,
        w[0, 2] + w[1, 0] * r2 - w[1, 1] * r1,
    )


@njit(forceinline=True)
def grip_of(mu, laws, face, node, force, speed):
    """Coefficient of friction. mu : where a number says it all; laws : Laws in its place, or None; force : normal one
    [N]; speed : the sliding one [mm/s], before friction"""
    if laws is None:
        return mu
    row = laws.rows[law_at(laws.law_of_face, face)]
    return coefficient(row, max(force, 0.0) / laws.area[node], speed / laws.lapse[0])[0]
