"""Pictures of a run: the formed sheet coloured by a field, and the tools cut open around it."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import report
from .vtk_files import read_pvd

# field -> label, factor from the file's unit to the label's
LABELS = {
    "thinning": ("thinning [%]", 100.0),
    "thickness": ("thickness [mm]", 1.0),
    "strain_major": ("major strain", 1.0),
    "strain_minor": ("minor strain", 1.0),
    "fld_margin": ("margin to the forming limit [%]", 100.0),
    "plastic_strain": ("equivalent plastic strain", 1.0),
    "stress": ("von Mises stress [MPa]", 1.0),
    "displacement": ("displacement [mm]", 1.0),
    "contact_gap": ("gap to the nearest tool [mm]", 1.0),
    "contact_pressure": ("contact pressure [MPa]", 1.0),
    "friction_traction": ("friction traction [MPa]", 1.0),
    "squeeze": ("squeeze between tools [mm]", 1.0),
}
TOOL_COLORS = (
    (0.56, 0.64, 0.71),
    (0.73, 0.64, 0.5),
    (0.5, 0.6, 0.55),
    (0.65, 0.56, 0.69),
)  # where CAD has none
INK = "#20262d"
COLOURS = "turbo"


class Shot(NamedTuple):
    """What a picture shows."""

    sheet: object  # pyvista.UnstructuredGrid, the whole part, with the array "shown"
    tools: dict  # name -> pyvista.PolyData
    stroke: float
    label: str
    extremes: tuple  # of the field as written, before it is spread over the nodes


def draw_run(folder, png, field="thinning", stroke=None, size=(1800, 850)):
    """Writes a picture: left the formed sheet, right the tools, if any, and the sheet cut open.

    folder : folder of a run, or a .pvd; field : point or cell field; stroke : mm, the nearest frame is shown
    Raises RunFolderError for a folder without frames or a field that does not exist.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    pyvista.OFF_SCREEN = True
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)  # VTK warns where there is no display, then draws without
    path = Path(folder)
    path = path if path.suffix == ".pvd" else path / "result.pvd"
    shot = load(path, field, stroke)
    plotter = pyvista.Plotter(
        shape=(1, 2 if shot.tools else 1),
        window_size=size if shot.tools else (size[0] // 2 + size[0] // 8, size[1]),
        border=False,
        off_screen=True,
    )
    plotter.set_background("white", top="#e6ebf0", all_renderers=True)
    scale = round_scale(shot.sheet["shown"])
    plotter.subplot(0, 0)
    draw_sheet(plotter, shot, scale)
    draw_words(plotter, path, shot)
    if shot.tools:
        plotter.subplot(0, 1)
        draw_section(plotter, shot, scale)
    plotter.enable_anti_aliasing("ssaa", all_renderers=True)
    Path(png).parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(png)
    plotter.close()


# What is shown


def load(path, field, stroke):
    """The frame nearest to a stroke as a Shot. path : .pvd"""
    import pyvista

    if not path.exists():
        raise report.RunFolderError(f"{path}: no such file, expected the folder of a run, or its .pvd file")
    try:
        entries = read_pvd(path)
    except ValueError as error:
        raise report.RunFolderError(str(error)) from None
    if not entries:
        raise report.RunFolderError(f"{path}: holds no frame yet")
    times = np.unique([entry.time for entry in entries])
    time = times[-1] if stroke is None else times[np.argmin(np.abs(times - stroke))]
    now = [entry for entry in entries if entry.time == time]
    sheet = next((pyvista.read(path.parent / entry.file) for entry in now if entry.part == 0), None)
    if sheet is None:
        raise report.RunFolderError(f"{path}: holds no sheet at {time:g} mm of stroke")
    label, extremes = show_field(sheet, field, path)
    tools = {entry.name: pyvista.read(path.parent / entry.file) for entry in now if entry.part > 0}
    return Shot(whole(sheet), tools, time, label, extremes)


def show_field(sheet, field, path):
    """Puts a field on the nodes as "shown": vectors by length, stresses by von Mises.

    Returns its label and its smallest and largest value.
    """
    known = sorted({*sheet.cell_data.keys(), *sheet.point_data.keys()})
    if field not in known:
        raise report.RunFolderError(f"{path}: found no field {field!r}, expected one of {', '.join(known)}")
    layer = next((end for end in ("_top", "_bottom") if field.endswith(end)), "")
    label, factor = LABELS.get(field.removesuffix(layer), (field.replace("_", " "), 1.0))
    label += layer.replace("_", ", ")
    on_cells = field in sheet.cell_data
    values = np.asarray(sheet.cell_data[field] if on_cells else sheet.point_data[field], dtype=float)
    if values.ndim == 2 and values.shape[1] == 6:
        values = von_mises(values)
    elif values.ndim == 2:
        values = np.linalg.norm(values, axis=1)
    extremes = factor * values.min(), factor * values.max()
    if on_cells:
        corners = sheet.cells_dict
        nodal, weight = np.zeros(sheet.n_points), np.zeros(sheet.n_points)
        for cells in corners.values():
            np.add.at(nodal, cells.ravel(), np.repeat(values, cells.shape[1]))
            np.add.at(weight, cells.ravel(), 1.0)
        values = nodal / np.maximum(weight, 1.0)
    sheet.point_data["shown"] = factor * values
    return label, extremes


def von_mises(stress):
    """(m,) of (m, 6) xx yy zz xy yz xz."""
    xx, yy, zz, xy, yz, xz = stress.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + xz**2))


