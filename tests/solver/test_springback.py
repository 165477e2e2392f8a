"""Bending by edge moments and springback, against the exact section (benchmarks.md K)."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm

from solver import Blank, Coulomb, Material, Membrane, PlanarHill, Scene, SceneError, Shell, Stage, Swift, Tool, form
from solver.springback import fitted, free_motions, least_supports
from tests.solver.lattice import Bar, square

STEEL = Material(206000.0, 0.3, PlanarHill(1.77), Swift(565.32, 0.007117, 0.2589), "mild steel")
THICKNESS = 0.78


def strip(length, width, n, distort=0.0):
    """Strip on [0, length] x [0, width]: symmetry at x = 0, plane strain by symmetry at both long sides."""
    mesh = square(n, 1.0, distort)
    groups = mesh.groups | {"symmetry_y": np.concatenate([mesh.groups["symmetry_y"], mesh.groups["top"]])}
    return SimpleNamespace(points=mesh.points * [length, width, 1.0], cells=mesh.cells, groups=groups)


def section_moment(curvature, n=400):
    """Moment [N] of the plane-strain section bent in one go, by fine quadrature of the material alone."""
    place, weight = np.polynomial.legendre.leggauss(n)
    old, new = STEEL.new_state(n), STEEL.new_state(n)
    z = 0.5 * THICKNESS * place
    metric = np.column_stack([1.0 + 2.0 * z * curvature, np.ones(n), np.zeros(n)])
    STEEL.update(metric, old, new)
    return 0.5 * THICKNESS * np.sum(weight * z * new.second_stress[:, 0])


def bent_strip(moment, layers, distort=0.0):
    blank = Blank(strip(6.0, 3.0, 6, distort), THICKNESS, STEEL, Shell(layers), fixed={"all": "y", "symmetry_x": "z"})
    stages = [Stage(moments={"right": moment}, name="bend"), Stage(name="springback")]
    return form(Scene(blank, stages), frames=4)


def curvature_of(points):
    """Curvature of the circle through the strip's nodes, positive where the top is stretched."""
    x, z = points[:, 0], points[:, 2]
    a = np.column_stack([2.0 * x, 2.0 * z, np.ones(len(x))])
    centre_x, centre_z, rest = np.linalg.lstsq(a, x**2 + z**2, rcond=None)[0]
    return -np.sign(centre_z - z.mean()) / np.sqrt(rest + centre_x**2 + centre_z**2)


@pytest.mark.parametrize("distort", [0.0, 0.25])
def test_bending_and_springback_of_a_strip(distort):
    # Radius 50 in plane strain, r = 1.77: M = 35.5701 N bends it there, released it keeps 62.3961 (benchmarks.md K).
    results = bent_strip(35.5701, layers=31, distort=distort)
    bent, free = (curvature_of(results.frames[k].points) for k in (4, -1))
    # The section is soft in tension of its top layers: a moment of 1 % is a curvature of 4 %. Compare moments.
    assert section_moment(bent) == pytest.approx(35.5701, rel=5e-3)
    assert section_moment(1.0 / 50.0) == pytest.approx(35.5701, rel=3e-3)
    relieved = 12.0 * (1.0 - 0.3**2) * 35.5701 / (206000.0 * THICKNESS**3)
    assert bent - free == pytest.approx(relieved, rel=5e-3)
    fields = results.frames[4].cell_fields
    assert fields["curvature"][:, 0] == pytest.approx(bent, rel=0.02)
    assert fields["section_moment"][:, 0] == pytest.approx(35.5701, rel=1e-2)
    assert np.abs(results.frames[-1].cell_fields["section_moment"][:, 0]).max() < 0.1


def test_fewer_layers_err_as_their_quadrature_does():
    # theory_shell.md 8: at R/t from 10 to 100 the moment of 7 Legendre points is 1.4 to 2.0 % low.
    bent = curvature_of(bent_strip(35.5701, layers=7).frames[4].points)
    assert 1.013 < section_moment(bent) / 35.5701 < 1.023


