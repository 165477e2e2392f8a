"""A square cup drawn by formula, for tests of files and pictures: no solver, no CAD.

Points keep their distance from the centre along a cup's section, in a norm whose circles are rounded squares.
"""

from types import SimpleNamespace

import numpy as np
import pytest

import solver
from solver.results import Frame

NORM = 8.0  # its circles are squares with rounded corners
PUNCH, DIE, PUNCH_RADIUS, DIE_RADIUS = 35.0, 37.0, 8.0, 5.0
THICKNESS = 0.8


def quarter_blank(half=75.0, n=24):
    """Triangles over [0, half]^2 with symmetry groups, as mesh_blank gives them."""
    along = np.linspace(0.0, half, n + 1)
    x, y = np.meshgrid(along, along, indexing="ij")
    node = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = node[:-1, :-1].ravel(), node[1:, :-1].ravel(), node[1:, 1:].ravel(), node[:-1, 1:].ravel()
    return SimpleNamespace(
        points=np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]),
        cells=np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])]),
        groups={"symmetry_x": node[0], "symmetry_y": node[:, 0], "center": node[:1, 0]},
    )


def section(depth):
    """(k, 2) radius and height of a cup's section, and (k,) its length from the centre, in mm."""
    r1, r2 = min(PUNCH_RADIUS, 0.5 * depth), min(DIE_RADIUS, 0.5 * depth)
    quarter = np.linspace(0.0, 0.5 * np.pi, 12)
    bottom = [(PUNCH - r1 + r1 * np.sin(t), -depth + r1 * (1.0 - np.cos(t))) for t in quarter]
    top = [(DIE + r2 * (1.0 - np.cos(t)), r2 * (np.sin(t) - 1.0)) for t in quarter]
    line = np.array([(0.0, -depth), *bottom, *top, (200.0, 0.0)])
    return line, np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])


def drawn(points, depth):
    """Where the flat points (n, 3) are when the cup is `depth` mm deep."""
    if depth == 0.0:
        return points.copy()
    rho = np.linalg.norm(points[:, :2], ord=NORM, axis=1)
    line, length = section(depth)
    radius, height = np.interp(rho, length, line[:, 0]), np.interp(rho, length, line[:, 1])
    shrink = np.divide(radius, rho, out=np.ones_like(rho), where=rho > 0.0)
    return np.column_stack([points[:, :2] * shrink[:, None], height])


def fake_frame(mesh, depth, increment):
    """A solver.Frame of the cup; the fields are smooth and their names those of a run."""
    points = drawn(mesh.points, depth)
    flat, now = (
        0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
        for p in (mesh.points[mesh.cells], points[mesh.cells])
    )
    thinning = np.clip(0.2 * (1.0 - flat / now), -0.15, 0.25)
    n_nodes, n_cells = len(points), len(mesh.cells)
    return Frame(
        stage="draw",
        increment=increment,
        stroke=depth,
        points=points,
        point_fields={
            "displacement": points - mesh.points,
            "contact_gap": np.abs(points[:, 2]),
            "contact_pressure": np.linspace(0.0, 5.0, n_nodes),
            "friction_traction": np.zeros((n_nodes, 3)),
            "squeeze": np.zeros(n_nodes),
            "contact_tool": np.full(n_nodes, -1),
        },
        cell_fields={
            "thickness": THICKNESS * (1.0 - thinning),
            "thinning": thinning,
            "strain_major": np.full(n_cells, 0.1),
            "strain_minor": np.full(n_cells, -0.05),
            "plastic_strain": np.full(n_cells, 0.12),
            "stress": np.arange(6.0 * n_cells).reshape(n_cells, 6),
        },
        tool_offsets={"PUNCH": np.array([0.0, 0.0, -depth]), "DIE": np.zeros(3), "BLANK_HOLDER": np.zeros(3)},
    )


def turned(line, n=96):
    """Points and triangles of a section swept round the square. line : (k, 2) radius and height [mm]."""
    angle = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    around /= np.linalg.norm(around, ord=NORM, axis=1)[:, None]
    points = np.array([(r * c, r * s, z) for r, z in line for c, s in around])
    i, j = np.meshgrid(np.arange(len(line) - 1), np.arange(n), indexing="ij")
    a, b = (i * n + j).ravel(), (i * n + (j + 1) % n).ravel()
    return points, np.vstack([np.column_stack([a, b, b + n]), np.column_stack([a, b + n, a + n])])


