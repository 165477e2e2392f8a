"""The command `cadlink`. Each command imports what it needs when it runs, so that --help stays quick."""

import os
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, CycloptsError, Parameter

from .kernel_cache import choose_kernel_cache
from .materials_command import materials

DONE, UNEXPECTED, WRONG_INPUT, STOPPED_EARLY, INTERRUPTED = 0, 1, 2, 3, 130

app = App(
    name="cadlink",
    help="Sheet-metal forming on exact CAD surfaces: a STEP die in, a formed sheet out.",
    help_epilogue="Exit status: 0 done; 2 wrong input; 3 the run stopped early, --resume goes on; 130 Ctrl-C."
    " With --debug, an unexpected error shows where it came from.",
    help_format="plaintext",
)

app.command(materials)

Json = Annotated[bool, Parameter(name="--json", negative=(), help="Print JSON instead of tables.")]


@app.command
def inspect(file: Path, *, thickness: float | None = None, as_json: Json = False):
    """Show what a STEP file holds: parts, faces by kind, unit, size, smallest radii, and how well its faces meet.

    Parameters
    ----------
    file
        STEP file.
    thickness
        Sheet thickness in mm: slivers and concave radii are measured against it.
    """
    from cadlink.ahead import expect_step

    expect_step(file)
    from .inspect_step import describe, parts_table, remarks_on

    parts = describe(file, thickness)
    if as_json:
        print_json(parts)
    else:
        print_table(parts_table(parts))
        print(*remarks_on(parts), sep="\n")


@app.command
def check(scene: Path, *, as_json: Json = False):
    """Check a scene and say what will run, what is skipped, and why.

    Parameters
    ----------
    scene
        Scene file (TOML).
    """
    expect_cad(scene)
    from .check_scene import check_scene

    checked = check_scene(scene)
    if as_json:
        print_json(checked)
    else:
        starts = [f"  {name}: {travel:.4g} mm along its axis" for name, travel in checked["starts"].items()]
        print(checked["name"], checked["plan"], "Closing the tools on the blank:", *starts, sep="\n")


@app.command
def run(
    scene: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    resume: Annotated[bool, Parameter(negative=())] = False,
    as_json: Json = False,
):
    """Form the sheet a scene describes, and compare it with measured values where the scene has some.

    Parameters
    ----------
    scene
        Scene file (TOML).
    output
        Folder for result.pvd, history.csv, summary.json, run.log, checkpoint.h5.
    resume
        Go on from the folder's checkpoint.
    """
    expect_cad(scene)
    from .run_folder import run_in_folder

    summary = run_in_folder(scene, output, resume)
    print_report(summary, as_json)
    if summary["finished"]:
        return DONE
    again = f"cadlink run {scene} -o {output} --resume"
    reached = summary["figures"].get("stroke", 0.0)
    say(f"stopped at {reached:.4g} mm of stroke: {summary['message']}. The last good state is saved: {again}")
    return INTERRUPTED if summary["interrupted"] else STOPPED_EARLY


@app.command
def show(
    folder: Path,
    *,
    png: Path,
    field: str = "thinning",
    stroke: float | None = None,
):
    """Draw the formed sheet, coloured by a field, and the tools around it.

    Parameters
    ----------
    folder
        Folder of a run, or a .pvd file.
    png
        Picture to write.
    field
        Point or cell field, such as thinning, thickness, plastic_strain, contact_pressure.
    stroke
        Stroke in mm, the nearest frame is drawn; the last one by default.
    """
    from .pyvista_view import draw_run

    draw_run(folder, png, field=field, stroke=stroke)
    print(png)


@app.command
def report(folder: Path, *, plot: Path | None = None, as_json: Json = False):
    """Print the figures of a run, and the comparison with measured values.

    Parameters
    ----------
    folder
        Folder of a run.
    plot
        Picture of forces, draw-in and thinning over the stroke to write.
    """
    from . import report as figures

    print_report(figures.read_summary(folder), as_json)
    if plot:
        figures.plot(folder, plot)