def whole(sheet):
    """The sheet with its mirror images, for each symmetry plane its file names."""
    for axis in sheet.field_data.get("symmetry", ()):
        normal = np.eye(3)["xyz".index(axis)]
        sheet = sheet.merge(sheet.reflect(normal), merge_points=True)
    return sheet


class Scale(NamedTuple):
    """Colours of a field: round limits and the number of steps between them."""

    limits: tuple
    n_steps: int


def round_scale(values, most=8):
    """A Scale that holds all values in at most so many steps of 1, 2, 2.5 or 5 times a power of ten."""
    low, high = float(np.min(values)), float(np.max(values))
    if high - low <= 1e-9 * max(abs(low), abs(high), 1e-9):
        low, high = low - 0.5, high + 0.5
    power = 10.0 ** np.floor(np.log10((high - low) / most))
    steps = power * np.array([1.0, 2.0, 2.5, 5.0, 10.0, 20.0])
    first, last = np.floor(low / steps + 1e-9), np.ceil(high / steps - 1e-9)
    k = int(np.argmax(last - first <= most))
    return Scale((first[k] * steps[k], last[k] * steps[k]), int(last[k] - first[k]))


# How it is drawn


def draw_sheet(plotter, shot, scale):
    """The whole sheet from above, and the scalar bar."""
    surface = shot.sheet.extract_surface(algorithm="dataset_surface")
    bar = {
        "title": shot.label + "\n", "color": INK, "title_font_size": 26, "label_font_size": 22,
        "n_labels": scale.n_steps + 1, "fmt": "%.4g", "width": 0.5, "height": 0.06,
        "position_x": 0.25, "position_y": 0.04,
    }  # fmt: skip
    plotter.add_mesh(
        surface, scalars="shown", cmap=COLOURS, clim=scale.limits, n_colors=4 * scale.n_steps,
        scalar_bar_args=bar, smooth_shading=True, split_sharp_edges=False,
        specular=0.25, specular_power=20, ambient=0.25,
    )  # fmt: skip
    edges = surface.extract_feature_edges(boundary_edges=True, feature_edges=False, manifold_edges=False)
    plotter.add_mesh(edges, color=INK, line_width=2)
    look_from(plotter, surface, azimuth=-55.0, elevation=38.0, zoom=1.05)


def draw_section(plotter, shot, scale):
    """Tools where they stand, cut open, the sheet between them."""
    import pyvista

    surface = shot.sheet.extract_surface(algorithm="dataset_surface")
    # the cut lies a little beside the plane of symmetry, whose nodes would make it ragged
    origin = np.asarray(surface.center) + [0.0, 1e-4 * surface.length, 0.0]
    for i, (name, tool) in enumerate(shot.tools.items()):
        colour = tool.field_data.get("color", TOOL_COLORS[i % len(TOOL_COLORS)])
        half, face = cut(tool, origin)
        plotter.add_mesh(half, color=mixed(colour, 0.7, 0.3), ambient=0.2, smooth_shading=True, split_sharp_edges=True)
        if face is not None:
            plotter.add_mesh(face, color=mixed(colour, 0.35, 0.6), lighting=False)
            rim = face.extract_surface(algorithm="dataset_surface").extract_feature_edges(
                boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
            )
            plotter.add_mesh(rim, color=mixed(colour, 0.4), line_width=2, lighting=False)
        place = (0.06 + 0.31 * (i % 3), 0.06 - 0.035 * (i // 3))
        plotter.add_text(name, position=place, viewport=True, font_size=12, color=mixed(colour, 0.62))
    shown = {
        "scalars": "shown",
        "cmap": COLOURS,
        "clim": scale.limits,
        "n_colors": 4 * scale.n_steps,
        "show_scalar_bar": False,
    }
    plotter.add_mesh(surface.clip("-y", origin=origin), **shown)
    plotter.add_mesh(surface.slice("y", origin=origin), line_width=6, lighting=False, **shown)
    everything = pyvista.merge([*shot.tools.values()])
    look_from(plotter, everything, azimuth=-72.0, elevation=24.0, zoom=1.35)


def cut(tool, origin):
    """The half of a tool behind y = origin, and the face the cut leaves: None where the tool is open."""
    closed = tool.clean(tolerance=1e-6).triangulate()
    half = closed.clip("-y", origin=origin)
    if not closed.is_manifold:
        return half, None
    face = closed.clip_closed_surface("y", origin=origin)
    flat = np.abs(face.cell_centers().points[:, 1] - origin[1]) < 1e-6 * closed.length
    return half, face.extract_cells(flat) if flat.any() else None


def mixed(colour, share, white=0.0):
    """A share of a colour, and of white; the rest is black."""
    return tuple(share * float(c) + white for c in colour)


def look_from(plotter, mesh, azimuth, elevation, zoom):
    """Camera towards the middle of a mesh, z up. azimuth, elevation : degrees."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    centre = np.asarray(mesh.center)
    plotter.camera.focal_point = centre
    plotter.camera.position = centre + 3.0 * mesh.length * towards
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.reset_camera(bounds=mesh.bounds)
    plotter.camera.zoom(zoom)


def draw_words(plotter, path, shot):
    """Name of the run, stroke and range of the field."""
    try:
        name = report.read_summary(path.parent)["name"]
    except report.RunFolderError:
        name = path.stem
    low, high = shot.extremes
    text = f"stroke {shot.stroke:.4g} mm; {shot.label} {low:.3g} to {high:.3g}"
    plotter.add_text(name, position=(0.03, 0.935), viewport=True, font_size=18, color=INK)
    plotter.add_text(text, position=(0.03, 0.895), viewport=True, font_size=12, color=INK)
