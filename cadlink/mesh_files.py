"""Triangles and quadrilaterals of a mesh file, whatever the format, through meshio."""

import contextlib
import io
import warnings
from pathlib import Path

import numpy as np

from cadlink.errors import CadError

KINDS = ("triangle", "quad")
# The corners of elements with nodes on their sides come first.
CORNERS = {"triangle6": 3, "triangle7": 3, "quad8": 4, "quad9": 4}


def read_mesh(path):
    """points (n, 3) and a list of cells (m, 3), (m, 4) as the file has them.

    raises : CadError, one line, for a file that is missing, unknown, damaged, or without triangles or quadrilaterals
    """
    path = Path(path)
    if path.is_dir():
        raise CadError(f"{path}: found a folder, expected a mesh file such as STL or OBJ")
    if not path.exists():
        raise CadError(f"{path}: no such file, expected a mesh file such as STL or OBJ")
    if path.stat().st_size == 0:
        raise CadError(f"{path}: empty, expected a mesh file such as STL or OBJ")
    import meshio  # 0.2 s

    said = io.StringIO()
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            warnings.simplefilter("ignore")
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio raises whatever its parsers do, or leaves
        known = path.suffix.lower() in meshio.extension_to_filetypes
        why = str(error).strip().splitlines()
        why = why[0] if why and known and not isinstance(error, SystemExit) else "expected a format meshio reads"
        if known and why.startswith("expected a format"):
            why = f"damaged, or not a {path.suffix.lower()} file"
        raise CadError(f"{path}: cannot be read as a mesh ({why})") from None
    points = np.asarray(mesh.points, float)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise CadError(f"{path}: found no points in it, expected a mesh of triangles or quadrilaterals")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    cells = []
    for block in mesh.cells:
        data = np.asarray(block.data)
        if block.type in CORNERS:
            data = data[:, : CORNERS[block.type]]
        elif block.type not in KINDS:
            continue
        if len(data):
            cells.append(data.astype(np.int64))
    if not cells:
        found = ", ".join(sorted({block.type for block in mesh.cells})) or "no cells"
        raise CadError(f"{path}: found {found}, expected triangles or quadrilaterals")
    return points, cells
