"""Meshes one flat outline with gmsh: a script for a process of its own, since gmsh can take its process down.

    python -P blank_worker.py FOLDER

reads FOLDER/job.json, and FOLDER/face.brep where the job has no loops; writes FOLDER/mesh.npz. Status 1: the
last line on stderr says why. This module alone imports gmsh; it imports nothing of cadlink, so that it starts
quickly.
"""

import json
import sys
from pathlib import Path

import gmsh
import numpy as np

# (Mesh.Algorithm, Mesh.RecombinationAlgorithm): Delaunay, frontal and frontal for quadrilaterals, then
# simple or blossom recombination with a subdivision, after which no triangle remains
QUAD_WAYS = ((8, 2), (8, 3), (6, 3), (5, 3))
SAMPLES = 65  # points along each curve of a face, to tell its loops apart


def main(folder):
    """Runs the job in a folder; the exit status."""
    job = json.loads((folder / "job.json").read_text())
    gmsh.initialize(["blank_worker", "-nopopup"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        face = face_of_loops(job["loops"]) if job["loops"] else face_of_brep(folder / "face.brep")
        samples, loop_of_curve = sample_curves(face)
        face, areas = cut(face, job["cuts"])
        if face is None:
            points, cells = np.empty((0, 2)), np.empty((0, 3), dtype=np.int64)
        else:
            place_node(face, job["center"])
            points, cells = mesh(job["size"], job["shape"])
        np.savez(folder / "mesh.npz", points=points, cells=cells, samples=samples, loop=loop_of_curve, areas=areas)
    except Exception as error:  # gmsh raises plain Exception
        print(" ".join(str(error).split()), file=sys.stderr)
        return 1
    finally:
        gmsh.finalize()
    return 0


def face_of_loops(loops):
    """The plane face between an outer loop and its holes."""
    occ = gmsh.model.occ
    wires = []
    for loop in loops:
        corner = [occ.addPoint(x, y, 0.0) for x, y in loop["points"]]
        curves = []
        for i, start in enumerate(corner):
            end = corner[(i + 1) % len(corner)]
            if str(i) in loop["arcs"]:
                middle = occ.addPoint(*loop["arcs"][str(i)], 0.0)
                curves.append(occ.addCircleArc(start, middle, end, center=False))
                occ.remove([(0, middle)])
            else:
                curves.append(occ.addLine(start, end))
        wires.append(occ.addCurveLoop(curves))
    face = occ.addPlaneSurface(wires)
    occ.synchronize()
    return face


def face_of_brep(path):
    """The one face of a B-rep file, in the plane z = 0."""
    gmsh.model.occ.importShapes(str(path))
    gmsh.model.occ.synchronize()
    faces = gmsh.model.getEntities(2)
    if len(faces) != 1:
        raise ValueError(f"expected one face, found {len(faces)}")
    return faces[0][1]


def sample_curves(face):
    """Points along every curve of the face's loops, and each curve's loop.

    returns : (n_curves, SAMPLES, 2) mm, (n_curves,)
    """
    samples, loop_of_curve = [], []
    _, loops = gmsh.model.occ.getCurveLoops(face)
    for loop, curves in enumerate(loops):
        for curve in np.abs(curves):
            (start,), (end,) = gmsh.model.getParametrizationBounds(1, curve)
            xyz = gmsh.model.getValue(1, curve, np.linspace(start, end, SAMPLES))
            samples.append(np.reshape(xyz, (-1, 3))[:, :2])
            loop_of_curve.append(loop)
    return np.array(samples), np.array(loop_of_curve)


def cut(face, directions):
    """Keeps the half-planes direction . x >= 0, one after the other.

    returns : what is left of the face, None if nothing is; the areas [mm^2] before and after each cut
    """
    occ = gmsh.model.occ
    x0, y0, _, x1, y1, _ = gmsh.model.getBoundingBox(2, face)
    reach = 4.0 * max(abs(x0), abs(y0), abs(x1), abs(y1))
    areas = [occ.getMass(2, face)]
    for direction in directions:
        a = np.array(direction)
        along = np.array([-a[1], a[0]])
        corners = [-reach * along, reach * (a - along), reach * (a + along), reach * along]
        corner = [occ.addPoint(x, y, 0.0) for x, y in corners]
        edges = [occ.addLine(corner[i], corner[(i + 1) % 4]) for i in range(4)]
        half = occ.addPlaneSurface([occ.addCurveLoop(edges)])
        kept, _ = occ.intersect([(2, face)], [(2, half)])
        kept = [tag for dim, tag in kept if dim == 2]
        if len(kept) > 1:
            raise ValueError(f"the symmetry plane leaves {len(kept)} separate pieces")
        if not kept:
            return None, np.array([*areas, 0.0])
        face = kept[0]
        areas.append(occ.getMass(2, face))
    occ.synchronize()
    return face, np.array(areas)


def place_node(face, center):
    """Asks for a node at a point, if the face has that point."""
    occ = gmsh.model.occ
    x0, y0, _, x1, y1, _ = gmsh.model.getBoundingBox(2, face)
    point = occ.addPoint(*center, 0.0)
    distance = occ.getDistance(0, point, 2, face)[0]
    if distance <= 1e-9 * max(x1 - x0, y1 - y0):
        occ.fragment([(2, face)], [(0, point)])
    else:
        occ.remove([(0, point)])
    occ.synchronize()


def mesh(size, shape):
    """Triangles or quadrilaterals of one size: points (n, 2) mm, cells (m, 3) or (m, 4).

    No way to make quadrilaterals is best on every outline, and each fails on some; of four, the one with the bluntest
    worst corner.
    """
    options = {
        "Mesh.MeshSizeMin": size,
        "Mesh.MeshSizeMax": size,
        "Mesh.MeshSizeExtendFromBoundary": 0,
        "Mesh.MeshSizeFromPoints": 0,
        "Mesh.RandomSeed": 1,
    }
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
    if shape == "triangle":
        return triangles()
    meshes, failed = [], None
    for algorithm, recombination in QUAD_WAYS:
        try:
            meshes.append(quads(algorithm, recombination))
        except Exception as error:  # gmsh raises plain Exception
            failed = error
    if not meshes:
        raise ValueError(f"{failed}; try a smaller size, or triangles")
    return max(meshes, key=lambda found: worst_corner(*found))


def triangles():
    """Frontal Delaunay triangles."""
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.model.mesh.generate(2)
    return result(2, 3)


def quads(algorithm, recombination):
    """Quadrilaterals joined from triangles."""
    gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.Algorithm", algorithm)
    gmsh.option.setNumber("Mesh.RecombineAll", 1)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", recombination)
    gmsh.model.mesh.generate(2)
    return result(3, 4)


def result(kind, n_corners):
    """The mesh gmsh holds: points (n, 2) mm and cells (m, n_corners), rows of points."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    row[tags] = np.arange(len(tags))
    found = {int(k): row[nodes] for k, nodes in zip(*gmsh.model.mesh.getElements(2)[::2])}
    if set(found) != {kind}:
        raise ValueError(f"the mesh has cells without {n_corners} corners")
    return xyz.reshape(-1, 3)[:, :2], found[kind].reshape(-1, n_corners)


def worst_corner(points, cells):
    """The smallest sine among the corners of all cells; negative where a cell is not convex."""
    corner = points[cells]
    ahead = np.roll(corner, -1, axis=1) - corner
    behind = np.roll(corner, 1, axis=1) - corner
    cross = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    sine = cross / np.hypot(ahead[..., 0], ahead[..., 1]) / np.hypot(behind[..., 0], behind[..., 1])
    return np.min(sine * np.sign(sine.sum(axis=1, keepdims=True)))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
