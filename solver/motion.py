"""Where tools stand: closing on the blank before a stage, and their travel during it."""

import numpy as np

from .errors import SceneError

N_STEPS = 500


def closing_distance(tool, points, reach, direction, tolerance):
    """Distance [mm] a tool moves along a direction until it first touches the sheet; negative where it
    overlaps and has to draw back. None where it passes by.

    points : (n, 3) mid-surface nodes in the tool's frame; reach : (n,) half the thickness; direction : (3,) unit
    The gap is 1-Lipschitz, so moving by the smallest gap never jumps over the first touch.
    """
    hit = tool.surface.project(points)
    moved = 0.0
    near = np.arange(len(points))
    farthest = 2.0 * np.max(np.abs(hit.distance)) + 2.0 * np.ptp(points, axis=0).max()
    for _ in range(N_STEPS):
        gap = hit.distance - reach[near]
        k = int(np.argmin(gap))
        if abs(gap[k]) <= tolerance:
            return moved
        # The gap closes at the rate of the normal along the direction: exact for a plane, cautious otherwise.
        rate = abs(float(hit.normal[k] @ direction)) if gap[k] < 0.0 else 1.0
        moved += gap[k] / max(rate, 0.1)
        if abs(moved) > farthest:
            return None
        hit = tool.surface.project(points[near] - moved * direction)
    return None


def side_of_blank(tool, points):
    """+1 where the tool presses on the blank when it moves along its axis, -1 where against it."""
    hit = tool.surface.project(points)
    k = int(np.argmin(hit.distance))
    facing = float(hit.normal[k] @ tool.unit_axis)
    if abs(facing) < 0.1:
        raise SceneError(
            f"tool {tool.name!r}: its axis {tuple(tool.axis)} runs along the blank where it is nearest; "
            "expected an axis that leads to the blank"
        )
    return 1.0 if facing > 0.0 else -1.0


def place_tools(stage, points, half_thickness, touching=None):
    """Travel of every tool at the start of a stage and the side it presses from: {name: (travel, press)}.

    points : (n, 3) sheet nodes; half_thickness : (n,); touching : {name: travel} of tools that touch the sheet already
    A tool that travels, presses or keeps a gap is first closed until it touches the sheet; one that does, stays.
    Raises SceneError for a tool that never meets the blank or that overlaps it from the start.
    """
    thickness = 2.0 * float(half_thickness.mean())
    tolerance = 1e-9 * max(thickness, np.ptp(points, axis=0).max())
    travelling = [t for t in stage.tools if t.travel is not None]
    forward = np.sign(travelling[0].travel) * travelling[0].unit_axis if travelling else None
    touching = touching or {}
    placed = {}
    for tool in stage.tools:
        axis = tool.unit_axis
        if tool.travel is None and tool.gap is None and not tool.gives_way:
            _check_fixed(tool, points, half_thickness, forward, tolerance, thickness)
            placed[tool.name] = (0.0, 0.0)
            continue
        here = points - touching.get(tool.name, 0.0) * axis
        press = float(np.sign(tool.travel)) if tool.travel is not None else side_of_blank(tool, here)
        if tool.name in touching and tool.gap is None:
            placed[tool.name] = (float(touching[tool.name]), press)
            continue
        distance = closing_distance(tool, points, half_thickness, press * axis, tolerance)
        if distance is None:
            raise SceneError(
                f"tool {tool.name!r}: moving along {_arrow(press * axis)} it never meets the blank, "
                f"which lies in {_box(points)}; expected the blank in its way"
            )
        if tool.gap is not None:
            distance -= tool.gap - thickness
        placed[tool.name] = (press * distance, press)
    return placed


def _check_fixed(tool, points, half_thickness, forward, tolerance, thickness):
    hit = tool.surface.project(points)
    overlap = float(np.max(half_thickness - hit.distance))
    if overlap > 0.1 * thickness:
        raise SceneError(
            f"tool {tool.name!r}: overlaps the blank by {overlap:.3g} mm, expected the blank on its surface"
        )
    if forward is not None and closing_distance(tool, points, half_thickness, -forward, tolerance) is None:
        raise SceneError(
            f"tool {tool.name!r}: the blank misses it: pushed along {_arrow(forward)}, the blank in "
            f"{_box(points)} never meets it"
        )


def _box(points):
    low, high = points.min(axis=0), points.max(axis=0)
    return " x ".join(f"[{a:.4g}, {b:.4g}]" for a, b in zip(low, high, strict=True)) + " mm"


def _arrow(direction):
    return "(" + ", ".join(f"{c + 0.0:g}" for c in direction) + ")"
