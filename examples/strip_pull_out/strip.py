"""A strip pulled out between die and blank-holder: the founding paper's verification, and its Figs. 8 and 9.

Straight out it takes F_H = 2 mu F_B; over the die radius F_V = F_H exp(mu pi / 2), if every point of the bend touches.
A strip of elements touches at its nodes only, and has an exact value of its own. Symbols, at a node of the strip that
slides over the tool at the angle phi (0 on the flat, pi / 2 on the wall), with the element behind it inclined by a and
the one before it by b, T and U their tensions:

    along the tool    U cos(b - phi) - T cos(phi - a) = mu N
    across it         N = U sin(b - phi) + T sin(phi - a)

so that U / T = (cos(phi - a) + mu sin(phi - a)) / (cos(b - phi) - mu sin(b - phi)). In the middle of the bend both
angles are half of what an element spans, and the ratio is (1 + mu tan) / (1 - mu tan) of that half (benchmarks.md J);
nodes that enter and leave the bend make the ripple.
"""

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from cadlink import FacetSurface, read_step
from solver import Blank, Coulomb, Implicit, Increments, Material, Membrane, Scene, Stage, Tool, Voce, VonMises, form

FOLDER = Path(__file__).parent
SIZE, THICKNESS, WIDTH, LENGTH = 2.5, 1.0, 2.5, 50.0  # mm, of the strip; one element wide
MU, HOLDER_FORCE = 0.1, 5000.0  # N
COUNTS = (1.5, 3.0, 6.0)  # elements on the quarter circle
KINDS = {"exact": "exact faces", "nagata": "Nagata patches", "nodal": "facets, nodal normals", "element": "facets"}
FACETS = 6  # of the quarter circle
TRAVEL, STEPS = 40.0, 50
HORIZONTAL = 2.0 * MU * HOLDER_FORCE
STEEL = Material(206000.0, 0.3, VonMises(), Voce(2000.0, 0.0, 1.0))  # stays elastic
STIFFNESS = STEEL.young / (1.0 - STEEL.poisson**2) * THICKNESS * WIDTH  # N per strain; its width is held
STRETCHES = 4  # rounds in which tensions and lengths settle, each to a hundredth


# The strip


def bend_radius(count):
    """Radius [mm] of the strip's mid-plane on a bend that holds so many elements."""
    return count * SIZE / (0.5 * np.pi)


def path(s, bend):
    """Points (..., 2) x, z of the mid-plane at lengths s (...) [mm] along it: flat up to 0, the bend, the wall."""
    s = np.asarray(s, float)
    phi = np.clip(s / bend, 0.0, 0.5 * np.pi)
    x = np.minimum(s, 0.0) + bend * np.sin(phi)
    z = 0.5 * THICKNESS - bend * (1.0 - np.cos(phi)) - np.maximum(s - 0.5 * np.pi * bend, 0.0)
    return np.stack([x, z], axis=-1)


def nodes_on_path(first, bend, sizes):
    """Lengths (..., n + 1) along the path of nodes that are sizes (..., n) [mm] apart in a straight line, the foremost
    at `first` (...), the others behind it."""
    found = [np.asarray(first, float)]
    for size in np.moveaxis(sizes, -1, 0):
        # The node behind: nearer along the path than 1.2 elements; halving.
        low, high = found[-1] - 1.2 * size, found[-1]
        here = path(high, bend)
        for _ in range(60):
            middle = 0.5 * (low + high)
            far = np.linalg.norm(path(middle, bend) - here, axis=-1) > size
            low, high = np.where(far, middle, low), np.where(far, high, middle)
        found.append(0.5 * (low + high))
    return np.stack(found, axis=-1)


def strip_mesh(points):
    """Triangles of a strip one element wide. points : (n, 2) x, z of its nodes"""
    n = len(points)
    both = np.zeros((n, 2, 3))
    both[:, :, [0, 2]] = points[:, None]
    both[:, 1, 1] = WIDTH
    a = 2 * np.arange(n - 1)
    cells = np.concatenate([np.column_stack([a, a + 1, a + 2]), np.column_stack([a + 1, a + 3, a + 2])])
    groups = {"front": np.array([0, 1]), "all": np.arange(2 * n)}
    return SimpleNamespace(points=both.reshape(-1, 3), cells=cells, groups=groups)


