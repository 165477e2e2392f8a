"""Quadratic patches from corner normals (Nagata, Comput. Aided Geom. Des. 22, 2005, 327).

A side from x0 to x1 with unit normals n0 and n1 at its ends becomes x0 + (d - c) r + c r^2, d = x1 - x0: the shortest
c whose end tangents are across the normals,

    n0 . (d - c) = 0,    n1 . (d + c) = 0.

On a crease the side belongs to two patches, and the tangents are across the normals of both (least squares). A patch is
the surface of lowest degree through its sides: on a triangle a quadratic, on a quadrilateral the blend of its sides
(Coons). Coefficients are those of facet_closest.py.
"""

import numpy as np

LARGEST = 1.0  # |c| over |d|: more (a turn of a right angle along the side) is no shape, and the side stays straight
# Of the largest singular value: smaller ones do not count. They are differences of nearly equal normals; what they
# would say of c is its part along the side, which moves points within the patch and not the patch.
CUTOFF = 0.02
STEEPEST = 0.3  # cosine of the largest angle (73 degrees) between a patch and its flat facet
ROUNDS = 5  # of straightening: a side made straight changes the patch beyond it


def side_curves(points, corners, normals, edges):
    """c of each side (m, 4, 3); neighbours find the same.

    normals : (m, 4, 3) unit corner normals; edges : Edges of the corners
    """
    n_sides = np.where(corners[:, 3] < 0, 3, 4)
    f, g = edges.owner[:, 0], edges.owner[:, 1]
    i, j = edges.slot[:, 0], edges.slot[:, 1]
    g, j = np.where(g < 0, f, g), np.where(g < 0, i, j)
    i1, j1 = (i + 1) % n_sides[f], (j + 1) % n_sides[g]
    start, end = corners[f, i], corners[f, i1]
    along = corners[g, j] == start  # the other side runs the same way: a rim, or an odd mesh
    n0 = np.stack([normals[f, i], np.where(along[:, None], normals[g, j], normals[g, j1])], axis=1)
    n1 = np.stack([normals[f, i1], np.where(along[:, None], normals[g, j1], normals[g, j])], axis=1)
    d = points[end] - points[start]
    rows = np.concatenate([n0, n1], axis=1)  # (e, 4, 3)
    wanted = np.concatenate([np.einsum("ekc,ec->ek", n0, d), -np.einsum("ekc,ec->ek", n1, d)], axis=1)
    c = np.einsum("eck,ek->ec", np.linalg.pinv(rows, rcond=CUTOFF), wanted)
    too_bent = np.linalg.norm(c, axis=1) > LARGEST * np.linalg.norm(d, axis=1)
    c[too_bent] = 0.0
    return unfolded(points[corners], corners[:, 3] < 0, c, edges)


def unfolded(x, triangle, c, edges):
    """(m, 4, 3) side curves from those of the edges (e, 3); sides of patches that would fold over are straightened.

    A thin facet whose long sides bend apart may turn its normal round; it stays flat instead.
    """
    real = edges.side_edge >= 0
    found = np.zeros((len(x), 4, 3))
    found[real] = c[edges.side_edge[real]]
    for _ in range(ROUNDS):
        folded = steepest_turn(patch_coefficients(x, triangle, found), triangle, x) < STEEPEST
        folded &= found.any(axis=(1, 2))
        if not folded.any():
            break
        sides = edges.side_edge[folded]
        c[sides[sides >= 0]] = 0.0
        found[real] = c[edges.side_edge[real]]
    return found


def steepest_turn(a, triangle, x):
    """(m,) smallest cosine between a patch's normal and that of its flat facet, at 15 or 25 places."""
    last = np.where(triangle[:, None], x[:, 2], x[:, 3])
    flat = np.cross(x[:, 2] - x[:, 0], last - x[:, 1])
    least = np.ones(len(a))
    for s, t in np.ndindex(5, 5):
        u, v = s / 4.0, t / 4.0
        fs = np.array([0.0, 1.0, 0.0, 2.0 * u, v, 0.0, 2.0 * u * v, v * v])
        ft = np.array([0.0, 0.0, 1.0, 0.0, u, 2.0 * v, u * u, 2.0 * u * v])
        n = np.cross(np.einsum("i,mic->mc", fs, a), np.einsum("i,mic->mc", ft, a))
        size = np.linalg.norm(n, axis=1) * np.linalg.norm(flat, axis=1)
        cosine = np.einsum("mc,mc->m", n, flat) / np.where(size > 0.0, size, 1.0)
        counts = ~triangle | (u + v <= 1.0)
        least = np.where(counts & (cosine < least), cosine, least)
    return least


