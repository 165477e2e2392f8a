"""The normal force of a node by its trial force, and what metal between two tools bears at most (theory.md 6).

Symbols, of a node: f trial force and g its law, the positive part rounded over a band |f| < kn h [N] (h skin [mm]);
N force that presses it, A its area, t thickness of its elements, s what it gives way in an increment [mm];
F(s) = A p(e + s/t) with p the sheet's flow pressure (materials/through_thickness.py) at the equivalent plastic strain
e: what it is pressed thinner hardens it by s/t, as it does von Mises' metal.

What gives way half to either tool takes from both, N = g(f - kn s/2). Beyond F(0) metal between two tools flows by
the s with N = F(s).
"""

from typing import NamedTuple

import numpy as np
from numba import njit

EASE = 0.005  # of the contact's stiffness, that is left of it beside the hardening of metal that flows
TRIES, EXACT = 30, 1e-12  # of the search for s; relative to the force


class Flow(NamedTuple):
    """How n nodes flow.

    strain (n,): e; thickness (n,): t [mm]; area (n,): A [mm^2], inf of nodes that no two tools touch
    strains (k,), pressures (k,) [MPa]: the flow pressure over the equivalent plastic strain
    """

    strain: np.ndarray
    thickness: np.ndarray
    area: np.ndarray
    strains: np.ndarray
    pressures: np.ndarray

    @property
    def force(self):
        """F(0) of the nodes, (n,) [N]."""
        return np.interp(self.strain, self.strains, self.pressures) * self.area


def no_flow(n):
    """Flow of n nodes that no two tools touch."""
    return Flow(np.zeros(n), np.ones(n), np.full(n, np.inf), np.zeros(1), np.ones(1))


@njit(forceinline=True)
def elastic_force(trial, band, held):
    """g [N] and its slope. trial : f, band [N]; held : the node may pull at its tool"""
    if trial <= -band:
        return (trial + band, 1.0) if held else (0.0, 0.0)
    if trial < band:
        return (trial + band) ** 2 / (4.0 * band), 0.5 * (trial + band) / band
    return trial, 1.0


def normal_slope(trial, band, held):
    """Slope of g, arrays (n,) [N]. held : as above"""
    return np.where(held, 1.0, np.clip(0.5 * (trial + band) / band, 0.0, 1.0))


def force_of(trial, band):
    """g, arrays (n,) [N]."""
    return np.where(trial >= band, trial, np.maximum(trial + band, 0.0) ** 2 / (4.0 * band))


def trial_of(force, band):
    """Where g has a force, arrays (n,) [N]: its inverse, and -band where there is none."""
    return np.where(force > band, force, 2.0 * np.sqrt(band * np.maximum(force, 0.0)) - band)


@njit(forceinline=True)
def flow_force(flow, node, s):
    """F [N] and its slope [N/mm] at s [mm], between the points of the curve a straight line."""
    strain = flow.strain[node] + s / flow.thickness[node]
    k = np.searchsorted(flow.strains, strain, side="right")
    if k == 0 or k == len(flow.strains):
        return flow.area[node] * flow.pressures[max(k - 1, 0)], 0.0
    rise = (flow.pressures[k] - flow.pressures[k - 1]) / (flow.strains[k] - flow.strains[k - 1])
    pressure = flow.pressures[k - 1] + rise * (strain - flow.strains[k - 1])
    return flow.area[node] * pressure, flow.area[node] * rise / flow.thickness[node]


@njit(forceinline=True)
def normal_law(trial, band, kn, held, flow, node):
    """N [N] and its slope by the trial force [N]. kn [N/mm]; flow : Flow"""
    force, slope = elastic_force(trial, band, held)
    if flow.area[node] == np.inf:
        return force, slope
    bears, hardens = flow_force(flow, node, 0.0)
    if force <= bears:
        return force, slope
    # Newton's method: what is borne never falls with s, and what presses does.
    s, presses, gives = 0.0, force, slope
    for _ in range(TRIES):
        if abs(presses - bears) <= EXACT * force:
            break
        s += (presses - bears) / (hardens + 0.5 * kn * gives)
        bears, hardens = flow_force(flow, node, s)
        presses, gives = elastic_force(trial - 0.5 * kn * s, band, False)
    part = hardens * gives / (hardens + 0.5 * kn * gives)
    return bears + EASE * (force - bears), part + EASE * (slope - part)
