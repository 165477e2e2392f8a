"""Forming limits: reference/benchmarks.md, 'Forming limits', and the closed forms named there."""

import numpy as np
import pytest
from scipy.optimize import brentq

from solver import Hill48, Material, SceneError, Swift, VonMises
from solver.materials.forming_limit import KeelerBrazier, LimitCurve, fld_margin, hill_local, swift_diffuse
from solver.materials.marciniak import limit_strains, marciniak_kuczynski
from tests.solver.materials.paths import reference

# Nearly rigid, and nearly Hollomon's K e^0.2.
HOLLOMON = Material(2e7, 0.3, VonMises(), Swift(500.0, 1e-6, 0.2))


def rows(name):
    return [
        [float(value) for value in line.split(",")]
        for line in reference(name).read_text().splitlines()
        if line[:1].isdigit() or line[:1] == "-"
    ]


def test_keeler_brazier_meets_the_reference():
    for t, n, engineering, true, *at in rows("fld_naddrg.csv"):
        curve = KeelerBrazier(t, n)
        assert 100 * curve.plane_strain == pytest.approx(engineering, abs=1e-4)
        assert curve(0.0) == pytest.approx(true, abs=1e-6)
        assert curve(np.array([-0.1, -0.2, 0.1, 0.18])) == pytest.approx(at, abs=1e-6)


def test_closed_necking_strains_meet_the_reference():
    for ratio, _, hill, _, swift, _ in rows("fld_necking_closed.csv"):
        if ratio <= 0.0:
            assert hill_local(0.2, ratio) == pytest.approx(hill, abs=1e-6)
        assert swift_diffuse(0.2, ratio) == pytest.approx(swift, abs=1e-6)


def test_marciniak_kuczynski_meets_the_reference_table():
    table = [row for row in rows("fld_mk.csv") if row[0] < 0.999]
    for f0 in sorted({row[0] for row in table}):
        ratio, major = np.array([row[1:3] for row in table if row[0] == f0]).T
        got = limit_strains(HOLLOMON, f0, np.column_stack([ratio, np.zeros(len(ratio))]), step=2e-4)
        assert got == pytest.approx(major, abs=5e-4)  # the table's own error


@pytest.mark.slow
def test_marciniak_kuczynski_with_the_smallest_imperfection_meets_the_reference():
    # f0 = 0.999: the longest paths, up to a major strain above 1.
    table = np.array([row for row in rows("fld_mk.csv") if row[0] == 0.999])
    assert len(table) >= 6
    got = limit_strains(HOLLOMON, 0.999, np.column_stack([table[:, 1], np.zeros(len(table))]), step=1e-4)
    assert got == pytest.approx(table[:, 2], abs=5e-4)  # the table's own error


@pytest.mark.slow
@pytest.mark.parametrize("f0, limit", [(0.999, 0.18066), (0.995, 0.15850), (0.99, 0.14311), (0.98, 0.12304)])
def test_marciniak_kuczynski_in_plane_strain_converges_to_the_exact_limit(f0, limit):
    # Force e^n exp(-e) of sheet and groove: F(a) = f0 F(b), and the groove stretches ten times as fast where
    # n/a - 1 = 10 (n/b - 1): a little before the groove's largest force, b = n, whose strain is benchmarks.md's limit.
    n = 0.2

    def sheet(b):
        """Strain of the sheet beside a groove strained by b."""
        return brentq(lambda a: n * np.log(a / b) - a + b - np.log(f0), 1e-6, n)

    b = brentq(lambda b: n / sheet(b) - 1.0 - 10.0 * (n / b - 1.0), 0.7 * n, n * (1.0 - 1e-9))
    assert sheet(n * (1.0 - 1e-9)) == pytest.approx(limit, abs=1e-5)
    step = 5e-5
    got = limit_strains(HOLLOMON, f0, np.array([[0.0, 0.0]]), step=step)[0]
    assert got == pytest.approx(sheet(b), abs=1.5 * step)  # told to a step


