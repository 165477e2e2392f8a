"""Frames of a run as files ParaView opens: a .pvd collection, a .vtu per frame, a .vtp per tool and place.

The data sit inline, base64 and zlib: ParaView, pyvista and meshio all read that; appended data fail in some
distributions' ParaView. The time of a frame is the stroke of the leading tool [mm].
"""

import os
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkIntArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    VTK_QUAD,
    VTK_TRIANGLE,
    vtkCellArray,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

CELL_KINDS = {3: VTK_TRIANGLE, 4: VTK_QUAD}
COMPONENTS = {"stress": ("XX", "YY", "ZZ", "XY", "YZ", "XZ")}


class Entry(NamedTuple):
    """One line of a .pvd: a file, relative to it, shown from this time on."""

    time: float  # mm of stroke
    part: int  # 0 is the sheet, 1.. the tools
    name: str
    file: str


class PvdWriter:
    """Writes frames as they come; the .pvd is complete after each, so a run that stops leaves valid files.

    path : cup.pvd; frames/cup_0000.vtu and tools/cup_PUNCH_0000.vtp are written beside it
    scene : solver.Scene; tools whose surface has a CAD part (`surface.part.triangles()`) are written too
    resume : keep the frames the file has
    A frame takes the place of those with its stroke or more: what a resumed run goes through again.
    Raises OSError where the files cannot be written.
    """

    def __init__(self, path, scene, resume=False):
        self.path = Path(path)
        self.cells = np.ascontiguousarray(scene.blank.mesh.cells, dtype=np.int64)
        self.symmetry = scene.blank.symmetry_planes
        self.tools = {name: shown for name, tool in scene.tools.items() if (shown := _shown(tool)) is not None}
        self.file_names = _file_names(self.tools)
        self.places = {}  # tool name -> (place, file) written last
        self.entries = read_pvd(self.path) if resume and self.path.exists() else []
        if not self.entries:
            self._remove_earlier_run()

    def write(self, frame):
        """Append one frame (solver.Frame): the sheet, and each tool that has moved since the last."""
        earlier = frame.stroke - 1e-9 * max(1.0, abs(frame.stroke))
        self.entries = [entry for entry in self.entries if entry.time < earlier]
        number = sum(entry.part == 0 for entry in self.entries)
        sheet = self._place("frames", f"{self.path.stem}_{number:04d}.vtu")
        write_sheet(self.path.parent / sheet, frame, self.cells, self.symmetry)
        self.entries.append(Entry(frame.stroke, 0, "sheet", sheet))
        for part, name in enumerate(self.tools, start=1):
            turn = frame.tool_turns.get(name, np.eye(3))
            place = np.column_stack([turn, frame.tool_offsets.get(name, np.zeros(3))])
            self.entries.append(Entry(frame.stroke, part, name, self._tool_file(name, place, number)))
        write_pvd(self.path, self.entries)

    def close(self):
        """Every frame is on disk already; an empty run leaves an empty collection."""
        write_pvd(self.path, self.entries)

    def _tool_file(self, name, place, number):
        """File with the tool at this place, (3, 4) turn and displacement; the last one again where it stands still."""
        last = self.places.get(name)
        if last is None or not np.array_equal(last[0], place):
            file = self._place("tools", f"{self.path.stem}_{self.file_names[name]}_{number:04d}.vtp")
            points, cells, color = self.tools[name]
            write_triangles(self.path.parent / file, points @ place[:, :3].T + place[:, 3], cells, name, color)
            self.places[name] = (place, file)
        return self.places[name][1]

    def _place(self, folder, file):
        (self.path.parent / folder).mkdir(parents=True, exist_ok=True)
        return f"{folder}/{file}"

    def _remove_earlier_run(self):
        """Files an earlier run of the same name left here; the collection first, so that it never dangles."""
        earlier = read_pvd(self.path) if self.path.exists() else []
        self.path.unlink(missing_ok=True)
        for entry in earlier:
            (self.path.parent / entry.file).unlink(missing_ok=True)


def _shown(tool):
    """Points (n, 3), triangles (m, 3), colour of a tool as its file has it; None where it has no triangles."""
    part = getattr(tool.surface, "part", None)
    triangles = getattr(tool.surface if part is None else part, "triangles", None)
    if triangles is None:
        return None
    points, cells = triangles()
    return np.asarray(points, dtype=float), np.asarray(cells, dtype=np.int64), getattr(part, "color", None)


