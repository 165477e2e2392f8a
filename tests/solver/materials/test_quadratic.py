"""Closed forms: reference/benchmarks.md L, theory.md 4."""

import numpy as np
import pytest

from solver import CowperSymonds, Hill48, Material, PlanarHill, SceneError, Swift, VonMises
from solver.materials.block import BLOCK
from tests.solver.materials.paths import metric_of as metric_points
from tests.solver.materials.paths import reference

E, NU = 206000.0, 0.3
CURVE = Swift(565.32, 0.007117, 0.2589)


def respond(metric, r=1.77, plastic=None, equivalent=None):
    metric = np.atleast_2d(metric).astype(float)
    material = Material(E, NU, PlanarHill(r), CURVE)
    old, new = material.new_state(len(metric)), material.new_state(len(metric))
    old.plastic[:] = 0.0 if plastic is None else plastic
    old.equivalent[:] = 0.0 if equivalent is None else equivalent
    material.update(metric, old, new)
    return (
        new.second_stress, new.tangent, new.strain, new.plastic, new.equivalent, new.stress, new.thickness_strain,
    )  # fmt: skip


def equivalent_stress(t, r):
    a, b, c = t.T
    return np.sqrt(a**2 + b**2 - 2 * r / (1 + r) * a * b + 2 * (1 + 2 * r) / (1 + r) * c**2)


def metric_of(h11, h22):
    return [np.exp(2 * h11), np.exp(2 * h22), 0.0]


@pytest.mark.parametrize("r", [0.5, 1.0, 1.77, 2.5])
@pytest.mark.parametrize("scale", [1e-4, 0.02, 0.4])
def test_tangent_matches_finite_differences(r, scale):
    rng = np.random.default_rng(3)
    for _ in range(5):
        y = scale * rng.uniform(-1, 1, 3)
        plastic, equivalent = 0.3 * scale * rng.uniform(-1, 1, (1, 3)), np.array([0.1 * scale])

        def stress(y, plastic=plastic, equivalent=equivalent):
            return respond([1 + 2 * y[0], 1 + 2 * y[1], y[2]], r, plastic, equivalent)[0][0]

        tangent = respond([1 + 2 * y[0], 1 + 2 * y[1], y[2]], r, plastic, equivalent)[1][0]
        step = 1e-6 * max(scale, 0.01)
        numeric = np.column_stack([(stress(y + step * e) - stress(y - step * e)) / (2 * step) for e in np.eye(3)])
        assert tangent == pytest.approx(numeric, rel=1e-5, abs=1e-5 * np.abs(numeric).max())
        assert tangent == pytest.approx(tangent.T, rel=1e-9, abs=1e-9 * np.abs(tangent).max())


@pytest.mark.parametrize("r", [-0.4, 0.0, 0.5, 1.0, 1.77, 5.0])
def test_return_map_ends_on_the_locus_from_a_thousand_times_yield(r):
    rng = np.random.default_rng(0)
    n = 100_000
    h = rng.standard_normal((n, 3))
    h *= (10.0 ** rng.uniform(-4, 0.18, n) / np.linalg.norm(h, axis=1))[:, None]  # log strains up to 1.5
    mean, half = 0.5 * (h[:, 0] + h[:, 1]), 0.5 * (h[:, 0] - h[:, 1])
    radius = np.hypot(half, 0.5 * h[:, 2])
    grown, ratio = np.exp(2 * mean), np.sinh(2 * radius) / radius
    metric = np.column_stack([
        grown * (np.cosh(2 * radius) + ratio * half),
        grown * (np.cosh(2 * radius) - ratio * half),
        grown * ratio * 0.5 * h[:, 2],
    ])  # fmt: skip
    _, _, strain, plastic, equivalent, t, _ = respond(metric, r)
    assert strain == pytest.approx(h, rel=1e-9, abs=1e-12)
    size, limit = equivalent_stress(t, r), CURVE(equivalent)
    yielding = equivalent > 0.0
    assert yielding.mean() > 0.7
    assert size[yielding] == pytest.approx(limit[yielding], rel=1e-8)
    assert (size[~yielding] <= limit[~yielding] * (1 + 1e-8)).all()
    assert np.isfinite(plastic).all()


