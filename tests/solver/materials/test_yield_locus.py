"""Yield stresses and r-values in every direction, derivatives, convexity. reference/benchmarks.md L and E.5."""

import warnings

import numpy as np
import pytest

from solver import Hill48, Hill90, Material, PlanarHill, SceneError, Swift, Vegter, VonMises, Yld2000
from solver.materials.yield_locus import convexity, equibiaxial, gradients, plane_strain, uniaxial
from tests.solver.materials.paths import reference

ROUND = np.radians(np.arange(0.0, 360.0, 7.5))
# AA2090-T3 (benchmarks.md E.5): stresses and r-values at 0, 45, 90 degrees, equibiaxial.
AA2090 = {"s0": 1.0, "s45": 0.8114, "s90": 0.9102, "sb": 1.035, "r0": 0.2115, "r45": 1.5769, "r90": 0.6923, "rb": 0.67}
VEGTER = Vegter(
    uniaxial=(1.0, 1.02, 0.98), r=(1.79, 1.51, 2.27), plane_strain=(1.25, 1.27, 1.26), shear=(0.57, 0.58, 0.57),
    biaxial=1.2, rb=0.9, plane_strain_ratio=(0.5, 0.52, 0.5),
)  # fmt: skip
LOCI = {
    "von Mises": VonMises(),
    "planar Hill": PlanarHill(1.77),
    "Hill48": Hill48(1.79, 1.51, 2.27),
    "Hill90": Hill90(1.0, 1.03, 0.98, 1.1, 1.5),
    "Vegter": VEGTER,
    "Yld2000": Yld2000((0.9, 1.05, 0.95, 1.02, 0.98, 1.03, 0.96, 1.1), 8.0),
}


def folded(angles):
    """The same direction between 0 and 90 degrees: the loci are orthotropic."""
    return np.arccos(np.abs(np.cos(angles)))


@pytest.mark.parametrize("locus", LOCI.values(), ids=LOCI)
def test_gradient_and_curvature_match_finite_differences(locus):
    x = np.random.default_rng(1).standard_normal((2000, 3))
    _, n, h = gradients(locus, x)
    step = 1e-6
    for j, e in enumerate(np.eye(3) * step):
        plus, minus = gradients(locus, x + e), gradients(locus, x - e)
        assert n[:, j] == pytest.approx((plus[0] - minus[0]) / (2 * step), abs=1e-8)
        error = np.abs(h[:, :, j] - (plus[1] - minus[1]) / (2 * step)).max(axis=1) / np.abs(h).max(axis=(1, 2))
        assert np.sort(error)[-3] < 1e-7  # a state or two of Vegter's may lie across a joint of two curves
        assert error.max() < 1e-2


@pytest.mark.parametrize("locus", LOCI.values(), ids=LOCI)
def test_a_locus_is_homogeneous_even_orthotropic_and_convex(locus):
    x = np.random.default_rng(2).standard_normal((500, 3))
    phi, n, h = gradients(locus, x)
    assert phi == pytest.approx(np.einsum("pi,pi->p", n, x), rel=1e-13)
    assert np.abs(np.einsum("pij,pj->pi", h, x)).max() < 1e-11
    assert gradients(locus, 1e6 * x)[0] == pytest.approx(1e6 * phi, rel=1e-13)
    assert gradients(locus, -x)[0] == pytest.approx(phi, rel=1e-14)
    assert gradients(locus, x * [1.0, 1.0, -1.0])[0] == pytest.approx(phi, rel=1e-13)
    assert convexity(locus)[0] > -1e-9
    assert (gradients(locus, np.zeros((1, 3)))[0] == 0.0).all()


