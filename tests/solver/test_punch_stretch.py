"""Stretching by a hemispherical punch with friction, where a membrane is honest: against an axisymmetric solution
(benchmarks.md F.2, WB_mu017), and against itself with half the torsion stiffness."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cadlink import Disc, mesh_blank
from solver import Blank, Coulomb, Implicit, Increments, Material, Membrane, Scene, Stage, Swift, Tool, VonMises, form
from tests.solver.lattice import Ball

THICKNESS, CLAMP, SHOULDER, PUNCH = 0.85, 59.18, 6.35, 50.8
# sigma = 510 (0.00535677 + ep)^0.210084, E = 206800, r = 1, mu = 0.17 on punch and die
STEEL = Material(206800.0, 0.3, VonMises(), Swift(510.0, 0.00535677, 0.210084), "WB steel")
FORCE = {10.0: 7170.0, 20.0: 22770.0, 30.0: 42660.0}
POLE = {10.0: -0.0630, 20.0: -0.1594, 30.0: -0.2842}


class Ring:
    """A torus about z, solid inside."""

    def __init__(self, radius, tube, height):
        self.radius, self.tube, self.height = radius, tube, height

    def project(self, points, seed=None):
        rho = np.hypot(points[:, 0], points[:, 1])
        axis = rho == 0.0
        out = np.column_stack([points[:, 0] + axis, points[:, 1], 0.0 * rho]) / (rho + axis)[:, None]
        spine = self.radius * out + [0.0, 0.0, self.height]
        away = points - spine
        size = np.linalg.norm(away, axis=1)
        normal = away / size[:, None]
        foot = spine + self.tube * normal
        cos = np.sum(normal * out, axis=1)
        around = np.column_stack([-out[:, 1], out[:, 0], np.zeros(len(points))])
        return SimpleNamespace(
            distance=size - self.tube,
            point=foot,
            normal=normal,
            curvature=np.column_stack([cos / (self.radius + self.tube * cos), np.full(len(points), 1.0 / self.tube)]),
            direction=around,
            face=np.zeros(len(points), int),
            seed=np.zeros(len(points), int),
        )


def quarter(size):
    return mesh_blank(Disc(CLAMP), size, arrangement="structured", symmetry=("x", "y"))


def stretched(size, travel, method):
    """The punch stretches the sheet over the shoulder; the reference's radii are those of the mid-surface."""
    blank = Blank(quarter(size), THICKNESS, STEEL, Membrane(), fixed={"rim": "xyz"})
    oil, half = Coulomb(0.17), 0.5 * THICKNESS
    punch = Tool("PUNCH", Ball((0.0, 0.0, PUNCH + 5.0), PUNCH - half), oil, travel=-travel)
    die = Tool("DIE", Ring(CLAMP, SHOULDER - half, -SHOULDER), oil)
    return form(Scene(blank, [Stage([punch, die])]), method, frames=int(travel / 5.0))


def test_force_thickness_and_half_the_torsion_stiffness():
    method = Implicit(increments=Increments(largest=0.1))
    full, half = (stretched(4.0, 10.0, m) for m in (method, replace(method, torsion=0.5 * method.torsion)))
    assert full.at("force_PUNCH", 10.0) == pytest.approx(FORCE[10.0], rel=0.03)
    for stroke in (5.0, 10.0):
        assert half.at("force_PUNCH", stroke) == pytest.approx(full.at("force_PUNCH", stroke), rel=1e-3)
    a, b = (r.frames[-1].cell_fields["thickness"] for r in (full, half))
    assert b == pytest.approx(a, rel=1e-3)


@pytest.mark.slow
def test_force_and_pole_to_30_mm():
    method = Implicit(increments=Increments(largest=0.2))
    full, half = (stretched(2.5, 30.0, m) for m in (method, replace(method, torsion=0.5 * method.torsion)))
    cells = np.asarray(quarter(2.5).cells)
    for frame, other in zip(full.frames[1:], half.frames[1:]):
        assert half.at("force_PUNCH", frame.stroke) == pytest.approx(full.at("force_PUNCH", frame.stroke), rel=1e-3)
        assert other.cell_fields["thickness"] == pytest.approx(frame.cell_fields["thickness"], rel=1e-3)
        stroke = round(frame.stroke, 6)
        if stroke in FORCE:
            assert full.at("force_PUNCH", stroke) == pytest.approx(FORCE[stroke], rel=0.015)
            pole = np.argmin(np.linalg.norm(full.frames[0].points[:, :2], axis=1))
            near = (cells == pole).any(axis=1)
            strain = np.log(frame.cell_fields["thickness"][near] / THICKNESS)
            assert strain == pytest.approx(POLE[stroke], abs=0.008)
