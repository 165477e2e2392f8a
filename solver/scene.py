"""What is formed, by what, in which order: frozen descriptions, checked on construction.

A `Scene` is a `Blank` and a list of `Stage`s; a stage lists the `Tool`s that take part and what each
does. Units: mm, N, s, MPa. Nothing here changes during a run.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from .contact.drawbead import Drawbead
from .contact.friction import ByFace, Coulomb, CoulombPressure, CoulombVelocity, Stribeck, check_law
from .elements.formulation import Membrane, Shell
from .errors import SceneError
from .materials.material import Material

AXES = "xyz"


class Surface(Protocol):
    """A rigid skin a point can be projected on: `cadlink.ToolSurface`, or anything with its call.

    A surface that also has `tightest` (radius of its tightest hollow, mm) and `feet` (further feet of a point) is
    touched in several places by a node that its corners hold.
    """

    def project(self, points: np.ndarray, seed: Any = None) -> Any:
        """Closest points. points : (n, 3) mm. Returns distance (n,), point (n, 3), normal (n, 3),
        curvature (n, 2), direction (n, 3), face (n,), seed."""
        ...


@dataclass(frozen=True)
class Blank:
    """The sheet before forming.

    mesh : anything with points (n, 3) mm, cells (m, 3) and groups {name: node ids}; the points lie on
        the sheet's mid-surface. Nodes of the groups symmetry_x, symmetry_y, symmetry_z stay on their
        plane; forces and tool loads are then those of the whole part.
    thickness : mm
    material : Material
    element : Shell(layers=7), the default, or Membrane()
    rolling : rolling direction, a vector in space, projected on each triangle
    fixed : {group: axes held}, for example {"rim": "xyz"}; a shell may still turn about it
    clamped : groups of nodes held in place, on whose edges a shell cannot turn either
    draw_in : {name: direction} along which the movement of the rim towards the blank's centre is
        recorded, for example {"DX": (1, 0, 0)}
    forming_limit : major strain at which the sheet necks, a function of the minor one: LimitCurve, KeelerBrazier or
        marciniak_kuczynski(...); the margin to it is then recorded
    """

    mesh: Any
    thickness: float
    material: Material
    element: Membrane | Shell = Shell()
    rolling: Sequence[float] = (1.0, 0.0, 0.0)
    fixed: Mapping[str, str] = field(default_factory=dict)
    clamped: Sequence[str] = ()
    draw_in: Mapping[str, Sequence[float]] = field(default_factory=dict)
    forming_limit: Callable | None = None

    def __post_init__(self):
        if not (self.forming_limit is None or callable(self.forming_limit)):
            raise SceneError(f"blank forming_limit: found {self.forming_limit!r}, expected a curve such as LimitCurve")
        if not (np.isfinite(self.thickness) and self.thickness > 0.0):
            raise SceneError(f"blank thickness: found {self.thickness!r}, expected a length above 0 mm")
        points, cells = np.asarray(self.mesh.points), np.asarray(self.mesh.cells)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise SceneError(f"blank mesh points: found shape {points.shape}, expected (n, 3) finite numbers")
        if cells.ndim != 2 or cells.shape[1] != 3 or len(cells) == 0:
            raise SceneError(f"blank mesh cells: found shape {cells.shape}, expected triangles, (m, 3)")
        if cells.min() < 0 or cells.max() >= len(points):
            raise SceneError(f"blank mesh cells name node {cells.max()}, but there are {len(points)} nodes")
        missing = np.setdiff1d(np.arange(len(points)), cells)
        if len(missing):
            raise SceneError(f"blank mesh: node {missing[0]} belongs to no triangle")
        if not isinstance(self.element, (Membrane, Shell)):
            raise SceneError(f"blank element: found {self.element!r}, expected Shell() or Membrane()")
        for group in self.clamped:
            self.nodes_of(group)
        for group, axes in self.fixed.items():
            self.nodes_of(group)
            if not axes or set(axes) - set(AXES):
                raise SceneError(f"blank fixed {group!r}: found {axes!r}, expected some of the letters xyz")
        for name, direction in {"rolling": self.rolling, **self.draw_in}.items():
            if np.shape(direction) != (3,) or not np.linalg.norm(direction) > 0.0:
                raise SceneError(f"blank direction {name!r}: found {direction!r}, expected 3 numbers, not all 0")

    def nodes_of(self, group):
        """Node ids of a named group. Raises SceneError with the names that exist."""
        if group not in self.mesh.groups:
            raise SceneError(f"blank group {group!r} does not exist; there are {sorted(self.mesh.groups)}")
        return np.asarray(self.mesh.groups[group], dtype=np.int64)

    @property
    def symmetry_planes(self):
        """Axes whose plane of symmetry the mesh is cut at, for example ("x", "y")."""
        return tuple(axis for axis in AXES if f"symmetry_{axis}" in self.mesh.groups)

    @property
    def share(self):
        """Part of the whole blank that is modelled: 1/4 for a quarter."""
        return 0.5 ** len(self.symmetry_planes)

    @property
    def mesh_size(self):
        """Median length of the triangles' sides [mm]."""
        points, cells = np.asarray(self.mesh.points), np.asarray(self.mesh.cells)
        sides = points[cells[:, [1, 2, 0]]] - points[cells]
        return float(np.median(np.linalg.norm(sides, axis=2)))


