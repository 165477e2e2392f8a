"""What the reading process hands over of faces and edges. Knows neither OpenCASCADE nor numba."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

PLANE, CYLINDER, CONE, SPHERE, TORUS, PATCHES = range(6)  # forms of a face
LINE, CIRCLE, BEZIER = 0, 1, 2  # forms of an edge


class EdgeCurve(NamedTuple):
    """A 3-D edge: the arcs it is made of and, for a circle, its closed form.

    form    LINE, CIRCLE or BEZIER
    frame   (3, 3) of a circle: centre, x radius vector, y radius vector [mm]
    arcs    list of Arc with 3-D control points
    """

    form: int
    frame: np.ndarray
    arcs: list
    first: float
    last: float


@dataclass
class FaceRecord:
    """One face.

    kind     what the CAD file calls it: "plane", "bspline", ..
    form     PLANE .. TORUS, or PATCHES
    frame    (4, 3) origin, x, y, z of the closed form [mm]
    size     (2,) radius; radius and half angle; large and small radius [mm, rad]
    sense    +1 where (frame normal or S_u x S_v) leaves the material, -1 where it enters
    period   (2,) period of u and v, 0 where there is none
    gap      mm, how far the form misses the face as drawn: a closed form a spline (recognize.py), patches a swept or
             offset surface; 0 for all others
    u_arcs, v_arcs   (n, 3) t0, t1, ramp of the patch grid
    patches  (nu, nv) nested list of homogeneous control nets (p+1, q+1, 4)
    """

    kind: str
    form: int
    sense: float
    frame: np.ndarray = field(default_factory=lambda: np.zeros((4, 3)))
    size: np.ndarray = field(default_factory=lambda: np.zeros(2))
    period: np.ndarray = field(default_factory=lambda: np.zeros(2))
    gap: float = 0.0
    u_arcs: np.ndarray | None = None
    v_arcs: np.ndarray | None = None
    patches: list | None = None
