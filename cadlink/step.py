"""A STEP file as named parts, placed, in mm.

OpenCASCADE reads in a process of its own (brep.py): a file that crashes or hangs it costs one
CadError, and this process never loads it.
"""

import os
from collections.abc import Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cadlink import read_cache
from cadlink.ahead import HEAD, MARK, SEW, begin_to_load
from cadlink.child import in_child, run_module
from cadlink.edges import edge_polyline
from cadlink.errors import CadError, UnknownPart
from cadlink.gaps import gaps_of
from cadlink.pick import pick_faces
from cadlink.shifted import shifted

TIMEOUT = 300.0  # s
READER = "cadlink.brep"
TESSELLATOR = "cadlink.tessellation"


class Sewing(NamedTuple):
    """How a part was made of loose faces: tolerance [mm], faces, and edges that stayed free (0 for a solid)."""

    tolerance: float
    faces: int
    free_edges: int


class Plane(NamedTuple):
    """A planar face: centroid [mm], unit normal out of the material, area [mm^2], face index."""

    origin: np.ndarray
    normal: np.ndarray
    area: float
    face: int


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
    tree          names of the products from the top of the assembly down to this part's
    sewn          Sewing where loose faces of the file were joined, or None
    face_names    name of each face in the file, "" for none
    face_colors   (r, g, b) of each face, the part's where it has none of its own, or None
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
        self.tree = record.get("tree") or ()
        self.sewn = Sewing(*record["sewn"]) if record.get("sewn") else None
        self.face_names = record.get("face_names") or [""] * self.n_faces
        self.face_colors = record.get("face_colors") or [color] * self.n_faces

    def __repr__(self):
        size = " x ".join(f"{x:.6g}" for x in np.ptp(self.bounding_box, axis=0))
        body = "solid" if self.solid else "shell"
        return f"<Part {self.name!r}: {body}, {self.n_faces} faces, {size} mm>"

    def surface(self, faces=None, *, offset=0.0, flip=False):
        """The exact surface of this part: ToolSurface, or a surface of the same call where it is moved or turned.

        faces : numbers, names or colours ("#rrggbb", or (r, g, b) in 0 .. 1) of the faces to keep; None for all
        offset : mm, clearance: the surface moves away from its material by this much
        flip : the material is on the other side of the faces
        raises : CadError, one line, for faces the part does not have
        """
        from cadlink.surface import ToolSurface  # numba loads only when a surface is wanted

        surface = ToolSurface(self, faces=faces)
        return shifted(surface, offset, flip)

    def edge(self, numbers=None, *, through=None, chord=0.05):
        """Corners (k, 3) [mm] of a chain of edges, for example for a drawbead.

        numbers : of the edges along the chain; through : points (x, y, z) in their place, each near its edge
        chord : mm, largest distance of the polyline from the edges
        raises : CadError, one line, for edges the part does not have or that do not meet
        """
        return edge_polyline(self, numbers, through, chord)

    def pick(self, faces):
        """Indices (k,) of faces by number, name or colour, as `Projection.face` tells them. Raises CadError."""
        return pick_faces(self, faces)

    def triangles(self):
        """points (n, 3) [mm] and cells (m, 3) for pictures; normals leave the material."""
        return self.record["points"], self.record["cells"]

    def facets(self, chord, *, angle=30.0, normals="nodal", faces=None, crease=40.0, exact_normals=True):
        """FacetSurface of this part's triangles, to compare with the exact surface.

        chord : mm, largest distance of a triangle from its face
        angle : degrees, largest angle between neighbouring triangles of one face
        normals, crease : as for FacetSurface; Nagata patches take the exact normals of the faces at their corners
            unless exact_normals is False
        faces : indices, names or colours of the faces to keep, None for all; `face` of a projection is the index
        raises : CadError, one line, where OpenCASCADE fails
        """
        from cadlink.facets import FacetSurface  # numba loads only when a surface is wanted

        if not (np.isfinite(chord) and chord > 0.0):
            raise CadError(f"part {self.name!r}: chord {chord!r}, expected a length in mm above 0")
        if not 0.0 < angle <= 90.0:
            raise CadError(f"part {self.name!r}: angle {angle!r}, expected degrees above 0, at most 90")
        chosen = None if faces is None else pick_faces(self, faces).tolist()
        job = {"brep": self.brep, "chord": float(chord), "angle": float(np.radians(angle)), "faces": chosen}
        found = in_child(TESSELLATOR, job, TIMEOUT, "dividing it into triangles", f"part {self.name!r}")
        exact = found["normals"] if normals == "nagata" and exact_normals else None
        surface = FacetSurface(
            found["points"],
            found["cells"],
            normals,
            crease=None if normals == "element" else crease,
            corner_normals=exact,
            labels=found["face"],
        )
        surface.part, surface.on_faces = self, found["on_face"]
        return surface

    def gap_report(self, thickness=None):
        """Gaps: how well edges and faces meet, normal jumps, slivers, and the smallest concave radius.

        thickness : mm of the sheet to be formed, against which slivers and radii are measured; None where not known
        raises : CadError for a thickness that is no length above 0
        """
        if thickness is not None and not (np.isfinite(thickness) and thickness > 0.0):
            raise CadError(f"thickness {thickness!r}, expected a length in mm above 0")
        return gaps_of(self, thickness)

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


