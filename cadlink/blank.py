"""Flat blanks as meshes: triangles or quadrilaterals inside an outline, with named edges.

Structured meshes come by formula (cadlink.lattice); unstructured ones from gmsh, in a process of its own.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, pi
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from cadlink.blank_edges import ON_PLANE, edge_groups, nodes_on_planes
from cadlink.errors import CadError
from cadlink.flatness import bow, edge_wave
from cadlink.lattice import (
    lattice_equilateral,
    lattice_quarter_disc,
    lattice_rectangle,
    lattice_ring,
    mirror,
    split_quads,
)
from cadlink.outline import Disc, Polygon, Rectangle
from cadlink.plate import FaceOutline, blank_outline

WORKER = Path(__file__).with_name("blank_worker.py")
MOST_CELLS = 4e6
SYMMETRIC = 1e-6  # relative area: when the two sides of a symmetry plane count as equal
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Mesh:
    """A blank.

    points : (n, 3) mm
    cells : (m, 3) triangles or (m, 4) quadrilaterals, counter-clockwise seen from the tip of the normal
    groups : name -> node ids. "rim": the outer edge without symmetry planes, in counter-clockwise order;
        "symmetry_x", "symmetry_y", "symmetry_z": nodes on the plane normal to that axis, in order along it;
        "hole-1", ...: in order along the hole, holes sorted by x, then y; "center": the node at the outline's
        centre, if there is one
    normal : (3,) unit
    thickness : of the plate that was meshed [mm]; None if the outline has none
    """

    points: np.ndarray
    cells: np.ndarray
    groups: Mapping[str, np.ndarray]
    normal: np.ndarray
    thickness: float | None = None

    @property
    def areas(self):
        """(m,) area of each cell [mm^2]."""
        corner = self.points[self.cells]
        if self.cells.shape[1] == 3:
            first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        else:
            first, second = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
        return 0.5 * np.cross(first, second) @ self.normal


def mesh_blank(
    outline, size, *, arrangement="unstructured", shape="triangle", symmetry=(), z=None, flatness=0.0, edge_waves=None,
    timeout=120.0,
):  # fmt: skip
    """A flat blank as a mesh, ready to be formed.

    outline : Rectangle, Disc, Polygon; or a Part (or FaceOutline) that is a plate or a planar face.
        A plate is meshed on its mid-plane, and its thickness is on the mesh
    size : edge length to aim at [mm]
    arrangement : "unstructured"; or "structured": rectangles (rows with all diagonals one way), discs, rings; or
        "equilateral": rectangles of triangles with equal sides, the first along the blank's x axis
    shape : "triangle" or "quad"
    symmetry : axes whose plane through the origin halves the blank: ("x",) keeps x >= 0, ("x", "y") a quarter
    z : height of the mesh [mm]; None leaves a part where it is, and other outlines at 0
    flatness : how far from flat the blank is delivered [mm]: it rises from its plane by at most that, smoothly, along
        the normal, or against it where negative (cadlink.flatness); 0 is perfectly flat
    edge_waves : that many waves round the edge make it so, an even number beside symmetry; None is a bow of many waves
    timeout : seconds gmsh may take
    returns : Mesh. Nodes on a symmetry plane are on it exactly; the same input gives the same mesh;
        neighbouring cells and nodes have near numbers
    raises : CadError where the input is wrong, cannot be structured, is not symmetric, or where gmsh fails
    """
    _check_choices(size, arrangement, shape, z, flatness, timeout)
    outline, frame = _placed(outline, z)
    cuts = _half_planes(symmetry, frame.axes)
    _check_waves(edge_waves, flatness, cuts)
    expected = outline.area / size**2 / 2 ** len(cuts) * (2.0 if shape == "triangle" else 1.0)
    if expected > MOST_CELLS:
        raise CadError(f"mesh_blank size: {size:g} mm makes {expected:.0e} cells; expected at most {MOST_CELLS:.0e}")

    if arrangement != "unstructured":
        xy, cells, loops = _structured(outline, size, shape, cuts, arrangement)
    else:
        xy, cells, loops = _unstructured(outline, size, shape, cuts, timeout)

    xy, planes = nodes_on_planes(xy, cuts)
    groups = edge_groups(xy, cells, planes, loops, outline.center)
    if edge_waves is None:
        height = bow(xy @ _along(cuts), flatness)
    else:
        height = edge_wave((xy - outline.center) @ _along(cuts), flatness, edge_waves)
    points = frame.origin + xy @ frame.axes[:2] + np.outer(height, frame.axes[2])
    for name, nodes in planes.items():
        points[nodes, AXES.index(name)] = 0.0
    return Mesh(points, cells, groups, frame.axes[2], frame.thickness)


# ---- what is asked for


@dataclass(frozen=True, eq=False)
class _Frame:
    origin: np.ndarray
    axes: np.ndarray
    thickness: float | None = None


def _check_choices(size, arrangement, shape, z, flatness, timeout):
    for name, value in (("size", size), ("timeout", timeout)):
        if not _is_number(value) or not value > 0.0:
            raise CadError(f"mesh_blank {name}: expected a number > 0, got {value!r}")
    for name, value, known in (
        ("arrangement", arrangement, ("unstructured", "structured", "equilateral")),
        ("shape", shape, ("triangle", "quad")),
    ):
        if value not in known:
            raise CadError(f"mesh_blank {name}: expected {' or '.join(map(repr, known))}, got {value!r}")
    if arrangement == "equilateral" and shape != "triangle":
        raise CadError(f"mesh_blank shape: an equilateral lattice is of triangles, got {shape!r}")
    if z is not None and not _is_number(z):
        raise CadError(f"mesh_blank z: expected a height in mm, got {z!r}")
    if not _is_number(flatness):
        raise CadError(f"mesh_blank flatness: expected a height in mm, got {flatness!r}")


def _check_waves(edge_waves, flatness, cuts):
    if edge_waves is None:
        return
    if isinstance(edge_waves, bool) or not isinstance(edge_waves, (int, np.integer)) or edge_waves < 1:
        raise CadError(f"mesh_blank edge_waves: expected a whole number of waves > 0, got {edge_waves!r}")
    if cuts and edge_waves % 2:
        raise CadError(f"mesh_blank edge_waves: expected an even number beside symmetry, got {edge_waves!r}")
    if flatness == 0.0:
        raise CadError("mesh_blank edge_waves: expected a flatness other than 0, their height in mm, got 0")


def _is_number(value):
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool) and isfinite(value)


def _placed(outline, z):
    """The outline in its own plane, and where that plane is."""
    if isinstance(outline, (Rectangle, Disc, Polygon)):
        return outline, _Frame(np.array([0.0, 0.0, z or 0.0]), np.eye(3))
    if not isinstance(outline, FaceOutline):
        outline = blank_outline(outline)
    origin = outline.origin
    if z is not None:
        if outline.axes[2, 2] != 1.0:
            raise CadError(f"mesh_blank z: {outline.name or 'the face'} is not normal to z; leave z out")
        origin = np.array([0.0, 0.0, z])
    return outline, _Frame(origin, outline.axes, outline.thickness)


def _half_planes(symmetry, axes):
    """axis name -> direction in the plane of the outline that points into the half to keep, (2,) unit."""
    names = tuple(symmetry)
    if len(set(names)) < len(names) or not set(names) <= set(AXES):
        raise CadError(f"mesh_blank symmetry: expected some of 'x', 'y', 'z', each once, got {symmetry!r}")
    cuts = {}
    for name in names:
        direction = axes[:2, AXES.index(name)]
        if abs(np.hypot(*direction) - 1.0) > 1e-9:
            raise CadError(f"mesh_blank symmetry: the plane {name} = 0 is not perpendicular to the blank")
        cuts[name] = direction
    return cuts


def _along(cuts):
    """Axes in the plane of the outline (2, 2), as columns, the first across a symmetry plane where there is one."""
    x, y = next(iter(cuts.values()), np.array([1.0, 0.0]))
    return np.array([[x, -y], [y, x]])


# ---- structured


def _structured(outline, size, shape, cuts, arrangement):
    """Rectangles by rows; discs and rings about the origin's symmetry planes."""
    simple = outline.simple if isinstance(outline, FaceOutline) else outline
    along_axes = all(np.abs(direction).max() == 1.0 for direction in cuts.values())
    if simple is None or isinstance(simple, Polygon) or not along_axes:
        raise CadError("mesh_blank arrangement: only rectangles, discs and rings can be 'structured', along their axes")
    kept = {int(np.argmax(np.abs(direction))): name for name, direction in cuts.items()}
    if arrangement == "equilateral":
        if not isinstance(simple, Rectangle):
            raise CadError("mesh_blank arrangement: only rectangles can be 'equilateral'")
        points, cells = lattice_equilateral(*_kept_bounds(simple, kept), size)
        return points, cells, [loop.polyline() for loop in simple.loops]
    build = _structured_rectangle if isinstance(simple, Rectangle) else _structured_disc
    points, quads = build(simple, size, kept)
    cells = split_quads(points, quads) if shape == "triangle" else quads
    if isinstance(simple, Disc) and not simple.holes:
        for axis in {0, 1} - kept.keys():
            points, cells = mirror(points, cells, axis)
        points = points + np.array(simple.center)
    if isinstance(simple, Disc):
        points, cells = _near_numbers(points, cells)
    return points, cells, [loop.polyline() for loop in simple.loops]


