"""The figures of a run: history.csv and summary.json in its folder, tables and plots made from them."""

import csv
import json
from itertools import zip_longest
from pathlib import Path

import numpy as np

# figure -> words, unit, factor to that unit, decimals; in the order a report shows them
FIGURES = {
    "stroke": ("stroke", "mm", 1.0, 2),
    "increments": ("increments", "", 1, 0),
    "iterations": ("Newton iterations, or steps", "", 1, 0),
    "iterations_per_increment": ("the same per increment", "", 1.0, 1),
    "increments_per_mm": ("increments per mm of stroke", "1/mm", 1.0, 2),
    "dynamic_increments": ("dynamic increments", "", 1, 0),
    "nodes_skipped": ("nodes known to be far from a tool", "%", 100.0, 1),
    "thickness_min": ("smallest thickness", "mm", 1.0, 3),
    "thickness_max": ("largest thickness", "mm", 1.0, 3),
    "thinning_max": ("largest thinning", "%", 100.0, 1),
    "fld_margin_min": ("smallest margin to the forming limit", "%", 100.0, 1),
    "fld_margin_x": ("there, x", "mm", 1.0, 1),
    "fld_margin_y": ("there, y", "mm", 1.0, 1),
    "fld_margin_z": ("there, z", "mm", 1.0, 1),
    "contact_foot_error": ("largest error of a contact point on its tool", "µm", 1e3, 4),
    "cad_gap": ("largest gap between faces of the CAD tools", "µm", 1e3, 4),
    "cad_form": ("largest distance of a CAD face from where it is drawn", "µm", 1e3, 4),
    "contact_sharp_nodes": ("nodes on sharp edges of tools, at most", "", 1, 0),
    "contact_several_feet": ("nodes held by several walls of one tool, at most", "", 1, 0),
}
# the same by the first letters of a figure's name
FAMILIES = {
    "max_force_": ("largest force of ", "kN", 1e-3, 2),
    "bead_": ("restraint of drawbead ", "kN", 1e-3, 2),
    "uplift_": ("uplift of drawbead ", "kN", 1e-3, 2),
    "tilt_": ("tilt of ", "degrees", 1.0, 4),
    "draw_in_": ("draw-in ", "mm", 1.0, 2),
    "energy_": ("energy: ", "J", 1e-3, 2),
    "seconds_": ("time: ", "s", 1.0, 1),
}


class RunFolderError(ValueError):
    """A folder does not hold a run. One line: which file, what was expected."""


# Files


