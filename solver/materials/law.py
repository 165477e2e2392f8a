"""The seam between element and material: metrics in, stresses out, whole arrays.

A law is any object with `young`, `initial_yield_stress` [MPa], `name`, `n_history`, `describe()` and
`update(metric, old, new, tangent=True, dt=None)`. The solver asks for nothing else. `Material` combines the laws of
this package; a law of one's own derives from `Law` and writes `respond`:

    class LinearElastic(Law):
        young, poisson, name = 70000.0, 0.33, "linear in logarithmic strain"
        initial_yield_stress = 100.0

        def respond(self, strain, old, new, dt):
            c = self.young / (1.0 - self.poisson**2)
            nu = self.poisson
            stiffness = c * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 - 0.5 * nu]])
            new.stress[:] = strain @ stiffness
            new.thickness_strain[:] = -nu / (1.0 - nu) * (strain[:, 0] + strain[:, 1])
            return np.broadcast_to(stiffness, (len(strain), 3, 3))
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from ..lanes import BLOCK, give, n_blocks, take
from ..state import Arrays
from .block import (
    METRIC,
    ROOM,
    SECOND,
    H,
    T,
    block_pull_back,
    block_pull_back_stiffness,
    block_strains,
    take_stiffness,
)

NO_TANGENT = np.empty((0, 3, 3))


@dataclass
class PointState(Arrays):
    """What a law reads and fills at p points; `solver.state.SheetState` has the same names."""

    strain: np.ndarray  # (p, 3) logarithmic strain H11, H22, 2 H12
    plastic: np.ndarray  # (p, 3) its plastic part
    equivalent: np.ndarray  # (p,) equivalent plastic strain
    history: np.ndarray  # (p, k) what else the law remembers; k = 0 for isotropic hardening
    stress: np.ndarray  # (p, 3) T, conjugate to H [MPa]
    thickness_strain: np.ndarray  # (p,) H33
    second_stress: np.ndarray  # (p, 3) second Piola-Kirchhoff S [MPa]
    tangent: np.ndarray  # (p, 3, 3) dS/dE [MPa]


def point_state(n_points, n_history=0):
    """Undeformed points."""
    shapes = {"strain": (3,), "plastic": (3,), "equivalent": (), "history": (n_history,), "stress": (3,)}
    shapes |= {"thickness_strain": (), "second_stress": (3,), "tangent": (3, 3)}
    return PointState(**{name: np.zeros((n_points, *shape)) for name, shape in shapes.items()})


class Law:
    """Base of a user's own material: strain and pull-back are done here, `respond` is the law.

    respond(strain, old, new, dt) : strain (p, 3) logarithmic [H11, H22, 2 H12] in rolling axes; reads the histories
        of old, fills new.stress (p, 3) T [MPa], new.thickness_strain (p,), and new.plastic, new.equivalent,
        new.history (p, n_history) where the law has them; returns dT/dH (p, 3, 3) [MPa]
    """

    name = "own material"
    n_history = 0

    def respond(self, strain, old, new, dt):
        """The law itself."""
        raise TypeError(f"{type(self).__name__}: a material of one's own needs respond(strain, old, new, dt)")

    def describe(self):
        """One line for the plan."""
        return f"{self.name}: {type(self).__name__}, plane stress"

    def new_state(self, n_points):
        """PointState of undeformed points."""
        return point_state(n_points, self.n_history)

    def prepare(self):
        """Called once before a run."""

    def update(self, metric, old, new, tangent=True, dt=None):
        """Fill new from metric (p, 3) C11 C22 C12 and the history in old; dt [s] is None in quasi-static forming."""
        strains(metric, new.strain)
        stiffness = np.ascontiguousarray(self.respond(new.strain, old, new, dt), dtype=float)
        pull_back(metric, new.stress, stiffness, new.second_stress, new.tangent if tangent else NO_TANGENT)


@njit(parallel=True, cache=True, error_model="numpy")
def strains(metric, strain):
    """Fills strain (p, 3), logarithmic, from metric (p, 3)."""
    n_points, metric, strain = metric.shape[0], metric.reshape(-1), strain.reshape(-1)
    for block in prange(n_blocks(n_points)):
        a3, w = 3 * BLOCK * block, np.empty(ROOM)
        n = min(BLOCK, n_points - BLOCK * block)
        take(n, metric[a3:], w, METRIC)
        block_strains(n, w)
        give(n, w, H, strain[a3:])


@njit(parallel=True, cache=True, error_model="numpy")
def pull_back(metric, stress, stiffness, second_stress, tangent):
    """Fills S (p, 3) and, where it is not empty, dS/dE (p, 3, 3), from T (p, 3) and dT/dH (p, 3, 3) [MPa]."""
    n_points, metric, stress = metric.shape[0], metric.reshape(-1), stress.reshape(-1)
    second_stress = second_stress.reshape(-1)
    for block in prange(n_blocks(n_points)):
        a, w = BLOCK * block, np.empty(ROOM)
        a3, n = 3 * a, min(BLOCK, n_points - a)
        take(n, metric[a3:], w, METRIC)
        block_strains(n, w)
        take(n, stress[a3:], w, T)
        block_pull_back(n, w)
        give(n, w, SECOND, second_stress[a3:])
        if tangent.shape[0] > 0:
            for p in range(n):
                take_stiffness(w, p, stiffness[a + p])
            block_pull_back_stiffness(n, w, tangent[a:])