def test_hill48_round_all_directions():
    # benchmarks.md L: s = [G c4 + F s4 + H (c2 - s2)^2 + 2N c2 s2]^(-1/2), r = [H + (2N-F-G-4H) s2c2]/[F s2 + G c2]
    for r0, r45, r90 in [(1.79, 1.51, 2.27), (0.526, 0.253, 0.601), (0.2115, 1.5769, 0.6923)]:
        g, h, f = 1 / (1 + r0), r0 / (1 + r0), r0 / (r90 * (1 + r0))
        n = (r0 + r90) * (1 + 2 * r45) / (2 * r90 * (1 + r0))
        c2, s2 = np.cos(ROUND) ** 2, np.sin(ROUND) ** 2
        stress, r = uniaxial(Hill48(r0, r45, r90), ROUND)
        assert stress == pytest.approx(
            (g * c2**2 + f * s2**2 + h * (c2 - s2) ** 2 + 2 * n * c2 * s2) ** -0.5, rel=1e-12
        )
        assert r == pytest.approx((h + (2 * n - f - g - 4 * h) * s2 * c2) / (f * s2 + g * c2), rel=1e-11)
        assert equibiaxial(Hill48(r0, r45, r90)) == pytest.approx(((f + g) ** -0.5, f / g), rel=1e-12)


def test_planar_hill_is_the_same_round_all_directions():
    for r in (0.5, 1.0, 1.77):
        stress, got = uniaxial(VonMises() if r == 1.0 else PlanarHill(r), ROUND)
        assert stress == pytest.approx(1.0, rel=1e-12)
        assert got == pytest.approx(r, rel=1e-10)
        assert equibiaxial(PlanarHill(r)) == pytest.approx((np.sqrt((1 + r) / 2), 1.0), rel=1e-12)


def test_hill48_tables_of_the_reference():
    rows = [line.split(",") for line in reference("hill48_angles.csv").read_text().splitlines()[1:]]
    values = {"NUMISHEET93": (1.79, 1.51, 2.27), "ESAFORM2021": (0.526, 0.253, 0.601)}
    values |= {"Tian2016": (0.8, 0.37, 0.54), "AA2090-T3": (0.2115, 1.5769, 0.6923)}
    for name, angle, stress, r in rows:
        locus = Hill48(*next(values[key] for key in values if name.startswith(key)))
        got = uniaxial(locus, np.radians([float(angle)]))
        assert [got[0][0], got[1][0]] == pytest.approx([float(stress), float(r)], abs=1e-6)
    for line in reference("hill48_points.csv").read_text().splitlines()[1:]:
        row = [float(value) for value in line.rsplit(",", 22)[1:]]
        locus = Hill48(*row[:3])
        assert equibiaxial(locus) == pytest.approx(row[9:11], abs=1e-6)
        major, minor = plane_strain(locus)
        assert [major, minor / major] == pytest.approx(row[11:13], abs=1e-6)
        major, minor = plane_strain(locus, np.pi / 2)
        assert [major, minor / major] == pytest.approx(row[13:15], abs=1e-6)
        assert 1 / gradients(locus, [[0.0, 0.0, 1.0]])[0][0] == pytest.approx(row[15], abs=1e-6)


def test_yld2000_meets_the_eight_tests_it_is_fitted_to():
    locus = Yld2000.fit(**AA2090)
    stress, r = uniaxial(locus, np.radians([0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0]))
    s0, s45, s90, r0, r45, r90 = (AA2090[key] for key in ("s0", "s45", "s90", "r0", "r45", "r90"))
    assert stress == pytest.approx([s0, s45, s90, s45, s0, s45, s90, s45], rel=1e-10)
    assert r == pytest.approx([r0, r45, r90, r45, r0, r45, r90, r45], rel=1e-10)
    assert equibiaxial(locus) == pytest.approx((AA2090["sb"], AA2090["rb"]), rel=1e-10)


def test_yld2000_fit_finds_the_alphas_barlat_published():
    # Barlat et al. 2003, table 3 (recalled): AA2090-T3, a = 8. The stress and r-values fitted there are those above.
    published = [0.4865, 1.3783, 0.7536, 1.0246, 1.0363, 0.9036, 1.2321, 1.4858]
    assert Yld2000.fit(**AA2090).alphas == pytest.approx(published, abs=6e-3)


