"""Metal between two tools flows across its thickness before it bears more than its flow stress (theory.md 6).

Symbols, at a node: N force that presses it from both sides, A its area now, p the sheet's flow pressure
(materials/through_thickness.py), F = p A; s how much thinner the tools have pressed the sheet for good [mm].

Elements know a sheet's thickness from its strains in the plane only. Rigid tools rest on its thickest node, with a
pressure that no metal has. So a pinched node bears F and hardly more; what it gives way beyond that is added to s, and
contact takes the sheet to be s thinner there. Where the metal goes to, sideways, elements are not told: s is small.
"""

import numpy as np

from ..elements.assembly import gather_thickness
from .node_on_tool import EASE, trial_of

FLAT = 1.0 / 3.0  # of the thickness, by which tools press no sheet that is drawn


def flow_forces(sheet, state, half_thickness):
    """F (n,) [N]. state : SheetState; half_thickness : (n,) that contact sees [mm]

    What a node was pressed thinner hardens it by the strain s/t, as it does von Mises' metal.
    """
    equivalent = np.empty(len(half_thickness))
    layers = state.equivalent.reshape(len(sheet.triangles.cells), -1)
    gather_thickness(layers @ sheet.elements.weight, sheet.triangles.area, *sheet.corners, equivalent)
    thickness = 2.0 * half_thickness + state.flattened
    equivalent += state.flattened / thickness
    area = sheet.area * sheet.blank.thickness / thickness  # the elements' volume is constant
    return np.interp(equivalent, *sheet.flow_pressure) * area


def give_way(contacts, force, stiffness, skin):
    """s (n,) [mm] that an increment adds, and the skins' retreat in the contacts' gaps.

    contacts : ContactStates of all tools; force : F (n,) [N]; stiffness (n,) [N/mm], skin [mm] : of the contact law
    """
    feet, added = [foot for contact in contacts for foot in contact.feet], np.zeros(len(force))
    for foot in feet:
        flows = foot.normal_force > force
        borne, limit, k = foot.normal_force[flows], force[flows], stiffness[flows]
        without = limit + (borne - limit) / EASE  # what the same overlap would take without flow
        added[flows] += (trial_of(without, k * skin) - trial_of(borne, k * skin)) / k
    for foot in feet:
        foot.gap += 0.5 * added
    return added


def pressed_flat(sheet, state):
    """What is wrong where tools press the sheet so hard that it flows out between them, "" where they do not.

    state : State
    """
    squeeze = state.squeeze
    node = int(np.argmax(squeeze))
    if squeeze[node] <= FLAT * sheet.blank.thickness:
        return ""
    place = ", ".join(f"{x:.1f}" for x in state.sheet.x[node])
    return f"tools press the sheet flat, {squeeze[node]:.2g} mm of {sheet.blank.thickness:g} mm near ({place}) mm"