def read_step(path, timeout=TIMEOUT, *, sew=SEW):
    """The parts of a STEP file (AP203, AP214, AP242), placed as the assembly places them, in mm.

    path : file name
    timeout : s, after which reading is given up
    sew : mm; loose faces of one product that meet within it are sewn to shells and solids, which `Part.sewn` tells;
        0 leaves each a part of its own
    returns : Assembly, a mapping from part name to Part; a file read before comes from the user's cache folder
        (read_cache.py)
    raises : CadError, one line, for a file that is missing, is not STEP, has no faces or only triangles, refers to
        files that are missing, or makes OpenCASCADE crash or hang
    """
    if not (np.isfinite(sew) and sew >= 0.0):
        raise CadError(f"read_step sew: found {sew!r}, expected a length in mm, 0 or more")
    path = Path(path)
    check_step(path)
    key = read_cache.key_of(path, sew)
    result = read_cache.recall(key)
    if result is None:
        result = read_in_child(path, timeout, sew, partial(read_cache.keep, key))
        if "error" in result:
            raise CadError(f"{path}: {result['error']}")
    unit = result["unit"]
    parts = [Part(name, color, record, unit, path) for name, color, record in result["parts"]]
    return Assembly(parts, unit, path)


def check_step(path):
    """Raise CadError unless the file exists and starts like STEP (ISO 10303-21)."""
    if path.is_dir():
        raise CadError(f"{path}: found a folder, expected a STEP file")
    try:
        with open(path, "rb") as stream:
            head = stream.read(HEAD)
    except FileNotFoundError:
        raise CadError(f"{path}: no such file, expected a STEP file") from None
    except OSError as error:
        raise CadError(f"{path}: cannot be read ({error.strerror}), expected a STEP file") from None
    if not head:
        raise CadError(f"{path}: found an empty file, expected STEP (ISO-10303-21)")
    if MARK not in head:
        start = head[:24].decode("ascii", "replace")
        raise CadError(f"{path}: not a STEP file: starts with {start!r}, expected 'ISO-10303-21'")


def read_in_child(path, timeout, sew=SEW, keep=None):
    """What the reading process returns, or {"error": line} if it crashed or hung; keep as for run_module."""
    begin_to_load()
    # Meanwhile this process loads numba, which the surface of a part needs.
    import cadlink.surface  # noqa: F401

    return run_module(READER, [str(path.resolve()), repr(float(sew))], timeout, "reading it", keep)