bench = App(name="bench", help="Time and accuracy, measured here and now on one core.")
app.command(bench)


@bench.command
def projection(*cases: str, points: int = 20000, as_json: Json = False):
    """Exact projection against OpenCASCADE and against facets: ns per point and largest error.

    Parameters
    ----------
    cases
        Any of die, die-nurbs, die-recognized, torus-nurbs, torus-recognized, nacelle; all by default. Cases whose
        files are not there are left out.
    points
        Points within 2 mm of the surface.
    """
    from .bench_projection import measure, projection_table, sentences

    rows = measure(cases, points)
    if as_json:
        print_json(rows)
    else:
        print_table(projection_table(rows))
        print(*sentences(rows), sep="\n")


@bench.command
def shell(*problems: str, finest: int = 3, as_json: Json = False):
    """The shell against published large-deflection problems, on lattices and unstructured meshes. Takes minutes.

    The second table has what the meshes tend to, which is not what is published where that is a coarse mesh's answer.

    Parameters
    ----------
    problems
        Names such as cantilever, hemisphere, "hinged roof"; all by default.
    finest
        Number of refinements, 1 to 3.
    """
    from . import shell_limits
    from .bench_shell import HEADER, checked, line_of, rows

    found = []
    for row in rows(checked(problems), range(finest)):
        found.append(row)
        say(", ".join(text for text in line_of(row) if text))
    limits = list(shell_limits.limit_rows(found))
    if as_json:
        print_json({"runs": found, "limits": limits})
    else:
        second = plain_table(shell_limits.HEADER, map(shell_limits.line_of, limits))
        print_table(plain_table(HEADER, map(line_of, found)), second)


@bench.command
def elements(*, as_json: Json = False):
    """Time per element and step of membranes and shells, and with each material law, ns on one core."""
    from .bench_elements import HEADER, LAW_HEADER, law_line, law_rows, line_of, rows

    say("the first time, the kernels of every law are compiled for a minute or two")
    found, laws = rows(), law_rows()
    if as_json:
        print_json({"elements": found, "laws": laws})
    else:
        print_table(plain_table(HEADER, map(line_of, found)), plain_table(LAW_HEADER, map(law_line, laws)))


@bench.command
def explicit(*, largest: int = 100_000, as_json: Json = False):
    """The explicit solver: time, memory and operations per triangle and step, the share of contact in the square cup,
    and a stretched disc, time against error.

    Parameters
    ----------
    largest
        Triangles of the largest sheet, up to 500000, which takes about 2 GB.
    """
    from .bench_explicit import (
        CUP_HEADER,
        HEADER,
        STRETCH_HEADER,
        STRETCH_YARDSTICK,
        cup_line,
        cup_shares,
        line_of,
        rows,
        stretch_line,
        stretch_rows,
    )

    found, cup, discs = rows(largest), cup_shares(), stretch_rows()
    if as_json:
        print_json({"sheets": found, "cup": cup, "hemispherical_punch": discs, "yardstick_s": STRETCH_YARDSTICK})
    else:
        tables = plain_table(CUP_HEADER, [cup_line(cup)]), plain_table(STRETCH_HEADER, map(stretch_line, discs))
        print_table(plain_table(HEADER, map(line_of, found)), *tables)


@bench.command
def implicit(*, travel: float = 15.0, material: Literal["aluminium", "steel"] = "aluminium", as_json: Json = False):
    """The implicit solver: time against error on four meshes, where the time goes, iterations and increments.

    Parameters
    ----------
    travel
        Depth of the square cup in mm; 15 and 40 have measured draw-ins.
    material
        Of the square cup.
    """
    from .bench_implicit import CUP_HEADER, HEADER, YARDSTICK, cup_line, cup_rows, line_of, punch_rows

    punches, cups = punch_rows(), cup_rows(travel=travel, material=material)
    if as_json:
        print_json({"hemispherical_punch": punches, "square_cup": cups, "yardstick_s": YARDSTICK})
    else:
        print_table(plain_table(HEADER, map(line_of, punches)), plain_table(CUP_HEADER, map(cup_line, cups)))
        print(f"yardstick: {YARDSTICK:.0f} to 400 s of one core for 224 to 480 shells or bricks, a well-known code")