@dataclass(frozen=True)
class Spring:
    """A spring that presses a tool towards the blank along its axis; never pulls.

    stiffness : N/mm; preload : N where the tool first touches the blank. Both of the whole part.
    """

    stiffness: float
    preload: float = 0.0

    def __post_init__(self):
        if not (np.isfinite(self.stiffness) and self.stiffness > 0.0):
            raise SceneError(f"spring stiffness: found {self.stiffness!r}, expected N/mm above 0")
        if not (np.isfinite(self.preload) and self.preload >= 0.0):
            raise SceneError(f"spring preload: found {self.preload!r}, expected N, 0 or more")


@dataclass(frozen=True)
class Tool:
    """A rigid tool and what it does in its stage. Give at most one of travel, to, force, gap and spring: without
    them the tool stands still.

    surface : Surface, normals out of the material
    friction : Coulomb, CoulombPressure, CoulombVelocity, Stribeck, ByFace, or None for a frictionless tool
    axis : direction of its motion
    travel : mm along the axis over the stage, counted from first touching the blank
    to : mm along the axis from its place in the CAD file where its travel ends, wherever it first touches the blank
    force : N for the whole part, pressing towards the blank
    gap : mm between this tool and the far side of the blank; the blank's thickness means just touching
    spring : Spring that presses it towards the blank
    stop : mm that a force or spring gives way, from first touching the blank; there the tool bottoms out
    rides_on : name of the travelling tool that its spring, or its stop, stands on: a pad in a punch or die; both are
        then counted from the stage's start
    tilts : whether a force or spring leaves it free to tilt about the two axes across its own; else it is guided
    at : where the force or spring acts, a point of the CAD file or several cushion pins that share it [mm]; by default
        the middle of the blank
    """

    name: str
    surface: Surface
    friction: Coulomb | CoulombPressure | CoulombVelocity | Stribeck | ByFace | None = None
    axis: Sequence[float] = (0.0, 0.0, 1.0)
    travel: float | None = None
    to: float | None = None
    force: float | None = None
    gap: float | None = None
    spring: Spring | None = None
    stop: float | None = None
    rides_on: str | None = None
    tilts: bool = False
    at: Sequence | None = None

    def __post_init__(self):
        if not isinstance(self.friction, ByFace):
            check_law(f"tool {self.name!r} friction", self.friction)
        duties = [key for key in ("travel", "to", "force", "gap", "spring") if getattr(self, key) is not None]
        if len(duties) > 1:
            raise SceneError(f"tool {self.name!r}: found {' and '.join(duties)}, expected at most one of them")
        if np.shape(self.axis) != (3,) or not np.linalg.norm(self.axis) > 0.0:
            raise SceneError(f"tool {self.name!r} axis: found {self.axis!r}, expected 3 numbers, not all 0")
        if self.travel is not None and not (np.isfinite(self.travel) and self.travel != 0.0):
            raise SceneError(f"tool {self.name!r} travel: found {self.travel!r}, expected mm other than 0")
        if not (self.to is None or np.isfinite(self.to)):
            raise SceneError(f"tool {self.name!r} to: found {self.to!r}, expected mm from its place in the CAD file")
        if not (self.spring is None or isinstance(self.spring, Spring)):
            raise SceneError(f"tool {self.name!r} spring: found {self.spring!r}, expected Spring(stiffness, preload)")
        for key in ("stop", "rides_on", "tilts", "at"):
            if getattr(self, key) is not None and getattr(self, key) is not False and not self.gives_way:
                raise SceneError(f"tool {self.name!r} {key}: found beside no force or spring, expected one of them")
        if self.at is not None and not (np.shape(self.at)[-1:] == (3,) and np.ndim(self.at) in (1, 2)):
            raise SceneError(
                f"tool {self.name!r} at: found {self.at!r}, expected a point, 3 numbers, or a list of them"
            )
        for key in ("force", "gap", "stop"):
            value = getattr(self, key)
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise SceneError(f"tool {self.name!r} {key}: found {value!r}, expected a number above 0")

    @property
    def stands_still(self):
        """Whether it neither travels nor presses nor keeps a gap."""
        return not (self.travels or self.gives_way) and self.gap is None

    @property
    def travels(self):
        """Whether its movement is prescribed."""
        return self.travel is not None or self.to is not None

    @property
    def gives_way(self):
        """Whether a force or a spring bears the tool."""
        return self.force is not None or self.spring is not None

    @property
    def unit_axis(self):
        """Axis as a unit vector, (3,)."""
        return np.asarray(self.axis, dtype=float) / np.linalg.norm(self.axis)

    @property
    def mu(self):
        """Coefficient of friction where one number says it all, 0 without friction, NaN for any other law."""
        if self.friction is None:
            return 0.0
        return self.friction.mu if isinstance(self.friction, Coulomb) else np.nan


