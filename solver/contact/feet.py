"""Tools a node can touch in several places at once: in corners tighter than half the sheet.

A tool's surface then tells all feet of a node, three at most. Each is a contact of its own: force, friction, tangent.
A contact remembers its friction from one increment to the next, so a foot is told by its normal which of the last
increment's it continues, and takes its place; which of them is nearest may change without any force noticing.
"""

import numpy as np

from .node_on_tool import OPEN

MOST = 3  # walls that hold a point
THICKER = 1.25  # a sheet may become thicker by a quarter where it is drawn in
SAME_WALL = 0.7  # cosine between normals of one foot before and after an increment, at least


def tight_radius(thickness):
    """Radius of a hollow up to which a node can touch it in several places [mm]."""
    return 0.5 * THICKER * thickness


def feet_per_node(surface, thickness):
    """How many feet of a node are looked for: 1, or 3 where a hollow of the surface is tighter than half the sheet.

    thickness : mm
    """
    tightest = getattr(surface, "tightest", None)
    return MOST if tightest is not None and tightest() <= tight_radius(thickness) else 1


def sort_feet(surface, points, nodes, hit, reach, before):
    """Feet of nodes on one tool, place by place: [(node ids (k,), Projection of their feet)], as many as before.feet.

    points : (n, 3) of the nodes in the tool's frame; nodes : (n,) ids; hit : their Projection; reach : (n,) mm
    before : ContactState at the increment's start
    """
    owner, further = surface.feet(points, hit, reach)
    rank = 1 + np.arange(len(owner)) - np.searchsorted(owner, owner)
    all_owners, all_ranks = np.concatenate([np.arange(len(nodes)), owner]), np.concatenate([0 * nodes, rank])
    normals = np.zeros((len(nodes), MOST, 3))
    normals[all_owners, all_ranks] = np.concatenate([hit.normal, further.normal])
    exists = np.zeros((len(nodes), MOST), bool)
    exists[all_owners, all_ranks] = True
    touched = np.column_stack([foot.status[nodes] != OPEN for foot in before.feet])
    then = np.stack([foot.normal[nodes] for foot in before.feet], axis=1)
    place = places(normals, exists, then, touched)[all_owners, all_ranks]
    values = [np.concatenate([getattr(hit, name), getattr(further, name)]) for name in hit._fields]
    rows = [np.flatnonzero(place == k) for k in range(MOST)]
    return [(nodes[all_owners[row]], type(hit)(*(value[row] for value in values))) for row in rows]


def places(normals, exists, then, touched):
    """Place (n, 3) of each foot: that of the last increment's foot with the nearest normal, then free ones in order.

    normals : (n, 3 feet, 3) and exists (n, 3); then : (n, 3 places, 3) and touched (n, 3), at the increment's start
    """
    n = len(normals)
    place = np.full((n, MOST), -1)
    likeness = np.einsum("nfc,npc->nfp", normals, then)
    likeness[~(exists[:, :, None] & touched[:, None, :])] = -1.0
    every = np.arange(n)
    for _ in range(MOST):
        foot, other = np.divmod(likeness.reshape(n, MOST * MOST).argmax(axis=1), MOST)
        sure = likeness[every, foot, other] > SAME_WALL
        place[every[sure], foot[sure]] = other[sure]
        likeness[every, foot, :] = -1.0
        likeness[every, :, other] = -1.0
    # New feet: places nobody held go first.
    for foot in range(MOST):
        new = np.flatnonzero(exists[:, foot] & (place[:, foot] < 0))
        taken = (place[new][:, :, None] == np.arange(MOST)).any(axis=1)
        place[new, foot] = (2 * taken + touched[new]).argmin(axis=1)
    return place
