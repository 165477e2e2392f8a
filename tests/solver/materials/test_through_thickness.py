"""The pressure under which a sheet flows across its thickness, against closed forms."""

import numpy as np
import pytest

from solver import Hill48, Material, PlanarHill, Swift, VonMises, YoshidaUemori
from solver.materials.law import Law
from solver.materials.through_thickness import flow_pressure

CURVE = Swift(565.32, 0.007117, 0.2589)


@pytest.mark.parametrize("r", [0.6, 1.0, 1.77])
def test_a_planar_isotropic_sheet_flows_under_its_equibiaxial_stress(r):
    """Hill: sqrt((1 + r)/2) times the yield stress, and by its work an equivalent strain of 2 h sqrt((1 + r)/2) under
    the strains h."""
    strain, pressure = flow_pressure(Material(206000.0, 0.3, PlanarHill(r), CURVE))
    assert strain[0] == 0.0
    assert strain[-1] == pytest.approx(2.0 * 0.99 * np.sqrt(0.5 * (1.0 + r)), rel=5e-3)  # less its elastic part
    later = strain > 1e-3
    assert pressure[later] == pytest.approx(np.sqrt(0.5 * (1.0 + r)) * CURVE(strain[later]), rel=1e-9)
    assert pressure[0] == pytest.approx(np.sqrt(0.5 * (1.0 + r)) * CURVE(np.zeros(1))[0], rel=0.01)


def test_a_sheet_of_three_r_values_flows_between_what_its_directions_say():
    _, pressure = flow_pressure(Material(206000.0, 0.3, Hill48(1.79, 1.51, 2.27), CURVE))
    stress = CURVE(np.zeros(1))[0]
    assert np.sqrt(0.5 * 2.51) * stress < pressure[0] < np.sqrt(0.5 * 3.27) * stress


def test_a_surface_that_moves_hardens_up_to_its_bounding_surface():
    law = YoshidaUemori(Y=124.0, B=168.0, C=500.0, R_sat=190.0, m=12.0, b=9.0, h=0.5)
    strain, pressure = flow_pressure(Material(206000.0, 0.3, VonMises(), law))
    assert pressure[0] == pytest.approx(law.Y, rel=0.02)
    assert np.interp(1.9, strain, pressure) == pytest.approx(law.B + law.R_sat + law.b, rel=1e-3)
    assert (np.diff(pressure) > -1e-6).all()


def test_what_does_not_yield_does_not_flow():
    class Rubber(Law):
        young, initial_yield_stress = 100.0, 10.0

        def respond(self, strain, old, new, dt):
            stiffness = self.young / 0.75 * np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.25]])
            new.stress[:] = strain @ stiffness
            new.thickness_strain[:] = -strain[:, 0] - strain[:, 1]
            return np.broadcast_to(stiffness, (len(strain), 3, 3))

    strain, pressure = flow_pressure(Rubber())
    assert strain == [0.0] and pressure == [np.inf]
