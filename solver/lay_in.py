"""A formed part laid into the next stage: lifted out of the fixed tools it no longer fits, for the press to close on.

A part that has sprung back is wider than its die. Laid in from outside, it comes to rest where it first touches, higher
than it lay before; the tools then push it home. It moves as a rigid body along the stage's stroke, so that nothing in
it changes.
"""

import numpy as np

from .errors import SceneError
from .motion import DEEP, arrow, closing_distance, way_of_tools

STEP = 0.5  # of the way out that is looked along, relative to the thickness


def lift_out(stage, points, half_thickness, held, touching=()):
    """Way (3,) [mm] that a part has to be lifted until it rests on the stage's fixed tools, and a line on it; zeros and
    "" where it cuts into none of them.

    points : (n, 3) nodes; half_thickness : (n,); held : (n, 3) bool, supports; touching : names of tools in contact
    Raises SceneError where it cannot be lifted.
    """
    fixed = [tool for tool in stage.tools if tool.stands_still]
    thickness = 2.0 * float(half_thickness.mean())
    overlap = {tool.name: overlap_of(tool, points, half_thickness) for tool in fixed}
    caught = [tool for tool in fixed if overlap[tool.name] > DEEP * thickness]
    if not caught:
        return np.zeros(3), ""
    deepest = max(caught, key=lambda tool: overlap[tool.name])
    what = (
        f"stage {stage.name!r}, tool {deepest.name!r}: overlaps the formed part by {overlap[deepest.name]:.3g} mm, and "
    )
    forward = way_in(stage, points, half_thickness)
    if forward is None:
        raise SceneError(f"{what}nothing presses the part into it, expected a travel, force, spring or gravity")
    if touching:
        raise SceneError(f"{what}tool {sorted(touching)[0]!r} still holds the part, expected a springback stage before")
    if held[:, np.abs(forward) > 1e-6].any():
        raise SceneError(f"{what}the blank's supports hold the part along {arrow(forward)}, the way it would be lifted")
    heights = {tool.name: height(tool, points, half_thickness, forward) for tool in caught}
    lift = max(heights.values())
    if lift < np.inf:
        name = in_the_way(fixed, points, half_thickness, -lift * forward)
    else:
        name = max(heights, key=heights.get)
    if name is not None:
        raise SceneError(
            f"{what}tool {name!r} is in the way of lifting it along {arrow(-forward)}, expected fixed tools on one "
            "side of it; let those on the other travel or press"
        )
    shift = -lift * forward
    return shift, (
        f"stage {stage.name!r}: the part overlapped {', '.join(tool.name for tool in caught)} by up to "
        f"{overlap[deepest.name]:.3g} mm and was lifted by {lift:.4g} mm along {arrow(-forward)}, to rest on it"
    )


def in_the_way(fixed, points, half_thickness, shift):
    """Name of a standing tool that a part would have to pass through when it is moved by `shift` (3,), or None."""
    thickness = 2.0 * float(half_thickness.mean())
    ways = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(shift) / (STEP * thickness)))
    for tool in fixed:
        deepest = max(overlap_of(tool, points + way * shift, half_thickness) for way in ways)
        if deepest > overlap_of(tool, points, half_thickness) + thickness:
            return tool.name
    return None


def way_in(stage, points, half_thickness):
    """Unit vector (3,) along which a stage pushes the sheet into its fixed tools; None where nothing pushes."""
    try:
        found = way_of_tools(stage, points, half_thickness)
    except SceneError as error:
        raise SceneError(f"stage {stage.name!r}, {error}") from None
    if found is None and stage.gravity is not None and np.any(stage.gravity):
        return np.asarray(stage.gravity, dtype=float) / np.linalg.norm(stage.gravity)
    return found


def overlap_of(tool, points, half_thickness):
    """How deep the sheet cuts into a tool at its place in the CAD file [mm], negative where it is clear."""
    return float(np.max(half_thickness - tool.surface.project(points).distance))


def height(tool, points, half_thickness, forward):
    """How far [mm] against `forward` the sheet first touches a standing tool on its way in from outside; inf where no
    way leads out."""
    distance = tool.surface.project(points).distance
    outside = 2.0 * (np.abs(distance).max() + np.ptp(points, axis=0).max())
    start = points - outside * forward
    if overlap_of(tool, start, half_thickness) > 0.0:
        return np.inf
    tolerance = 1e-9 * outside
    lowered = closing_distance(tool, start, half_thickness, -forward, tolerance)
    return np.inf if lowered is None else outside - lowered
