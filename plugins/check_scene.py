"""Checks a scene as far as that goes without forming: file, keys, CAD, mesh, and where the tools start."""

from .scene_file import SceneFile, SceneFileError


def check_scene(path):
    """{"scene", "name", "nodes", "triangles", "plan", "starts": [lines], "tool_starts": {tool: mm}}.

    Raises SceneFileError with a line for each mistake.
    """
    from solver import SceneError
    from solver.motion import place_tools

    scene_file = SceneFile.read(path)
    scene = scene_file.build()
    mesh, half = scene.blank.mesh, 0.5 * scene.blank.thickness
    try:
        plan = scene.plan()
        placed = place_tools(scene.stages[0], mesh.points, _each(mesh.points, half))
    except SceneError as error:
        raise SceneFileError(f"{scene_file.path}: {error}") from error
    travels = {name: float(travel) for name, (travel, _) in placed.items()}
    return {
        "scene": str(scene_file.path),
        "name": scene.name,
        "nodes": len(mesh.points),
        "triangles": len(mesh.cells),
        "plan": str(plan),
        "tool_starts": travels,
        "starts": ["Starts:"]
        + [f"  {name}: {travel + 0.0:.4g} mm from its place in the CAD file" for name, travel in travels.items()],
    }


def _each(points, value):
    import numpy as np

    return np.full(len(points), value)
