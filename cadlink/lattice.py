"""Structured meshes of rectangles, discs and rings: points and cells by formula, without gmsh."""

from math import ceil, pi, sqrt

import numpy as np


def lattice_rectangle(x0, x1, y0, y1, size):
    """Rows of equal rectangles, node i + j (nx + 1) at column i and row j.

    returns : points (n, 2) mm, quadrilaterals (m, 4), counter-clockwise from the corner nearest (x0, y0)
    """
    nx, ny = cells_along(x1 - x0, size), cells_along(y1 - y0, size)
    x, y = np.meshgrid(np.linspace(x0, x1, nx + 1), np.linspace(y0, y1, ny + 1))
    return np.column_stack((x.ravel(), y.ravel())), quads_of_grid(nx, ny)


def lattice_equilateral(x0, x1, y0, y1, size):
    """Rows of triangles with sides along x and at 60 degrees to it, as near as the rectangle allows; half triangles at
    the two ends of a row.

    returns : points (n, 2) mm, triangles (m, 3), both by rows
    """
    nx, ny = cells_along(x1 - x0, size), cells_along(y1 - y0, 0.5 * sqrt(3.0) * size)
    even = np.linspace(x0, x1, nx + 1)
    odd = np.concatenate(([x0], 0.5 * (even[1:] + even[:-1]), [x1]))
    rows = [even if j % 2 == 0 else odd for j in range(ny + 1)]
    points = np.column_stack((np.concatenate(rows), np.repeat(np.linspace(y0, y1, ny + 1), [len(row) for row in rows])))
    first = np.concatenate(([0], np.cumsum([len(row) for row in rows])))
    cells = []
    for j in range(ny):
        e, o = (first[j], first[j + 1]) if j % 2 == 0 else (first[j + 1], first[j])
        i, k = np.arange(nx), np.arange(nx + 1)
        along = np.column_stack((e + i, e + i + 1, o + i + 1))  # sides on the even row
        across = np.column_stack((e + k, o + k + 1, o + k))
        row = np.vstack((along, across))[np.argsort(np.concatenate((2 * i + 1, 2 * k)), kind="stable")]
        cells.append(row if j % 2 == 0 else row[:, ::-1])
    return points, np.vstack(cells)


def lattice_ring(inner, outer, first, last, size):
    """Radial lines and circles between two radii, from angle `first` to `last` [rad]; may close.

    returns : points (n, 2) mm about the origin, quadrilaterals (m, 4)
    """
    n_radial = cells_along(outer - inner, size)
    sweep = last - first
    n_around = max(ceil(sweep / (pi / 4) - 1e-9), cells_along(0.5 * (inner + outer) * sweep, size))
    radius = np.linspace(inner, outer, n_radial + 1)
    angle = np.linspace(first, last, n_around + 1)
    points = (radius[None, :, None] * unit(angle)[:, None, :]).reshape(-1, 2)
    quads = quads_of_grid(n_radial, n_around)
    if sweep > 2 * pi - 1e-9:
        n_last = n_around * (n_radial + 1)  # the last line is the first again
        points, quads = points[:n_last], np.where(quads >= n_last, quads - n_last, quads)
    return points, quads


def lattice_quarter_disc(radius, size):
    """The quarter x, y >= 0 of a disc about the origin in three blocks: a bulged square and two fans.

        rim:   2n arcs of equal angle
        fans:  m rings between the square's two free sides and the rim
        square: n x n cells; its sides bulge part of the way to a circle, which keeps its far corner blunt

    returns : points (n, 2) mm, quadrilaterals (m, 4)
    """
    n = cells_along(pi / 4 * radius, size)
    side = 0.6 * radius
    n_rings = cells_along(radius - side, size)

    # the square, blended between straight grid lines and the elliptic map of square to disc
    u, v = np.meshgrid(np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 1.0, n + 1))
    x = side * u * (0.6 + 0.4 * np.sqrt(1 - 0.5 * v**2))
    y = side * v * (0.6 + 0.4 * np.sqrt(1 - 0.5 * u**2))
    square = np.column_stack((x.ravel(), y.ravel()))
    quads = [quads_of_grid(n, n)]

    # the fans: straight spokes from the square's free sides to the rim
    index = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    free = np.concatenate((index[:, n], index[n, n - 1 :: -1]))  # anticlockwise from (side, 0) to (0, side)
    rim = radius * unit(np.linspace(0.0, pi / 2, 2 * n + 1))
    part = np.arange(1, n_rings + 1) / n_rings
    spokes = square[free][None] + part[:, None, None] * (rim - square[free])[None]
    ring = np.vstack((free, len(square) + np.arange(n_rings * (2 * n + 1)).reshape(n_rings, -1)))
    a, b, c, d = ring[:-1, :-1], ring[1:, :-1], ring[1:, 1:], ring[:-1, 1:]
    quads.append(np.stack((a, b, c, d), axis=-1).reshape(-1, 4))

    points = np.vstack((square, spokes.reshape(-1, 2)))
    points[np.abs(points) < 1e-12 * radius] = 0.0
    return points, np.vstack(quads)


def cells_along(length, size):
    """The number of cells of about `size` that fill a length; at least one."""
    return max(1, round(length / size))


def quads_of_grid(nx, ny):
    """Quadrilaterals of a grid of nx by ny cells whose node at (i, j) is i + j (nx + 1)."""
    a = (np.arange(nx)[None] + np.arange(ny)[:, None] * (nx + 1)).ravel()
    return np.column_stack((a, a + 1, a + nx + 2, a + nx + 1))


def split_quads(points, quads):
    """Two triangles per quadrilateral, along its shorter diagonal; on a tie the one from its first corner."""
    a, b, c, d = quads.T
    ac = np.hypot(*(points[c] - points[a]).T)
    bd = np.hypot(*(points[d] - points[b]).T)
    first = np.where((ac <= bd * (1 + 1e-9))[:, None], np.stack((a, b, c), 1), np.stack((a, b, d), 1))
    second = np.where((ac <= bd * (1 + 1e-9))[:, None], np.stack((a, c, d), 1), np.stack((b, c, d), 1))
    return np.stack((first, second), axis=1).reshape(-1, 3)


def mirror(points, cells, axis):
    """The mesh and its mirror image in the plane through the origin normal to `axis`, joined there."""
    image = np.arange(len(points))
    off = points[:, axis] != 0.0
    image[off] = len(points) + np.arange(np.count_nonzero(off))
    reflected = points[off].copy()
    reflected[:, axis] *= -1.0
    return np.vstack((points, reflected)), np.vstack((cells, image[cells][:, ::-1]))


def unit(angle):
    """(..., 2) unit vectors at angles [rad]."""
    return np.stack((np.cos(angle), np.sin(angle)), axis=-1)
