"""The time a stage lasts, in which both solvers count inertia: crossings of the blank by a transverse wave.

Quasi-static forming has a stroke, not a time. In the sheet stretched at its yield stress a transverse wave runs at
c = sqrt(s_y/rho); how often it crosses the blank in a stage says how fast the stage is, whatever the density.
"""

from .scene import AXES


def reach(sheet):
    """Way from the blank's middle to its farthest side [mm]."""
    planes = sheet.blank.symmetry_planes
    extent = sheet.points.max(axis=0) - sheet.points.min(axis=0)
    return float(max(extent[axis] * (1.0 if AXES[axis] in planes else 0.5) for axis in range(3)))