def _file_names(names):
    """{tool name: what it is called in file names}, letters every file system takes, each another."""
    chosen = {}
    for name in names:
        plain = re.sub(r"[^\w.-]+", "_", name)
        while plain in chosen.values():
            plain += "_"
        chosen[name] = plain
    return chosen


def write_sheet(path, frame, cells, symmetry=()):
    """The sheet of one frame as a .vtu, with its fields; stroke, stage, increment, symmetry as field data.

    frame : solver.Frame; cells : (m, 3) or (m, 4); symmetry : ("x", "y") for a quarter
    """
    grid = vtkUnstructuredGrid()
    grid.SetPoints(_points(frame.points))
    grid.SetCells(CELL_KINDS[cells.shape[1]], _cells(cells))
    for fields, data in ((frame.point_fields, grid.GetPointData()), (frame.cell_fields, grid.GetCellData())):
        for name, values in fields.items():
            data.AddArray(_array(name, values))
    about = grid.GetFieldData()
    about.AddArray(_single(vtkDoubleArray(), "stroke", [float(frame.stroke)]))
    about.AddArray(_single(vtkIntArray(), "increment", [int(frame.increment)]))
    about.AddArray(_single(vtkStringArray(), "stage", [frame.stage]))
    about.AddArray(_single(vtkStringArray(), "symmetry", list(symmetry)))
    _write(vtkXMLUnstructuredGridWriter(), grid, path)


def write_triangles(path, points, cells, name, color=None):
    """A tool as a .vtp. points : (n, 3) mm; cells : (m, 3); color : (r, g, b), 0 to 1, as field data."""
    surface = vtkPolyData()
    surface.SetPoints(_points(points))
    surface.SetPolys(_cells(cells))
    about = surface.GetFieldData()
    about.AddArray(_single(vtkStringArray(), "tool", [name]))
    if color is not None:
        about.AddArray(_single(vtkDoubleArray(), "color", [float(c) for c in color[:3]]))
    _write(vtkXMLPolyDataWriter(), surface, path)


def _points(points):
    held = vtkPoints()
    held.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    return held


def _cells(cells):
    n_cells, n_corners = cells.shape
    held = vtkCellArray()
    first = np.arange(0, n_cells * n_corners + 1, n_corners, dtype=np.int64)
    held.SetData(numpy_to_vtkIdTypeArray(first, deep=True), numpy_to_vtkIdTypeArray(cells.ravel(), deep=True))
    return held


def _array(name, values):
    held = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    held.SetName(name)
    for i, component in enumerate(COMPONENTS.get(name, ())):
        held.SetComponentName(i, component)
    return held


def _single(held, name, values):
    held.SetName(name)
    for value in values:
        held.InsertNextValue(value)
    return held


def _write(writer, data, path):
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.SetDataModeToBinary()
    writer.SetCompressorTypeToZLib()
    if not writer.Write():
        raise OSError(f"{path}: could not be written")


def write_pvd(path, entries):
    """The collection, replaced as a whole: a reader sees the old file or the new one."""
    root = ET.Element("VTKFile", type="Collection", version="1.0", byte_order="LittleEndian")
    collection = ET.SubElement(root, "Collection")
    for entry in entries:
        time = f"{entry.time:.10g}"
        ET.SubElement(collection, "DataSet", timestep=time, part=str(entry.part), name=entry.name, file=entry.file)
    ET.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + ".part")
    ET.ElementTree(root).write(unfinished, encoding="utf-8", xml_declaration=True)
    os.replace(unfinished, path)


def read_pvd(path):
    """Entries of a .pvd in its order. Raises ValueError where it is not one."""
    try:
        sets = [one.attrib for one in ET.parse(path).getroot().findall("Collection/DataSet")]
        return [
            Entry(float(one["timestep"]), int(one.get("part", 0)), one.get("name", "sheet"), one["file"])
            for one in sets
        ]
    except (ET.ParseError, TypeError, KeyError, ValueError) as error:
        raise ValueError(f"{path}: expected a .pvd collection of VTK files ({error})") from None
