"""Where the tools' work goes: the sheet, friction, contact, torsion, motion; and what is left unaccounted for.

The marches count the work of each step; here it is summed. In the implicit one every term is a trapezium over the
increment. Internal energy is stress times strain in the material, the external one force times travel of the tools and
loads, so that their balance measures the increments' error.
"""

import numpy as np

from .contact.drive import carried

NAMES = ("external", "internal", "friction", "contact", "torsion", "kinetic", "damping")


class Energy:
    """Sums over the increments [mJ], of the modelled share; kinetic and damping are 0 in implicit stages."""

    def __init__(self):
        self.sums = dict.fromkeys(NAMES, 0.0)

    def add(self, work):
        """What one accepted increment or record adds: {name: mJ}"""
        for name, value in work.items():
            self.sums[name] += value

    def torsion_share(self):
        """Work the stabilisation has given or taken, relative to the external work so far."""
        return abs(self.sums["torsion"]) / max(abs(self.sums["external"]), 1e-300)

    def kinetic_share(self):
        """Kinetic relative to internal energy."""
        return self.sums["kinetic"] / max(abs(self.sums["internal"]), 1e-300)

    def totals(self, share):
        """{name: mJ of the whole part}, with the imbalance external - all others."""
        totals = {name: value / share for name, value in self.sums.items()}
        totals["imbalance"] = totals["external"] - sum(totals[n] for n in NAMES[1:])
        return totals


def work_of(sheet, old, new, tools):
    """Work in one accepted increment, {name: mJ}. tools : ToolRuns"""
    a, b = old.sheet, new.sheet
    work = dict.fromkeys(NAMES, 0.0)
    volume = sheet.elements.point_volume
    work["torsion"] = sheet.elements.stabilisation_work(a, b)
    work["internal"] = 0.5 * float(np.sum(volume[:, None] * (a.stress + b.stress) * (b.strain - a.strain)))
    moved = b.x - a.x
    sheet_work = 0.0
    for run in tools:
        before, after = old.tools[run.tool.name], new.tools[run.tool.name]
        shift = carried(run, before, after, a.x)[0] - a.x
        slid = moved - shift
        feet = (*before.feet, *after.feet)
        friction = 0.5 * float(np.sum(sum(foot.friction_force for foot in feet) * slid))
        normal = 0.5 * float(np.sum(sum(foot.normal_force[:, None] * foot.normal for foot in feet) * slid))
        tool = 0.5 * float(np.sum((before.push + after.push) * shift))
        work["friction"] -= friction
        work["contact"] -= normal
        work["external"] += tool
        sheet_work += friction + normal + tool
    # Supports and loads do the rest of the work on the nodes.
    work["external"] += 0.5 * float(np.sum((a.internal + b.internal) * (b.u - a.u))) - sheet_work
    return work
