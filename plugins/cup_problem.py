"""The square cup as a problem of convergence: its scene on any mesh, and how far two runs of it are apart.

Compared are draw-ins, the curves of punch and blank-holder force, and the thickness at material points: each
relative to the finer run.
"""

from pathlib import Path

import numpy as np

CUP = Path(__file__).resolve().parents[1] / "examples" / "square_cup"
DRAW_INS = ("draw_in_DX", "draw_in_DD")
WINDOW = 1.0  # mm of stroke over which forces are averaged: nodes that run over a die radius make them ripple
SAMPLES = 20  # of a curve in a window
GRID = 2.5  # mm between material points


def cup_scene(material, size, travel):
    """A quarter of the square cup from its scene file, and {draw-in: measured at that depth}.

    material : "aluminium" or "steel"; size : of the mesh [mm]; travel : of the punch [mm]
    """
    from .scene_file import SceneFile

    path = CUP / f"{material}.toml"
    file = SceneFile.read(path)
    blank = file.keys.blank.model_copy(update={"size": size})
    punch = file.keys.tools["PUNCH"].model_copy(update={"travel": -travel})
    keys = file.keys.model_copy(update={"blank": blank, "tools": file.keys.tools | {"PUNCH": punch}})
    measured = {row.quantity: row.measured for row in file.keys.compare.rows if row.stroke == travel}
    return SceneFile(path, keys).build(), {name: measured[name] for name in DRAW_INS if name in measured}


def differences(scene, results, finer_scene, finer):
    """{draw_in_error, force_error, holder_error, thickness_error} of a run against a finer one.

    Forces: largest difference of the curves over the largest force. Thickness: relative, of 99 in 100 points.
    """
    stroke = finer.history["stroke"][-1]
    draw_in = [abs(results.at(name, stroke) / finer.at(name, stroke) - 1.0) for name in DRAW_INS]
    here, there = thickness_map(scene, results), thickness_map(finer_scene, finer)
    return {
        "draw_in_error": max(draw_in),
        "force_error": curve_error(results, finer, "force_PUNCH"),
        "holder_error": curve_error(results, finer, "force_BLANK_HOLDER"),
        "thickness_error": float(np.quantile(np.abs(here / there - 1.0), 0.99)),
    }


def curve_error(results, finer, column):
    """Largest difference of two curves of the history over the stroke, averaged over WINDOW, over the largest value."""
    stroke = np.arange(0.0, finer.history["stroke"][-1], WINDOW / SAMPLES)
    mean = np.full(SAMPLES, 1.0 / SAMPLES)
    here, there = (np.convolve([run.at(column, s) for s in stroke], mean, mode="valid") for run in (results, finer))
    return float(np.abs(here - there).max() / np.abs(there).max())


def thickness_map(scene, results):
    """Thickness [mm] at material points (k,) in the last frame: nodes have the mean of their triangles."""
    from scipy.interpolate import LinearNDInterpolator

    mesh, thickness = scene.blank.mesh, results.frames[-1].cell_fields["thickness"]
    total, count = np.zeros(len(mesh.points)), np.zeros(len(mesh.points))
    for corner in mesh.cells.T:
        np.add.at(total, corner, thickness)
        np.add.at(count, corner, 1.0)
    at = [np.arange(0.5 * GRID, high, GRID) for high in mesh.points.max(axis=0)[:2]]
    return LinearNDInterpolator(mesh.points[:, :2], total / count)(*np.meshgrid(*at)).ravel()
