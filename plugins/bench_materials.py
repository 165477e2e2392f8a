"""Time per point and update of every material law, on one core: rows `bench_rows()` for `cadlink bench`.

Points sit at random strains a forming run sees, with plastic strain behind them, and take a step in which most of
them flow. Times are the least of several repeats; ratios are to planar Hill with isotropic hardening.
"""

import time

import numpy as np

import solver
from solver.materials.law import PointState

CURVE = solver.Swift(565.32, 0.007117, 0.2589)
LOCI = {
    "planar Hill": solver.PlanarHill(1.77),
    "Hill48": solver.Hill48(1.79, 1.51, 2.27),
    "Hill90": solver.Hill90(1.0, 1.03, 0.98, 1.1, 1.5),
    "Yld2000": solver.Yld2000((0.4865, 1.3783, 0.7536, 1.0246, 1.0363, 0.9036, 1.2321, 1.4858), 8.0),
    "Vegter": solver.Vegter((1, 1.02, 0.98), (1.79, 1.51, 2.27), (1.25, 1.27, 1.26), (0.57, 0.58, 0.57), 1.2, 0.9),
}
LAWS = {
    "isotropic": CURVE,
    "Armstrong-Frederick": solver.ArmstrongFrederick(CURVE, 10000.0, 25.0),
    "Yoshida-Uemori": solver.YoshidaUemori(Y=124, B=168, C=500, R_sat=190, m=12, b=9, h=0.5),
    "two surfaces": solver.TwoSurface(CURVE, 120.0, 60000.0, 2.0),
}
CASES = [(locus, "isotropic") for locus in LOCI]
CASES += [(locus, law) for law in list(LAWS)[1:] for locus in ("planar Hill", "Yld2000")]


def bench_rows(cases=None, n_points=7000, repeats=7, step=0.002):
    """Rows of (locus, law, share of points that flow, ns with tangent, ns without, ratios), ready for a table or JSON.

    cases : pairs of names, all of CASES by default; step : size of the strain increment
    """
    import numba

    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        rows = [time_case(*case, n_points, repeats, step) for case in cases or CASES]
        unit = next((row for row in rows if (row["locus"], row["law"]) == CASES[0]), None)
        unit = unit or time_case(*CASES[0], n_points, repeats, step)
    finally:
        numba.set_num_threads(threads)
    for row in rows:
        row["ratio_with_tangent"] = row["ns_with_tangent"] / unit["ns_with_tangent"]
        row["ratio_without"] = row["ns_without"] / unit["ns_without"]
    return rows


def time_case(locus, law, n_points=7000, repeats=7, step=0.002):
    """One row of `bench_rows`, without ratios."""
    material = solver.Material(206000.0, 0.3, LOCI[locus], LAWS[law])
    rng = np.random.default_rng(0)
    strain = rng.uniform(-0.1, 0.1, (n_points, 3))
    direction = rng.standard_normal((n_points, 3))
    old, new = material.new_state(n_points), material.new_state(n_points)
    for scale in np.linspace(0.1, 1.0, 10):  # to the place, in ten increments
        material.update(metric(scale * strain), old, new, tangent=False)
        old.copy_from(new)
    ahead = metric(strain + step * direction / np.linalg.norm(direction, axis=1)[:, None])
    nanoseconds = {}
    for tangent in (True, False):
        material.update(ahead, old, new, tangent=tangent)
        nanoseconds[tangent] = 1e9 * min(seconds(material, ahead, old, new, tangent) for _ in range(repeats)) / n_points
    return {
        "locus": locus,
        "law": law,
        "flowing": float((new.equivalent > old.equivalent).mean()),
        "ns_with_tangent": nanoseconds[True],
        "ns_without": nanoseconds[False],
    }


def seconds(material, ahead, old: PointState, new: PointState, tangent):
    """Time of one update."""
    start = time.perf_counter()
    material.update(ahead, old, new, tangent=tangent)
    return time.perf_counter() - start


def metric(y):
    """Metric (p, 3) of Green strains [E11, E22, 2 E12]."""
    return np.ascontiguousarray(np.column_stack([1 + 2 * y[:, 0], 1 + 2 * y[:, 1], y[:, 2]]))


def bench_table(rows):
    """rich table of `bench_rows`."""
    from rich.table import Table

    table = Table("locus", "hardening", "flowing", "with tangent", "", "without", "", title="ns per point, one core")
    for row in rows:
        table.add_row(
            row["locus"],
            row["law"],
            f"{100 * row['flowing']:.0f} %",
            f"{row['ns_with_tangent']:.0f}",
            f"x {row['ratio_with_tangent']:.1f}",
            f"{row['ns_without']:.0f}",
            f"x {row['ratio_without']:.1f}",
        )
    return table
