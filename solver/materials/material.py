"""A sheet material: elasticity, a yield locus and a hardening curve, freely combined."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import SceneError
from .hardening import tabulate
from .law import NO_TANGENT, point_state
from .planar_hill import PlanarHill, update


@dataclass(frozen=True)
class Material:
    """Elastic-plastic sheet.

    young : Young's modulus [MPa]
    poisson : Poisson's ratio
    locus : VonMises() or PlanarHill(r)
    hardening : callable, equivalent plastic strain (n,) -> yield stress (n,) [MPa]; Swift, Voce, Ludwik,
        HockettSherby, Table, Sum, or any function
    name : heads reports
    """

    young: float
    poisson: float
    locus: PlanarHill
    hardening: Callable
    name: str = "sheet"

    def __post_init__(self):
        if not (np.isfinite(self.young) and self.young > 0.0):
            raise SceneError(f"material Young's modulus: found {self.young!r}, expected MPa above 0")
        if not 0.0 <= self.poisson < 0.5:
            raise SceneError(f"material Poisson's ratio: found {self.poisson!r}, expected 0 up to 0.5")
        if not callable(self.hardening):
            raise SceneError(f"material hardening: found {self.hardening!r}, expected a curve such as Swift")

    n_history = 0

    @cached_property
    def table(self):
        """Hardening curve as the kernels take it."""
        return tabulate(self.hardening)

    def prepare(self):
        """Make what the kernels need. Raises SceneError where the hardening curve is not one."""
        _ = self.table

    def new_state(self, n_points):
        """PointState of undeformed points."""
        return point_state(n_points, self.n_history)

    def update(self, metric, old, new, tangent=True, dt=None):
        """Stress of every point: fills new from its metric and the histories in old.

        metric : (p, 3) C11 C22 C12 in rolling axes
        old, new : PointState, SheetState, or anything with their arrays
        tangent : whether new.tangent = dS/dE is wanted
        dt : length of the increment [s]; None in quasi-static forming
        """
        update(
            metric, old.plastic, old.equivalent, float(self.young), float(self.poisson), float(self.locus.r),
            self.table, new.second_stress, new.tangent if tangent else NO_TANGENT, new.strain, new.plastic,
            new.equivalent, new.stress, new.thickness_strain,
        )  # fmt: skip

    def describe(self):
        """One line for the plan."""
        return f"{self.name}: {_name(self.locus)} with {_name(self.hardening)}, plane stress"

    @property
    def initial_yield_stress(self):
        """MPa."""
        return float(np.asarray(self.hardening(np.zeros(1))).ravel()[0])


def _name(thing):
    return (
        repr(thing)
        if hasattr(type(thing), "__dataclass_fields__")
        else getattr(thing, "__name__", type(thing).__name__)
    )
