"""The arrays that change, grouped by the stage that fills them.

n nodes, k edge slopes of a shell, p integration points: one a triangle in a membrane, one a layer in a shell.
"""

from dataclasses import dataclass, field, fields

import numpy as np


@dataclass
class Arrays:
    """A set of arrays that is copied, stored and loaded as one."""

    def copy_from(self, other):
        """Take over every value of another set of the same shapes."""
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value[...] = getattr(other, item.name)

    def arrays(self):
        """{name: array}."""
        return {f.name: getattr(self, f.name) for f in fields(self) if isinstance(getattr(self, f.name), np.ndarray)}


@dataclass
class SheetState(Arrays):
    """The sheet at one instant."""

    # move
    u: np.ndarray  # (n + k, 3) node positions; below them edge slopes times mesh size, in the first column [mm]
    # strain
    metric: np.ndarray  # (p, 3) C11, C22, C12
    # material
    strain: np.ndarray  # (p, 3) logarithmic strain H11, H22, 2 H12
    plastic: np.ndarray  # (p, 3) its plastic part
    equivalent: np.ndarray  # (p,) equivalent plastic strain
    history: np.ndarray  # (p, j) what else the law remembers, such as a backstress; j = 0 for isotropic hardening
    stress: np.ndarray  # (p, 3) T, conjugate to H [MPa]
    thickness_strain: np.ndarray  # (p,) H33
    second_stress: np.ndarray  # (p, 3) second Piola-Kirchhoff S [MPa]
    tangent: np.ndarray  # (p, 3, 3) dS/dE [MPa], empty where no stage is implicit
    # contact
    flattened: np.ndarray  # (n,) how much thinner tools on both sides have pressed the nodes for good [mm]
    # gather
    internal: np.ndarray  # (n + k, 3) internal forces [N]
    external: np.ndarray  # (n + k, 3) forces of the loads [N]
    n_nodes: int

    @property
    def x(self):
        """Node positions, (n, 3) [mm], the same memory as u."""
        return self.u[: self.n_nodes]


@dataclass
class FootState(Arrays):
    """One foot of each node on a tool, at one instant."""

    # contact
    gap: np.ndarray  # (n,) skin to tool [mm]; a lower bound for nodes out of reach
    normal_force: np.ndarray  # (n,) [N], 0 or more
    multiplier: np.ndarray  # (n,) of the augmented Lagrangian [N]
    normal: np.ndarray  # (n, 3) of the tool at the foot
    friction_force: np.ndarray  # (n, 3) on the sheet [N], in the tool's frame
    status: np.ndarray  # (n,) open, stick or slip

    def release(self):
        """Forget every touch."""
        for values in (self.normal_force, self.multiplier, self.friction_force, self.status):
            values[...] = 0
        self.gap[...] = np.inf


@dataclass
class ContactState(FootState):
    """One tool and the nodes it touches, at one instant: at one foot each, or at further ones in its tight corners."""

    # move
    travel: np.ndarray  # (1,) along the tool's axis from its place in the CAD file [mm]
    tilt: np.ndarray  # (3,) rotation vector about its pivot [rad]
    rest: np.ndarray  # (1,) travel where it first touched the sheet, from which a spring is pushed back [mm]
    # contact
    force: np.ndarray  # (3,) of the modelled sheet on the tool [N]
    further: tuple = ()  # FootStates

    @property
    def feet(self):
        """The FootStates of all feet."""
        return (self, *self.further)

    @property
    def touching(self):
        """Whether each node touches the tool, (n,)."""
        return np.any([foot.status != 0 for foot in self.feet], axis=0)

    @property
    def overlap(self):
        """How deep each node is in the tool where it touches it, (n,) [mm], 0 elsewhere."""
        return np.max([np.where(foot.status != 0, -foot.gap, 0.0) for foot in self.feet], axis=0, initial=0.0)

    @property
    def push(self):
        """Forces on the nodes, (n, 3) [N]."""
        return sum(foot.normal_force[:, None] * foot.normal + foot.friction_force for foot in self.feet)

    def copy_from(self, other):
        """Take over every value of another state of the same tool."""
        super().copy_from(other)
        for mine, theirs in zip(self.further, other.further):
            mine.copy_from(theirs)

    def arrays(self):
        """{name: array}, those of further feet as "foot2/gap" and so on."""
        further = {f"foot{k}/{name}": a for k, foot in enumerate(self.further, 2) for name, a in foot.arrays().items()}
        return super().arrays() | further

    def release(self):
        """Forget every touch."""
        super().release()
        self.force[:] = 0.0
        self.tilt[:] = 0.0
        for foot in self.further:
            foot.release()


