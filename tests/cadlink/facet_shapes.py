"""Meshes for the tests, and the slow truth about them: every facet asked, every patch sampled."""

import numpy as np


def torus_mesh(n=24, m=14, large=12.0, small=4.0, quads=True, noise=0.0, seed=0):
    """points, cells and exact normals at the points of a torus round the z axis."""
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    out = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1)
    points = small * out + large * np.stack([np.cos(u), np.sin(u), 0 * u], axis=-1)
    points = points.reshape(-1, 3) + noise * np.random.default_rng(seed).normal(size=(n * m, 3))
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    at = lambda i, j: (i % n) * m + j % m  # noqa: E731
    cells = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], axis=-1).reshape(-1, 4)
    return points, cells if quads else halves(cells), out.reshape(-1, 3)


def halves(quads):
    """Two triangles of each quadrilateral."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def cylinder_mesh(n=16, rows=3, radius=8.0, height=12.0, turn=2 * np.pi, capped=True):
    """A can of quadrilaterals with lids of triangles, or an open strip of `turn` rad."""
    closed = turn > 6.28
    k = n if closed else n + 1
    t = turn * np.arange(k) / n
    z = np.linspace(0.0, height, rows + 1)
    ring = radius * np.column_stack([np.cos(t), np.sin(t)])
    points = np.vstack([np.column_stack([ring, np.full(k, h)]) for h in z])
    side = np.array([(i, (i + 1) % k) for i in range(n)])
    cells = [
        np.column_stack([side[:, 0] + k * r, side[:, 1] + k * r, side[:, 1] + k * (r + 1), side[:, 0] + k * (r + 1)])
        for r in range(rows)
    ]
    quads = np.vstack(cells)
    if not (capped and closed):
        return points, quads
    low, high = len(points), len(points) + 1
    points = np.vstack([points, [[0.0, 0.0, 0.0], [0.0, 0.0, height]]])
    bottom = np.column_stack([side[:, 1], side[:, 0], np.full(n, low)])
    top = np.column_stack([side + k * rows, np.full(n, high)])
    return points, [quads, np.vstack([bottom, top])]


def box_mesh(size=(20.0, 14.0, 8.0)):
    """Six quadrilaterals, normals outwards, centred."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return corners, quads


def distance_to_triangles(points, corners, p):
    """Smallest distance of each p to all triangles: feet on planes inside, feet on all sides. No tree, no regions."""
    a, b, c = (points[corners[:, k]] for k in range(3))
    best = np.full(len(p), np.inf)
    for k, q in enumerate(p):
        n = np.cross(b - a, c - a)
        n2 = (n * n).sum(1)
        ok = n2 > 0
        n2 = np.where(ok, n2, 1.0)
        w = (np.cross(b - a, q - a) * n).sum(1) / n2
        v = (np.cross(q - a, c - a) * n).sum(1) / n2
        inside = ok & (v >= 0) & (w >= 0) & (v + w <= 1)
        plane = np.abs(((q - a) * n).sum(1)) / np.sqrt(n2)
        found = np.where(inside, plane, np.inf).min()
        for x, y in ((a, b), (b, c), (c, a)):
            d = y - x
            size = (d * d).sum(1)
            t = np.clip(((q - x) * d).sum(1) / np.where(size > 0, size, 1.0), 0, 1)
            found = min(found, np.linalg.norm(q - x - t[:, None] * d, axis=1).min())
        best[k] = found
    return best


def winding(points, triangles, p):
    """Winding number of each p (van Oosterom & Strackee 1983)."""
    found = np.empty(len(p))
    for k, q in enumerate(p):
        a, b, c = (points[triangles[:, i]] - q for i in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
        found[k] = np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2 * np.pi)
    return found


def sampled_patches(skin, n=40):
    """Dense points on all patches of a FacetSkin: (m, k, 3), and the largest spacing."""
    g = np.linspace(0.0, 1.0, n + 1)
    s, t = (x.ravel() for x in np.meshgrid(g, g, indexing="ij"))
    found = []
    for a, sides in zip(skin.patch, skin.sides):
        keep = s + t <= 1.0 + 1e-12 if sides == 3 else np.ones(len(s), bool)
        u, v = s[keep], t[keep]
        f = np.array([np.ones_like(u), u, v, u * u, u * v, v * v, u * u * v, u * v * v])
        found.append(f.T @ a)
    return found
