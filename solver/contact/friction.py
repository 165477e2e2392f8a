"""Friction laws: the coefficient from pressure and sliding speed, for a whole tool or face by face (theory.md 7).

    p, v   pressure [MPa], sliding speed [mm/s];  mu  coefficient of friction;  eta viscosity [MPa s], Ra roughness [mm]
    N, A   normal force [N] and area of a node [mm^2], p = N / A

    CoulombPressure   mu = mu_0 (p / p_0)^(a - 1)
    CoulombVelocity   mu = mu_fast + (mu_0 - mu_fast) exp(-v / v_0)
    Stribeck          mu = 1/2 ((mu_b + mu_h) + (mu_b - mu_h) tanh(ln(L^2 / (L_b L_h)) / ln(L_b / L_h))),
                      L = eta v / (p Ra)

A law is a row of numbers to the kernels, its kind first. Friction stays an elastic-plastic stick-slip whatever the law:
node_on_tool.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp, log, tanh
from typing import NamedTuple

import numpy as np
from numba import njit

from ..errors import SceneError

COULOMB, PRESSURE, VELOCITY, STRIBECK = 0.0, 1.0, 2.0, 3.0
ROW = 6
LEAST = (
    1e-3  # of the reference pressure: below, a falling coefficient stays as it is there instead of going to infinity
)


def _check(what, value, above=None, at_least=0.0):
    good = isinstance(value, (int, float, np.number)) and np.isfinite(value)
    if not good or (value <= above if above is not None else value < at_least):
        words = f"a number above {above:g}" if above is not None else f"a number of {at_least:g} or more"
        raise SceneError(f"{what}: found {value!r}, expected {words}")


@dataclass(frozen=True)
class Coulomb:
    """Friction traction limited to mu times the contact pressure.

    mu : coefficient of friction, 0 or more
    """

    mu: float
    needs_speed = False

    def __post_init__(self):
        _check("friction coefficient", self.mu)

    def row(self):
        """Numbers for the kernels."""
        return [COULOMB, self.mu]

    def __str__(self):
        return f"friction {self.mu:g}"


@dataclass(frozen=True)
class CoulombPressure:
    """A coefficient that follows the pressure, mu (p / pressure)^(exponent - 1).

    mu : coefficient at the reference pressure; pressure : MPa; exponent : of the traction, 1 for Coulomb's law, as a
    rule 0.8 to 1. Below a thousandth of the reference pressure the coefficient keeps the value it has there.
    """

    mu: float
    pressure: float
    exponent: float
    needs_speed = False

    def __post_init__(self):
        _check("friction coefficient", self.mu)
        _check("friction pressure", self.pressure, above=0.0)
        _check("friction exponent", self.exponent, above=0.0)

    def row(self):
        """Numbers for the kernels."""
        return [PRESSURE, self.mu, self.pressure, self.exponent]

    def __str__(self):
        return f"friction {self.mu:g} (p / {self.pressure:g} MPa)^{self.exponent - 1.0:.3g}"


@dataclass(frozen=True)
class CoulombVelocity:
    """A coefficient that changes from `mu` at rest to `fast` at high speed, as exp(-v / velocity).

    velocity : mm/s
    """

    mu: float
    fast: float
    velocity: float
    needs_speed = True

    def __post_init__(self):
        _check("friction coefficient at rest", self.mu)
        _check("friction coefficient at speed", self.fast)
        _check("friction velocity", self.velocity, above=0.0)

    def row(self):
        """Numbers for the kernels."""
        return [VELOCITY, self.mu, self.fast, self.velocity]

    def __str__(self):
        return f"friction {self.mu:g} at rest to {self.fast:g} far above {self.velocity:g} mm/s"


@dataclass(frozen=True)
class Stribeck:
    """From boundary to hydrodynamic lubrication, by the lubrication number L = viscosity v / (p roughness) (ter Haar).

    boundary, hydrodynamic : coefficients far below L_boundary and far above L_hydrodynamic, the bounds of the mixed
        regime
    viscosity : of the lubricant [MPa s] (1 Pa s = 1e-6 MPa s); roughness : Ra [mm]
    """

    boundary: float
    hydrodynamic: float
    L_boundary: float
    L_hydrodynamic: float
    viscosity: float
    roughness: float
    needs_speed = True

    def __post_init__(self):
        for name in ("boundary", "hydrodynamic"):
            _check(f"Stribeck {name} coefficient", getattr(self, name))
        for name in ("L_boundary", "viscosity", "roughness"):
            _check(f"Stribeck {name}", getattr(self, name), above=0.0)
        _check("Stribeck L_hydrodynamic", self.L_hydrodynamic, above=self.L_boundary)

    def row(self):
        """Numbers for the kernels."""
        middle = self.L_boundary * self.L_hydrodynamic
        breadth = log(self.L_boundary / self.L_hydrodynamic)
        return [STRIBECK, self.boundary, self.hydrodynamic, self.viscosity / self.roughness, middle, breadth]

    def __str__(self):
        return f"Stribeck friction, {self.boundary:g} boundary to {self.hydrodynamic:g} hydrodynamic"


LAWS = (Coulomb, CoulombPressure, CoulombVelocity, Stribeck)


@dataclass(frozen=True)
class ByFace:
    """One law on most of a tool, others on some of its faces.

    elsewhere : law of all other faces, None for a frictionless one
    faces : {index of a face, as Projection.face tells it: law}
    """

    elsewhere: object
    faces: Mapping[int, object]

    def __post_init__(self):
        for face, law in self.faces.items():
            if isinstance(face, bool) or not isinstance(face, (int, np.integer)) or face < 0:
                raise SceneError(f"friction by face: found face {face!r}, expected its index, 0 or more")
            check_law(f"friction of face {face}", law)
        check_law("friction elsewhere", self.elsewhere)

    @property
    def needs_speed(self):
        """Whether any of its laws depends on the sliding speed."""
        return any(law.needs_speed for law in self.laws)

    @property
    def laws(self):
        """Its laws, that of the other faces first."""
        return (self.elsewhere or Coulomb(0.0), *self.faces.values())

    def __str__(self):
        by_law = {}
        for face, law in self.faces.items():
            by_law.setdefault(str(law or Coulomb(0.0)), []).append(str(face))
        some = "; ".join(f"{law} on face(s) {', '.join(faces)}" for law, faces in by_law.items())
        return f"{self.elsewhere or Coulomb(0.0)}; {some}"


def check_law(what, law):
    """Raises SceneError for what is no friction law."""
    if not (law is None or isinstance(law, LAWS)):
        names = ", ".join(kind.__name__ for kind in LAWS)
        raise SceneError(f"{what}: found {law!r}, expected one of {names}, or None")


class Laws(NamedTuple):
    """Friction of one tool where it is more than one number.

    rows : (l, 6), a law each; law_of_face : (f,), that of every face, those beyond have the last one
    area : (n,) of the nodes now [mm^2]; lapse : (1,) by which a movement [mm] (explicit: a velocity) is divided to give
    the sliding speed [mm/s]: seconds in the increment, inf at rest
    """

    rows: np.ndarray
    law_of_face: np.ndarray
    area: np.ndarray
    lapse: np.ndarray


def laws_of(friction, n_nodes):
    """Laws of a tool's friction, or None where one coefficient says it all."""
    if friction is None or isinstance(friction, Coulomb):
        return None
    given, faces = ((friction,), {}) if isinstance(friction, LAWS) else (friction.laws, friction.faces)
    rows = np.zeros((len(given), ROW))
    for row, law in zip(rows, given, strict=True):
        numbers = (law or Coulomb(0.0)).row()
        row[: len(numbers)] = numbers
    law_of_face = np.zeros(max(faces, default=-1) + 2, dtype=np.int64)
    for number, face in enumerate(faces, 1):
        law_of_face[face] = number
    return Laws(rows, law_of_face, np.ones(n_nodes), np.full(1, np.inf))


