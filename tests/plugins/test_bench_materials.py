from plugins.bench_materials import CASES, LAWS, LOCI, bench_rows, bench_table


def test_rows_of_the_bench_give_times_and_ratios():
    rows = bench_rows([("planar Hill", "isotropic"), ("Hill48", "isotropic")], n_points=200, repeats=2)
    assert [row["locus"] for row in rows] == ["planar Hill", "Hill48"]
    assert rows[0]["ratio_with_tangent"] == rows[0]["ratio_without"] == 1.0
    assert all(row["ns_with_tangent"] > 0.0 and 0.3 < row["flowing"] <= 1.0 for row in rows)
    assert bench_table(rows).row_count == 2


def test_every_locus_and_every_law_is_timed():
    assert {locus for locus, _ in CASES} == set(LOCI)
    assert {law for _, law in CASES} == set(LAWS)
