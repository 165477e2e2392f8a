"""Tensile tests from CSV files: hardening curves, r-value and a plot, for `cadlink materials fit`."""

import csv
from pathlib import Path

import numpy as np

from solver import SceneError
from solver.materials.fit import KINDS, fit_curve, flow_curve, r_value

COLUMNS = {
    "strain": ("strain", "engineering_strain", "eng_strain", "true_strain", "eps", "e"),
    "stress": ("stress", "engineering_stress", "eng_stress", "true_stress", "stress_mpa", "sigma", "s"),
    "width_strain": ("width_strain", "transverse_strain", "true_width_strain", "eng_width_strain"),
}


def read_test(path):
    """Columns of a CSV file by our names, {name: (n,)}, and whether its header says they are true values.

    Lines before the header that start with # are skipped. Raises SceneError naming the file and what was expected.
    """
    path = Path(path)
    with path.open(newline="", encoding="utf-8-sig") as file:
        lines = [line for line in file if line.strip() and not line.startswith("#")]
    if not lines:
        raise SceneError(f"{path}: found no rows, expected a header and columns strain, stress")
    separator = next((sign for sign in (";", "\t") if sign in lines[0]), ",")
    header, *rows = csv.reader(lines, delimiter=separator)
    plain = [name.strip().lower().replace(" ", "_").split("[")[0].split("(")[0].strip("_") for name in header]
    columns = {}
    for name, known in COLUMNS.items():
        place = next((plain.index(word) for word in known if word in plain), None)
        if place is None:
            if name == "width_strain":
                continue
            raise SceneError(f"{path}: found columns {', '.join(header)}, expected one called {name}")
        try:
            columns[name] = np.array([float(row[place]) for row in rows])
        except (ValueError, IndexError) as error:
            raise SceneError(f"{path}: column {header[place]!r} holds what is no number ({error})") from None
    return columns, any(name.startswith("true") for name in plain)


def fit_test(path, true=None, young=None):
    """What a tensile test says, ready for JSON: young, points, curves {kind: parameters and error}, r_value."""
    columns, said_true = read_test(path)
    true = said_true if true is None else true
    flow = flow_curve(columns["strain"], columns["stress"], true=true, young=young)
    fits = {kind: fit_curve(kind, flow) for kind in KINDS}
    result = {
        "file": str(path),
        "young": flow.young,
        "points": len(flow.plastic),
        "uniform_plastic_strain": float(flow.plastic[-1]),
        "curves": {kind: {**vars(fit.curve), "error": fit.error} for kind, fit in fits.items()},
    }
    if "width_strain" in columns:
        strain, width, stress = columns["strain"], columns["width_strain"], columns["stress"]
        if not true:
            strain, width, stress = np.log1p(strain), np.log1p(width), stress * (1.0 + strain)
        top = float(flow.plastic[-1])
        bounds = {"low": 0.05, "high": 0.15} if top >= 0.15 else {"low": 0.3 * top, "high": 0.9 * top}
        uniform = strain <= top + flow.stress[-1] / flow.young
        result["r_value"] = r_value(strain[uniform], width[uniform], stress[uniform], flow.young, **bounds)
    return result, flow, fits


def fit_table(result):
    """rich table of fitted curves."""
    from rich.table import Table

    table = Table("curve", "parameters (MPa)", "rms error", title=result["file"], title_justify="left")
    for kind, curve in result["curves"].items():
        numbers = ", ".join(f"{name} = {value:.5g}" for name, value in curve.items() if name != "error")
        table.add_row(kind.replace("_", "-"), numbers, f"{100 * curve['error']:.2f} %")
    return table


def plot_fit(flow, fits, path):
    """Picture of the test and the fitted curves, carried on to twice the uniform strain."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7.0, 4.5), layout="constrained")
    axes.plot(flow.plastic, flow.stress, ".", color="0.4", markersize=4, label="test, to uniform elongation")
    strain = np.linspace(0.0, 2.0 * flow.plastic[-1], 300)
    for kind, fit in fits.items():
        axes.plot(strain, fit.curve(strain), label=f"{kind.replace('_', '-')} ({100 * fit.error:.2f} %)")
    axes.set(xlabel="plastic strain", ylabel="true stress [MPa]", xlim=(0.0, None))
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=150)
    pyplot.close(figure)
