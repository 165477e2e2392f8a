"""Checks a scene as far as that goes without forming: file, keys, CAD, mesh, and where the tools start."""

import numpy as np

from .scene_file import SceneFile, SceneFileError


def check_scene(path):
    """{"scene", "name", "nodes", "triangles", "plan", "starts": {tool: mm}} of a scene file.

    Raises SceneFileError with a line for each mistake.
    """
    scene_file = SceneFile.read(path)
    scene = scene_file.build()
    return {
        "scene": str(scene_file.path),
        "name": scene.name,
        "nodes": len(scene.blank.mesh.points),
        "triangles": len(scene.blank.mesh.cells),
        "plan": str(scene.plan(scene_file.method)),
        "starts": tool_starts(scene_file, scene),
    }


def tool_starts(scene_file, scene):
    """{tool of the first stage: mm it moves along its axis until it touches the blank}.

    Raises SceneFileError for a tool that never meets the blank, or overlaps it.
    """
    from solver import SceneError
    from solver.motion import place_tools

    points = scene.blank.mesh.points
    try:
        placed = place_tools(scene.stages[0], points, np.full(len(points), 0.5 * scene.blank.thickness))
    except SceneError as error:
        raise SceneFileError(f"{scene_file.path}: {error}") from error
    return {name: float(travel) + 0.0 for name, (travel, _) in placed.items()}
