"""The arrays that change, grouped by the stage that fills them. n nodes, m triangles."""

from dataclasses import dataclass, fields

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
    x: np.ndarray  # (n, 3) node positions [mm]
    # strain
    metric: np.ndarray  # (m, 3) C11, C22, C12
    # material
    strain: np.ndarray  # (m, 3) logarithmic strain H11, H22, 2 H12
    plastic: np.ndarray  # (m, 3) its plastic part
    equivalent: np.ndarray  # (m,) equivalent plastic strain
    history: np.ndarray  # (m, k) what else the law remembers, such as a backstress; k = 0 for isotropic hardening
    stress: np.ndarray  # (m, 3) T, conjugate to H [MPa]
    thickness_strain: np.ndarray  # (m,) H33
    second_stress: np.ndarray  # (m, 3) second Piola-Kirchhoff S [MPa]
    tangent: np.ndarray  # (m, 3, 3) dS/dE [MPa]
    # gather
    internal: np.ndarray  # (n, 3) internal forces [N]
    external: np.ndarray  # (n, 3) forces of the pressure [N]


@dataclass
class ContactState(Arrays):
    """One tool and the nodes it touches, at one instant."""

    # move
    travel: np.ndarray  # (1,) along the tool's axis from its place in the CAD file [mm]
    # contact
    gap: np.ndarray  # (n,) skin to tool [mm]; a lower bound for nodes out of reach
    normal_force: np.ndarray  # (n,) [N], 0 or more
    multiplier: np.ndarray  # (n,) of the augmented Lagrangian [N]
    normal: np.ndarray  # (n, 3) of the tool at the foot
    friction_force: np.ndarray  # (n, 3) on the sheet [N], in the tool's frame
    status: np.ndarray  # (n,) open, stick or slip
    force: np.ndarray  # (3,) of the modelled sheet on the tool [N]


@dataclass
class State:
    """Sheet and tools at one instant. tools: {name: ContactState}"""

    sheet: SheetState
    tools: dict

    def copy_from(self, other):
        """Take over every value of another state of the same scene."""
        self.sheet.copy_from(other.sheet)
        for name, contact in self.tools.items():
            contact.copy_from(other.tools[name])


def new_sheet(points, n_tris, n_history=0):
    """A flat, stress-free sheet. points : (n, 3); n_history : columns of the law's history"""
    return SheetState(
        x=np.array(points, dtype=float, order="C"),
        metric=np.tile([1.0, 1.0, 0.0], (n_tris, 1)),
        strain=np.zeros((n_tris, 3)),
        plastic=np.zeros((n_tris, 3)),
        equivalent=np.zeros(n_tris),
        history=np.zeros((n_tris, n_history)),
        stress=np.zeros((n_tris, 3)),
        thickness_strain=np.zeros(n_tris),
        second_stress=np.zeros((n_tris, 3)),
        tangent=np.zeros((n_tris, 3, 3)),
        internal=np.zeros((len(points), 3)),
        external=np.zeros((len(points), 3)),
    )


def new_contact(n_nodes):
    """A tool that touches nothing yet."""
    return ContactState(
        travel=np.zeros(1),
        gap=np.full(n_nodes, np.inf),
        normal_force=np.zeros(n_nodes),
        multiplier=np.zeros(n_nodes),
        normal=np.zeros((n_nodes, 3)),
        friction_force=np.zeros((n_nodes, 3)),
        status=np.zeros(n_nodes, dtype=np.int64),
        force=np.zeros(3),
    )