@bench.command(name="materials")
def bench_materials(*, as_json: Json = False):
    """Time per point and update of every material law, ns on one core."""
    from .bench_materials import bench_rows, bench_table

    found = bench_rows()
    if as_json:
        print_json(found)
    else:
        print_table(bench_table(found))


@app.command
def schema():
    """Print the JSON schema of scene files, for editors that complete and check TOML."""
    from .scene_keys import SceneKeys

    print_json(SceneKeys.model_json_schema())


def expect_cad(scene):
    """OpenCASCADE loads on another core while the solver does, where the scene's STEP file must be read."""
    import tomllib

    from cadlink.ahead import expect_step

    try:
        cad = tomllib.loads(scene.read_text(encoding="utf-8")).get("cad")
    except (OSError, ValueError):  # whoever reads the scene has the line for it
        return
    if isinstance(cad, str):
        expect_step(scene.parent / cad)


def print_table(*tables):
    """rich tables on standard output, as wide as they are where no terminal limits them."""
    from rich.console import Console

    console = Console()
    if not console.is_terminal:
        console = Console(width=200)
    for table in tables:
        console.print(table)


def plain_table(header, lines):
    """rich table of texts, numbers to the right."""
    from rich.table import Table

    table = Table()
    for k, title in enumerate(header):
        table.add_column(title, justify="left" if k == 0 else "right")
    for line in lines:
        table.add_row(*line)
    return table


def print_json(data):
    """JSON on standard output."""
    from .report import as_json

    print(as_json(data))


def print_report(summary, as_json):
    """Figures and comparison of a run."""
    from .report import comparison_table, figures_table

    if as_json:
        print_json(summary)
    else:
        print_table(figures_table(summary), *([comparison_table(summary)] if summary["comparison"] else []))
        for remark in summary["figures"].get("remarks", []):
            print(f"Mind: {remark}.")


def say(text):
    """Each line of a message on standard error."""
    for line in str(text).splitlines():
        print(f"cadlink: {line}", file=sys.stderr)


def input_errors():
    """Exceptions that mean the input is wrong, of the modules that are loaded: no other can have raised."""
    names = {
        "cadlink.errors": "CadError",
        "solver.errors": "SceneError",
        "plugins.scene_file": "SceneFileError",
        "plugins.report": "RunFolderError",
        "plugins.bench_projection": "BenchError",
        "plugins.bench_shell": "BenchError",
    }
    return tuple(getattr(sys.modules[module], name) for module, name in names.items() if module in sys.modules)


def main(arguments=None):
    """Run one command. arguments : list of str, those of the process by default. Returns the exit status."""
    choose_kernel_cache()
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in arguments
    arguments = [argument for argument in arguments if argument != "--debug"]
    try:
        status = app(arguments, exit_on_error=False, print_error=False, result_action="return_value")
        return status if isinstance(status, int) else DONE
    except CycloptsError as error:
        say(" ".join(str(error).split()) + " (cadlink --help)")
        return WRONG_INPUT
    except KeyboardInterrupt:
        say("interrupted")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except Exception as error:
        if debug:
            raise
        if isinstance(error, input_errors()):
            say(error)
            return WRONG_INPUT
        if isinstance(error, OSError) and error.filename:
            say(f"{error.filename}: {error.strerror}")
            return WRONG_INPUT
        say(f"unexpected {type(error).__name__}: {error}. Traceback in {keep_traceback()}; --debug shows it")
        return UNEXPECTED


def keep_traceback():
    """Writes the traceback of the current exception to a file of its own. Returns its path."""
    with tempfile.NamedTemporaryFile("w", prefix="cadlink-", suffix=".log", delete=False) as file:
        traceback.print_exc(file=file)
    return file.name


if __name__ == "__main__":
    sys.exit(main())
