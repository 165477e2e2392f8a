"""Material parameters from tensile tests: true stress and plastic strain, hardening curves, r-values.

The curve is read between the onset of flow and uniform elongation (the largest force), where a tensile test is still
uniaxial. Hardening curves are fitted by least squares of the relative error in stress.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .hardening import HockettSherby, Swift, Voce

KINDS = ("swift", "voce", "hockett_sherby")


@dataclass(frozen=True)
class Flow:
    """Plastic strain (k,) rising from near 0 and true stress (k,) [MPa] up to uniform elongation; young [MPa]."""

    plastic: np.ndarray
    stress: np.ndarray
    young: float


@dataclass(frozen=True)
class Fit:
    """curve : hardening curve; error : root mean square of its relative error in stress"""

    curve: object
    error: float


def flow_curve(strain, stress, *, true=False, young=None, offset=0.002):
    """Flow from a tensile test.

    strain : (n,), stress : (n,) [MPa]; engineering values, or true ones where `true`
    young : MPa; by default the slope between a tenth and a half of the stress at `offset`
    offset : plastic strain at which flow starts to count
    Raises SceneError where the columns are no tensile test.
    """
    strain, stress = np.asarray(strain, dtype=float), np.asarray(stress, dtype=float)
    if strain.ndim != 1 or strain.shape != stress.shape or len(strain) < 10:
        raise SceneError("tensile test: expected strain and stress of equal length, at least ten rows")
    if not (np.isfinite(strain).all() and np.isfinite(stress).all()):
        raise SceneError("tensile test: found values that are no numbers")
    if strain.max() <= 0.0 or stress.max() <= 0.0:
        raise SceneError("tensile test: found no tension; strain is a ratio (0.2 is 20 %) and stress MPa, both above 0")
    if strain.max() > 3.0:
        raise SceneError(f"tensile test: found a strain of {strain.max():g}, expected a ratio (0.2 is 20 %)")
    engineering = stress * np.exp(-strain) if true else stress
    last = int(np.argmax(engineering)) + 1
    strain, stress = strain[:last], stress[:last]
    if not true:
        strain, stress = np.log1p(strain), stress * (1.0 + strain)
    young = young or elastic_slope(strain, stress)
    plastic = strain - stress / young
    # From where the plastic strain leaves the noise of the elastic part for good.
    first = len(plastic) - int(np.argmax(plastic[::-1] < offset)) if (plastic < offset).any() else 0
    keep = np.arange(first, last)
    keep = keep[np.concatenate([[True], np.diff(np.maximum.accumulate(plastic[keep])) > 0.0])] if len(keep) else keep
    if len(keep) < 5:
        raise SceneError(
            f"tensile test: found {len(keep)} points between a plastic strain of {offset:g} and the largest force"
        )
    return Flow(plastic[keep], stress[keep], float(young))


def elastic_slope(strain, stress):
    """Young's modulus [MPa] from the start of a test: the slope between 10 and 50 % of the early yield stress."""
    early = strain <= strain[0] + 0.01
    limit = 0.6 * stress[early].max()
    part = np.flatnonzero(early & (stress >= 0.1 * limit) & (stress <= 0.7 * limit))
    part = part[part < int(np.argmax(stress > limit))]
    if len(part) < 3:
        raise SceneError("tensile test: fewer than three points in the elastic part; give Young's modulus")
    return float(np.polyfit(strain[part], stress[part], 1)[0])


def fit_curve(kind, flow):
    """Hardening curve of a kind ("swift", "voce" or "hockett_sherby") fitted to a Flow. Returns Fit."""
    from scipy.optimize import least_squares

    if kind not in KINDS:
        raise SceneError(f"hardening curve {kind!r}: expected one of {', '.join(KINDS)}")
    p, s = flow.plastic, flow.stress
    first, last = float(s[0]), float(s.max())
    rise = max(last - first, 1e-3 * last)
    # Unknowns as logarithms, so that every try is a curve.
    starts = {
        "swift": [(last * 1.5, 0.005, 0.2), (last * 1.3, 0.02, 0.1), (last * 2.0, 0.005, 0.4)],
        "voce": [(first, rise, 10.0), (first, 1.5 * rise, 4.0), (first, rise, 30.0)],
        "hockett_sherby": [(first, rise, 5.0, 0.8), (0.9 * first, 1.5 * rise, 3.0, 0.6), (first, rise, 15.0, 1.0)],
    }[kind]

    def make(x):
        values = [float(value) for value in np.exp(x)]
        if kind == "swift":
            return Swift(values[0], values[1], min(values[2], 0.999))
        if kind == "voce":
            return Voce(*values)
        return HockettSherby(values[0], values[0] + values[1], *values[2:])

    tries = [
        least_squares(
            lambda x: make(x)(p) / s - 1.0, np.log(start), bounds=(-25.0, 12.0), xtol=1e-14, ftol=1e-14, gtol=1e-14,
            max_nfev=2000,
        )
        for start in starts
    ]  # fmt: skip
    best = min(tries, key=lambda found: found.cost)
    return Fit(make(best.x), float(np.sqrt(np.mean(best.fun**2))))


def r_value(strain, width_strain, stress=None, young=None, low=0.05, high=0.15, poisson=0.3):
    """r-value: slope of the plastic width strain over the plastic thickness strain.

    strain, width_strain : (n,) logarithmic strains along and across the pull; low, high : the strains used
    stress, young : MPa, to take the elastic strains off; left in where they are not given
    Raises SceneError where there are too few points.
    """
    strain, width = np.asarray(strain, dtype=float), np.asarray(width_strain, dtype=float)
    part = (strain >= low) & (strain <= high)
    if part.sum() < 3:
        raise SceneError(
            f"r-value: found {part.sum()} points at strains from {low:g} to {high:g}, expected three or more"
        )
    elastic = np.asarray(stress, dtype=float) / young if stress is not None and young else np.zeros_like(strain)
    along, across = (strain - elastic)[part], (width + poisson * elastic)[part]
    slope = float(np.polyfit(along, across, 1)[0])
    if not -1.0 < slope < 0.0:
        raise SceneError(f"r-value: found a width strain of {slope:.3g} per strain along, expected between -1 and 0")
    return -slope / (1.0 + slope)
