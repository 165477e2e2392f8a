"""Height and wavelength of the wrinkles along the rim of a formed sheet.

    python examples/coupelle/wrinkles.py out/coupelle_tenth [out/..]

The rim is that of the quarter computed. The wave is its height over the die along the arc, less its mean and its tilt;
the wavelength is the arc over the number of waves, counted from crossings of the mean.
"""

import sys
from pathlib import Path

import numpy as np


def rim_of(sheet):
    """Points of the rim in order along the arc, (n, 3): boundary nodes off the planes of symmetry, ends included."""
    edges = sheet.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    points = np.asarray(edges.points)
    radius = np.hypot(points[:, 0], points[:, 1])
    on_rim = radius > 0.9 * radius.max()
    points = points[on_rim]
    return points[np.argsort(np.arctan2(points[:, 1], points[:, 0]))]


def wrinkles(rim):
    """Peak-to-peak height [mm] and wavelength [mm] (inf where there is no wave) of a rim (n, 3)."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rim[:, :2], axis=0), axis=1))])
    wave = rim[:, 2] - np.polyval(np.polyfit(arc, rim[:, 2], 1), arc)
    crossings = np.flatnonzero(np.diff(np.sign(wave)))
    if len(crossings) < 2:
        return float(np.ptp(wave)), float("inf")
    return float(np.ptp(wave)), 2.0 * float(arc[crossings[-1]] - arc[crossings[0]]) / (len(crossings) - 1)


def sheet_of(folder):
    """The sheet, the first part, of a run's last frame."""
    import pyvista

    reader = pyvista.get_reader(str(Path(folder) / "result.pvd"))
    reader.set_active_time_value(reader.time_values[-1])
    return reader.read()[0].extract_surface(algorithm=None)


if __name__ == "__main__":
    for run in sys.argv[1:]:
        height, length = wrinkles(rim_of(sheet_of(run)))
        print(f"{run}: wrinkles {height:.2f} mm high, {length:.0f} mm long")