def test_uniaxial_tension():
    # Total strain = s/E + ep at the yield stress s(ep); width and thickness follow r and nu.
    r, ep = 1.77, 0.2
    s = CURVE(ep)
    h1, h2 = s / E + ep, -NU * s / E - r / (1 + r) * ep
    _, _, _, _, equivalent, t, h33 = respond(metric_of(h1, h2), r)
    assert t[0] == pytest.approx([s, 0.0, 0.0], rel=1e-8, abs=1e-8 * s)
    assert equivalent[0] == pytest.approx(ep, rel=1e-8)
    assert h33[0] == pytest.approx(-NU * s / E - ep / (1 + r), rel=1e-8)


def test_plane_strain_tension_approaches_the_rigid_plastic_ratio():
    # benchmarks.md L: s11/s0 = 1.300025, s22/s11 = 0.638989 for r = 1.77; elastic strains of 0.2 % fade.
    strains = np.linspace(0.0, 0.3, 400)[1:]
    plastic, equivalent = np.zeros((1, 3)), np.zeros(1)
    for h1 in strains:
        _, _, _, plastic, equivalent, t, _ = respond(metric_of(h1, 0.0), 1.77, plastic, equivalent)
    s0 = CURVE(equivalent[0])
    assert t[0, 0] / s0 == pytest.approx(1.300025, rel=1e-5)
    assert t[0, 1] / t[0, 0] == pytest.approx(0.638989, rel=2e-3)


def test_plane_strain_of_one_proportional_stress_path():
    # Stress ratio held at r/(1+r): the plastic flow has no transverse part, only elastic strain remains.
    r, ep = 1.77, 0.25
    s1 = (1 + r) / np.sqrt(1 + 2 * r) * CURVE(ep)
    s2 = r / (1 + r) * s1
    plastic = ep * (s1 - r / (1 + r) * s2) / CURVE(ep)
    metric = metric_of((s1 - NU * s2) / E + plastic, (s2 - NU * s1) / E)
    _, _, _, hp, equivalent, t, _ = respond(metric, r)
    assert t[0] == pytest.approx([s1, s2, 0.0], rel=1e-8, abs=1e-6)
    assert equivalent[0] == pytest.approx(ep, rel=1e-8)
    assert hp[0, 1] == pytest.approx(0.0, abs=1e-9)


def test_equibiaxial_tension():
    # s_b = sqrt((1+r)/2) s0, and work gives ep = 2 s_b/s0 times the plastic strain of each direction.
    r, ep = 1.77, 0.4
    s = np.sqrt((1 + r) / 2) * CURVE(ep)
    plastic = ep * CURVE(ep) / (2 * s)
    h = (1 - NU) * s / E + plastic
    _, _, _, _, equivalent, t, h33 = respond(metric_of(h, h), r)
    assert t[0] == pytest.approx([s, s, 0.0], rel=1e-8, abs=1e-6)
    assert equivalent[0] == pytest.approx(ep, rel=1e-8)
    assert h33[0] == pytest.approx(-2 * NU * s / E - 2 * plastic, rel=1e-8)


@pytest.mark.parametrize("path", [("uniaxial", 376.0647, 0.0), ("shear", 212.9533, -212.9533)])
def test_published_proportional_paths(path):
    # benchmarks.md L: stresses at eps_1 = 0.20, rigid-plastic; here the elastic part is added to the strain.
    _, s1, s2 = path
    r = 1.77
    s0 = equivalent_stress(np.array([[s1, s2, 0.0]]), r)[0]
    ep = (s0 / CURVE.K) ** (1 / CURVE.n) - CURVE.e0
    flow = np.array([s1 - r / (1 + r) * s2, s2 - r / (1 + r) * s1]) / s0
    metric = metric_of((s1 - NU * s2) / E + ep * flow[0], (s2 - NU * s1) / E + ep * flow[1])
    assert ep * flow[0] == pytest.approx(0.2, rel=1e-5)
    assert respond(metric, r)[5][0, :2] == pytest.approx([s1, s2], rel=1e-6, abs=1e-4)


def test_r_below_minus_one_half_is_refused():
    with pytest.raises(SceneError, match="above -0.5"):
        PlanarHill(-0.6)


def hill48_rows():
    """benchmarks.md L: r0, r45, r90, F, G, H, N of each material."""
    lines = reference("hill48_points.csv").read_text().splitlines()[1:]
    return [[float(value) for value in line.rsplit(",", 22)[1:]] for line in lines]


def test_hill48_matrix_is_that_of_the_reference():
    for r0, r45, r90, f, g, h, n, *_ in hill48_rows():
        expected = [[g + h, -h, 0.0], [-h, f + h, 0.0], [0.0, 0.0, 2 * n]]
        assert Hill48(r0, r45, r90).matrix == pytest.approx(np.array(expected), abs=2e-6)