def facets_of_die(radius, kind):
    """The die's skin in quadrilaterals as wide as the strip's elements, six on the quarter circle."""
    flat, wall = np.arange(-80.0, -0.5 * SIZE, SIZE), np.arange(SIZE, 80.0, SIZE)
    phi = np.linspace(0.0, 0.5 * np.pi, FACETS + 1)
    x = np.concatenate([flat, radius * np.sin(phi), np.full(len(wall), radius)])
    z = np.concatenate([0.0 * flat, radius * (np.cos(phi) - 1.0), -radius - wall])
    angle = np.concatenate([0.0 * flat, phi, np.full(len(wall), 0.5 * np.pi)])
    n = len(x)
    points = np.concatenate([np.column_stack([x, np.full(n, y), z]) for y in (-5.0, WIDTH + 5.0)])
    k = np.arange(n - 1)
    cells = np.column_stack([k, k + 1, k + 1 + n, k + n])
    exact = np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    exact = np.vstack([exact, exact])[cells] if kind == "nagata" else None
    surface = FacetSurface(points, cells, kind, corner_normals=exact)
    if surface.project([[-10.0, 0.0, 1.0]]).distance < 0.0:
        return FacetSurface(points, cells, kind, corner_normals=exact, flip=True)
    return surface


def strip_scene(count, kind="exact", pull="down", element=None):
    """The strip pulled over the bend ("down") or straight out ("out")."""
    assembly = read_step(FOLDER / f"strip_{count:g}.step")
    bend = bend_radius(count)
    lead = 0.5 * np.pi * bend + 1.3 * SIZE if pull == "down" else 1.3 * SIZE
    n = round(LENGTH / SIZE) + 1 + int(np.ceil(lead / SIZE))
    if pull == "down":
        mesh, move = strip_mesh(path(nodes_on_path(lead, bend, np.full(n - 1, SIZE)), bend)), (None, None, -TRAVEL)
    else:
        flat = np.column_stack([lead - SIZE * np.arange(n), np.full(n, 0.5 * THICKNESS)])
        mesh, move = strip_mesh(flat), (TRAVEL, None, None)
    friction = Coulomb(MU)
    surface = assembly["DIE"].surface() if kind == "exact" else facets_of_die(bend - 0.5 * THICKNESS, kind)
    die = Tool("DIE", surface, friction)
    holder = Tool("BLANK_HOLDER", assembly["BLANK_HOLDER"].surface(), friction, force=HOLDER_FORCE)
    blank = Blank(mesh, THICKNESS, STEEL, element or Membrane(), fixed={"all": "y"})
    return Scene(blank, [Stage([die, holder], name="pull", moved={"front": move})], name=f"strip, {count:g} elements")


def pull_out(count, kind="exact", pull="down", element=None, torsion=3e-4):
    """Travel [mm] and pulling force [N] of every increment, and the Results."""
    step = TRAVEL / STEPS / SIZE
    method = Implicit(increments=Increments(first=step * SIZE / THICKNESS, largest=step), torsion=torsion)
    results = form(strip_scene(count, kind, pull, element), method, frames=STEPS)
    column = "reaction_front_z" if pull == "down" else "reaction_front_x"
    travel = TRAVEL * np.array([f.stroke for f in results.frames[1:]])
    force = np.interp(travel, TRAVEL * np.array(results.history["stroke"]), np.abs(results.history[column]))
    return travel, force, results


# What a strip of elements takes exactly


def exact_forces(travel, count):
    """F_V (m,) [N] of a strip of elements at travels (m,) [mm], each element as much longer as its tension makes it:
    with the ripple with which nodes enter and leave the bend."""
    bend = bend_radius(count)
    first = 0.5 * np.pi * bend + 1.3 * SIZE + np.asarray(travel, float)  # along the path, of the foremost node
    n = 2 + int(np.ceil(first.max() / SIZE))
    tension = np.full((len(first), n), HORIZONTAL)  # from the hindmost element on
    for _ in range(STRETCHES):
        sizes = SIZE * (1.0 + tension / STIFFNESS)
        s = nodes_on_path(first, bend, sizes[:, ::-1])[:, ::-1]
        legs = np.diff(path(s, bend), axis=1)
        angle = np.arctan2(-legs[..., 1], legs[..., 0])
        phi = np.clip(s[:, 1:-1] / bend, 0.0, 0.5 * np.pi)
        a, b = phi - angle[:, :-1], angle[:, 1:] - phi
        ratio = (np.cos(a) + MU * np.sin(a)) / (np.cos(b) - MU * np.sin(b))
        tension[:, 1:] = HORIZONTAL * np.cumprod(ratio, axis=1)
    return tension[:, -1]


def mean_and_ripple(travel, force, start):
    """Mean over whole elements of travel from `start` on, and half the difference between largest and smallest [N]."""
    n = int((travel[-1] - start) / SIZE)
    x = np.linspace(start, start + n * SIZE, 40 * n, endpoint=False)
    f = np.interp(x, travel, force)
    return float(f.mean()), 0.5 * float(f.max() - f.min())
