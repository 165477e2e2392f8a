"""`cadlink materials`: published sheets, and parameters from tensile tests."""

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

materials = App(name="materials", help="Published sheets, and material parameters from tensile tests.")

Json = Annotated[bool, Parameter(name="--json", negative=(), help="Print JSON instead of tables.")]


@materials.command(name="list")
def list_sheets(*, as_json: Json = False):
    """List the published sheets a scene can name: material = "numisheet93-steel"."""
    from .command_line import print_json, print_table

    rows = [describe_sheet(name) for name in sheet_names()]
    if as_json:
        print_json(rows)
        return
    from rich.table import Table

    table = Table("name", "t [mm]", "E [MPa]", "locus", "hardening")
    for row in rows:
        thickness = f"{row['thickness']:g}" if row["thickness"] else ""
        table.add_row(row["name"], thickness, f"{row['young']:.0f}", row["locus"], row["hardening"])
    print_table(table)


@materials.command
def show(name: str, *, plot: Path | None = None, as_json: Json = False):
    """Show a published sheet: its numbers, its source, how they were come by, yield stresses and r-values.

    Parameters
    ----------
    name
        One of `cadlink materials list`.
    plot
        Picture of its hardening curve and its yield stresses and r-values over the angle to write.
    """
    from .command_line import print_json, print_table

    described = describe_sheet(name)
    described |= directions(name)
    if as_json:
        print_json(described)
    else:
        from rich.table import Table

        for key in ("name", "thickness", "young", "poisson", "locus", "hardening", "source", "grade"):
            print(f"{key}: {described[key] if described[key] is not None else 'not told'}")
        table = Table("angle to rolling", "yield stress / curve", "r-value")
        for angle, stress, r in zip(described["angles"], described["yield_stress"], described["r_value"]):
            table.add_row(f"{angle:g}", f"{stress:.4f}", f"{r:.4f}")
        print_table(table)
    if plot:
        plot_sheet(name, plot)


@materials.command
def fit(
    file: Path,
    *,
    plot: Path | None = None,
    young: float | None = None,
    true: Annotated[bool | None, Parameter(negative="--engineering")] = None,
    as_json: Json = False,
):
    """Fit hardening curves to a tensile test, and read the r-value where the width was measured.

    Parameters
    ----------
    file
        CSV file with columns strain and stress [MPa], and width_strain where it was measured. Strains are ratios.
    plot
        Picture of the test and the curves to write.
    young
        Young's modulus in MPa; read from the elastic part by default.
    true
        The columns are true stress and logarithmic strain; by default the header's word "true" decides.
    """
    from .command_line import print_json, print_table
    from .tensile import fit_table, fit_test, plot_fit

    result, flow, fits = fit_test(file, true=true, young=young)
    if as_json:
        print_json(result)
    else:
        print_table(fit_table(result))
        print(f"Young's modulus {result['young']:.0f} MPa, {result['points']} points to a plastic strain of", end=" ")
        print(f"{result['uniform_plastic_strain']:.4f}")
        if "r_value" in result:
            print(f"r-value {result['r_value']:.4f}")
    if plot:
        plot_fit(flow, fits, plot)


def sheet_names():
    """Names of the published sheets."""
    from solver.materials.library import SHEETS

    return list(SHEETS)


def describe_sheet(name):
    """What is known of a published sheet, ready for JSON."""
    from solver.materials.library import SHEETS, published_sheet

    material, sheet = published_sheet(name), SHEETS[name]
    return {
        "name": name,
        "thickness": sheet.thickness,
        "young": material.young,
        "poisson": material.poisson,
        "locus": short(material.locus),
        "hardening": short(material.hardening),
        "source": sheet.source,
        "grade": sheet.grade,
    }


def short(thing):
    """A description with four digits."""
    import re

    return re.sub(r"\d+\.\d{5,}", lambda number: f"{float(number.group()):.5g}", repr(thing))


def directions(name, step=15.0):
    """Yield stress relative to the curve and r-value of a sheet from 0 to 90 degrees, ready for JSON."""
    import numpy as np

    from solver.materials.library import published_sheet
    from solver.materials.yield_locus import uniaxial

    angles = np.arange(0.0, 90.0 + 0.5 * step, step)
    stress, r = uniaxial(published_sheet(name).locus, np.radians(angles))
    return {"angles": angles.tolist(), "yield_stress": stress.tolist(), "r_value": r.tolist()}


def plot_sheet(name, path):
    """Picture of a sheet: stress in tension, and yield stress and r-value over the angle."""
    import matplotlib

    matplotlib.use("Agg")
    import numpy as np
    from matplotlib import pyplot

    from solver.materials.library import published_sheet

    material, around = published_sheet(name), directions(name, 5.0)
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
    if callable(material.hardening):
        strain = np.linspace(0.0, 0.5, 300)
        left.plot(strain, material.hardening(strain))
        left.set(xlabel="plastic strain", ylabel="yield stress [MPa]", title=name)
    else:
        left.text(0.5, 0.5, short(material.hardening), ha="center", va="center", wrap=True, fontsize=8)
        left.set_axis_off()
    right.plot(around["angles"], around["yield_stress"], color="tab:blue")
    right.set(xlabel="angle to the rolling direction [deg]", ylabel="yield stress / curve")
    other = right.twinx()
    other.plot(around["angles"], around["r_value"], color="tab:orange")
    other.set_ylabel("r-value", color="tab:orange")
    figure.savefig(path, dpi=150)
    pyplot.close(figure)