def _structured_rectangle(rectangle, size, kept):
    return lattice_rectangle(*_kept_bounds(rectangle, kept), size)


def _kept_bounds(rectangle, kept):
    if rectangle.holes:
        raise CadError("mesh_blank arrangement: a rectangle with holes cannot be 'structured'")
    bounds = list(rectangle.bounds)
    for axis, name in kept.items():
        low, high = bounds[2 * axis : 2 * axis + 2]
        length = high - low
        _check_halves(name, max(high, 0.0) / length if low < -ON_PLANE * length else 1.0, low > ON_PLANE * length)
        bounds[2 * axis] = 0.0
    return bounds


def _structured_disc(disc, size, kept):
    centre = np.array(disc.center, dtype=float)
    for axis, name in kept.items():
        if abs(centre[axis]) > disc.radius:
            raise CadError(f"mesh_blank symmetry: the outline does not reach across the plane {name} = 0")
        if abs(centre[axis]) > ON_PLANE * disc.radius:
            raise CadError(f"mesh_blank symmetry: the disc's centre is not on the plane {name} = 0")
    if not disc.holes:
        return lattice_quarter_disc(disc.radius, size)
    hole = disc.holes[0]
    ring = len(disc.holes) == 1 and isinstance(hole, Disc)
    if not ring or np.hypot(*(centre - hole.center)) > ON_PLANE * disc.radius:
        raise CadError("mesh_blank arrangement: of discs with holes only concentric rings can be 'structured'")
    first, last = {(): (0, 2), (0,): (-0.5, 0.5), (1,): (0, 1)}.get(tuple(kept), (0, 0.5))
    points, quads = lattice_ring(hole.radius, disc.radius, first * pi, last * pi, size)
    return points + centre, quads


