"""The implicit method's few options, every one relative to a scale of the scene."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Newton:
    """When an increment has converged.

    residual : of the out-of-balance force, relative to the forces in play
    enough : the same where it falls no further, as where a node comes and goes
    correction : of the movement of a node that is still lacking, relative to the mesh size
    iterations : more than this and the increment is cut
    """

    residual: float = 5e-4
    enough: float = 5e-4
    correction: float = 1e-4
    iterations: int = 25


@dataclass(frozen=True)
class Increments:
    """How far one increment goes.

    first : travel of the leading tool, relative to the thickness
    largest : of the same, relative to the mesh size
    swift, slow : iterations up to which the next increment grows, above which it shrinks
    """

    first: float = 0.1
    largest: float = 0.2
    swift: int = 10
    slow: int = 18


@dataclass(frozen=True)
class Implicit:
    """Quasi-static Newton.

    torsion : T* of membranes relative to the initial yield stress (theory.md 2)
    penalty : contact stiffness relative to E t / size^2 (theory.md 6)
    stick : tangential contact stiffness before slip, relative to E t / size^2 (theory.md 7)
    skin : gap below which the contact force sets in, relative to the thickness
    penetration : allowed overlap relative to the thickness; more is removed by augmentation
    """

    newton: Newton = field(default_factory=Newton)
    increments: Increments = field(default_factory=Increments)
    torsion: float = 0.01
    penalty: float = 3.0
    stick: float = 0.03
    skin: float = 3e-3
    penetration: float = 1e-3
    needs_tangents = True

    def describe(self):
        """One line for the plan."""
        return f"implicit, Newton to a residual of {self.newton.residual:g} of the forces in play"

    def of(self, stage):
        """The method that runs a stage."""
        return self

    def start(self, stage, sheet, placed):
        """March of a stage not yet begun."""
        from .increments import start_march

        return start_march(stage, sheet, self, placed)

    def march(self, sheet, stage, tools, old, new, begun, stops):
        """Run a stage; see implicit/increments.py."""
        from .increments import march

        return march(sheet, stage, tools, old, new, begun, self, stops)
