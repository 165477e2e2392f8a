"""Where tools stand: closing on the blank before a stage, and which way they press."""

import numpy as np

from .errors import SceneError

N_STEPS = 2000
DEEP = 0.1  # overlap with a tool that stands still, relative to the thickness, that is more than contact's own
SIDES = 1.0, -1.0
CLOSE = 0.01  # gap, relative to the thickness, that closes as on the tool's tangent plane


def closing_distance(tool, points, reach, direction, tolerance):
    """Distance [mm] a tool moves along a direction until it first touches the sheet; negative where it
    overlaps and has to draw back. None where it passes by.

    points : (n, 3) mid-surface nodes in the tool's frame; reach : (n,) half the thickness; direction : (3,) unit
    The gap is 1-Lipschitz, so moving by the smallest gap never jumps over the first touch.
    """
    hit = tool.surface.project(points)
    moved, close = 0.0, CLOSE * 2.0 * float(reach.mean())
    farthest = 2.0 * np.max(np.abs(hit.distance)) + 2.0 * np.ptp(points, axis=0).max()
    for _ in range(N_STEPS):
        gap = hit.distance - reach
        k = int(np.argmin(gap))
        if abs(gap[k]) <= tolerance:
            return moved
        # The gap closes at the rate of the normal along the direction: exact for a plane, cautious otherwise. Along a
        # wall it hardly closes, and steps as short as the gap would not get on.
        rate = abs(float(hit.normal[k] @ direction)) if gap[k] < close else 1.0
        moved += gap[k] / max(rate, 0.1)
        if abs(moved) > farthest:
            return None
        hit = tool.surface.project(points - moved * direction)
    return None


def side_of_blank(tool, points, half_thickness):
    """+1 where the tool presses on the blank when it moves along its axis, -1 where against it."""
    hit = tool.surface.project(points)
    k = int(np.argmin(hit.distance))
    facing = float(hit.normal[k] @ tool.unit_axis)
    if abs(facing) >= 0.1:
        return 1.0 if facing > 0.0 else -1.0
    # Beside a wall of a formed part: the way that leads to the part.
    tolerance = 1e-6 * np.ptp(points, axis=0).max()
    ways = {press: closing_distance(tool, points, half_thickness, press * tool.unit_axis, tolerance) for press in SIDES}
    found = [press for press, way in ways.items() if way is not None]
    if len(found) != 1:
        raise SceneError(
            f"tool {tool.name!r}: its axis {tuple(tool.axis)} runs along the blank where it is nearest; "
            "expected an axis that leads to the blank"
        )
    return found[0]


def press_of(tool, points, half_thickness):
    """Sign of a tool's axis along which it presses on the blank. points : (n, 3) beside the tool's place in its file"""
    return float(np.sign(tool.travel)) if tool.travel is not None else side_of_blank(tool, points, half_thickness)


def way_of_tools(stage, points, half_thickness):
    """Unit vector (3,) along which the stage's tools push the sheet into those that stand still: that of the first that
    travels, else of the first that presses; None where none does either."""
    movers = [tool for tool in stage.tools if tool.travels] or [t for t in stage.tools if not t.stands_still]
    return press_of(movers[0], points, half_thickness) * movers[0].unit_axis if movers else None


def place_tools(stage, points, half_thickness, touching=None):
    """Travel of every tool at the start of a stage and the side it presses from: {name: (travel, press)}.

    points : (n, 3) sheet nodes; half_thickness : (n,); touching : {name: travel} of tools that touch the sheet already
    A tool that travels, presses or keeps a gap is first closed until it touches the sheet; one that does, stays.
    Raises SceneError for a tool that never meets the blank or that overlaps it from the start.
    """
    touching = touching or {}
    try:
        travels = any(tool.travels for tool in stage.tools)
        forward = way_of_tools(stage, points, half_thickness) if travels else None
        return {
            tool.name: _place(tool, points, half_thickness, forward, touching.get(tool.name)) for tool in stage.tools
        }
    except SceneError as error:
        raise SceneError(f"stage {stage.name!r}, {error}") from None


def _place(tool, points, half_thickness, forward, travel):
    """Travel and side of one tool. forward : (3,) of the stage's stroke, or None; travel : of a tool that touches"""
    thickness = 2.0 * float(half_thickness.mean())
    tolerance = 1e-9 * max(thickness, np.ptp(points, axis=0).max())
    if tool.stands_still:
        _check_fixed(tool, points, half_thickness, forward, tolerance, thickness)
        return 0.0, 0.0
    if travel is not None and tool.gap is None:
        start = float(travel)
        here = points - start * tool.unit_axis
        press = press_of(tool, here, half_thickness) if tool.to is None else float(np.sign(tool.to - start))
    else:
        here = points - (travel or 0.0) * tool.unit_axis
        press = press_of(tool, here, half_thickness)
        start = _closed(tool, points, half_thickness, press, tolerance, thickness)
    if tool.to is not None and press * (tool.to - start) <= 0.0:
        raise SceneError(
            f"tool {tool.name!r} to: found {tool.to:g} mm, expected beyond {start:.4g} mm, where it touches the blank"
        )
    return start, press


def _closed(tool, points, half_thickness, press, tolerance, thickness):
    """Travel [mm] at which a tool touches the sheet first, or keeps its gap."""
    way = press * tool.unit_axis
    distance = closing_distance(tool, points, half_thickness, way, tolerance)
    if distance is None:
        raise SceneError(
            f"tool {tool.name!r}: moving along {arrow(way)} it never meets the blank, "
            f"which lies in {_box(points)}; expected the blank in its way"
        )
    if tool.gap is not None:
        distance -= tool.gap - thickness
    return press * distance


def _check_fixed(tool, points, half_thickness, forward, tolerance, thickness):
    hit = tool.surface.project(points)
    overlap = float(np.max(half_thickness - hit.distance))
    if overlap > DEEP * thickness:
        raise SceneError(
            f"tool {tool.name!r}: overlaps the blank by {overlap:.3g} mm, expected the blank on its surface"
        )
    if forward is not None and closing_distance(tool, points, half_thickness, -forward, tolerance) is None:
        raise SceneError(
            f"tool {tool.name!r}: the blank misses it: pushed along {arrow(forward)}, the blank in "
            f"{_box(points)} never meets it"
        )


def _box(points):
    low, high = points.min(axis=0), points.max(axis=0)
    return " x ".join(f"[{a:.4g}, {b:.4g}]" for a, b in zip(low, high, strict=True)) + " mm"


def arrow(direction):
    return "(" + ", ".join(f"{c + 0.0:g}" for c in direction) + ")"