# ---- unstructured


def _unstructured(outline, size, shape, cuts, timeout):
    """The mesh of gmsh, run in a process of its own: it may crash or hang, and this one must not."""
    brep = outline.brep if isinstance(outline, FaceOutline) else None
    loops = [] if brep else outline.loops
    job = {
        "size": float(size),
        "shape": shape,
        "center": list(map(float, outline.center)),
        "cuts": [direction.tolist() for direction in cuts.values()],
        "loops": [
            {
                "points": loop.points.tolist(),
                "arcs": {str(i): list(map(float, p)) for i, p in loop.arcs.items()},
            }
            for loop in loops
        ],
    }
    with tempfile.TemporaryDirectory(prefix="cadlink-blank-") as name:
        folder = Path(name)
        (folder / "job.json").write_text(json.dumps(job))
        if brep:
            (folder / "face.brep").write_bytes(brep)
        run_worker(folder, timeout)
        with np.load(folder / "mesh.npz") as result:
            points, cells, areas = result["points"], result["cells"], result["areas"]
            samples, loop_of_curve = result["samples"], result["loop"]
    for name, before, after in zip(cuts, areas, areas[1:]):
        _check_halves(name, after / before, False)
    points, cells = _near_numbers(points, _anticlockwise(points, cells))

    polylines = [samples[loop_of_curve == k] for k in range(loop_of_curve.max() + 1)]
    polylines.sort(key=lambda curves: -np.ptp(curves, axis=(0, 1)).max())  # the outer loop is the widest
    return points, cells, polylines


def run_worker(folder, timeout, worker=WORKER):
    """Runs a worker script on a folder; a failure, a crash and a hang are each one CadError."""
    try:
        done = subprocess.run(
            [sys.executable, "-P", str(worker), str(folder)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout,
        )
    except subprocess.TimeoutExpired:
        raise CadError(f"mesh_blank: gmsh did not finish in {timeout:g} s; try a larger size") from None
    if done.returncode < 0:
        raise CadError(f"mesh_blank: gmsh crashed (signal {-done.returncode}) on this outline")
    if done.returncode > 0 or not (folder / "mesh.npz").exists():
        said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise CadError(f"mesh_blank: gmsh failed: {said[-1]}")


def _check_halves(name, part, beside):
    """Refuses a symmetry plane that neither halves the outline nor leaves it whole, touching it."""
    if part < SYMMETRIC or beside:
        raise CadError(f"mesh_blank symmetry: the outline does not reach across the plane {name} = 0")
    if min(abs(part - 0.5), abs(part - 1.0)) > SYMMETRIC:
        raise CadError(
            f"mesh_blank symmetry: the plane {name} = 0 does not halve the outline: "
            f"{100 * part:.4g} % of its area has {name} > 0"
        )


def _anticlockwise(points, cells):
    corner = points[cells]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    clockwise = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] < 0.0
    cells = cells.copy()
    cells[clockwise] = cells[clockwise, ::-1]
    return cells


def _near_numbers(points, cells):
    """Nodes and cells renumbered so that neighbours are near in memory; unused nodes dropped."""
    n, corners = len(points), cells.shape[1]
    row = cells.repeat(corners, axis=1).ravel()
    column = np.tile(cells, corners).ravel()
    graph = csr_array(coo_array((np.ones(len(row), dtype=np.int8), (row, column)), shape=(n, n)))
    order = reverse_cuthill_mckee(graph, symmetric_mode=True)
    order = order[np.isin(order, cells)]
    new = np.full(n, -1, dtype=np.int64)
    new[order] = np.arange(len(order))
    cells = new[cells]
    # each cell starts at its lowest node, and cells follow their nodes
    lowest = cells.argmin(axis=1)[:, None]
    cells = np.take_along_axis(cells, (lowest + np.arange(corners)) % corners, axis=1)
    return points[order], cells[np.lexsort(cells.T[::-1])]
