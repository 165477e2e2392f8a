"""FacetSurface against brute force, winding numbers, differences and closed forms."""

import numpy as np
import pytest

from cadlink import CadError, FacetSurface
from tests.cadlink.facet_shapes import (
    box_mesh,
    cylinder_mesh,
    distance_to_triangles,
    halves,
    sampled_patches,
    torus_mesh,
    winding,
)

KINDS = ["element", "nodal", "nagata"]


def around(surface, n, seed=0):
    """Half anywhere, half near the skin."""
    rng = np.random.default_rng(seed)
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    points = low + (rng.random((n, 3)) * 1.5 - 0.25) * (high - low)
    cells = surface.triangles()[1]
    chosen = cells[rng.integers(len(cells), size=n // 2)]
    weight = rng.dirichlet(np.ones(3), n // 2)
    foot = np.einsum("nk,nkc->nc", weight, surface.points[chosen])
    points[: n // 2] = foot + rng.normal(size=(n // 2, 3)) * 0.02 * np.ptp(low - high)
    return points


MESHES = {
    "torus of triangles": lambda: torus_mesh(quads=False, noise=0.3)[:2],
    "torus of quadrilaterals": lambda: torus_mesh(noise=0.3)[:2],
    "can": cylinder_mesh,
    "box": box_mesh,
    "open strip": lambda: cylinder_mesh(turn=1.5),
    "one triangle": lambda: (np.array([[0.0, 0, 0], [10, 0, 1], [2, 7, 0]]), np.array([[0, 1, 2]])),
}


@pytest.mark.parametrize("kind", ["element", "nodal"])
@pytest.mark.parametrize("name", MESHES)
def test_distance_is_that_to_all_triangles(name, kind):
    surface = FacetSurface(*MESHES[name](), kind)
    points = around(surface, 400)
    hit = surface.project(points)
    vertices, triangles = surface.triangles()
    assert np.abs(hit.distance) == pytest.approx(distance_to_triangles(vertices, triangles, points), abs=1e-12)
    assert np.linalg.norm(points - hit.point, axis=1) == pytest.approx(np.abs(hit.distance), abs=1e-12)
    if surface.closed:
        away = np.abs(hit.distance) > 1e-9
        inside = winding(vertices, triangles, points) > 0.5
        assert ((hit.distance < 0.0) == inside)[away].all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", MESHES)
def test_seed_changes_nothing_and_fields_are_sound(name, kind):
    surface = FacetSurface(*MESHES[name](), kind)
    points = around(surface, 500)
    hit = surface.project(points)
    moved = points + np.random.default_rng(3).normal(size=points.shape) * 0.05
    cold, warm = surface.project(moved), surface.project(moved, hit.seed)
    assert np.abs(cold.distance - warm.distance).max() < 1e-12
    assert np.abs(cold.distance - hit.distance).max() <= np.linalg.norm(moved - points, axis=1).max() or not (
        surface.closed
    )
    for field in (hit.normal, hit.direction):
        assert np.linalg.norm(field, axis=1) == pytest.approx(1.0, abs=1e-12)
    assert np.abs((hit.normal * hit.direction).sum(axis=1)).max() < 1e-9
    assert (hit.curvature[:, 0] >= hit.curvature[:, 1]).all()
    count = sum(len(c) for c in cells) if isinstance(cells := MESHES[name]()[1], list) else len(cells)
    assert hit.face.min() >= 0 and hit.face.max() < count


@pytest.mark.parametrize("name", MESHES)
def test_nagata_distance_is_that_to_dense_samples(name):
    """Nearest of all samples is an upper bound; it is above the true distance by at most spacing^2 / (2 d)."""
    surface = FacetSurface(*MESHES[name](), "nagata")
    points = around(surface, 120, seed=2)
    hit = surface.project(points)
    samples = sampled_patches(surface.skin)
    truth = np.array([min(np.linalg.norm(x - p, axis=1).min() for x in samples) for p in points])
    spacing = max(np.ptp(x, axis=0).max() for x in samples) / 40.0
    assert (np.abs(hit.distance) <= truth + 1e-12).all()
    assert (np.abs(hit.distance) >= np.sqrt(np.maximum(truth**2 - 2.0 * spacing**2, 0.0)) - 1e-9).all()
    # The foot is on its patch.
    for k in range(0, 120, 10):
        assert np.linalg.norm(samples[hit.face[k]] - hit.point[k], axis=1).min() < 1.5 * spacing


@pytest.mark.parametrize("name", ["torus of triangles", "torus of quadrilaterals", "can", "open strip"])
def test_nagata_normal_is_the_gradient_and_curvature_the_hessian(name):
    surface = FacetSurface(*MESHES[name](), "nagata")
    points = around(surface, 600, seed=5)
    hit = surface.project(points)
    step = 1e-5
    gradient, hessian = np.zeros((600, 3)), np.zeros((600, 3, 3))
    steady = np.abs(hit.distance) > 0.02
    for c in range(3):
        move = np.zeros(3)
        move[c] = step
        after, before = surface.project(points + move), surface.project(points - move)
        gradient[:, c] = (after.distance - before.distance) / (2.0 * step)
        hessian[:, :, c] = (after.normal - before.normal) / (2.0 * step)
        for other in (after, before):
            steady &= (other.face == hit.face) & (np.sign(other.distance) == np.sign(hit.distance))
            steady &= np.linalg.norm(other.point - hit.point, axis=1) < 40.0 * step
    assert steady.sum() > 300
    assert np.abs(gradient - hit.normal)[steady].max() < 1e-6
    d, across = hit.distance, np.cross(hit.normal, hit.direction)
    expected = 0.0
    for i, e in enumerate((hit.direction, across)):
        k = hit.curvature[:, i]
        factor = k / (1.0 + k * d)
        steady &= (np.abs(1.0 + k * d) > 0.3) & (np.abs(factor) < 10.0)
        expected = expected + factor[:, None, None] * e[:, :, None] * e[:, None, :]
    # On a smooth side the foot stays while the point turns round it: that curvature is the neighbours' matter.
    skin = surface.skin
    inside = np.array([foot_inside(skin, *s) for s in hit.seed])
    wrong = np.abs(hessian - expected).max(axis=(1, 2))[steady & inside]
    assert len(wrong) > 150 and wrong.max() < 1e-4


def foot_inside(skin, item, s, t):
    room = 1e-3
    last = 1.0 - s - t if skin.sides[int(item)] == 3 else min(1.0 - s, 1.0 - t)
    return min(s, t, last) > room


def test_nodal_normals_are_averages_of_the_elements_at_a_node():
    """Seed Eq. 14 on a box: at a corner (1, 1, 1)/sqrt 3, in the middle of a face the face's own."""
    points, cells = box_mesh()
    surface = FacetSurface(points, cells, "nodal")
    hit = surface.project(np.array([[10.5, 7.4, 4.3], [12.0, 0.0, 0.0], [12.0, 3.5, 0.0]]))
    assert hit.normal[0] == pytest.approx(np.ones(3) / np.sqrt(3.0))
    assert hit.normal[1] == pytest.approx([1.0, 0.0, 0.0])
    # Bilinear in the face: at y = 3.5 of 7, half way from the middle to the side, (1, 1/2, 0) / |..|.
    assert hit.normal[2] == pytest.approx(np.array([1.0, 0.5, 0.0]) / np.sqrt(1.25))
    assert hit.distance == pytest.approx([np.sqrt(0.25 + 0.16 + 0.09), 2.0, 2.0])
    assert hit.face[1] == 1


def test_element_normals_are_those_of_the_elements():
    points, cells = box_mesh()
    surface = FacetSurface(points, cells, "element")
    hit = surface.project(np.array([[12.0, 0.0, 0.0], [11.0, 7.5, 0.0], [-5.0, 0.0, -4.5]]))
    assert hit.normal == pytest.approx(np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 0, -1.0]]))
    assert hit.distance == pytest.approx([2.0, np.hypot(1.0, 0.5), 0.5])
    assert (hit.curvature == 0.0).all()


@pytest.mark.parametrize("kind, order", [("element", 1), ("nodal", 2), ("nagata", 2)])
def test_normals_converge_on_a_torus(kind, order):
    """On the torus itself element normals err by the chord's angle, averaged ones by its square."""
    worst = []
    for n in (24, 48):
        points, cells, _ = torus_mesh(2 * n, n)
        surface = FacetSurface(points, cells, kind)
        p, exact = torus_points(400)
        hit = surface.project(p)
        worst.append(np.linalg.norm(hit.normal - exact, axis=1).max())
    assert worst[0] / worst[1] == pytest.approx(2.0**order, rel=0.25)


def torus_points(n):
    rng = np.random.default_rng(1)
    u, v = rng.random((2, n)) * 2 * np.pi
    normal = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    return 12.0 * np.column_stack([np.cos(u), np.sin(u), 0 * u]) + 4.0 * normal, normal


def test_nagata_on_exact_normals_errs_by_the_fourth_power_of_the_angle():
    """A parabola with the end tangents of an arc of angle a is at most R a^4 / 128 outside it."""
    worst = []
    for n in (8, 16):
        points, cells = cylinder_mesh(n=n, rows=1, turn=np.pi, capped=False)
        known = points[cells] * [1.0, 1.0, 0.0]
        surface = FacetSurface(points, cells, "nagata", corner_normals=known)
        t = np.linspace(0.01, np.pi - 0.01, 500)
        p = np.column_stack([9.0 * np.cos(t), 9.0 * np.sin(t), np.full(500, 6.3)])
        worst.append(np.abs(surface.project(p).distance - 1.0).max())
        assert worst[-1] == pytest.approx(8.0 * (np.pi / n) ** 4 / 128.0, rel=0.03)
    assert worst[0] / worst[1] == pytest.approx(16.0, rel=0.05)


def test_nodal_curvature_is_that_of_the_cylinder():
    points, cells = cylinder_mesh(n=60, rows=1)
    hit = FacetSurface(points, cells[0], "nodal").project(np.array([[8.5 * np.cos(0.05), 8.5 * np.sin(0.05), 6.0]]))
    assert hit.curvature[0] == pytest.approx([1.0 / 8.0, 0.0], rel=5e-3, abs=1e-12)


def test_nagata_keeps_creases():
    """The rim of a can stays sharp, its round side is smooth; a lower crease angle makes all its sides sharp."""
    points, cells = cylinder_mesh(n=16)
    p = np.array([[8.4, 0.1, 12.5], [8.4 * np.cos(0.39), 8.4 * np.sin(0.39), 6.0]])
    hit = FacetSurface(points, cells, "nagata").project(p)
    assert hit.curvature[0, 0] == 1e12 and hit.curvature[0, 1] == pytest.approx(1.0 / 8.0, abs=0.08)
    assert hit.normal[0] == pytest.approx([0.62, 0.0, 0.78], abs=0.05)
    assert hit.curvature[1] == pytest.approx([1.0 / 8.0, 0.0], abs=0.02)
    assert hit.distance[1] == pytest.approx(0.4, abs=8.0 * (np.pi / 8.0) ** 4 / 64.0)
    faceted = FacetSurface(points, cells, "nagata", crease=5.0).project(p)
    assert faceted.distance[1] == pytest.approx(8.4 - 8.0, abs=0.16)


def test_facets_turned_the_wrong_way_are_turned_round():
    points, cells, _ = torus_mesh(quads=False)
    mixed = cells.copy()
    wrong = np.random.default_rng(4).random(len(cells)) < 0.4
    mixed[wrong] = mixed[wrong][:, ::-1]
    right, mended = FacetSurface(points, cells, "element"), FacetSurface(points, mixed, "element")
    assert (mended.turned == wrong).all() and not right.turned.any()
    p = around(right, 200)
    assert mended.project(p).distance == pytest.approx(right.project(p).distance, abs=1e-12)
    inward = FacetSurface(points, cells[:, ::-1], "element")
    assert inward.turned.all()
    assert inward.project(p).distance == pytest.approx(right.project(p).distance, abs=1e-12)
    hollow = FacetSurface(points, cells, "element", flip=True)
    assert np.abs(hollow.project(p).distance + right.project(p).distance).max() < 1e-12


def test_cavity_points_into_itself():
    """A small box inside a large one is a hole in the material."""
    outer, cells = box_mesh()
    points, both = np.vstack([outer, 0.3 * outer]), np.vstack([cells, cells + 8])
    hit = FacetSurface(points, both, "element").project(np.array([[0.0, 0, 0], [8.0, 0, 0], [11.0, 0, 0]]))
    assert hit.distance == pytest.approx([1.2, -2.0, 1.0])


def test_open_mesh_has_two_sides():
    """Over the strip +, under it -, beyond its rim the way of the nearest point; flip changes the side."""
    points = np.array([[0.0, 0, 0], [10, 0, 0], [10, 5, 0], [0, 5, 0]])
    surface = FacetSurface(points, np.array([[0, 1, 2, 3]]), "nodal")
    p = np.array([[3.0, 2, 1], [3, 2, -1], [13, 2, 4], [13, 2, -4]])
    hit = surface.project(p)
    assert not surface.closed
    assert hit.distance == pytest.approx([1.0, -1.0, 5.0, -5.0])
    assert hit.normal[2] == pytest.approx([0.6, 0.0, 0.8]) and hit.curvature[2] == pytest.approx([1e12, 0.0])
    assert hit.normal[3] == pytest.approx([-0.6, 0.0, 0.8]) and hit.curvature[3] == pytest.approx([0.0, -1e12])
    other = FacetSurface(points, np.array([[0, 1, 2, 3]]), "nodal", flip=True).project(p)
    assert other.distance == pytest.approx(-hit.distance)


def test_slivers_and_collapsed_cells_do_no_harm():
    """A thin triangle between two others, and cells that repeat a point."""
    points = np.array([[0.0, 0, 0], [10, 0, 0], [5, 0, 0], [5, 6, 0], [5, -6, 0], [5, 6, 0]])
    cells = np.array([[0, 2, 3], [2, 1, 3], [0, 1, 2], [1, 0, 4], [3, 5, 0]])
    surface = FacetSurface(points, cells, "element")
    assert surface.dropped == 1
    p = np.random.default_rng(0).normal(size=(200, 3)) * 4.0
    hit = surface.project(p)
    assert np.isfinite(np.column_stack([hit.distance, hit.normal, hit.curvature])).all()
    assert np.abs(hit.distance) == pytest.approx(distance_to_triangles(*surface.triangles(), p), abs=1e-12)
    over = surface.project(np.array([[5.0, 0.0, 1.0], [3.0, 0.0, -2.0]]))
    assert np.abs(over.distance) == pytest.approx([1.0, 2.0]) and over.distance[0] * over.distance[1] < 0.0


def test_one_cell_many_cells_and_points_far_away():
    points, cells, _ = torus_mesh(60, 40, quads=False)
    surface = FacetSurface(points, cells, "element")
    p = np.random.default_rng(0).normal(size=(50, 3)) * 1e4
    assert np.abs(surface.project(p).distance) == pytest.approx(
        distance_to_triangles(*surface.triangles(), p), rel=1e-13
    )


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "vtk", "off"])
def test_files_of_every_kind(tmp_path, suffix):
    import meshio

    points, cells, _ = torus_mesh(quads=False)
    path = tmp_path / f"die.{suffix}"
    meshio.Mesh(points, [("triangle", cells)]).write(path)
    surface = FacetSurface.read(path, "element")
    assert surface.closed and len(surface.corners) == len(cells)
    p = around(surface, 100)
    assert surface.project(p).distance == pytest.approx(
        FacetSurface(points, cells, "element").project(p).distance, abs=1e-5
    )
    inch = FacetSurface.read(path, "element", scale=25.4)
    assert np.ptp(inch.points, axis=0) == pytest.approx(25.4 * np.ptp(surface.points, axis=0))