def patch_coefficients(x, triangle, c):
    """(m, 8, 3) coefficients of the patches.

    x : (m, 4, 3) values at the corners; triangle : (m,) where the last does not count; c : (m, 4, 3) side curves, 0 for
        linear and bilinear interpolation
    """
    a = np.zeros((len(x), 8, 3))
    t = triangle
    # Triangle: sides 0-1, 1-2, 2-0.
    c01, c12, c20 = c[t, 0], c[t, 1], c[t, 2]
    a[t, 0] = x[t, 0]
    a[t, 1], a[t, 2] = x[t, 1] - x[t, 0] - c01, x[t, 2] - x[t, 0] - c20
    a[t, 3], a[t, 5] = c01, c20
    a[t, 4] = c01 + c20 - c12
    # Quadrilateral: sides 0-1, 1-2, 2-3, 3-0.
    q = ~t
    c01, c12, c23, c30 = (c[q, k] for k in range(4))
    a[q, 0] = x[q, 0]
    a[q, 1], a[q, 2] = x[q, 1] - x[q, 0] - c01, x[q, 3] - x[q, 0] - c30
    a[q, 3], a[q, 5] = c01, c30
    a[q, 4] = x[q, 0] - x[q, 1] + x[q, 2] - x[q, 3] + c01 - c23 + c30 - c12
    a[q, 6], a[q, 7] = c23 - c01, c12 - c30
    return a


def patch_boxes(a, sides):
    """Lowest and highest corner of boxes round the patches: of their Bezier points (m, 3) each."""
    x, s, t, ss, st, tt, sst, stt = np.moveaxis(a, 1, 0)
    # Bezier points of degree 2: f(0), f(0) + f'/2, f(1).
    tri = [x, x + 0.5 * s, x + s + ss, x + 0.5 * t, x + t + tt, x + 0.5 * (s + t + st)]
    quad = []
    for b0, b1, b2 in ((x, s, ss), (x + 0.5 * t, s + 0.5 * st, ss + 0.5 * sst), (x + t + tt, s + st + stt, ss + sst)):
        quad += [b0, b0 + 0.5 * b1, b0 + b1 + b2]
    tri, quad = np.array(tri), np.array(quad)
    three = (sides == 3)[:, None]
    return np.where(three, tri.min(axis=0), quad.min(axis=0)), np.where(three, tri.max(axis=0), quad.max(axis=0))


def corner_frames(a, sides):
    """Unit normal and angle [rad] of each patch at its corners, (m, 4, 3) and (m, 4)."""
    m = len(a)
    normal, angle = np.zeros((m, 4, 3)), np.zeros((m, 4))
    places = {3: [(0, 0), (1, 0), (0, 1)], 4: [(0, 0), (1, 0), (1, 1), (0, 1)]}
    # Directions of the sides that leave and reach each corner, in (s, t).
    leave = {3: [(1, 0), (-1, 1), (0, -1)], 4: [(1, 0), (0, 1), (-1, 0), (0, -1)]}
    for n_sides in (3, 4):
        mine = sides == n_sides
        for k, (s, t) in enumerate(places[n_sides]):
            fs = np.array([0.0, 1.0, 0.0, 2.0 * s, t, 0.0, 2.0 * s * t, t * t])
            ft = np.array([0.0, 0.0, 1.0, 0.0, s, 2.0 * t, s * s, 2.0 * s * t])
            xs, xt = np.einsum("i,mic->mc", fs, a[mine]), np.einsum("i,mic->mc", ft, a[mine])
            out, before = leave[n_sides][k], leave[n_sides][k - 1]
            u, v = out[0] * xs + out[1] * xt, -(before[0] * xs + before[1] * xt)
            n = np.cross(u, v)
            size = np.linalg.norm(n, axis=1)
            normal[mine, k] = n / np.where(size > 0.0, size, 1.0)[:, None]
            angle[mine, k] = np.arctan2(size, np.einsum("mc,mc->m", u, v))
    return normal, angle


def bulge_and_bend(x, triangle, c):
    """How far each patch may be from the flat triangles between its corners [mm], and about its largest curvature.

    A triangle moves by sum l_i l_j c_k, at most |c|/3; a quadrilateral by at most |c|/2 from its bilinear surface,
    which is at most a quarter of x0 - x1 + x2 - x3 from the triangles.
    """
    size = np.linalg.norm(c, axis=2)
    following = np.where(triangle[:, None], [1, 2, 0, 3], [1, 2, 3, 0])
    d = np.take_along_axis(x, following[..., None], axis=1) - x
    length = np.linalg.norm(d, axis=2)
    warp = np.where(triangle[:, None], 0.0, x[:, 0] - x[:, 1] + x[:, 2] - x[:, 3])
    twist = np.linalg.norm(warp, axis=1)
    bulge = np.where(triangle, 1.0 / 3.0, 0.5) * size.max(axis=1) + 0.25 * twist
    bend = 4.0 * np.max(size / np.where(length > 0.0, length, np.inf) ** 2, axis=1)
    across = np.where(length > 0.0, length, np.inf).min(axis=1)
    return bulge, bend + 2.0 * twist / across**2