@dataclass
class State:
    """Sheet, tools and drawbeads at one instant. tools: {name: ContactState}, beads: {name: BeadState}"""

    sheet: SheetState
    tools: dict
    beads: dict = field(default_factory=dict)

    def copy_from(self, other):
        """Take over every value of another state of the same scene."""
        self.sheet.copy_from(other.sheet)
        for name, contact in self.tools.items():
            contact.copy_from(other.tools[name])
        for name, bead in self.beads.items():
            bead.copy_from(other.beads[name])

    @property
    def squeeze(self):
        """By how much tools on both sides have pressed the sheet thinner, (n,) [mm]: for good, and what a node between
        two gives way now."""
        overlap = np.sum([contact.overlap for contact in self.tools.values()], axis=0)
        return self.sheet.flattened + np.where(self.pinched, overlap, 0.0)

    @property
    def pinched(self):
        """Whether each node touches two tools or more, (n,)."""
        return np.sum([contact.touching for contact in self.tools.values()], axis=0) > 1

    def groups(self):
        """Its sets of arrays by the names they are stored under."""
        tools = {f"tools/{name}": contact for name, contact in self.tools.items()}
        return {"sheet": self.sheet, **tools, **{f"beads/{name}": bead for name, bead in self.beads.items()}}


def new_sheet(points, n_slopes, n_points, n_history=0, tangents=True):
    """A sheet in its initial shape, stress-free. points : (n, 3); n_history : columns of the law's
    history; tangents : whether they are wanted, the largest array of all"""
    n_rows = len(points) + n_slopes
    return SheetState(
        u=np.vstack([points, np.zeros((n_slopes, 3))]),
        metric=np.tile([1.0, 1.0, 0.0], (n_points, 1)),
        strain=np.zeros((n_points, 3)),
        plastic=np.zeros((n_points, 3)),
        equivalent=np.zeros(n_points),
        history=np.zeros((n_points, n_history)),
        stress=np.zeros((n_points, 3)),
        thickness_strain=np.zeros(n_points),
        second_stress=np.zeros((n_points, 3)),
        tangent=np.zeros((n_points if tangents else 0, 3, 3)),
        flattened=np.zeros(len(points)),
        internal=np.zeros((n_rows, 3)),
        external=np.zeros((n_rows, 3)),
        n_nodes=len(points),
    )


def new_contact(n_nodes, n_feet=1):
    """A tool that touches nothing yet. n_feet : of a node"""
    further = tuple(FootState(**_no_feet(n_nodes)) for _ in range(n_feet - 1))
    return ContactState(
        travel=np.zeros(1), tilt=np.zeros(3), rest=np.zeros(1), force=np.zeros(3), further=further, **_no_feet(n_nodes)
    )


def _no_feet(n_nodes):
    return {
        "gap": np.full(n_nodes, np.inf),
        "normal_force": np.zeros(n_nodes),
        "multiplier": np.zeros(n_nodes),
        "normal": np.zeros((n_nodes, 3)),
        "friction_force": np.zeros((n_nodes, 3)),
        "status": np.zeros(n_nodes, dtype=np.int64),
    }
