"""All feet of a point, not only the nearest: where the distance to a skin has its other local minima.

    p     the point;  q a foot;  h = |p - q|;  m = (p - q) / h
    n, d  normal and signed distance at the nearest foot

In a corner that is tighter than half the sheet a node meets two or three walls at once, and `project` tells of one.
Whatever the surface is made of, its pieces propose stationary points q, and `project` itself judges them: q is a foot
if the point a little way from q towards p comes back to q (the first-order condition: m lies in the cone of normals
at q, be that on a face, an edge or a vertex), and if no curvature turns it into a maximum, 1 + k d > 0.

Feet whose normals differ by less than ALIKE = 0.15 rad (8.6 degrees) count as one, the nearer. Where two walls meet
at a small angle a, the second foot of a point at h from the first appears at h (1/cos a - 1) more; below ALIKE that is
less than a hundredth of h, and the second force would set in with a jump, above it from nothing.
"""

from typing import NamedTuple

import numpy as np

from cadlink.projection import Projection, checked_points

ALIKE = 0.15  # rad
FURTHER = 2  # feet beside the nearest, at most: three walls hold a point
STEP = 0.01  # of h, the way from a foot towards the point where it is put to the test
BACK = 2e-3  # of that way: a foot comes back this near
TURNING = 1e-3  # least 1 + k d


class Feet(NamedTuple):
    """Further feet of n points, the nearest of a point first.

    owner : (k,) rising numbers of the points
    hit : Projection of those k feet
    """

    owner: np.ndarray
    hit: Projection


def further_feet(surface, propose, points, hit, reach):
    """Feet: at most two beside the known one, within reach, on the same side of the skin.

    surface : what has `project`
    propose : function of points (n, 3), towards (n, 3), reach (n,) that returns owner (c,), rising, and q (c, 3):
        stationary points of the distance to the surface's pieces, but for those seen along `towards`
    points : (n, 3) mm; hit : their Projection; reach : (n,) mm
    """
    points = checked_points(points)
    reach = np.ascontiguousarray(np.broadcast_to(reach, len(points)), float)
    side = np.where(hit.distance >= 0.0, 1.0, -1.0)
    owner, q = propose(points, side[:, None] * hit.normal, reach)
    h = np.linalg.norm(points[owner] - q, axis=1)
    m = (points[owner] - q) / h[:, None]
    found = surface.project(q + STEP * h[:, None] * m)
    d = side[owner] * h
    back = np.linalg.norm(found.point - q, axis=1) <= BACK * STEP * h
    lowest = (1.0 + found.curvature * d[:, None]).min(axis=1) > TURNING
    good = back & lowest & (found.distance * d > 0.0) & ~alike(found.normal, hit.normal[owner])
    good = np.flatnonzero(good)
    kept = good[one_of_each(owner[good], h[good], found.normal[good])]
    fields = [values[kept] for values in found]
    return Feet(owner[kept], Projection(*fields)._replace(distance=d[kept]))


def alike(a, b):
    """Whether unit vectors (k, 3) differ by less than ALIKE."""
    return np.einsum("kc,kc->k", a, b) > np.cos(ALIKE)


def one_of_each(owner, h, normal):
    """Rows of the nearest feet of each owner whose normals are not alike, FURTHER at most; owner by owner."""
    order = np.lexsort((h, owner))
    kept = []
    for _ in range(FURTHER):
        mine, first, which = np.unique(owner[order], return_index=True, return_inverse=True)
        if not len(mine):
            break
        kept.append(order[first])
        nearest = order[first][which]
        rest = ~alike(normal[order], normal[nearest])
        rest[first] = False
        order = order[rest]
    kept = np.concatenate(kept) if kept else np.zeros(0, int)
    return kept[np.lexsort((h[kept], owner[kept]))]
