"""How exact contact was: the error of the feet, and where a foot is not plain.

    x, q   node and foot;  n, d  normal and signed distance as the surface tells them

On exact faces x - q = d n to round-off. What facets miss shows as the part of x - q across n: with interpolated normals
they push where the foot is not.
"""

import numpy as np

SHARP = 1e9  # 1/mm: a larger curvature is an edge's


class ContactBudget:
    """The worst of what frames have shown, over all tools.

    foot_error : mm, largest of |x - q - d n| at touching nodes
    sharp_nodes : most nodes at once that touched an edge or vertex of a tool
    several_feet : most nodes at once that touched one tool in several places; 0 where no tool has a corner so tight
    """

    def __init__(self):
        self.foot_error, self.sharp_nodes, self.several_feet = 0.0, 0, 0

    def add(self, stage_hits):
        """One frame. stage_hits : [(points (n, 3) in the tool's frame, their Projection, ContactState)] of its tools"""
        sharp = several = 0
        for points, hit, contact in stage_hits:
            on = contact.touching
            miss = points - hit.point - hit.distance[:, None] * hit.normal
            self.foot_error = max(self.foot_error, float(np.linalg.norm(miss[on], axis=1).max(initial=0.0)))
            sharp += int((np.abs(hit.curvature[on]).max(axis=1) > SHARP).sum()) if on.any() else 0
            several += int((np.sum([foot.status != 0 for foot in contact.feet], axis=0) > 1).sum())
        self.sharp_nodes, self.several_feet = max(self.sharp_nodes, sharp), max(self.several_feet, several)

    def figures(self):
        """{name: number}."""
        return dict(vars(self))
