"""The truth about a file: how well its faces meet, and what in it is smaller than a sheet can follow."""

from typing import NamedTuple

import numpy as np

MEANT_SMOOTH = 0.01  # rad (0.57 deg): faces that meet at less were drawn to continue each other
KEPT_SMOOTH = 8.7e-4  # rad (0.05 deg): up to here contact takes them as one
NARROW = 1e-5  # of the part's diagonal: a face narrower than this is a sliver
MISSED = 1e-5  # mm: a user should know of forms that miss their faces by more
NARROW_FOR_SHEET = 0.01  # of the sheet thickness, where that is known


class Gaps(NamedTuple):
    """How well the file's own faces and edges meet, and what in it is very small [mm].

    edge          largest distance between an edge and the same edge as drawn on its faces
    vertex        the same at a vertex: from the ends of its edges, or their own gap if larger
    tolerance     largest tolerance the file (or its reader) grants an edge or vertex
    smooth_edges  number of edges whose faces continue each other, to less than 0.57 degrees
    jump          largest angle between normals across those [degrees]
    kinks         how many of those turn by more than 0.05 degrees: contact takes them as sharp
    slivers       faces narrower than 1e-5 of the part, or than a hundredth of the sheet
    concave_radius  smallest radius the tool is hollow with, inf for none
    form          largest distance between a face as drawn and the form it is met in: 0 but for swept and offset
                  surfaces and splines that are planes, cylinders, cones, spheres or tori
    thickness     of the sheet, or None
    """

    edge: float
    vertex: float
    tolerance: float
    smooth_edges: int
    jump: float
    kinks: int
    slivers: tuple
    concave_radius: float
    form: float
    thickness: float | None = None

    @property
    def too_tight(self):
        """Whether a concave radius is below half the sheet thickness, so that sheet touches on both sides of it."""
        return self.thickness is not None and self.concave_radius < 0.5 * self.thickness

    def remarks(self):
        """What a user should know, a short line each; an empty list where all is well."""
        found = []
        if max(self.edge, self.vertex) > 1e-3:
            found.append(f"faces meet only within {max(self.edge, self.vertex):.2g} mm")
        if self.form > MISSED:
            found.append(f"a face is met up to {self.form:.2g} mm from where it is drawn")
        if self.kinks:
            found.append(f"{self.kinks} edges drawn smooth turn by up to {self.jump:.2g} degrees: taken as sharp")
        if self.slivers:
            shown = ", ".join(map(str, self.slivers[:5])) + (", .." if len(self.slivers) > 5 else "")
            found.append(f"{len(self.slivers)} slivers (faces {shown})")
        if self.too_tight and self.thickness is not None:
            half = 0.5 * self.thickness
            found.append(f"concave radius {self.concave_radius:.3g} mm is below half the sheet, {half:.3g} mm")
        return found


def gaps_of(part, thickness=None):
    """Gaps of a part; thickness : mm of the sheet to be formed, or None."""
    skin = part.record["skin"]
    tolerances = np.append(skin["edge_tolerances"], skin["vertex_tolerances"])
    turns = skin["edge_turns"]
    smooth = turns[turns < MEANT_SMOOTH]  # nan is not
    diagonal = float(np.linalg.norm(np.ptp(part.bounding_box, axis=0)))
    narrow = NARROW * diagonal if thickness is None else NARROW_FOR_SHEET * thickness
    return Gaps(
        float(skin["edge_gaps"].max(initial=0.0)),
        float(skin["vertex_gaps"].max(initial=0.0)),
        float(tolerances.max(initial=0.0)),
        len(smooth),
        float(np.degrees(smooth.max(initial=0.0))),
        int((smooth > KEPT_SMOOTH).sum()),
        tuple(int(k) for k in np.flatnonzero(np.array(part.record["face_widths"]) < narrow)),
        float(part.smallest_concave_radius),
        max((face.gap for face in skin["faces"]), default=0.0),
        thickness,
    )
