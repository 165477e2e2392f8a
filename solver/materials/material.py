"""A sheet material: elasticity, a yield locus and a hardening law, freely combined."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import SceneError
from .hardening import tabulate
from .isotropic import CurveData
from .law import NO_TANGENT, point_state
from .modulus import DecayingModulus, Elastic
from .quadratic import Quadratic
from .quadratic_return import modes_of
from .rate import rate_data
from .update import update_points
from .yield_locus import LOCI, warn_unless_convex


@dataclass(frozen=True)
class Material:
    """Elastic-plastic sheet.

    young : Young's modulus [MPa]
    poisson : Poisson's ratio
    locus : VonMises(), PlanarHill(r), Hill48, Vegter, Yld2000 or Hill90, in rolling axes
    hardening : callable, equivalent plastic strain (n,) -> yield stress (n,) [MPa]; Swift, Voce, Ludwik,
        HockettSherby, Table, Sum, or any function. Or Chaboche, ArmstrongFrederick, YoshidaUemori, TwoSurface,
        which move the yield surface too
    name : heads reports
    rate : CowperSymonds or PowerLawRate; counts where increments have a length in time
    modulus : DecayingModulus where unloading shows a modulus that falls with plastic strain
    density : tonne/mm^3, that of steel; quasi-static forming does not depend on it
    """

    young: float
    poisson: float
    locus: Any
    hardening: Callable | Any
    name: str = "sheet"
    rate: Any = None
    modulus: DecayingModulus | None = None
    density: float = 7.85e-9

    def __post_init__(self):
        if not (np.isfinite(self.young) and self.young > 0.0):
            raise SceneError(f"material Young's modulus: found {self.young!r}, expected MPa above 0")
        if not 0.0 <= self.poisson < 0.5:
            raise SceneError(f"material Poisson's ratio: found {self.poisson!r}, expected 0 up to 0.5")
        if not (np.isfinite(self.density) and self.density > 0.0):
            raise SceneError(
                f"material density: found {self.density!r}, expected tonne/mm^3 above 0, as 7.85e-9 of steel"
            )
        if not isinstance(self.locus, LOCI):
            raise SceneError(f"material locus: found {self.locus!r}, expected a yield locus such as VonMises()")
        if not (callable(self.hardening) or hasattr(self.hardening, "data")):
            raise SceneError(f"material hardening: found {self.hardening!r}, expected a curve such as Swift")
        if self.rate is not None and not hasattr(self.rate, "data"):
            raise SceneError(f"material rate: found {self.rate!r}, expected a factor such as CowperSymonds")
        if self.modulus is not None and not isinstance(self.modulus, DecayingModulus):
            raise SceneError(f"material modulus: found {self.modulus!r}, expected DecayingModulus")
        if self.modulus is not None and self.modulus.E_a > self.young:
            raise SceneError(f"modulus E_a: found {self.modulus.E_a!r}, expected at most young = {self.young!r} MPa")

    @property
    def moves(self):
        """Whether the yield surface moves: kinematic or mixed hardening."""
        return hasattr(self.hardening, "data")

    @property
    def n_history(self):
        """Columns of the history beside plastic and equivalent strain."""
        return self.hardening.n_history if self.moves else 0

    @property
    def one_equation(self):
        """Whether a point's return map is one scalar equation."""
        return isinstance(self.locus, Quadratic) and not self.moves and self.modulus is None

    @cached_property
    def elastic(self):
        """Elasticity as the kernels take it."""
        lost, xi = (self.young - self.modulus.E_a, self.modulus.xi) if self.modulus else (0.0, 0.0)
        return Elastic(float(self.young), float(self.poisson), float(lost), float(xi))

    @cached_property
    def law(self):
        """Hardening as the kernels take it."""
        return self.hardening.data() if self.moves else CurveData(tabulate(self.hardening))

    @cached_property
    def shape(self):
        """Yield locus as the kernels take it: modes where one scalar equation is enough."""
        if self.one_equation:
            return modes_of(self.locus.matrix, self.young, self.poisson)
        return self.locus.data()

    def prepare(self):
        """Make what the kernels need. Raises SceneError where the hardening curve is not one; warns where the locus is
        not convex."""
        _ = self.law, self.shape
        warn_unless_convex(self.locus)

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
        update_points(
            *self.compiled(dt), metric, old.plastic, old.equivalent, old.history, new.second_stress,
            new.tangent if tangent else NO_TANGENT, new.strain, new.plastic, new.equivalent, new.history, new.stress,
            new.thickness_strain,
        )  # fmt: skip

    def compiled(self, dt=None):
        """The law as the kernels take it: locus, hardening, rate, elasticity. dt : length of the increment [s]"""
        return self.shape, self.law, rate_data(self.rate, dt), self.elastic

    def describe(self):
        """One line for the plan."""
        rate = f" and {_name(self.rate)}" if self.rate is not None else ""
        modulus = f", modulus falling to {self.modulus.E_a:g} MPa" if self.modulus else ""
        return f"{self.name}: {_name(self.locus)} with {_name(self.hardening)}{rate}{modulus}, plane stress"

    @property
    def initial_yield_stress(self):
        """MPa."""
        if self.moves:
            return self.hardening.initial_yield_stress
        return float(np.ravel(self.hardening(np.zeros(1)))[0])


def _name(thing):
    return (
        repr(thing)
        if hasattr(type(thing), "__dataclass_fields__")
        else getattr(thing, "__name__", type(thing).__name__)
    )
