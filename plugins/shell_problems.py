"""Large-deflection shell problems of Sze, Liu and Lo (Finite Elements in Analysis and Design 40 (2004) 1551-1569):
geometry, supports, loads and the published answers.

Lengths, forces and stresses are in the units of the paper.
"""

from dataclasses import dataclass, field

import numpy as np

from .shell_curves import CURVES, SMOOTH


@dataclass(frozen=True)
class Problem:
    """One problem. size : (a, b) of the parameter rectangle; shape : (s, t) -> points; groups : {name: (s, t) -> bool};
    cells : divisions along s and t for each refinement; loads : keywords of the stage, at the full load; probes :
    {name: (group, axis, sign)}, in the order of the columns of curve, the published rows (share of the full load,
    displacements); clamped, fixed : supports; wrinkles : whether the path is followed by the loaded nodes alone, past
    what forms and turns over around them; smooth : rows like those of curve, of the splines of `shell_splines.py`."""

    title: str
    young: float
    poisson: float
    thickness: float
    size: tuple
    shape: object
    groups: dict
    cells: tuple
    loads: dict
    probes: dict
    curve: np.ndarray
    clamped: tuple = ()
    fixed: dict = field(default_factory=dict)
    wrinkles: bool = False
    smooth: np.ndarray | None = None


def at(s=None, t=None):
    """Condition on the relative coordinates of the parameter rectangle."""

    def true(u, v):
        near = np.ones(len(u), dtype=bool)
        for value, wanted in ((u, s), (v, t)):
            if wanted is not None:
                near &= np.abs(value - wanted) < 1e-9
        return near

    return true


def flat(s, t):
    return np.column_stack([s, t, np.zeros_like(s)])


def annulus(s, t):
    return np.column_stack([(6.0 + t) * np.cos(s), -(6.0 + t) * np.sin(s), np.zeros_like(s)])


def hemisphere(s, t):
    return 10.0 * np.column_stack([np.cos(t) * np.cos(s), np.cos(t) * np.sin(s), np.sin(t)])


def tube(radius):
    """Quarter of a tube along y: s is the angle from the crown (z), t the place along the axis."""

    def shape(s, t):
        return np.column_stack([radius * np.sin(s), t, radius * np.cos(s)])

    return shape


TURN = np.array([[0.0, 0.0, 0.0], [1.0, 12.0, 24.0 / np.pi]])  # half a turn of a cantilever of length 12, exact

PROBLEMS = {
    "cantilever": Problem(
        "cantilever, end shear", 1.2e6, 0.0, 0.1, (10.0, 1.0), flat, {"root": at(s=0), "end": at(s=1), "tip": at(1, 0)},
        ((10, 1), (20, 2), (40, 4)), {"forces": {"end": (0.0, 0.0, 4.0)}},
        {"u": ("tip", 0, -1), "w": ("tip", 2, 1)}, CURVES["cantilever"], clamped=("root",),
    ),
    "roll-up": Problem(
        "cantilever, end moment, half a turn", 1.2e6, 0.0, 0.1, (12.0, 1.0), flat,
        {"root": at(s=0), "end": at(s=1), "tip": at(1, 0)}, ((16, 1), (32, 2), (64, 4)),
        {"moments": {"end": -25.0 * np.pi / 3.0}}, {"u": ("tip", 0, -1), "w": ("tip", 2, 1)}, TURN, clamped=("root",),
    ),
    "annular plate": Problem(
        "slit annular plate, line force", 21e6, 0.0, 0.03, (2.0 * np.pi, 4.0), annulus,
        {"root": at(s=1), "slit": at(s=0), "inner": at(0, 0), "outer": at(0, 1)}, ((20, 3), (40, 6), (80, 12)),
        {"forces": {"slit": (0.0, 0.0, 3.2)}}, {"A": ("inner", 2, 1), "B": ("outer", 2, 1)}, CURVES["annular plate"],
        clamped=("root",),
    ),
    "hemisphere": Problem(
        "hemisphere with a hole of 18 degrees", 6.825e7, 0.3, 0.04, (0.5 * np.pi, 0.4 * np.pi), hemisphere,
        {"symmetry_y": at(s=0), "symmetry_x": at(s=1), "out": at(0, 0), "in": at(1, 0), "rim": at(1, 1)},
        ((12, 12), (24, 24), (48, 48)), {"forces": {"out": (200.0, 0.0, 0.0), "in": (0.0, -200.0, 0.0)}},
        {"out": ("out", 0, 1), "in": ("in", 1, -1)}, CURVES["hemisphere"], fixed={"rim": "z"},
    ),
    "open cylinder": Problem(
        "pulled open cylinder", 10.5e6, 0.3125, 0.094, (0.5 * np.pi, 5.175), tube(4.953),
        {"symmetry_x": at(s=0), "symmetry_z": at(s=1), "symmetry_y": at(t=0), "A": at(0, 0), "B": at(1, 0),
         "C": at(1, 1)},
        ((12, 8), (24, 16), (48, 32)), {"forces": {"A": (0.0, 0.0, 10000.0)}},
        {"A": ("A", 2, 1), "B": ("B", 0, -1), "C": ("C", 0, -1)}, CURVES["open cylinder"],
    ),
    "pinched cylinder": Problem(
        "pinched cylinder with end diaphragms", 30e3, 0.3, 1.0, (0.5 * np.pi, 100.0), tube(100.0),
        {"symmetry_x": at(s=0), "symmetry_z": at(s=1), "symmetry_y": at(t=0), "A": at(0, 0), "B": at(1, 0),
         "end": at(t=1)},
        ((40, 40), (56, 56), (76, 76)), {"forces": {"A": (0.0, 0.0, -3000.0)}},
        {"A": ("A", 2, -1), "B": ("B", 0, 1)}, CURVES["pinched cylinder"], fixed={"end": "xz"},
        wrinkles=True, smooth=SMOOTH["pinched cylinder"],
    ),
    "semi-cylinder": Problem(
        "pinched semi-cylinder", 2068.5, 0.3, 3.0, (0.5 * np.pi, 304.8), tube(101.6),
        {"symmetry_x": at(s=0), "symmetry_z": at(s=1), "root": at(t=0), "A": at(0, 1)},
        ((12, 16), (24, 32), (48, 64)), {"forces": {"A": (0.0, 0.0, -1000.0)}}, {"A": ("A", 2, -1)},
        CURVES["semi-cylinder"], clamped=("root",),
    ),
    "hinged roof": Problem(
        "hinged cylindrical roof, h = 12.7", 3102.75, 0.3, 12.7, (0.1, 254.0), tube(2540.0),
        {"symmetry_x": at(s=0), "hinge": at(s=1), "symmetry_y": at(t=0), "A": at(0, 0)},
        ((8, 8), (16, 16), (32, 32)), {"forces": {"A": (0.0, 0.0, -750.0)}}, {"A": ("A", 2, -1)}, CURVES["hinged roof"],
        fixed={"hinge": "xyz"},
    ),
    "thin hinged roof": Problem(
        "hinged cylindrical roof, h = 6.35, through its snap-back", 3102.75, 0.3, 6.35, (0.1, 254.0), tube(2540.0),
        {"symmetry_x": at(s=0), "hinge": at(s=1), "symmetry_y": at(t=0), "A": at(0, 0)},
        ((8, 8), (16, 16), (32, 32)), {"forces": {"A": (0.0, 0.0, -750.0)}}, {"A": ("A", 2, -1)},
        CURVES["thin hinged roof"], fixed={"hinge": "xyz"},
    ),
}  # fmt: skip