@dataclass(frozen=True)
class Stage:
    """One operation: the tools that take part, loads, and prescribed movements.

    tools : Tools; the first with a travel sets the stroke
    pressure : MPa at the end of the stage on the sheet's face that its triangles' normals leave,
        pushing against them; it follows the sheet
    forces : {group: (Fx, Fy, Fz)} N on the modelled nodes of the group together, by their share of its edge
    line_loads : {group: (fx, fy, fz)} N/mm along an edge or a row of nodes inside the sheet, per initial length of what
        is modelled (half of what acts along a line of symmetry), in a direction that stays
    moments : {group: N} per mm of a shell's free edge; positive stretches the face that the normals leave
    moved : {group: (dx, dy, dz)} mm over the stage, None for a free axis
    gravity : (gx, gy, gz) mm/s^2 that acts on the sheet from the stage's start, or None
    drawbeads : Drawbeads that restrain the sheet
    pilots : groups of nodes on pins, such as the edge of a hole: they keep their place across the tools' axis
    speed : mm/s of the leading tool, or without one of the group moved farthest, for laws that depend on speed

    Loads rise in proportion over the stage. What the stage before left unbalanced (its tools, loads and supports) is
    relieved first, with this stage's tools at rest: a stage with nothing in it is springback. A formed part that cuts
    into tools standing still is first lifted out of them along the stroke (lay_in.py).
    """

    tools: Sequence[Tool] = ()
    name: str = "draw"
    pressure: float = 0.0
    forces: Mapping[str, Sequence[float]] = field(default_factory=dict)
    line_loads: Mapping[str, Sequence[float]] = field(default_factory=dict)
    moments: Mapping[str, float] = field(default_factory=dict)
    moved: Mapping[str, Sequence[float | None]] = field(default_factory=dict)
    speed: float | None = None
    gravity: Sequence[float] | None = None
    pilots: Sequence[str] = ()
    drawbeads: Sequence[Drawbead] = ()

    def __post_init__(self):
        if self.gravity is not None and not (np.shape(self.gravity) == (3,) and np.isfinite(self.gravity).all()):
            raise SceneError(f"stage {self.name!r} gravity: found {self.gravity!r}, expected 3 numbers in mm/s^2")
        both = sorted(set(self.pilots) & set(self.moved))
        if both:
            raise SceneError(f"stage {self.name!r} pilots: group {both[0]!r} is moved too, expected one of them")
        if self.pilots and not np.isclose(np.abs(self.leading_axis).max(), 1.0, atol=1e-12):
            raise SceneError(
                f"stage {self.name!r} pilots: found tools along {tuple(self.leading_axis)}, expected x, y or z: a pin "
                "holds two of these"
            )
        if self.speed is not None and not (np.isfinite(self.speed) and self.speed > 0.0):
            raise SceneError(f"stage {self.name!r} speed: found {self.speed!r}, expected mm/s above 0")
        for tool in self.tools:
            if self.path > 0.0 and self.speed is None and tool.friction is not None and tool.friction.needs_speed:
                raise SceneError(
                    f"stage {self.name!r} speed: missing, expected mm/s: friction of tool {tool.name!r} depends on "
                    "how fast the sheet slides"
                )
        names = [tool.name for tool in self.tools]
        if len(set(names)) < len(names):
            raise SceneError(f"stage {self.name!r}: tools {names} share a name, expected a name each")
        beads = [bead.name for bead in self.drawbeads]
        if len(set(beads)) < len(beads):
            raise SceneError(f"stage {self.name!r}: drawbeads {beads} share a name, expected a name each")
        for bead in self.drawbeads:
            borne = [tool.name for tool in self.tools if tool.gives_way]
            if bead.holder is not None and bead.holder not in borne:
                raise SceneError(
                    f"drawbead {bead.name!r} holder: found {bead.holder!r}, expected a tool of stage {self.name!r} "
                    f"that a force or spring bears, one of {borne}"
                )
        for tool in self.tools:
            carrier = next((other for other in self.tools if other.name == tool.rides_on), None)
            if tool.rides_on is not None and (carrier is None or not carrier.travels):
                travelling = [other.name for other in self.tools if other.travels]
                raise SceneError(
                    f"stage {self.name!r}: tool {tool.name!r} rides on {tool.rides_on!r}, expected a tool that travels "
                    f"in this stage, one of {travelling}"
                )
        for key, unit in (("forces", "N"), ("line_loads", "N/mm")):
            for group, force in getattr(self, key).items():
                if np.shape(force) != (3,) or not np.isfinite(np.asarray(force, dtype=float)).all():
                    raise SceneError(
                        f"stage {self.name!r} {key} {group!r}: found {force!r}, expected 3 numbers in {unit}"
                    )

    @property
    def is_springback(self):
        """Whether nothing acts in this stage: the sheet only relieves what was left unbalanced."""
        loads = self.pressure or self.forces or self.line_loads or self.moments or self.gravity is not None
        return not (self.tools or loads or self.movements or self.drawbeads)

    @property
    def leading_axis(self):
        """Unit axis (3,) of the first tool that travels, else of the first, else z."""
        tools = [tool for tool in self.tools if tool.travels] or list(self.tools)
        return tools[0].unit_axis if tools else np.array([0.0, 0.0, 1.0])

    @property
    def movements(self):
        """`moved`, and what pilots hold: {group: mm, None for a free axis}."""
        along = int(np.argmax(np.abs(self.leading_axis)))
        pinned = tuple(None if axis == along else 0.0 for axis in range(3))
        return {**self.moved, **dict.fromkeys(self.pilots, pinned)}

    @property
    def path(self):
        """Travel of the stage's leading tool, without one of the group moved farthest [mm]; 0 where nothing moves."""
        if any(tool.travels for tool in self.tools):
            return self.stroke
        return max((abs(d) for movement in self.moved.values() for d in movement if d is not None), default=0.0)

    @property
    def seconds(self):
        """How long the stage lasts, inf where nothing moves or nobody says how fast."""
        return self.path / self.speed if self.speed and self.path > 0.0 else np.inf

    @property
    def stroke(self):
        """Travel of the stage's leading tool [mm]; 1 where no tool travels (a pure load stage), inf where it goes `to`
        a place and has not closed on the sheet."""
        for tool in self.tools:
            if tool.travels:
                return np.inf if tool.travel is None else abs(tool.travel)
        return 1.0

    def closed(self, placed):
        """The stage whose tools have closed on the sheet: those that go `to` a place know their travel.

        placed : {tool: (mm along its axis, side it presses from)}
        """
        there = {tool.name: tool.to - placed[tool.name][0] for tool in self.tools if tool.to is not None}
        tools = [replace(t, travel=there[t.name], to=None) if t.name in there else t for t in self.tools]
        return replace(self, tools=tools) if there else self


@dataclass(frozen=True)
class Scene:
    """A blank and the stages that form it.

    name : heads reports and files
    """

    blank: Blank
    stages: Sequence[Stage]
    name: str = "forming"

    def __post_init__(self):
        if not self.stages:
            raise SceneError("scene: found no stage, expected at least one")
        for stage in self.stages:
            for bead in stage.drawbeads:
                if bead.curve is not self.drawbeads[bead.name].curve:
                    raise SceneError(f"drawbead {bead.name!r}: found two curves, expected one in all stages")
            for group in (*stage.movements, *stage.forces, *stage.moments):
                self.blank.nodes_of(group)

    @property
    def tools(self):
        """Every tool by name, as it first appears."""
        found = {}
        for stage in self.stages:
            for tool in stage.tools:
                found.setdefault(tool.name, tool)
        return found

    @property
    def drawbeads(self):
        """Every drawbead by name, as it first appears."""
        found = {}
        for stage in self.stages:
            for bead in stage.drawbeads:
                found.setdefault(bead.name, bead)
        return found

    def plan(self, method=None):
        """What will run, what is skipped, and why, by a method such as Implicit(). Returns Plan, whose str() is the
        text."""
        from .plan import plan

        return plan(self, method)
