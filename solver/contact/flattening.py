"""Metal between two tools flows across its thickness before it bears more than its flow stress (theory.md 6).

Elements know a sheet's thickness from its strains in the plane only. Rigid tools rest on its thickest node, with a
pressure that no metal has. So a pinched node bears F and hardly more (normal_law.py); what it gives way beyond that is
added to `flattened`, and contact takes the sheet to be that much thinner there. Where the metal goes to, sideways,
elements are not told: it is little.
"""

import numpy as np

from ..elements.assembly import gather_thickness
from .normal_law import Flow, trial_of

FLAT = 1.0 / 3.0  # of the thickness, by which tools press no sheet that is drawn


def flow_of(sheet, state, half_thickness):
    """Flow of all nodes, as if two tools touched them. state : SheetState; half_thickness : (n,) that contact sees
    [mm]"""
    equivalent = np.empty(len(half_thickness))
    layers = state.equivalent.reshape(len(sheet.triangles.cells), -1)
    gather_thickness(layers @ sheet.elements.weight, sheet.triangles.area, *sheet.corners, equivalent)
    thickness = 2.0 * half_thickness + state.flattened
    equivalent += state.flattened / thickness
    area = sheet.area * sheet.blank.thickness / thickness  # the elements' volume is constant
    return Flow(equivalent, thickness, area, *sheet.flow_pressure)


def give_way(contacts, flow, stiffness, skin):
    """What nodes give way for good in an increment (n,) [mm], and the skins' retreat in the contacts' gaps.

    contacts : ContactStates of all tools; flow : Flow; stiffness (n,) [N/mm], skin [mm] : of the contact law
    """
    feet, force = [foot for contact in contacts for foot in contact.feet], flow.force
    added = np.zeros(len(force))
    for foot in feet:
        flows = foot.normal_force > force
        k, trial = stiffness[flows], foot.multiplier[flows] - stiffness[flows] * foot.gap[flows]
        added[flows] += (trial - trial_of(foot.normal_force[flows], k * skin)) / k
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
