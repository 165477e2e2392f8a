"""A sheet material: elasticity, a yield locus and a hardening curve, freely combined."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .planar_hill import PlanarHill


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

    @property
    def initial_yield_stress(self):
        """MPa."""
        return float(np.asarray(self.hardening(np.zeros(1))).ravel()[0])
