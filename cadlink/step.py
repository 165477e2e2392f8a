"""A STEP file as named parts, placed, in mm.

OpenCASCADE reads in a process of its own (brep.py): a file that crashes or hangs it costs one
CadError, and this process never loads it.
"""

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cadlink import read_cache
from cadlink.errors import CadError, UnknownPart

TIMEOUT = 300.0  # s
READER = "cadlink.brep"


class Plane(NamedTuple):
    """A planar face: centroid [mm], unit normal out of the material, area [mm^2], face index."""

    origin: np.ndarray
    normal: np.ndarray
    area: float
    face: int


class Gaps(NamedTuple):
    """How well the file's own faces and edges meet [mm].

    edge    largest distance between an edge and the same edge as drawn on its faces
    vertex  the same at a vertex: from the ends of its edges, or their own gap if larger
    tolerance  largest tolerance the file (or its reader) grants an edge or vertex
    """

    edge: float
    vertex: float
    tolerance: float


class Part:
    """One solid, or free shell or face, of a STEP file: placed, in mm.

    name          product name; "bolt-2", "bolt-3" for further copies
    color         (r, g, b) in 0..1, or None
    kinds         Counter of face kinds: "plane", "cylinder", "cone", "sphere", "torus",
                  "revolution", "extrusion", "bspline", "bezier", "offset"
    n_faces       number of faces
    bounding_box  (2, 3) lowest and highest corner
    solid         True for a solid, False for an open shell or face
    planes        list of Plane, one for each planar face
    brep          the placed shape in mm, OpenCASCADE's binary BREP
    """

    def __init__(self, name, color, record, unit, path):
        self.name, self.color, self.unit, self.path = name, color, unit, path
        self.record = record
        self.kinds = record["kinds"]
        self.n_faces = len(record["kind_of_face"])
        self.bounding_box = record["box"]
        self.solid = record["solid"]
        self.planes = [Plane(*p) for p in record["planes"]]
        self.brep = record["brep"]

    def __repr__(self):
        size = " x ".join(f"{x:.6g}" for x in np.ptp(self.bounding_box, axis=0))
        body = "solid" if self.solid else "shell"
        return f"<Part {self.name!r}: {body}, {self.n_faces} faces, {size} mm>"

    def surface(self, faces=None):
        """ToolSurface of this part, or of the faces chosen by index."""
        from cadlink.surface import ToolSurface  # numba loads only when a surface is wanted

        return ToolSurface(self, faces=faces)

    def triangles(self):
        """points (n, 3) [mm] and cells (m, 3) for pictures; normals leave the material."""
        return self.record["points"], self.record["cells"]

    def gap_report(self):
        """Gaps of the file at this part's edges and vertices."""
        skin = self.record["skin"]
        tolerances = np.append(skin["edge_tolerances"], skin["vertex_tolerances"])
        return Gaps(
            float(skin["edge_gaps"].max(initial=0.0)),
            float(skin["vertex_gaps"].max(initial=0.0)),
            float(tolerances.max(initial=0.0)),
        )

    @cached_property
    def radii(self):
        """(smallest concave, smallest convex) radius of curvature of the faces [mm], inf for none.

        Convex is where the tool bulges outwards. Closed forms are exact; Bezier patches are
        sampled at 16 points or more of each nearly flat piece. Sharp edges do not count.
        """
        from cadlink.radii import smallest_radii  # numba loads only when asked

        return smallest_radii(self.record["skin"], float(np.ptp(self.bounding_box, axis=0).max()))

    @property
    def smallest_concave_radius(self):
        return self.radii[0]

    @property
    def smallest_convex_radius(self):
        return self.radii[1]

    def write_brep(self, path):
        """Write the placed shape in mm as a BREP text file, as gmsh reads it. Loads OpenCASCADE."""
        from OCP.BRepTools import BRepTools

        if not BRepTools.Write_s(self.shape(), os.fspath(path)):
            raise CadError(f"{path}: cannot be written")

    def shape(self):
        """The placed shape as a TopoDS_Shape. Loads OpenCASCADE."""
        import io

        from OCP.BinTools import BinTools
        from OCP.TopoDS import TopoDS_Shape

        shape = TopoDS_Shape()
        BinTools.Read_s(shape, io.BytesIO(self.brep))
        return shape


