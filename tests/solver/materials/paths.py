"""Material points driven along paths of strain and stress, and finite differences, for the tests of materials."""

from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]


def reference(name):
    """Path of a file of the shared reference data; skips the test where it is not there."""
    for parent in (ROOT, *ROOT.parents):
        path = parent / "shared" / "reference" / "computed" / name
        if path.exists():
            return path
    pytest.skip(f"the shared reference data (reference/computed/{name}) is not beside this checkout")


def metric_of(h):
    """Metric (p, 3) of logarithmic strains (p, 3) [H11, H22, 2 H12], by closed form."""
    h = np.atleast_2d(h)
    mean, half, shear = 0.5 * (h[:, 0] + h[:, 1]), 0.5 * (h[:, 0] - h[:, 1]), 0.5 * h[:, 2]
    radius = np.hypot(half, shear)
    ratio = np.where(radius > 0.0, np.sinh(2 * radius) / np.where(radius > 0.0, radius, 1.0), 2.0)
    grown = np.exp(2 * mean)
    return np.column_stack([
        grown * (np.cosh(2 * radius) + ratio * half),
        grown * (np.cosh(2 * radius) - ratio * half),
        grown * ratio * shear,
    ])  # fmt: skip


def pull(material, strains, dt=None, old=None):
    """Uniaxial stress along the rolling direction through total logarithmic strains (k,).

    Returns (stress (k,), equivalent plastic strain (k,), last state). Newton on the strain across, with the
    tangent; a step is no longer than the increment along, as the whole change is.
    """
    old = deepcopy(old) if old else material.new_state(1)
    new = material.new_state(1)
    across, stress, equivalent = float(old.strain[0, 1]), [], []
    scale = material.initial_yield_stress
    for strain in strains:
        reach = abs(strain - float(old.strain[0, 0]))
        for _ in range(50):
            material.update(metric_of([[strain, across, 0.0]]), old, new, dt=dt)
            if abs(new.stress[0, 1]) < 1e-10 * scale:
                break
            # dT22/dH22 from dS22/dE22: a diagonal state, C22 = exp(2 H22), T22 = S22 C22.
            c = np.exp(2 * across)
            step = new.stress[0, 1] / (new.tangent[0, 1, 1] * c * c + 2 * new.stress[0, 1])
            across -= float(np.clip(step, -reach, reach))
        else:
            raise AssertionError(f"no uniaxial state at strain {strain}")
        stress.append(new.stress[0, 0])
        equivalent.append(new.equivalent[0])
        old.copy_from(new)
    return np.array(stress), np.array(equivalent), old


def tangent_errors(material, scale, n=200, seed=0, dt=None):
    """Error of dS/dE against differences of fourth order, relative to its largest entry, (n,), at random states with a
    random history behind them."""
    rng = np.random.default_rng(seed)
    at, old, new, near = (material.new_state(n) for _ in range(4))
    y = scale * rng.uniform(-1, 1, (n, 3))
    material.update(green(y), at, old, dt=dt)
    y = y + scale * rng.uniform(-1, 1, (n, 3))
    material.update(green(y), old, new, dt=dt)
    numeric, step = np.zeros((n, 3, 3)), 2e-7
    for j, e in enumerate(np.eye(3) * step):
        for steps, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
            material.update(green(y + steps * e), old, near, tangent=False, dt=dt)
            numeric[:, :, j] += weight * near.second_stress / (12 * step)
    error = np.abs(numeric - new.tangent).max(axis=(1, 2)) / np.abs(numeric).max(axis=(1, 2))
    return error, new.equivalent > old.equivalent


def green(y):
    """Metric (p, 3) of Green strains [E11, E22, 2 E12]."""
    return np.column_stack([1 + 2 * y[:, 0], 1 + 2 * y[:, 1], y[:, 2]])