def test_a_strip_springs_back_from_a_die_and_its_forces_vanish():
    mesh = strip(20.0, 4.0, 10)
    blank = Blank(mesh, 1.0, STEEL, Shell(9), fixed={"all": "y"})
    tools = [
        Tool("PUNCH", Bar((0.0, 0.0, 6.0), 5.0), Coulomb(0.1), travel=-6.0),
        Tool("POST", Bar((14.0, 0.0, -4.5), 4.0), Coulomb(0.1)),
    ]
    results = form(Scene(blank, [Stage(tools), Stage(name="springback")]), frames=3)
    formed, free = results.frames[3], results.frames[-1]
    assert formed.stage == "draw" and free.stage == "springback"
    assert results.history["force_PUNCH"][-1] == 0.0
    opened = np.ptp(formed.points[:, 2]) - np.ptp(free.points[:, 2])
    assert 0.05 < opened < 0.9 * np.ptp(formed.points[:, 2])
    # Through the thickness the section carries no moment any more, but residual stress.
    assert np.abs(free.cell_fields["stress_top"][:, 0]).max() > 20.0


def test_least_supports_hold_what_is_free():
    x = np.random.default_rng(1).uniform(size=(20, 3)) * [10.0, 5.0, 1.0]
    fixed = np.zeros((20, 3), dtype=bool)
    nodes, axes = least_supports(x, fixed, [], False)
    assert len(nodes) == 6
    fixed[:, 0] = fixed[:, 1] = True  # all but the rise along z
    nodes, axes = least_supports(x, fixed, [], False)
    assert list(axes) == [2]
    fixed[:] = False
    nodes, axes = least_supports(x, fixed, [0, 1], False)  # a quarter on no tool may rise, and slide where not fixed
    assert len(axes) == 3
    fixed[:] = True
    assert len(least_supports(x, fixed, [], False)[0]) == 0


@pytest.mark.parametrize("supports", ["none", "one node", "plane", "plane strain", "all"])
def test_a_part_is_fitted_as_far_as_its_supports_let_it(supports):
    random = np.random.default_rng(4)
    before = random.uniform(size=(40, 3)) * [10.0, 6.0, 2.0]
    fixed, planes = np.zeros((40, 3), dtype=bool), []
    if supports == "one node":
        fixed[7] = True
    if supports == "plane":
        before[:5, 0], fixed[:5, 0], planes = 0.0, True, [0]
    if supports == "plane strain":
        fixed[:, 1] = True
    if supports == "all":
        fixed[:] = True
    # A motion that is free, and not small: that of its field of velocities.
    motions, free = free_motions(before, fixed, planes, False)
    twist = free @ random.uniform(0.2, 0.6, free.shape[1])
    field = np.linalg.lstsq(np.column_stack([before, np.ones(40)]), motions @ twist, rcond=None)[0]
    flow = expm(np.hstack([field, np.zeros((4, 1))]))
    x = (np.column_stack([before, np.ones(40)]) @ flow)[:, :3]
    assert x[fixed] == pytest.approx(before[fixed], abs=1e-12)
    weight = random.uniform(0.5, 1.5, 40)
    assert fitted(x, before, weight, fixed, planes, False) == pytest.approx(before, abs=1e-9)
    # A part that is also bent goes where no free motion brings it nearer, as rigidly.
    bent = x + 0.02 * np.where(fixed, 0.0, x[:, [2, 0, 1]] ** 2)
    fit = fitted(bent, before, weight, fixed, planes, False)
    assert fit[fixed] == pytest.approx(bent[fixed], abs=1e-12)
    assert np.linalg.norm(fit[1:] - fit[0], axis=1) == pytest.approx(np.linalg.norm(bent[1:] - bent[0], axis=1))
    motions, free = free_motions(fit, fixed, planes, False)
    pull = np.einsum("n,nc,ncj->j", weight, before - fit, motions @ free)
    assert pull == pytest.approx(np.zeros(free.shape[1]), abs=1e-8)


def test_moments_need_the_free_edge_of_a_shell():
    mesh = strip(6.0, 3.0, 4)
    scene = Scene(Blank(mesh, 1.0, STEEL, Membrane()), [Stage(moments={"right": 1.0})])
    with pytest.raises(SceneError, match="no free edge of a shell"):
        form(scene)