def test_isotropic_yld2000_with_exponent_2_or_4_is_von_mises():
    x = np.random.default_rng(3).standard_normal((100, 3))
    for a in (2.0, 4.0):
        assert gradients(Yld2000((1.0,) * 8, a), x)[0] == pytest.approx(gradients(VonMises(), x)[0], rel=1e-13)


def test_isotropic_yld2000_is_hosford():
    # Hosford's locus of exponent 8: |s1 - s2|^8 + |s1|^8 + |s2|^8 = 2 s^8 in principal stresses.
    s1, s2 = np.array([1.0, 1.0, 1.0, 0.7]), np.array([-1.0, 0.0, 0.5, 0.9])
    expected = (0.5 * (np.abs(s1 - s2) ** 8 + np.abs(s1) ** 8 + np.abs(s2) ** 8)) ** 0.125
    x = np.column_stack([s1, s2, np.zeros(4)])
    assert gradients(Yld2000((1.0,) * 8, 8.0), x)[0] == pytest.approx(expected, rel=1e-13)


def test_hill90_meets_its_tests():
    values = {"s0": 1.0, "s45": 1.03, "s90": 0.98, "sb": 1.1, "r45": 1.5}
    locus = Hill90(**values)
    stress, r = uniaxial(locus, np.radians([0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0]))
    assert stress == pytest.approx([1.0, 1.03, 0.98, 1.03, 1.0, 1.03, 0.98, 1.03], rel=1e-12)
    assert r[[1, 3, 5, 7]] == pytest.approx(1.5, rel=1e-11)
    assert equibiaxial(locus)[0] == pytest.approx(1.1, rel=1e-12)
    # In between, Hill's own formula: 1 + k - 2 a cos 2t + b cos^2 2t = (2 sb/s)^m.
    data = locus.data()
    c = np.cos(2 * ROUND)
    expected = 2.2 / (1 + data.k - 2 * data.a * c + data.b * c * c) ** (1 / data.m)
    assert uniaxial(locus, ROUND)[0] == pytest.approx(expected, rel=1e-12)


def test_hill90_of_equal_tests_with_exponent_2_is_planar_hill():
    # m = 2 where (2 sb)^2 = 2 (1 + r), Hill's own sb = sqrt((1 + r)/2).
    r = 1.77
    x = np.random.default_rng(4).standard_normal((100, 3))
    locus = Hill90(1.0, 1.0, 1.0, np.sqrt((1 + r) / 2), r)
    assert gradients(locus, x)[0] == pytest.approx(gradients(PlanarHill(r), x)[0], rel=1e-12)


def test_vegter_passes_through_its_points_with_their_normals():
    angles = np.radians([0.0, 45.0, 90.0])
    stress, r = uniaxial(VEGTER, angles)
    assert stress == pytest.approx(VEGTER.uniaxial, rel=1e-12)
    assert r == pytest.approx(VEGTER.r, rel=1e-10)
    assert equibiaxial(VEGTER) == pytest.approx((1.2, 0.9), rel=1e-12)
    for angle, major, ratio, shear in zip(angles, VEGTER.plane_strain, VEGTER.plane_strain_ratio, VEGTER.shear):
        assert plane_strain(VEGTER, angle) == pytest.approx((major, ratio * major), rel=1e-10)
        c, s = np.cos(2 * angle), np.sin(2 * angle)
        phi, n, _ = gradients(VEGTER, [[shear * c, -shear * c, shear * s]])
        assert phi[0] == pytest.approx(1.0, rel=1e-12)
        assert n[0, 0] + n[0, 1] == pytest.approx(0.0, abs=1e-12)  # no strain in thickness


def test_vegter_follows_cosine_series_round_all_directions():
    stress, r = uniaxial(VEGTER, ROUND)
    f0, f45, f90 = VEGTER.uniaxial
    # Three values fix a0 + a1 cos 2t + a2 cos 4t.
    series = 0.25 * (f0 + 2 * f45 + f90) + 0.5 * (f0 - f90) * np.cos(2 * ROUND)
    assert stress == pytest.approx(series + 0.25 * (f0 - 2 * f45 + f90) * np.cos(4 * ROUND), rel=1e-12)
    w0, w45, w90 = (r / (1 + r) for r in VEGTER.r)
    series = 0.25 * (w0 + 2 * w45 + w90) + 0.5 * (w0 - w90) * np.cos(2 * ROUND)
    assert r / (1 + r) == pytest.approx(series + 0.25 * (w0 - 2 * w45 + w90) * np.cos(4 * ROUND), rel=1e-10)


