"""Exact projection beside OpenCASCADE and beside closest points on facets: time and error in one run.

Points lie within BAND of the surface. Exact methods are held against OpenCASCADE's distance at SUBSET
of them (and against a formula where there is one), facets against the exact distance. Times are CPU
time of one core, the least of several repeats; a query starts from a search structure that stands, whose
own time and memory are in columns of their own.

Warm rows come in pairs. "moved x": every point moves by x once, in a random direction, after a cold search;
repeats start from the same seeds. "walk of 20 x": 20 such moves one after the other, each with the seeds of the
one before; the time is the mean of a move and the error that of the last.

A file is read three times: first of a session, which loads OpenCASCADE in a process of its own; with that loaded; and
from what is kept of it. Facets finer than MOST allows are left out, and the row says so.
"""

import contextlib
import os
import tempfile
import time
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIE = ROOT / "examples" / "square_cup" / "square_cup.step"
NACELLE = ROOT.parent / "shared" / "step" / "nacelle.stp"  # used where it is there
BAND = 2.0  # mm
SUBSET = 200
CHORDS = (0.1, 0.01, 0.001)  # mm
MOVES = 20  # of a walk
MOST = 2_000_000  # facets: OpenCASCADE's mesh and the trees of all peers take about 3 kB for each
FINE = 0.01  # mm: chord of the facets that the exact surface is held against in a sentence
RING, TUBE = 12.0, 4.0  # mm, radii of the torus


class BenchError(Exception):
    """One line that names what is wrong with a benchmark asked for."""


def cases():
    """Name -> (what it is, function that makes the part, exact distance or None)."""
    return {
        "die": ("example die, 22 planes, cylinders and tori", die, None),
        "die-nurbs": ("the same converted to NURBS, kept as such", die_of_nurbs, None),
        "die-recognized": ("the same NURBS, recognized", lambda: die_of_nurbs(recognize=True), None),
        "torus-nurbs": ("torus as a rational surface, kept as such", torus, distance_to_torus),
        "torus-recognized": ("the same, recognized", lambda: torus(recognize=True), distance_to_torus),
        "nacelle": ("engine nacelle, 6 rational B-splines of degree 5", nacelle, None),
    }


def die():
    from cadlink import read_step

    return read_step(DIE)["DIE"] if DIE.exists() else None


def nacelle():
    from cadlink import read_step

    return next(iter(read_step(NACELLE).values())) if NACELLE.exists() else None


def die_of_nurbs(recognize=False):
    part = die()
    return None if part is None else converted(part.shape(), "die-nurbs", recognize)


def torus(recognize=False):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    return converted(BRepPrimAPI_MakeTorus(RING, TUBE).Solid(), "torus-nurbs", recognize)


