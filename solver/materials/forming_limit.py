"""Forming limit curves, and how far a strain state is from one.

A curve gives the major logarithmic strain at which a sheet necks, for each minor one. It may be tabulated, follow the
rule of Keeler, Brazier and NADDRG, the closed forms of Hill and Swift, or be computed by the groove model of
Marciniak and Kuczynski (`marciniak.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError


@dataclass(frozen=True)
class LimitCurve:
    """Straight lines through points; beyond the ends the outer lines go on.

    minor, major : logarithmic strains, minor rising
    """

    minor: Sequence[float]
    major: Sequence[float]
    name: str = "forming limit"

    def __post_init__(self):
        minor, major = np.asarray(self.minor, dtype=float), np.asarray(self.major, dtype=float)
        if minor.ndim != 1 or minor.shape != major.shape or len(minor) < 2:
            raise SceneError("forming limit curve: expected two lists of equal length, at least two points")
        if not (np.isfinite(minor).all() and (np.diff(minor) > 0.0).all()):
            raise SceneError("forming limit curve: expected minor strains that rise")
        if not (np.isfinite(major).all() and (major > 0.0).all()):
            raise SceneError(f"forming limit curve: found major strain {major.min()}, expected values above 0")

    def __call__(self, minor):
        """Major strain at the limit, like minor."""
        minor = np.asarray(minor, dtype=float)
        x, y = np.asarray(self.minor, dtype=float), np.asarray(self.major, dtype=float)
        inside = np.interp(minor, x, y)
        before = y[0] + (minor - x[0]) * (y[1] - y[0]) / (x[1] - x[0])
        after = y[-1] + (minor - x[-1]) * (y[-1] - y[-2]) / (x[-1] - x[-2])
        return np.where(minor < x[0], before, np.where(minor > x[-1], after, inside))

    @classmethod
    def from_engineering(cls, minor, major, name="forming limit"):
        """From engineering strains (0.2 is 20 %)."""
        return cls(np.log1p(minor), np.log1p(major), name)


@dataclass(frozen=True)
class KeelerBrazier:
    """The NADDRG rule for low-carbon steels: FLC0 [% engineering] = (23.3 + 14.13 t) n/0.21 with n at most 0.21.

    Left of plane strain the thickness strain stays constant, right of it the engineering strains rise by 0.6.
    thickness : mm, up to 3.1; n : strain-hardening exponent
    """

    thickness: float
    n: float
    name: str = "Keeler-Brazier (NADDRG)"

    def __post_init__(self):
        if not 0.0 < self.thickness <= 3.1:
            raise SceneError(f"Keeler-Brazier thickness: found {self.thickness!r}, expected mm above 0, at most 3.1")
        if not (np.isfinite(self.n) and self.n > 0.0):
            raise SceneError(f"Keeler-Brazier n: found {self.n!r}, expected a number above 0")

    @property
    def plane_strain(self):
        """FLC0, an engineering strain."""
        return (23.3 + 14.13 * self.thickness) * min(self.n, 0.21) / 0.21 / 100.0

    def __call__(self, minor):
        """Major strain at the limit, like minor; logarithmic."""
        minor = np.asarray(minor, dtype=float)
        right = np.log1p(self.plane_strain + 0.6 * np.expm1(np.maximum(minor, 0.0)))
        return np.where(minor < 0.0, np.log1p(self.plane_strain) - minor, right)


def hill_local(n, ratio):
    """Major strain at Hill's local necking, n/(1 + ratio), for ratios minor/major up to 0 and any r (Hollomon)."""
    return n / (1.0 + np.asarray(ratio, dtype=float))


def swift_diffuse(n, ratio):
    """Major strain at Swift's diffuse necking, von Mises and Hollomon. ratio : minor/major strain"""
    ratio = np.asarray(ratio, dtype=float)
    a = (2.0 * ratio + 1.0) / (2.0 + ratio)  # ratio of stresses
    shape = 1.0 - a + a * a
    equivalent = n * 4.0 * shape**1.5 / ((1.0 + a) * (4.0 - 7.0 * a + 4.0 * a * a))
    return equivalent * (2.0 - a) / (2.0 * np.sqrt(shape))


def fld_margin(curve, major, minor):
    """How far strains are from the limit: 1 unstrained, 0 on the curve, negative beyond it.

    The distance in major strain at the same minor strain, over the limit there.
    curve : LimitCurve, KeelerBrazier, or any function of the minor strain; major, minor : (m,) logarithmic strains
    """
    limit = np.maximum(np.asarray(curve(minor), dtype=float), 1e-6)
    return 1.0 - np.asarray(major, dtype=float) / limit