def test_vegter_meets_as_many_directions_as_were_tested():
    # AA2090-T3 every 15 degrees (benchmarks.md E.5).
    uniaxial_stress = (1.0, 0.9605, 0.9102, 0.8114, 0.8096, 0.8815, 0.9102)
    r = (0.2115, 0.3269, 0.6923, 1.5769, 1.0385, 0.5384, 0.6923)
    locus = Vegter(uniaxial_stress, r, (1.1, 1.08, 1.05, 1.02, 1.02, 1.03, 1.08), (0.6,) * 7, 1.035, 0.67)
    stress, got = uniaxial(locus, np.radians(np.arange(0.0, 91.0, 15.0)))
    assert stress == pytest.approx(uniaxial_stress, rel=1e-12)
    assert got == pytest.approx(r, rel=1e-10)


def test_gradient_of_vegter_is_continuous_at_the_equibiaxial_point():
    _, pole, _ = gradients(VEGTER, [[1.0, 1.0, 0.0]])
    for angle in np.linspace(0.0, np.pi, 9):
        for size in (1e-12, 1e-9, 1e-7, 1e-6, 1e-4):
            near = [[1.0 + size * np.cos(2 * angle), 1.0 - size * np.cos(2 * angle), size * np.sin(2 * angle)]]
            assert gradients(VEGTER, near)[1][0] == pytest.approx(pole[0], abs=100 * size + 1e-13)


NOT_CONVEX = Hill90(1.0, 1.0, 0.6, 1.2, 1.5)


def test_a_locus_that_is_not_convex_gives_one_clear_warning():
    assert convexity(NOT_CONVEX)[0] < -1e-3
    with pytest.warns(UserWarning, match=r"Hill90\(.*\) is not convex: its curvature is negative near the stress"):
        Material(206000.0, 0.3, NOT_CONVEX, Swift(500.0, 0.01, 0.2)).prepare()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Material(206000.0, 0.3, VEGTER, Swift(500.0, 0.01, 0.2)).prepare()


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: Yld2000((1.0,) * 7), "Yld2000 alphas: found .* expected 8 numbers"),
        (lambda: Yld2000((1.0,) * 8, 1.0), "Yld2000 a: found 1.0, expected a number of 2 or more"),
        (lambda: Yld2000.fit(1, 1, 1, 1, 1, -1, 1, 1), "Yld2000 r45: found -1, expected a number above 0"),
        (lambda: Yld2000.fit(1, 0.1, 1, 3, 1, 9, 1, 0.01), "Yld2000: no alphas meet these tests"),
        (lambda: Hill90(1, 1, 1, 0.4, 1), "Hill90: found sb/s45 = 0.4"),
        (lambda: Hill90(1, 1, 1, 1, -1), "Hill90 r45: found -1"),
        (lambda: Vegter((1, 1), (1, 1, 1), (1.1, 1.1), (0.6, 0.6), 1, 1), "Vegter r: found 3 values, expected 2"),
        (lambda: Vegter((1, 1), (1, 1), (1.1, 1.1), (0.6, 0.5), 1, 1), "Vegter shear: .* expected the same at phi"),
        (lambda: Vegter((1, 1), (1, 1), (1.1, 1.1), (0.6, 0.6), -1, 1), "Vegter biaxial: found -1"),
        (lambda: Material(2e5, 0.3, "Mises", Swift(500, 0.01, 0.2)), "material locus: found 'Mises'"),
    ],
)
def test_wrong_parameters_are_refused_in_one_line(wrong, message):
    with pytest.raises(SceneError, match=message) as caught:
        wrong()
    assert "\n" not in str(caught.value)
