"""Which faces continue each other: smooth edges, and how badly the file draws them.

An edge is smooth where its faces' normals differ by less than SMOOTH all along. A nearest point on
such an edge is a foot on a face as well, up to the file's gaps and kinks; so the quick search
(quick.py) drops smooth edges and vertices and leaves feet in a band along the rim to the careful
one. Sharp edges keep a table of their mean normals, which tell the side.
"""

import numpy as np
from numba import njit

from cadlink.answer import faces_at_edge
from cadlink.nurbs import WORK
from cadlink.skin import SMOOTH, STATIONS, TIE


@njit(cache=True)
def survey_edges(skin):
    """Fill turn and normal of all edges."""
    work = np.zeros(WORK)
    for number in range(len(skin.edges)):
        edge = skin.edges[number]
        edge.turn[0] = 2.0
        for k in range(STATIONS):
            # The ends may be poles, where a face has no normal.
            tau = (k + 0.5) / STATIONS
            mean, turn = faces_at_edge(skin, edge, tau, work)
            edge.turn[0], edge.turn[1] = min(edge.turn[0], turn), max(edge.turn[1], turn)
            for c in range(3):
                edge.normal[k, c] = mean[c]


def group_faces(skin, corners):
    """Fill gap, angle, group and slack of all rims.

    corners : (face, gap of the vertex) of all corners of faces
    """
    rims, sides = skin.rims, skin.sides["face"]
    parent = np.arange(len(rims))

    def root(face):
        while parent[face] != face:
            parent[face] = parent[parent[face]]
            face = parent[face]
        return face

    for edge in skin.edges:
        if edge["turn"][1] > SMOOTH:
            continue
        mine = sides[edge["side_first"] : edge["side_last"]]
        rims["gap"][mine] = np.maximum(rims["gap"][mine], 2.0 * (edge["slack"] - TIE))
        rims["angle"][mine] = np.maximum(rims["angle"][mine], 2.0 * edge["turn"][1])
        for face in mine[1:]:
            parent[root(face)] = root(mine[0])
    for face, gap in corners:
        rims["gap"][face] = max(rims["gap"][face], 2.0 * gap)
    slacks = np.concatenate([skin.edges["slack"], skin.vertices["slack"]])
    rims["loose"] = slacks.max(initial=0.0)
    rims["group"] = [root(face) for face in range(len(rims))]
    face = skin.patches["face"][skin.leaves["patch"]]
    skin.leaves["sense"], skin.leaves["group"] = skin.faces["sense"][face], rims["group"][face]
    # Round-off of feet and of parameters.
    rims["gap"] += 1e-9
    rims["angle"] += 1e-9