class FakeSurface:
    """A plane z = height, shown as a tool."""

    def __init__(self, height, shown):
        self.height = height
        watertight = SimpleNamespace(edge=0.0, vertex=0.0)
        self.part = SimpleNamespace(triangles=lambda: shown, gap_report=lambda: watertight) if shown else None

    def misfit(self):
        return 0.0

    def project(self, points, seed=None):
        n = len(points)
        foot = np.column_stack([points[:, :2], np.full(n, self.height)])
        return SimpleNamespace(
            distance=points[:, 2] - self.height,
            point=foot,
            normal=np.tile([0.0, 0.0, 1.0], (n, 1)),
            curvature=np.zeros((n, 2)),
            direction=np.tile([1.0, 0.0, 0.0], (n, 1)),
            face=np.zeros(n, dtype=int),
            seed=None,
        )


def fake_scene(n=24):
    """A solver.Scene of the cup's tools, quarter blank and a simple material."""
    quarter = np.linspace(0.0, 0.5 * np.pi, 8)
    r, R = PUNCH_RADIUS, DIE_RADIUS
    nose = [(PUNCH - r + r * np.sin(t), r * (1.0 - np.cos(t))) for t in quarter]
    mouth = [(DIE + R * (1.0 - np.cos(t)), R * (np.sin(t) - 1.0)) for t in quarter]
    lines = {
        "PUNCH": [(0.0, 0.0), *nose, (PUNCH, 70.0), (0.0, 70.0)],
        "DIE": [(DIE, -60.0), (90.0, -60.0), (90.0, 0.0), *mouth[::-1], (DIE, -60.0)],
        "BLANK_HOLDER": [(DIE, 0.8), (90.0, 0.8), (90.0, 20.0), (DIE, 20.0), (DIE, 0.8)],
    }
    tools = [
        solver.Tool(name, FakeSurface(-0.4, turned(line)), travel=-40.0 if name == "PUNCH" else None)
        for name, line in lines.items()
    ]
    material = solver.Material(70e3, 0.3, solver.VonMises(), solver.Swift(500.0, 0.01, 0.2))
    blank = solver.Blank(quarter_blank(n=n), THICKNESS, material, draw_in={"DX": (1, 0, 0)})
    return solver.Scene(blank, [solver.Stage(tools)], name="a cup by formula")


@pytest.fixture
def cup():
    """.scene, and .frame(depth, increment) of it."""
    scene = fake_scene(n=12)
    return SimpleNamespace(scene=scene, frame=lambda depth, increment=0: fake_frame(scene.blank.mesh, depth, increment))


@pytest.fixture
def run_folder(cup, tmp_path):
    """A folder with the cup at four depths, as `cadlink run` leaves it."""
    from plugins import report
    from plugins.vtk_files import PvdWriter
    from solver.results import Results

    writer = PvdWriter(tmp_path / "result.pvd", cup.scene)
    results = Results(plan="Runs:\n  nothing", finished=True, energy={"internal": 2e4}, seconds={"total": 1.5})
    for increment, depth in enumerate((0.0, 10.0, 20.0, 40.0)):
        frame = cup.frame(depth, increment)
        writer.write(frame)
        results.record(
            stage="draw",
            increment=increment,
            stroke=depth,
            iterations=3,
            residual=1e-9,
            n_contacts=10,
            force_PUNCH=-1000.0 * depth,
            draw_in_DX=0.5 * depth,
            thickness_min=float(frame.cell_fields["thickness"].min()),
            thickness_max=float(frame.cell_fields["thickness"].max()),
            thinning_max=float(frame.cell_fields["thinning"].max()),
        )
    writer.close()
    rows = [
        SimpleNamespace(quantity="draw_in_DX", stroke=15.0, measured=6.0, scatter=0.5),
        SimpleNamespace(quantity="draw_in_DX", stroke=50.0, measured=30.0, scatter=None),
    ]
    scene_file = SimpleNamespace(
        path="scene.toml",
        keys=SimpleNamespace(compare=SimpleNamespace(rows=rows, source="a laboratory")),
        columns={"draw_in_DX": "mm"},
    )
    report.write_history(tmp_path, results.history)
    report.write_summary(tmp_path, report.summarize(scene_file, cup.scene, results))
    return tmp_path