def converted(shape, name, recognize):
    """A shape of B-splines only, as a part; recognize : in closed form where they have one."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    from cadlink.brep import part_record
    from cadlink.step import Part

    nurbs = BRepBuilderAPI_NurbsConvert(shape, True).Shape()
    return Part(name, None, part_record(nurbs, recognize), "mm", "memory")


def distance_to_torus(points):
    import numpy as np

    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - RING, points[:, 2]) - TUBE


def measure(names=(), n_points=20000):
    """Rows {case, about, method, points, ns, error, build, kilobytes, ratio, note}; None where not measured.

    build : s, of the search structure, or of reading the file; kilobytes : of the search structure

    names : of the cases, all by default; n_points : number of points for the exact methods
    """
    import numba

    known = cases()
    for name in names:
        if name not in known:
            raise BenchError(f"bench projection: no case {name!r}, expected some of: {', '.join(known)}")
    if n_points < 1:
        raise BenchError(f"bench projection: points must be 1 or more, found {n_points}")
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        return [row for name in names or known for row in measure_case(name, known[name], n_points)]
    finally:
        numba.set_num_threads(threads)


def measure_case(name, case, n_points):
    import numpy as np

    about, make, formula = case
    part = make()
    if part is None:
        return []
    surface = part.surface()
    points = points_near(surface, part.bounding_box, n_points)
    hit = surface.project(points)
    way = np.random.default_rng(1).normal(size=points.shape)
    way /= np.linalg.norm(way, axis=1)[:, None]
    rows = []

    def add(method, n, ns, error, note="", build=None, kilobytes=None):
        rows.append(
            {
                "case": name,
                "about": about,
                "method": method,
                "points": n,
                "ns": ns,
                "error": error,
                "build": build,
                "kilobytes": kilobytes,
                "note": note,
            }
        )

    for method, seconds in read_times(part.path):
        add(method, 0, None, None, build=seconds)

    few = points[:SUBSET]
    shape = part.shape()
    occ_seconds, truth = cpu_time(lambda: occ_distances(shape, few), 1)

    def error_at(at, found):
        """Largest error of signed distances at points: by formula, or of their size by OpenCASCADE."""
        if formula is not None:
            return float(np.abs(found - formula(at)).max())
        exact = truth if at is points else occ_distances(shape, at[:SUBSET])
        return float(np.abs(np.abs(found[:SUBSET]) - exact).max())

    build, kilobytes = size_of(part)
    for method, at, seed in (
        ("exact, cold", points, None),
        ("exact, moved 1 um", points + 1e-3 * way, hit.seed),
        ("exact, moved 50 um", points + 5e-2 * way, hit.seed),
    ):
        least, found = cpu_time(lambda at=at, seed=seed: surface.project(at, seed))
        add(method, len(at), 1e9 * least / len(at), error_at(at, found.distance), build=build, kilobytes=kilobytes)
        build = kilobytes = None
    warm = rows[-1]["ns"]
    for size, words in ((1e-3, "1 um"), (5e-2, "50 um")):
        seconds, at, found = timed_walk(surface, points, hit.seed, size)
        add(f"exact, walk of {MOVES} x {words}", len(at), 1e9 * seconds / len(at), error_at(at, found.distance))
    error = float(np.abs(truth - np.abs(formula(few))).max()) if formula is not None else None
    add("OCC DistShapeShape", len(few), 1e9 * occ_seconds / len(few), error, "the truth" if formula is None else "")
    rate = 0.0  # facets times chord, of the chord before
    for chord in CHORDS:
        if rate > MOST * chord:
            millions = rate / chord / 1e6
            note = f"left out: about {millions:.1f} million facets expected, {MOST / 1e6:g} million allowed"
            add(f"facets {chord:g} mm", 0, None, None, note)
            continue
        corners, cells = facets(shape, chord)
        rate = len(cells) * chord
        for method, search in (("libigl", igl_search), ("Open3D", open3d_search), ("VTK", vtk_search)):
            label = f"facets {chord:g} mm, {method}"
            build, query = cpu_time(partial(ready, search, corners, cells, points[:1]), 1)
            if query is None:
                add(label, 0, None, None, "not installed")
                continue
            some = points[: min(len(points), 5000)]
            least, found = cpu_time(lambda query=query, some=some: query(some), 2)
            miss = float(np.abs(found - np.abs(hit.distance[: len(some)])).max())
            add(label, len(some), 1e9 * least / len(some), miss, f"{len(cells)} facets", build)
    for row in rows:
        row["ratio"] = row["ns"] / warm if row["ns"] is not None else None
    return rows


def read_times(path):
    """(what, s) of a file read first of a session, with OpenCASCADE loaded, and again from what is kept of it."""
    from cadlink import read_step
    from cadlink.child import FORKED

    if not Path(path).is_file():
        return []
    FORKED.stop()
    found = []
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        for method, folder in (
            ("read, first of a session", one),
            ("read, OpenCASCADE loaded", two),
            ("read again, kept", two),
        ):
            # Reading is a process of its own: wall time.
            with kept_in(folder):
                start = time.perf_counter()
                read_step(path)
                found.append((method, time.perf_counter() - start))
    return found


@contextlib.contextmanager
def kept_in(folder):
    """What is kept of files that are read goes to another folder."""
    before = os.environ.get("CADLINK_READ_CACHE")
    os.environ["CADLINK_READ_CACHE"] = folder
    try:
        yield
    finally:
        if before is None:
            del os.environ["CADLINK_READ_CACHE"]
        else:
            os.environ["CADLINK_READ_CACHE"] = before


def size_of(part):
    """Time to build the search structure of a part's surface [s], and its memory [kB]."""
    least, surface = cpu_time(lambda: built(part), 3)
    arrays = [*surface.skin, *surface.hints]
    return least, sum(array.nbytes for array in arrays) / 1e3


def built(part):
    surface = part.surface()
    surface.project(part.bounding_box)
    return surface


def points_near(surface, box, n):
    """n points at most BAND from the skin, spread as points of the box are nearest to it."""
    import numpy as np

    rng = np.random.default_rng(0)
    anywhere = box[0] - BAND + rng.random((n, 3)) * (np.ptp(box, axis=0) + 2.0 * BAND)
    hit = surface.project(anywhere)
    return hit.point + BAND * (2.0 * rng.random((n, 1)) - 1.0) * hit.normal


def cpu_time(work, repeats=5):
    """Least CPU time of some repeats [s], and what the work returns."""
    least = float("inf")
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        least = min(least, time.process_time() - start)
    return least, result


def timed_walk(surface, points, seed, size, repeats=3):
    """Mean CPU time of a move in a random walk of MOVES [s], least of some repeats; where it ends, Projection there."""
    import numpy as np

    least = float("inf")
    for _ in range(repeats):
        rng, at, last, seconds = np.random.default_rng(2), points, seed, 0.0
        for _ in range(MOVES):
            way = rng.normal(size=points.shape)
            at = at + size * way / np.linalg.norm(way, axis=1)[:, None]
            start = time.process_time()
            found = surface.project(at, last)
            seconds += time.process_time() - start
            last = found.seed
        least = min(least, seconds / MOVES)
    return least, at, found


