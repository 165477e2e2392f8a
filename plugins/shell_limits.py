"""What the meshes of a shell problem tend to, and how fast: the published answers are those of a mesh, too.

The limit of a displacement v at the full load is extrapolated at second order from the two finest meshes of each kind,
v_h + (v_h - v_H)/((H/h)^2 - 1), and averaged over the kinds of mesh, whose difference tells how sure it is. The order
is that in which the largest error against it falls from the coarsest mesh of a kind to the finest.
"""

import numpy as np

HEADER = ["problem", "", "published", "limit", "between meshes [%]", "from published [%]", "errors [%]", "order"]


def limit_rows(done):
    """Rows of problem, probe, published, limit {mesh: value}, errors {mesh: of each refinement, coarsest first} and
    order {mesh: of the problem}, of every problem whose two finest meshes of some kind ran.

    done : rows of `bench_shell.measure`
    """
    for problem in dict.fromkeys(row["problem"] for row in done):
        mine = [row for row in done if row["problem"] == problem and "failed" not in row]
        kinds = {kind: [row for row in mine if row["mesh"] == kind] for kind in dict.fromkeys(r["mesh"] for r in mine)}
        kinds = {kind: runs for kind, runs in kinds.items() if len(runs) > 1}
        if not kinds:
            continue
        cells = {kind: [run["cells"] for run in runs] for kind, runs in kinds.items()}
        found = []
        for probe, (_, published, _) in mine[0]["values"].items():
            value = {kind: np.array([run["values"][probe][0] for run in runs]) for kind, runs in kinds.items()}
            limit = {
                kind: float(v[-1] + (v[-1] - v[-2]) / ((cells[kind][-1] / cells[kind][-2]) ** 2 - 1.0))
                for kind, v in value.items()
            }
            mean = np.mean(list(limit.values()))
            errors = {kind: (v / mean - 1.0).tolist() for kind, v in value.items()}
            found.append({"problem": problem, "probe": probe, "published": published, "limit": limit, "errors": errors})
        for row in found:
            row["order"] = {kind: order([other["errors"][kind] for other in found], cells[kind]) for kind in kinds}
        yield from found


def order(errors, cells):
    """Order of the largest of some errors (n_probes, n_refinements), from the coarsest mesh to the finest one, of
    cells (n_refinements,) along a side."""
    largest = np.abs(errors).max(axis=0)
    return float(np.log(largest[0] / largest[-1]) / np.log(cells[-1] / cells[0]))


def line_of(row):
    """A row as texts."""
    limits = list(row["limit"].values())
    mean = np.mean(limits)
    return [
        row["problem"],
        row["probe"],
        f"{row['published']:.5g}",
        f"{mean:.5g}",
        f"{100.0 * (max(limits) - min(limits)) / abs(mean):.2f}" if len(limits) > 1 else "",
        f"{100.0 * (mean / row['published'] - 1.0):+.2f}" if row["published"] else "",
        "; ".join(", ".join(f"{100.0 * e:+.2f}" for e in errors) for errors in row["errors"].values()),
        "; ".join(f"{order:.1f}" for order in row["order"].values()),
    ]
