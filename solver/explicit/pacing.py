"""How long a stage lasts, and how its tools speed up and slow down.

Quasi-static forming has a stroke, not a time. With c_T = sqrt(s_y/rho) the speed of a transverse wave in the sheet
stretched at its yield stress, and L the largest distance it has to go, a stage lasts `waves` L/c_T. The tools' speed v
then obeys rho v^2/2 = s_y (stroke/L)^2 / (2 waves^2): kinetic energy is a share 1/waves^2 or so of the plastic work
s_y (stroke/L)^2, whatever the density. A density other than the sheet's would change nothing but the unit of time,
so there is no uniform mass scaling: both are the same knob.
"""

from dataclasses import dataclass
from math import cos, pi, sin, sqrt

from ..pace import reach

PREPARATION = 0.25  # of a stage's time: loads of the last stage fade, tools that press come to bear


@dataclass(frozen=True)
class Pacing:
    """duration : of the stage; ramp : part of it to speed up, and to slow down; preparation : before it [s]"""

    duration: float
    ramp: float
    preparation: float

    def fraction(self, time):
        """Fraction of the stroke at a time of the stage, 0 before 0 and 1 at the end."""
        s, r = min(max(time / self.duration, 0.0), 1.0), self.ramp
        if s > 0.5:
            return 1.0 - self.fraction(self.duration * (1.0 - s)) if s < 1.0 else 1.0
        top = 1.0 / (1.0 - r)
        if s >= r:
            return top * (s - 0.5 * r)
        return 0.5 * top * (s - r / pi * sin(pi * s / r))

    def time(self, fraction):
        """Time at which a fraction of the stroke is reached; bisection to round-off."""
        if fraction <= 0.0:
            return self.preparation * fraction
        if fraction >= 1.0:
            return self.duration
        low, high = 0.0, self.duration
        while True:
            middle = 0.5 * (low + high)
            if middle in (low, high):
                return high
            low, high = (middle, high) if self.fraction(middle) < fraction else (low, middle)

    def readiness(self, time):
        """How far the preparation has gone, 0 at its start and 1 from the stage's start on."""
        if time >= 0.0 or self.preparation == 0.0:
            return 1.0
        return 0.5 * (1.0 - cos(pi * (1.0 + time / self.preparation)))


def wave_time(sheet, density):
    """Time in which a transverse wave at the yield stress goes from the blank's middle to its farthest side [s]."""
    return reach(sheet) / sqrt(sheet.blank.material.initial_yield_stress / density)


def pace(sheet, method):
    """Pacing of a stage."""
    duration = method.waves * wave_time(sheet, sheet.blank.material.density)
    return Pacing(duration, method.ramp, PREPARATION * duration)