class Assembly(Mapping):
    """The parts of a STEP file by name, in file order.

    unit   the file's own length unit: "mm", "cm", "m", "um", "inch", "ft"; geometry is in mm
    path   the file
    """

    def __init__(self, parts, unit, path):
        self._parts = {part.name: part for part in parts}
        self.unit, self.path = unit, path

    def __getitem__(self, name):
        if name not in self._parts:
            have = ", ".join(self._parts)
            raise UnknownPart(f"{self.path}: no part {name!r}, expected one of: {have}")
        return self._parts[name]

    def __iter__(self):
        return iter(self._parts)

    def __len__(self):
        return len(self._parts)

    def __repr__(self):
        return f"<Assembly {self.path}: {', '.join(self._parts)}; file unit {self.unit}>"


def read_step(path, timeout=TIMEOUT):
    """The parts of a STEP file (AP203, AP214, AP242), placed as the assembly places them, in mm.

    path : file name
    timeout : s, after which reading is given up
    returns : Assembly, a mapping from part name to Part; a file read before comes from the user's
        cache folder (read_cache.py)
    raises : CadError, one line, for a file that is missing, is not STEP, has no faces, or makes
        OpenCASCADE crash or hang
    """
    path = Path(path)
    check_step(path)
    key = read_cache.key_of(path)
    result = read_cache.recall(key)
    if result is None:
        result = read_in_child(path, timeout)
        if "error" in result:
            raise CadError(f"{path}: {result['error']}")
        read_cache.keep(key, result)
    unit = result["unit"]
    parts = [Part(name, color, record, unit, path) for name, color, record in result["parts"]]
    return Assembly(parts, unit, path)


def check_step(path):
    """Raise CadError unless the file exists and starts like STEP (ISO 10303-21)."""
    if path.is_dir():
        raise CadError(f"{path}: found a folder, expected a STEP file")
    try:
        with open(path, "rb") as stream:
            head = stream.read(4096)
    except FileNotFoundError:
        raise CadError(f"{path}: no such file, expected a STEP file") from None
    except OSError as error:
        raise CadError(f"{path}: cannot be read ({error.strerror}), expected a STEP file") from None
    if not head:
        raise CadError(f"{path}: found an empty file, expected STEP (ISO-10303-21)")
    if b"ISO-10303-21" not in head:
        start = head[:24].decode("ascii", "replace")
        raise CadError(f"{path}: not a STEP file: starts with {start!r}, expected 'ISO-10303-21'")


def read_in_child(path, timeout):
    """What the reading process returns, or {"error": line} if it crashed or hung."""
    package = str(Path(__file__).resolve().parent.parent)
    environment = dict(os.environ)
    environment["PYTHONPATH"] = os.pathsep.join(p for p in (package, environment.get("PYTHONPATH", "")) if p)
    with tempfile.TemporaryDirectory(prefix="cadlink-") as folder:
        out = os.path.join(folder, "parts.pickle")
        command = [sys.executable, "-m", READER, str(path.resolve()), out]
        try:
            child = subprocess.run(
                command,
                env=environment,
                timeout=timeout,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return {"error": f"OpenCASCADE did not finish within {timeout:g} s"}
        if child.returncode != 0 or not os.path.exists(out):
            lines = child.stderr.decode("utf-8", "replace").strip().splitlines()
            why = f"signal {-child.returncode}" if child.returncode < 0 else (lines or ["no reason"])[-1]
            return {"error": f"OpenCASCADE crashed while reading it ({why})"}
        with open(out, "rb") as stream:
            return pickle.load(stream)