@pytest.mark.parametrize("f0", [0.995, 0.98])
def test_marciniak_kuczynski_in_plane_strain_is_a_closed_form(f0):
    # benchmarks.md: n ln e - e = ln f0 + n ln n - n, the strain at which the groove reaches its largest force.
    n = 0.2
    exact = brentq(lambda e: n * np.log(e) - e - (np.log(f0) + n * np.log(n) - n), 1e-3, n)
    assert limit_strains(HOLLOMON, f0, np.array([[0.0, 0.0]]), step=1e-4)[0] == pytest.approx(exact, abs=6e-4)


def test_a_turned_groove_lowers_the_limit_left_of_plane_strain():
    # Hill's local necking n/(1 + ratio) bounds it from above, and a groove across the pull alone is too optimistic.
    ratios = (-0.4, -0.2, 0.0)
    turned = marciniak_kuczynski(HOLLOMON, 0.995, ratios, step=5e-4)
    straight = marciniak_kuczynski(HOLLOMON, 0.995, ratios, grooves=(0.0,), step=5e-4)
    for ratio, got, across in zip(ratios[:2], turned.major[:2], straight.major[:2]):
        assert 0.6 * hill_local(0.2, ratio) < got < hill_local(0.2, ratio)
        assert got < across
    assert turned.major[0] > turned.major[1] > turned.major[2]


def test_the_direction_of_the_pull_counts_for_an_anisotropic_sheet():
    steel = Material(206000.0, 0.3, Hill48(1.79, 1.51, 2.27), Swift(565.32, 0.007117, 0.2589))
    at = [limit_strains(steel, 0.99, np.array([[0.5, 0.0]]), angle, 5e-4)[0] for angle in (0.0, np.pi / 2, np.pi)]
    assert at[0] == pytest.approx(at[2], abs=1e-12)
    assert abs(at[0] - at[1]) > 1e-3


def test_margin_is_one_unstrained_and_zero_on_the_curve():
    curve = LimitCurve([-0.2, 0.0, 0.3], [0.5, 0.3, 0.4])
    minor = np.array([-0.3, -0.1, 0.0, 0.15, 0.4])
    limit = np.array([0.6, 0.4, 0.3, 0.35, 0.4 + 0.1 / 3])
    assert curve(minor) == pytest.approx(limit)
    assert fld_margin(curve, limit, minor) == pytest.approx(0.0, abs=1e-15)
    assert fld_margin(curve, np.zeros(5), minor) == pytest.approx(1.0)
    assert fld_margin(curve, 1.5 * limit, minor) == pytest.approx(-0.5)
    assert LimitCurve.from_engineering([0.0, 0.1], [0.3, 0.4])(np.log(1.1)) == pytest.approx(np.log(1.4))


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: LimitCurve([0.1, 0.0], [0.3, 0.3]), "minor strains that rise"),
        (lambda: LimitCurve([0.0, 0.1], [0.3, -0.3]), "found major strain -0.3"),
        (lambda: LimitCurve([0.0], [0.3]), "at least two points"),
        (lambda: KeelerBrazier(5.0, 0.2), "Keeler-Brazier thickness: found 5.0"),
        (lambda: KeelerBrazier(1.0, 0.0), "Keeler-Brazier n: found 0.0"),
        (lambda: marciniak_kuczynski(HOLLOMON, 1.0), "Marciniak-Kuczynski f0: found 1.0"),
        (lambda: marciniak_kuczynski(HOLLOMON, 0.99, (-2.0,)), "Marciniak-Kuczynski ratios"),
        (lambda: marciniak_kuczynski(HOLLOMON, 0.99, (1.0,), largest=0.1), "no necking up to a strain of 0.1"),
    ],
)
def test_wrong_values_are_refused(wrong, message):
    with pytest.raises(SceneError, match=message):
        wrong()