def test_binary_stl_and_quadrilaterals_beside_triangles(tmp_path):
    import meshio

    points, cells = cylinder_mesh()
    meshio.Mesh(points, [("triangle", np.vstack([halves(cells[0]), cells[1]]))]).write(tmp_path / "a.stl", binary=True)
    meshio.Mesh(points, [("quad", cells[0]), ("triangle", cells[1])]).write(tmp_path / "a.vtk")
    one, two = FacetSurface.read(tmp_path / "a.stl", "element"), FacetSurface.read(tmp_path / "a.vtk", "element")
    p = around(two, 100)
    assert one.closed and two.closed
    assert one.project(p).distance == pytest.approx(two.project(p).distance, abs=1e-5)


WRONG = {
    "no such file": (None, "die.stl: no such file"),
    "empty": (b"", "die.stl: empty"),
    "not a mesh": (b"what is this\n", "die.stl: cannot be read as a mesh"),
    "cut": (b"\0" * 80 + (100).to_bytes(4, "little") + b"\1" * 70, "die.stl: "),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files_are_one_line(tmp_path, name):
    content, line = WRONG[name]
    path = tmp_path / "die.stl"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(CadError) as error:
        FacetSurface.read(path)
    assert line in str(error.value) and "\n" not in str(error.value)


def test_a_file_without_facets_and_an_unknown_format(tmp_path):
    import meshio

    meshio.Mesh(np.eye(3), [("line", np.array([[0, 1]]))]).write(tmp_path / "wire.vtk")
    with pytest.raises(CadError, match="wire.vtk: found line, expected triangles or quadrilaterals"):
        FacetSurface.read(tmp_path / "wire.vtk")
    (tmp_path / "die.xyz").write_text("1 2 3")
    with pytest.raises(CadError, match="die.xyz: cannot be read as a mesh .expected a format meshio reads"):
        FacetSurface.read(tmp_path / "die.xyz")


def moebius():
    n = 30
    t = 2 * np.pi * np.arange(n) / n
    edge = lambda w: np.column_stack(  # noqa: E731
        [(10 + w * np.cos(t / 2)) * np.cos(t), (10 + w * np.cos(t / 2)) * np.sin(t), w * np.sin(t / 2)]
    )
    points = np.vstack([edge(-1.0), edge(1.0)])
    cells = [[i, i + 1, n + i + 1, n + i] for i in range(n - 1)] + [[n - 1, n, 0, 2 * n - 1]]
    return points, np.array(cells)


BAD = {
    "one-sided": (moebius, "one-sided surface"),
    "no cell": (lambda: (np.eye(3), np.zeros((0, 3), int)), "no cell"),
    "index": (lambda: (np.eye(3), np.array([[0, 1, 3]])), "points 0 to 3, expected 0 to 2"),
    "nan": (lambda: (np.eye(3) * np.nan, np.array([[0, 1, 2]])), "nan"),
    "shape": (lambda: (np.eye(3), np.array([[0, 1]])), "expected integers"),
    "flat points": (lambda: (np.zeros((3, 2)), np.array([[0, 1, 2]])), "expected (n, 3)"),
    "collapsed": (lambda: (np.zeros((3, 3)), np.array([[0, 1, 2]])), "collapsed"),
    "no area": (lambda: (np.outer([0.0, 1, 2], [1, 1, 1]), np.array([[0, 1, 2]])), "no cell has an area"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_meshes_are_one_line(name):
    make, line = BAD[name]
    with pytest.raises(CadError) as error:
        FacetSurface(*make())
    assert line in str(error.value) and "\n" not in str(error.value)


def test_unknown_normals_and_wrong_points():
    with pytest.raises(CadError, match="normals 'smooth', expected one of element, nodal, nagata"):
        FacetSurface(*box_mesh(), "smooth")
    surface = FacetSurface(*box_mesh())
    with pytest.raises(ValueError, match=r"points must be \(n, 3\)"):
        surface.project(np.zeros(3))
    with pytest.raises(ValueError, match="finite"):
        surface.project(np.full((1, 3), np.nan))
    assert len(surface.project(np.zeros((0, 3))).distance) == 0


def test_same_bits_at_any_thread_count(tmp_path):
    import os
    import subprocess
    import sys

    script = tmp_path / "hash.py"
    script.write_text(
        "import hashlib, numpy as np\n"
        "from cadlink import FacetSurface\n"
        "from tests.cadlink.facet_shapes import torus_mesh\n"
        "surface = FacetSurface(*torus_mesh()[:2], 'nagata')\n"
        "hit = surface.project(np.random.default_rng(0).normal(size=(3000, 3)) * 10.0)\n"
        "print(hashlib.sha256(b''.join(a.tobytes() for a in hit)).hexdigest())\n"
    )
    found = set()
    for threads in ("1", "2"):
        env = {**os.environ, "NUMBA_NUM_THREADS": threads, "PYTHONPATH": os.getcwd()}
        done = subprocess.run([sys.executable, script], env=env, capture_output=True, text=True, check=True)
        found.add(done.stdout)
    assert len(found) == 1