def test_hill48_with_one_r_value_is_planar_hill():
    assert Hill48(1.77, 1.77, 1.77).matrix == pytest.approx(PlanarHill(1.77).matrix, rel=1e-14)
    assert VonMises().matrix == pytest.approx(np.array([[1.0, -0.5, 0.0], [-0.5, 1.0, 0.0], [0.0, 0.0, 3.0]]))


def test_strain_of_a_small_increment_flows_along_the_normal_of_hill48():
    # Tension at 45 degrees of a sheet with r45 = 1.51: width strain over thickness strain.
    locus = Hill48(1.79, 1.51, 2.27)
    material = Material(E, NU, locus, CURVE)
    s45 = 1.114885  # benchmarks.md L
    stress = 0.5 * s45 * CURVE(0.1) * np.array([1.0, 1.0, 1.0])
    flow = locus.matrix @ stress / CURVE(0.1)
    elastic = np.array([stress[0] - NU * stress[1], stress[1] - NU * stress[0], 2 * (1 + NU) * stress[2]]) / E
    h = elastic + 0.1 * flow
    mean, half, radius = 0.5 * (h[0] + h[1]), 0.5 * (h[0] - h[1]), np.hypot(0.5 * (h[0] - h[1]), 0.5 * h[2])
    ratio = np.sinh(2 * radius) / radius
    metric = np.exp(2 * mean) * np.array([np.cosh(2 * radius) + ratio * half, np.cosh(2 * radius) - ratio * half, 0.0])
    metric[2] = np.exp(2 * mean) * ratio * 0.5 * h[2]
    new = material.new_state(1)
    material.update(metric[None], material.new_state(1), new)
    assert new.equivalent[0] == pytest.approx(0.1, rel=1e-5)
    assert new.stress[0] == pytest.approx(stress, rel=1e-5)
    plastic = new.plastic[0]
    along, across = 0.5 * (plastic[0] + plastic[1] + plastic[2]), 0.5 * (plastic[0] + plastic[1] - plastic[2])
    assert across / -(along + across) == pytest.approx(1.51, rel=1e-8)


@pytest.mark.parametrize("values", [(0.0, 1.0, 1.0), (1.0, -0.5, 1.0), (1.0, 1.0, float("nan"))])
def test_impossible_r_values_are_refused(values):
    with pytest.raises(SceneError, match="Hill48 r"):
        Hill48(*values)


@pytest.mark.parametrize("scale", [3e-3, 0.05, 1.5])
def test_a_point_does_not_see_the_others_of_its_block(scale):
    # Elastic, flowing and very far points mixed: the same bits in any order, and in a block of one's own.
    n = 3 * BLOCK + 5
    rng = np.random.default_rng(4)
    h = rng.uniform(-scale, scale, (n, 3)) * rng.uniform(0.0, 1.0, (n, 1)) ** 3
    results = []
    for order in (np.arange(n), rng.permutation(n)):
        found = respond(metric_points(h[order]), plastic=0.3 * h[order], equivalent=np.abs(h[order, 0]))
        back = np.argsort(order)
        results.append([array[back] for array in found])
    alone = [respond(metric_points(h[p]), plastic=0.3 * h[p : p + 1], equivalent=np.abs(h[p, :1])) for p in range(n)]
    results.append([np.concatenate(arrays) for arrays in zip(*alone)])
    for other in results[1:]:
        for one, two in zip(results[0], other):
            assert (one == two).all()


def test_where_sweeps_end_the_bracket_agrees():
    # The one-by-one solution, which a rate of effect nil asks for, against the block's.
    n = 500
    h = np.random.default_rng(5).uniform(-0.05, 0.05, (n, 3))
    found = []
    for rate, dt in ((None, None), (CowperSymonds(1e300, 1.0), 1.0)):
        material = Material(E, NU, PlanarHill(1.77), CURVE, rate=rate)
        new = material.new_state(n)
        material.update(metric_points(h), material.new_state(n), new, dt=dt)
        found.append(new)
    for name, array in found[0].arrays().items():
        scale = np.abs(array).max(initial=0.0)
        assert found[1].arrays()[name] == pytest.approx(array, rel=1e-10, abs=1e-12 * scale)


def test_what_is_not_finite_stays_not_a_number():
    metric = np.ones((BLOCK, 3)) * [1.02, 1.0, 0.0]
    metric[3] = np.nan
    s, tangent, *_ = respond(metric)
    assert np.isnan(s[3]).all() and np.isnan(tangent[3]).all()
    assert np.isfinite(np.delete(s, 3, axis=0)).all()
