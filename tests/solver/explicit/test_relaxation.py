"""Dynamic relaxation: stages in which nothing travels, brought to rest against closed forms and the implicit solver."""

from types import SimpleNamespace

import numpy as np
import pytest

from solver import Blank, Coulomb, Explicit, Implicit, Material, Membrane, Scene, Shell, Stage, Tool, VonMises, form
from tests.solver.explicit.patch import elastic
from tests.solver.lattice import Bar, Plane
from tests.solver.resuming import interrupted
from tests.solver.strips import flat_strip
from tests.solver.test_form import STEEL
from tests.solver.test_springback import STEEL as MILD
from tests.solver.test_springback import THICKNESS, curvature_of, strip

G = 9810.0
RELAX = Explicit(relax=True)


class After(SimpleNamespace):
    """One method in the first stage, another in those after it."""

    def describe(self):
        return "mixed"

    def of(self, stage):
        return self.first if stage.name == "first" else self.then


def balanced(results):
    """Whether the energies add up, the work of damping among them."""
    size = abs(results.energy["external"]) + abs(results.energy["internal"])
    return abs(results.energy["imbalance"]) < 1e-3 * size


def test_a_bent_strip_springs_back_as_its_section_does():
    blank = Blank(strip(6.0, 3.0, 6), THICKNESS, MILD, Shell(7), fixed={"all": "y", "symmetry_x": "z"})
    scene = Scene(blank, [Stage(moments={"right": 35.5701}, name="first"), Stage(name="springback")])
    both = [form(scene, After(first=Implicit(), then=then), frames=2) for then in (RELAX, Implicit())]
    change = [curvature_of(r.frames[2].points) - curvature_of(r.frames[-1].points) for r in both]
    # Relieved of its moment the section unbends by 12 (1 - nu^2) M / (E t^3).
    assert change[0] == pytest.approx(12.0 * (1.0 - 0.3**2) * 35.5701 / (206000.0 * THICKNESS**3), rel=0.01)
    assert change[0] == pytest.approx(change[1], rel=2e-3)
    # It does not swing over, which would make the outer layers yield back: what was at yield grows by waves alone.
    plastic = [r.frames[-1].cell_fields["plastic_strain_top"].mean() for r in both]
    assert plastic[0] == pytest.approx(plastic[1], rel=5e-3)
    assert both[0].energy["damping"] > 0.0 and balanced(both[0])
    assert any("at rest after" in note for note in both[0].notes)


@pytest.mark.parametrize("settling", [False, True])
def test_a_relaxing_stage_resumes_where_it_was(tmp_path, settling):
    # Stopped while what was in balance fades, and while the sheet comes to rest.
    blank = Blank(strip(6.0, 3.0, 6), THICKNESS, MILD, Shell(7), fixed={"all": "y", "symmetry_x": "z"})
    scene = Scene(blank, [Stage(moments={"right": 35.5701}, name="first"), Stage(name="springback")])
    whole = form(scene, RELAX, frames=2)
    stages = np.array(whole.history["stage"])
    records = np.flatnonzero(stages == stages[-1])
    last = records[-2] if settling else records[len(records) // 2]
    rest = interrupted(scene, RELAX, tmp_path / "strip.pvd", 2, lambda progress: progress.increment == last + 1)
    assert rest.history["iterations"] == whole.history["iterations"]
    assert rest.frames[-1].points == pytest.approx(whole.frames[-1].points, abs=1e-9)


def test_springback_of_a_strip_formed_explicitly_is_that_of_the_implicit_solver():
    blank = Blank(strip(20.0, 4.0, 10), 1.0, STEEL, Shell(5), fixed={"all": "y"})
    tools = [
        Tool("PUNCH", Bar((0.0, 0.0, 6.0), 5.0), Coulomb(0.1), travel=-4.0),
        Tool("POST", Bar((14.0, 0.0, -4.5), 4.0), Coulomb(0.1)),
    ]
    scene = Scene(blank, [Stage(tools), Stage(name="springback")])
    relaxed, implicit = (form(scene, method, frames=1) for method in (RELAX, Explicit()))
    # The same steps form the sheet; what is left then differs by the springback alone.
    assert np.array_equal(relaxed.frames[1].points, implicit.frames[1].points)
    way = np.abs(implicit.frames[-1].points - implicit.frames[1].points).max()
    assert way > 0.05
    assert np.abs(relaxed.frames[-1].points - implicit.frames[-1].points).max() < 0.01 * way
    assert balanced(relaxed) and relaxed.history["kinetic_share"][-1] < 1e-6


@pytest.mark.parametrize("length, thickness", [(50.0, 1.0), (100.0, 0.5)])
def test_a_cantilever_sags_under_its_weight(length, thickness):
    # q L^4 / (8 E I) is a hundredth of the length, by the density.
    mesh = flat_strip(length, 10.0, 12)
    wanted = 0.01 * length
    density = wanted * 8.0 * 206000.0 * thickness**2 / (12.0 * G * length**4)
    material = Material(206000.0, 0.0, VonMises(), lambda ep: 1e3 + 0.0 * ep, "elastic", density=density)
    blank = Blank(mesh, thickness, material, Shell(3), fixed={"all": "y"}, clamped=["back"])
    results = form(Scene(blank, [Stage(gravity=(0.0, 0.0, -G))]), RELAX, frames=1)
    assert -results.frames[-1].points[mesh.groups["front"], 2] == pytest.approx(wanted, rel=0.01)
    # Of what the weight gives, half is stored, if the load comes at once; all if it comes slowly.
    energy = results.energy
    assert 0.5 * energy["external"] * 0.99 < energy["internal"] <= energy["external"]
    assert energy["damping"] == pytest.approx(energy["external"] - energy["internal"], rel=1e-3)


def test_a_membrane_held_in_its_plane_bulges_under_pressure():
    """Nothing resists but what deflection stretches: flat, its step is that of waves that its supports hold."""
    # Elements of a strip along x, Poisson's ratio 0: E t w'^3 / 2 = p x from the middle, w = 3/4 (2 p/(E t))^1/3 L^4/3.
    length, n, thickness = 100.0, 40, 0.5
    mesh = flat_strip(length, 5.0, n)
    blank = Blank(mesh, thickness, elastic(0.0), Membrane(), fixed={"all": "xy", "front": "z"})
    pressure = 0.02**3 * 206000.0 * thickness / (2.0 * length)  # w' = 0.02 at the support
    results = form(Scene(blank, [Stage(pressure=pressure)]), RELAX, frames=1)
    found = np.abs(results.frames[-1].points[mesh.groups["back"], 2])
    assert found == pytest.approx(0.75 * 0.02 * length, rel=0.01)
    assert balanced(results)


def test_a_holder_settles_on_a_strip_and_presses_with_its_force():
    mesh = flat_strip(50.0, 10.0, 10)
    blank = Blank(mesh, 1.0, STEEL, Membrane(), fixed={"all": "y"})
    tools = [
        Tool("DIE", Plane((0.0, 0.0, -0.5), (0.0, 0.0, 1.0))),
        Tool("HOLDER", Plane((0.0, 0.0, 0.5), (0.0, 0.0, -1.0)), force=5000.0),
    ]
    results = form(Scene(blank, [Stage(tools, gravity=(0.0, 0.0, -G))]), RELAX, frames=1)
    assert results.finished
    assert results.history["force_HOLDER"][-1] == pytest.approx(5000.0, rel=2e-3)