def write_history(folder, history):
    """history.csv: a row per increment. history : {column: list}."""
    with open(Path(folder) / "history.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(history)
        rows.writerows(zip_longest(*history.values(), fillvalue=""))


def read_history(folder):
    """{column: list}, numbers where a column holds nothing else. Raises RunFolderError."""
    path = Path(folder) / "history.csv"
    try:
        with open(path, newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
    except (OSError, ValueError) as error:
        raise RunFolderError(f"{path}: cannot be read ({error}), expected the history of a run") from None
    columns = zip(*rows) if rows else [()] * len(header)
    return {name: _numbers(list(column)) for name, column in zip(header, columns)}


def _numbers(texts):
    try:
        return [float(text) if text else float("nan") for text in texts]
    except ValueError:
        return texts


def write_summary(folder, summary):
    """summary.json, replaced as a whole. summary : what `summarize` returns."""
    path = Path(folder) / "summary.json"
    unfinished = path.with_name("summary.json.part")
    unfinished.write_text(as_json(summary) + "\n", encoding="utf-8")
    unfinished.replace(path)


def read_summary(folder):
    """What `write_summary` wrote. Raises RunFolderError where the folder holds no run."""
    path = Path(folder) / "summary.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise RunFolderError(f"{path}: no such file, expected the folder of a run") from None
    except (OSError, ValueError) as error:
        raise RunFolderError(f"{path}: cannot be read ({error}), expected the summary of a run") from None


def as_json(value):
    """Indented JSON; numpy's numbers and arrays as plain ones, what is not finite as null."""
    return json.dumps(_plain(value), indent=2, allow_nan=False, ensure_ascii=False)


def _plain(value):
    if isinstance(value, dict):
        return {str(key): _plain(kept) for key, kept in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(kept) for kept in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)


# Figures


def summarize(scene_file, scene, results, message=None):
    """What a report needs to know of a run, as a dict for summary.json.

    scene_file : SceneFile; scene : solver.Scene; results : solver.Results; message : why it stopped early
    """
    keys = scene_file.keys
    rows = compare(keys.compare.rows, results.history, scene_file.columns) if keys.compare else []
    return {
        "name": scene.name,
        "scene": str(scene_file.path),
        "finished": bool(results.finished),
        "message": message,
        "symmetry": list(scene.blank.symmetry_planes),
        "initial_thickness": float(scene.blank.thickness),
        "figures": results.summary() | cad_errors(scene),
        "source": keys.compare.source if keys.compare else None,
        "comparison": rows,
        "plan": str(results.plan),
    }


def cad_errors(scene):
    """{"cad_gap": mm, "cad_form": mm}, how far faces of the CAD tools fail to meet, and how far they are met from where
    they are drawn, facets included; empty where no tool comes from CAD."""
    surfaces = [tool.surface for tool in scene.tools.values() if getattr(tool.surface, "part", None) is not None]
    if not surfaces:
        return {}
    reports = [surface.part.gap_report() for surface in surfaces]
    gap = max(max(report.edge, report.vertex) for report in reports)
    return {"cad_gap": gap, "cad_form": max(surface.misfit() for surface in surfaces)}


def compare(measured, history, units):
    """Computed values beside measured ones: a dict per row; computed None where the run did not get so far.

    measured : rows with quantity, stroke, measured, scatter; history : {column: list}; units : {column: unit}
    """
    rows = []
    strokes = np.asarray(history.get("stroke", ()), dtype=float)
    for row in measured:
        values = history.get(row.quantity, ())
        slack = 1e-6 * max(1.0, abs(row.stroke))
        reached = len(strokes) > 0 and len(values) == len(strokes) and strokes[-1] >= row.stroke - slack
        computed = float(np.interp(row.stroke, strokes, values)) if reached else None
        off = 100.0 * (computed / row.measured - 1.0) if reached and row.measured else None
        rows.append(
            {
                "quantity": row.quantity,
                "unit": units.get(row.quantity, ""),
                "stroke": row.stroke,
                "measured": row.measured,
                "scatter": row.scatter,
                "computed": computed,
                "percent_off": off,
            }
        )
    return rows


# Tables


def figures_table(summary):
    """The figures a run is judged by, as a rich table."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(summary["name"]), title_justify="left", show_header=False, box=None, pad_edge=False)
    table.add_column()
    table.add_column(justify="right")
    table.add_column()
    for words, number, unit in figure_rows(summary["figures"]):
        table.add_row(escape(words), number, unit)
    return table


def figure_rows(figures):
    """(words, number, unit) of each figure worth a line."""
    numbers = {
        key: value for key, value in figures.items() if isinstance(value, (int, float)) and not isinstance(value, bool)
    }
    for key, (words, unit, scale, decimals) in FIGURES.items():
        if key in numbers:
            yield words, f"{scale * numbers[key]:,.{decimals}f}", unit
    for start, (words, unit, scale, decimals) in FAMILIES.items():
        for key, value in numbers.items():
            if key.startswith(start):
                yield words + _words(key.removeprefix(start)), f"{scale * value:,.{decimals}f}", unit


def _words(name):
    return name.replace("draw_in", "draw-in").replace("_", " ")


def comparison_table(summary):
    """Computed beside measured values, as a rich table."""
    from rich.markup import escape
    from rich.table import Table

    caption = escape(f"measured: {summary['source']}")
    table = Table(caption=caption, caption_justify="left")
    for heading in ("quantity", "stroke [mm]", "measured", "computed", "off"):
        table.add_column(escape(heading), justify="left" if heading == "quantity" else "right")
    for row in summary["comparison"]:
        measured = f"{row['measured']:g}" + (f" ± {row['scatter']:g}" if row["scatter"] else "")
        computed, off = row["computed"], row["percent_off"]
        table.add_row(
            escape(_words(row["quantity"]) + (f" [{row['unit']}]" if row["unit"] else "")),
            f"{row['stroke']:g}",
            measured,
            "not reached" if computed is None else f"{computed:.2f}" if abs(computed) < 1000 else f"{computed:,.0f}",
            "" if off is None else f"{off:+.1f} %",
        )
    return table


# Plots


def plot(folder, file):
    """Forces, draw-in and thinning over the stroke, with the measured values, as a picture.

    Raises RunFolderError where the folder holds no run.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    history, summary = read_history(folder), read_summary(folder)
    panels = {
        "tool force [kN]": {k: 1e-3 for k in history if k.startswith("force_")},
        "draw-in [mm]": {k: 1.0 for k in history if k.startswith("draw_in_")},
        "largest thinning [%]": {k: 100.0 for k in history if k == "thinning_max"},
    }
    panels = {label: columns for label, columns in panels.items() if columns}
    figure, axes = pyplot.subplots(
        1, len(panels), figsize=(5.0 * len(panels), 4.0), layout="constrained", squeeze=False
    )
    for axis, (label, columns) in zip(axes[0], panels.items()):
        for column, scale in columns.items():
            name = column.removeprefix("force_").removeprefix("draw_in_")
            (line,) = axis.plot(history["stroke"], scale * np.asarray(history[column]), label=_words(name))
            _plot_measured(axis, summary["comparison"], column, scale, line.get_color())
        axis.set(xlabel="stroke [mm]", ylabel=label)
        axis.grid(alpha=0.3)
        if len(columns) > 1:
            axis.legend()
    figure.suptitle(summary["name"])
    figure.savefig(file, dpi=150)
    pyplot.close(figure)


def _plot_measured(axis, rows, column, scale, colour):
    rows = [row for row in rows if row["quantity"] == column]
    if rows:
        strokes = [row["stroke"] for row in rows]
        values = [scale * row["measured"] for row in rows]
        scatter = [scale * (row["scatter"] or 0.0) for row in rows]
        axis.errorbar(strokes, values, scatter, fmt="o", mfc="white", color=colour, capsize=4)