@njit(forceinline=True)
def coefficient(row, p, v):
    """mu and its derivatives by pressure and by sliding speed. row : (6,) of a law"""
    kind = row[0]
    if kind == PRESSURE:
        floor = LEAST * row[2]
        mu = row[1] * (max(p, floor) / row[2]) ** (row[3] - 1.0)
        return mu, (mu * (row[3] - 1.0) / p if p > floor else 0.0), 0.0
    if kind == VELOCITY:
        faded = (row[1] - row[2]) * exp(-v / row[3])
        return row[2] + faded, 0.0, -faded / row[3]
    if kind == STRIBECK:
        # L is 0 at rest and infinite without pressure: there the coefficient has its limits, and no slope.
        if v <= 0.0:
            return row[1], 0.0, 0.0
        if p <= 0.0:
            return row[2], 0.0, 0.0
        bend = tanh(2.0 * log(row[3] * v / p / row[4] ** 0.5) / row[5])
        by_log = (row[1] - row[2]) * (1.0 - bend * bend) / row[5]
        return 0.5 * (row[1] + row[2] + (row[1] - row[2]) * bend), -by_log / p, by_log / v
    return row[1], 0.0, 0.0


@njit(forceinline=True)
def friction_limit(row, normal_force, area, v):
    """Largest friction force of a node [N], and its derivatives by the normal force and by the sliding speed."""
    mu, by_pressure, by_speed = coefficient(row, normal_force / area, v)
    return mu * normal_force, mu + by_pressure * normal_force / area, by_speed * normal_force


@njit(forceinline=True)
def law_at(law_of_face, face):
    """Number of the law on a face."""
    return law_of_face[min(face, law_of_face.shape[0] - 1)]