def occ_distances(shape, points):
    """Distance to the shells of a shape: asked of a solid, OpenCASCADE says 0 inside."""
    import numpy as np
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL
    from OCP.TopoDS import TopoDS_Compound

    from cadlink.brep import explore

    builder, skin = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(skin)
    for part in explore(shape, TopAbs_SHELL) or explore(shape, TopAbs_FACE):
        builder.Add(skin, part)
    found = np.empty(len(points))
    for i, p in enumerate(points):
        found[i] = BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, p))).Vertex(), skin).Value()
    return found


# --- facets --------------------------------------------------------------------------------------


def facets(shape, chord):
    """points (n, 3) and triangles (m, 3) that stay within a chord [mm] of the faces."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools

    from cadlink.brep import faces_of
    from cadlink.display import triangles_of

    BRepTools.Clean_s(shape)
    BRepMesh_IncrementalMesh(shape, chord, False, 1.5, False)
    return triangles_of(faces_of(shape))


def ready(search, corners, cells, points):
    """A search that has answered once, so that its tree stands; None where it is not installed."""
    query = search(corners, cells)
    if query is not None:
        query(points)
    return query


def igl_search(corners, cells):
    """points -> distance to the facets by a tree of libigl 2.6; None where it is not installed."""
    try:
        import igl  # pyright: ignore[reportMissingImports]
    except ImportError:
        return None
    import numpy as np

    corners, cells, tree = np.ascontiguousarray(corners, float), np.ascontiguousarray(cells, np.int64), igl.AABB()
    tree.init(corners, cells)
    return lambda points: np.sqrt(tree.squared_distance(corners, cells, points)[0])


def open3d_search(corners, cells):
    """The same by Open3D, which computes in single precision."""
    try:
        import open3d  # pyright: ignore[reportMissingImports]
    except ImportError:
        return None
    import numpy as np

    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    tensor = open3d.core.Tensor
    scene.add_triangles(tensor(corners.astype(np.float32)), tensor(cells.astype(np.uint32)))

    def query(points):
        # The closest points themselves: they, too, are known to single precision.
        foot = scene.compute_closest_points(tensor(points.astype(np.float32)), nthreads=1)["points"].numpy()
        return np.linalg.norm(points - foot, axis=1)

    return query


def vtk_search(corners, cells):
    """The same by vtkStaticCellLocator, a Python call for each point included (about 1 us)."""
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import mutable, vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkGenericCell, vtkPolyData, vtkStaticCellLocator
    except ImportError:
        return None
    import numpy as np

    place, array, mesh = vtkPoints(), vtkCellArray(), vtkPolyData()
    place.SetData(numpy_to_vtk(np.ascontiguousarray(corners), deep=True))
    starts = np.arange(0, 3 * len(cells) + 1, 3, dtype=np.int64)
    array.SetData(
        numpy_to_vtkIdTypeArray(starts, deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells, np.int64).ravel(), deep=True),
    )
    mesh.SetPoints(place)
    mesh.SetPolys(array)
    locator = vtkStaticCellLocator()
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    foot, cell = [0.0, 0.0, 0.0], vtkGenericCell()
    number, sub, squared = mutable(0), mutable(0), mutable(0.0)

    def query(points):
        found = np.empty(len(points))
        for i, p in enumerate(points.tolist()):
            locator.FindClosestPoint(p, foot, cell, number, sub, squared)
            found[i] = squared.get()
        return np.sqrt(found)

    return query


def projection_table(rows):
    """Rows as a rich table."""
    from rich.table import Table

    table = Table(title="Closest points within 2 mm of the surface, one core, CPU time")
    columns = ("case", "method", "points", "ns/point", "largest error [mm]", "x moved 50 um", "built in [ms]", "kB", "")
    for column in columns:
        table.add_column(column, justify="left" if column in ("case", "method", "") else "right")
    last = None
    for row in rows:
        if row["case"] != last and last is not None:
            table.add_section()
        table.add_row(
            row["case"] if row["case"] != last else "",
            row["method"],
            str(row["points"] or ""),
            f"{row['ns']:.0f}" if row["ns"] is not None else "",
            f"{row['error']:.1e}" if row["error"] is not None else "",
            f"{row['ratio']:.3g}" if row["ratio"] is not None else "",
            f"{1e3 * row['build']:.3g}" if row["build"] is not None else "",
            f"{row['kilobytes']:.0f}" if row["kilobytes"] is not None else "",
            row["note"],
        )
        last = row["case"]
    return table


def sentences(rows):
    """For each case, exact beside the quickest and the nearest query on facets of FINE mm."""
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        mine = {row["method"]: row for row in rows if row["case"] == case and row["ns"] is not None}
        on_facets = [row for method, row in mine.items() if method.startswith(f"facets {FINE:g} mm,")]
        if not on_facets:
            continue
        cold, warm = mine["exact, cold"], mine["exact, moved 50 um"]
        quickest, nearest = min(row["ns"] for row in on_facets), min(row["error"] for row in on_facets)
        lines.append(
            f"{case}: exact {cold['ns']:.0f} ns cold, {warm['ns']:.0f} ns after 50 um, within {cold['error']:.0e} mm; "
            f"on facets of {FINE:g} mm the quickest query takes {quickest:.0f} ns, the nearest is {nearest:.0e} mm off"
        )
    return lines
