"""Where the tools' work goes: the sheet, friction, contact, torsion; and what is left unaccounted for.

Every term is a trapezium over the increment. Internal energy is stress times strain in the material, the external
one force times travel of the tools and loads, so that their balance measures the increments' error.
"""

import numpy as np


class Energy:
    """Sums over the increments [mJ], of the modelled share."""

    names = ("external", "internal", "friction", "contact", "torsion")

    def __init__(self, sheet):
        self.sheet = sheet
        self.sums = dict.fromkeys(self.names, 0.0)

    def add(self, old, new, tools, torsion):
        """One accepted increment; torsion : work of the stabilisation [mJ]."""
        self.sums["torsion"] += torsion
        a, b = old.sheet, new.sheet
        volume = self.sheet.elements.point_volume
        self.sums["internal"] += 0.5 * float(np.sum(volume[:, None] * (a.stress + b.stress) * (b.strain - a.strain)))
        moved = b.x - a.x
        sheet_work = 0.0
        for run in tools:
            before, after = old.tools[run.tool.name], new.tools[run.tool.name]
            shift = (after.travel - before.travel) * run.axis
            slid = moved - shift
            feet = (*before.feet, *after.feet)
            friction = 0.5 * float(np.sum(sum(foot.friction_force for foot in feet) * slid))
            normal = 0.5 * float(np.sum(sum(foot.normal_force[:, None] * foot.normal for foot in feet) * slid))
            tool = -0.5 * float((before.force + after.force) @ shift)
            self.sums["friction"] -= friction
            self.sums["contact"] -= normal
            self.sums["external"] += tool
            sheet_work += friction + normal + tool
        # Supports and loads do the rest of the work on the nodes.
        self.sums["external"] += 0.5 * float(np.sum((a.internal + b.internal) * (b.u - a.u))) - sheet_work

    def torsion_share(self):
        """Work the stabilisation has given or taken, relative to the external work so far."""
        return abs(self.sums["torsion"]) / max(abs(self.sums["external"]), 1e-300)

    def totals(self, share):
        """{name: mJ of the whole part}, with the imbalance external - all others."""
        totals = {name: value / share for name, value in self.sums.items()}
        totals["imbalance"] = totals["external"] - sum(totals[n] for n in self.names[1:])
        return totals
