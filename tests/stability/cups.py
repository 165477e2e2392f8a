r"""A small round cup in any unit, size and place: the scene of the stress tests.

z up        punch: a ball
       holder ____  o  ____     a plane on the sheet
       =====================    disc, its mid-plane at z = t / 2
       die ____       ____      a plane, a quarter of a tube, a bore
               \     /
"""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from cadlink import CylinderSurface, Disc, PlaneSurface, SphereSurface, TorusSurface, mesh_blank
from solver import Blank, Coulomb, Material, PlanarHill, Scene, Shell, Stage, Swift, Tool


class Die:
    """A plane with a round opening whose edge is rounded: three primitives, each where it is nearest.

    opening, radius : of the bore and of its edge; the plane goes through `origin`, `axis` points out of the material
    """

    def __init__(self, opening, radius, origin=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0)):
        self.origin, self.axis = np.asarray(origin, float), np.asarray(axis, float)
        self.spine, self.radius = opening + radius, radius
        below = self.origin - radius * self.axis
        self.parts = (
            PlaneSurface(self.origin, self.axis),
            TorusSurface(self.spine, radius, below, self.axis),
            CylinderSurface(opening, self.origin, self.axis, hollow=True),
        )

    def project(self, points, seed=None):
        away = points - self.origin
        height = away @ self.axis
        outward = np.linalg.norm(away - height[:, None] * self.axis, axis=1)
        which = np.where(outward >= self.spine, 0, np.where(height > -self.radius, 1, 2))
        hits = [part.project(points) for part in self.parts]
        rows = np.arange(len(points))
        return type(hits[0])(*(np.stack(values)[which, rows] for values in zip(*hits)))


@dataclass(frozen=True)
class Cup:
    """Dimensions of a cup and how it is drawn; lengths in mm and forces in N where `unit` is 1.

    unit : mm in a unit of length, 1000 for a scene in metres (newtons stay)
    size : of the mesh; quarter : of the disc, or the whole disc; flatness : how far from flat the blank is
    turn, shift : rotation (3, 3) and translation (3,) of the whole scene, which must then be a whole disc
    """

    thickness: float = 1.0
    blank: float = 20.0
    punch: float = 10.0
    opening: float = 12.0
    die_radius: float = 3.0
    size: float = 2.5
    travel: float = 5.0
    mu: float = 0.1
    holder_force: float = 10e3
    element: object = Shell(5)
    quarter: bool = True
    flatness: float = 0.0
    unit: float = 1.0
    turn: object = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    shift: tuple = (0.0, 0.0, 0.0)

    def scaled(self, factor):
        """Every length of the cup times a factor, and the force so that pressures stay."""
        lengths = ("thickness", "blank", "punch", "opening", "die_radius", "size", "travel", "flatness")
        return replace(
            self,
            holder_force=factor**2 * self.holder_force,
            **{name: factor * getattr(self, name) for name in lengths},
        )

    def mesh(self):
        """The blank in its place, in the scene's unit."""
        symmetry = ("x", "y") if self.quarter else ()
        flat = mesh_blank(
            Disc(self.blank), self.size, arrangement="structured", symmetry=symmetry, flatness=self.flatness
        )
        points = flat.points + [0.0, 0.0, 0.5 * self.thickness]
        return SimpleNamespace(points=self.place(points), cells=flat.cells, groups=dict(flat.groups))

    def place(self, points):
        """Points (n, 3) mm of the upright cup where the scene has them."""
        return (np.asarray(points, float) @ np.asarray(self.turn, float).T + self.shift) / self.unit

    def scene(self, mesh=None):
        """The scene; mesh : another one of the same blank."""
        unit, axis = self.unit, np.asarray(self.turn, float)[:, 2]
        at = lambda z: self.place([[0.0, 0.0, z]])[0]  # noqa: E731
        oil = Coulomb(self.mu) if self.mu else None
        ball = SphereSurface(self.punch / unit, at(self.thickness + self.punch))
        die = Die(self.opening / unit, self.die_radius / unit, at(0.0), axis)
        tools = [
            Tool("PUNCH", ball, oil, tuple(axis), travel=-self.travel / unit),
            Tool("DIE", die, oil, tuple(axis)),
        ]
        if self.holder_force:
            plane = PlaneSurface(at(self.thickness), -axis)
            tools.append(Tool("HOLDER", plane, oil, tuple(axis), force=self.holder_force))
        blank = Blank(
            mesh or self.mesh(),
            self.thickness / unit,
            steel(unit),
            self.element,
            rolling=tuple(np.asarray(self.turn, float)[:, 0]),
        )
        return Scene(blank, [Stage(tools)], name="cup")


def steel(unit=1.0):
    """A mild steel whose stresses are in N per square unit of length."""
    pascal = unit * unit
    return Material(206000.0 * pascal, 0.3, PlanarHill(1.77), Swift(565.32 * pascal, 0.007117, 0.2589))
