"""Dynamic relaxation: a stage in which nothing travels is brought to rest by damping its slowest movement critically.

    d    movement of the unknowns over some steps;  g  change of the force that resists it, internal less contact
    M    lumped masses;  r  forces out of balance (n + k, 3)

The Rayleigh quotient omega^2 = d.g / d.M d is the square of the frequency with which the sheet would swing along d;
c = 2 omega damps that swing critically (Underwood 1983, with differences of the true forces in place of a diagonal
stiffness). Faster modes fade sooner, so that d and omega tend to the slowest mode that takes part: damped too much it
creeps and lowers omega, too little it swings and raises it. The steps compared span a share of 1/omega.

At rest, what is out of balance would move the sheet by no more than a share of the way the stage has moved it, in the
slowest mode, and its kinetic energy would carry it no further:

    |M^-1/2 r| <= REST omega^2 |M^1/2 (u - u_0)|,   2 T <= (REST omega |M^1/2 (u - u_0)|)^2
"""

from math import pi, sqrt

import numpy as np

REST = 1e-3  # way still to go, relative to the way of the stage
STILL = 1e-2  # least way that counts as one, relative to the thickness
SHORT = 20  # steps of the first comparison
SPAN = 0.5  # of 1/omega, that later ones span; they lengthen by no more than a factor of two
LONGEST = 100.0  # swings of the sheet as a cantilever, and stages, after which it will not come to rest
ROUNDING = 10.0  # of a place, that what is out of balance may be though nothing is
FADED = 9.23  # omega t after which critical damping has left REST of a swing


class Relaxation:
    """Damping of one stage of a sheet, and whether it has come to rest.

    mass : (n + k,) tonne; fixed : (n + k, 3) bool; u : (n + k, 3) at the stage's start; dt : step, duration : of a
    stage [s]
    """

    def __init__(self, sheet, mass, fixed, u, dt, duration):
        self.mass, self.free, self.start = mass[:, None], ~fixed, u.copy()
        material, t = sheet.blank.material, sheet.blank.thickness
        self.least = STILL * t * sqrt(float(mass[: len(sheet.points)].sum()))
        self.omega = self.damping = 0.0
        self.u, self.g = u.copy(), None
        self.span = self.due = SHORT * dt
        self.elapsed, self.rested = 0.0, 0
        # A cantilever of the sheet's extent L swings with omega = 3.516 t/L^2 sqrt(E/(12 rho)).
        extent = float(np.ptp(sheet.points, axis=0).max())
        swing = 2.0 * pi * extent**2 / (3.516 * t) * sqrt(12.0 * material.density / material.young)
        self.patience = LONGEST * max(swing, duration)
        # Of places, which are of the size of the extent, in the forces of a step that the sheet just bears.
        self.rounding = ROUNDING * np.finfo(float).eps * extent * (2.0 / dt) ** 2 * sqrt(float(mass.sum()))
        # A slower swing could not fade in that time. A sheet that slides freely has none, and its drift fades as one.
        self.slowest = FADED / self.patience
        self.residual, self.kinetic = np.inf, np.inf  # as ways still to go, over the stage's

    def memory(self):
        """What it goes on with, {name: array}: numbers, places at the stage's start and at the last comparison, and the
        forces there."""
        numbers = self.omega, self.damping, self.span, self.due, self.elapsed, self.rested, self.residual, self.kinetic
        found = {"relaxation": np.array(numbers), "relaxation start": self.start, "relaxation u": self.u.copy()}
        return found if self.g is None else found | {"relaxation g": self.g}

    def recall(self, memory):
        """Go on with what `memory` gave."""
        self.omega, self.damping, self.span, self.due, self.elapsed, rested, self.residual, self.kinetic = memory[
            "relaxation"
        ].tolist()
        self.rested = int(rested)
        self.start, self.u, self.g = memory["relaxation start"], memory["relaxation u"], memory.get("relaxation g")

    def watch(self, u, v, v_before, external, dt, dtm, others):
        """Look at a step from u (n + k, 3), once a comparison is due; True where one was made.

        v, v_before : after and before it; external : loads; others : kinetic energy of the tools [mJ]
        """
        self.elapsed += dt
        if self.elapsed < self.due:
            return False
        mean = 0.5 * (v + v_before)
        out = np.where(self.free, self.mass * ((v - v_before) / dtm + self.damping * mean), 0.0)
        g = external - out
        if self.g is not None:
            d = np.where(self.free, u - self.u, 0.0)
            weight = float(np.sum(self.mass * d * d))
            if weight > 0.0:
                self.omega = sqrt(max(float(np.sum(d * (g - self.g))) / weight, self.slowest**2))
            self.damping = min(2.0 * self.omega, 1.0 / dt)
        self.u[:], self.g = u, g
        self.span = min(2.0 * self.span, max(SPAN / self.omega, SHORT * dt)) if self.omega > 0.0 else self.span
        self.due = self.elapsed + self.span
        way = sqrt(float(np.sum(self.mass * np.where(self.free, u - self.start, 0.0) ** 2)))
        way = max(way, self.least)
        kinetic = 0.5 * float(np.sum(self.mass * np.where(self.free, mean, 0.0) ** 2)) + others
        reach = max(self.omega, 1e-300) * way
        unrounded = max(sqrt(float(np.sum(out**2 / self.mass))) - self.rounding, 0.0)
        self.residual = unrounded / max(self.omega * reach, 1e-300)
        self.kinetic = sqrt(2.0 * kinetic) / reach
        self.rested = self.rested + 1 if max(self.residual, self.kinetic) <= REST else 0
        return True

    @property
    def at_rest(self):
        """Whether what is left to do is negligible, twice running."""
        return self.rested >= 2

    def note(self, stage, steps, taken):
        """How it went. steps : it took; taken : work of damping, of the whole part [mJ]"""
        return (
            f"stage {stage.name!r}: at rest after {steps} steps of dynamic relaxation, damping took {taken:.3g} mJ; "
            f"forces out of balance would move it {100.0 * self.residual:.2g} % further, its velocity "
            f"{100.0 * self.kinetic:.2g} %"
        )
