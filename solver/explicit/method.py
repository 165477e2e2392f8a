"""The explicit method's few options, every one relative to a scale of the scene."""

from dataclasses import dataclass, field

from ..errors import SceneError
from ..implicit.method import Implicit


@dataclass(frozen=True)
class Kinematic:
    """After the predicted step the force that puts the node exactly on the tool: no penetration, no stiffness."""


@dataclass(frozen=True)
class Touch:
    """The node's step is divided at the instant of first touch (seed section 8).

    restitution : of the normal velocity kept in a bounce, 0 to 1
    """

    restitution: float = 1.0

    def __post_init__(self):
        if not 0.0 <= self.restitution <= 1.0:
            raise SceneError(f"contact restitution: found {self.restitution!r}, expected 0 to 1")


@dataclass(frozen=True)
class Penalty:
    """A spring on the overlap.

    stiffness : of a node's spring, relative to its mass over the square of the stable step; stable alone up to 4
    """

    stiffness: float = 0.2

    def __post_init__(self):
        if not 0.0 < self.stiffness < 4.0:
            raise SceneError(f"contact penalty: found {self.stiffness!r}, expected a number above 0 and below 4")


@dataclass(frozen=True)
class Explicit:
    """Central differences; a stage of pure springback runs implicitly, unless it is to relax.

    contact : Kinematic(), Touch() or Penalty()
    safety : of the stable step, relative to the limit 2/omega_max
    waves : times a transverse wave in the sheet at its yield stress crosses the blank while a stage lasts. The share
        of kinetic energy falls with its square: the tools' speed follows from it
    ramp : part of the stage's time in which the tools reach their speed, and again in which they stop
    scaled : part of the blank's mass that may be added to triangles whose stable step is far below the median's
    steps : that a stage should take at most, 0 for any number: a target step. Triangles too fast for it get mass, as
        much as that takes
    damping : of the sheet's velocity, relative to the rate at which those waves cross the blank
    drift : of the energy balance, relative to the work done; above it a run stops
    relax : whether stages in which nothing travels (springback, weight, loads, tools that press) are brought to rest by
        dynamic relaxation: damped critically in the slowest mode that takes part, until what is left to do is
        negligible
    springback : Implicit, for stages in which nothing acts, where they do not relax
    """

    contact: Kinematic | Touch | Penalty = field(default_factory=Kinematic)
    safety: float = 0.9
    waves: float = 16.0
    ramp: float = 0.5
    scaled: float = 0.01
    steps: float = 0.0
    damping: float = 0.2
    drift: float = 0.05
    relax: bool = False
    springback: Implicit = field(default_factory=Implicit)

    def __post_init__(self):
        for name, low, high in (("safety", 0.0, 1.0), ("waves", 0.0, 1e6), ("ramp", 0.0, 0.5), ("drift", 0.0, 1e6)):
            if not low < getattr(self, name) <= high:
                raise SceneError(f"explicit {name}: found {getattr(self, name)!r}, expected above {low:g} to {high:g}")
        for name in ("scaled", "steps", "damping"):
            if not getattr(self, name) >= 0.0:
                raise SceneError(f"explicit {name}: found {getattr(self, name)!r}, expected a number of 0 or more")

    # Dynamics stabilises a membrane; what two tools pinch has the implicit stages' contact stiffness and skin.
    torsion = 0.0
    needs_tangents = False

    @property
    def penalty(self):
        """Of the implicit stages."""
        return self.springback.penalty

    @property
    def stick(self):
        """Of the implicit stages."""
        return self.springback.stick

    @property
    def skin(self):
        """Of the implicit stages."""
        return self.springback.skin

    def describe(self):
        """One line for the plan."""
        damped = f", damping {self.damping:g} of that rate" if self.damping else ""
        rest = "stages in which nothing travels relax to rest" if self.relax else "springback runs implicitly"
        return (
            f"explicit, {type(self.contact).__name__.lower()} contact, steps at {self.safety:g} of the stable one; a "
            f"stage lasts {self.waves:g} wave crossings of the blank{damped}; {rest}"
        )

    def of(self, stage):
        """The method that runs a stage."""
        return self.springback if stage.is_springback and not self.relax else self

    def relaxes(self, stage):
        """Whether a stage is brought to rest."""
        return self.relax and stage.path == 0.0

    def start(self, stage, sheet, placed):
        """March of a stage not yet begun."""
        from .march import start_march

        return start_march(stage, sheet, placed)

    def march(self, sheet, stage, tools, old, new, begun, stops):
        """Run a stage; see explicit/march.py."""
        from .march import march

        return march(sheet, stage, tools, old, new, begun, self, stops)
