"""Which nodes of a flat blank lie on which edge: symmetry planes, rim, holes."""

import numpy as np

from cadlink.errors import CadError

ON_PLANE = 1e-9  # relative to the size of the blank: when a node counts as lying on a symmetry plane


def nodes_on_planes(xy, cuts):
    """Puts nodes on the symmetry planes they are near.

    xy : (n, 2) mm
    cuts : axis name -> direction normal to the plane through the origin, (2,) unit
    returns : xy with those nodes moved onto their planes; axis name -> their ids, in order along the plane
    """
    reach = np.ptp(xy, axis=0).max()
    xy, planes = xy.copy(), {}
    for name, direction in cuts.items():
        height = xy @ direction
        nodes = np.flatnonzero(np.abs(height) <= ON_PLANE * reach)
        if len(nodes) < 2:
            raise CadError(f"mesh_blank symmetry: the outline does not reach across the plane {name} = 0")
        xy[nodes] -= height[nodes, None] * direction
        for axis in np.flatnonzero(np.abs(direction) == 1.0):
            xy[nodes, axis] = 0.0
        line = np.array([-direction[1], direction[0]])
        line *= np.sign(line[np.argmax(np.abs(line))])
        planes[name] = nodes[np.argsort(xy[nodes] @ line, kind="stable")]
    return xy, planes


def edge_groups(xy, cells, planes, loops, center):
    """The named node groups of a mesh in its plane.

    xy, cells : (n, 2) mm; (m, 3) or (m, 4), counter-clockwise
    planes : axis name -> node ids on that symmetry plane
    loops : the outline, the outer loop first: a closed polyline (k, 2), or open ones (n_curves, k, 2)
    center : (x, y) where a node, if there is one, is the group "center"
    returns : name -> node ids, as Mesh has them
    """
    groups = {f"symmetry_{name}": nodes for name, nodes in planes.items()}
    chains = _chains(cells, list(planes.values()), len(xy))

    # each chain of edges lies on one loop of the outline: that nearest to the middle of one of its edges
    of_loop = {}
    for chain in chains:
        k = (len(chain) - 1) // 2
        middle = 0.5 * (xy[chain[k]] + xy[chain[k + 1]])
        nearest = int(np.argmin([_distance(middle, loop) for loop in loops]))
        of_loop.setdefault(nearest, []).append(chain)

    groups["rim"] = _joined(of_loop.pop(0, []), xy)
    holes = [_joined(chains, xy) for chains in of_loop.values()]
    digits = 9 - int(np.ceil(np.log10(np.ptp(xy, axis=0).max())))
    holes.sort(key=lambda nodes: tuple(np.round(0.5 * (xy[nodes].min(axis=0) + xy[nodes].max(axis=0)), digits)))
    groups |= {f"hole-{k}": nodes for k, nodes in enumerate(holes, 1)}

    distance = np.hypot(*(xy - np.array(center)).T)
    nearest = int(np.argmin(distance))
    if distance[nearest] <= ON_PLANE * np.ptp(xy, axis=0).max():
        groups["center"] = np.array([nearest])
    return groups


def _chains(cells, planes, n_nodes):
    """Runs of boundary edges between symmetry planes: node ids in order; a closed run repeats its first."""
    start, end = cells.ravel(), np.roll(cells, -1, axis=1).ravel()
    forward, backward = start * n_nodes + end, end * n_nodes + start
    boundary = ~np.isin(forward, backward)
    start, end = start[boundary], end[boundary]
    if len(np.unique(start)) < len(start):
        raise CadError("mesh_blank: the outline touches itself at a point")
    for nodes in planes:
        on_plane = np.isin(start, nodes) & np.isin(end, nodes)
        start, end = start[~on_plane], end[~on_plane]
    after = dict(zip(start.tolist(), end.tolist()))
    firsts = sorted(set(after) - set(after.values()))  # open runs begin where nothing leads to
    chains = []
    while after:
        chain = [firsts.pop(0) if firsts else min(after)]
        while chain[-1] in after:
            chain.append(after.pop(chain[-1]))
        chains.append(np.array(chain))
    return chains


def _joined(chains, xy):
    """The nodes of one loop, in order; a closed loop starts at its node of largest x, then smallest |y|."""
    if len(chains) == 1 and chains[0][0] == chains[0][-1]:
        nodes = chains[0][:-1]
        far = np.flatnonzero(xy[nodes, 0] >= xy[nodes, 0].max() - ON_PLANE * np.ptp(xy[:, 0]))
        first = far[np.argmin(np.round(np.abs(xy[nodes[far], 1]), 9))]
        return np.roll(nodes, -first)
    centre = xy.mean(axis=0)
    angle = [np.arctan2(*(xy[chain[len(chain) // 2]] - centre)[::-1]) for chain in chains]
    return np.concatenate([chains[k] for k in np.argsort(angle)]) if chains else np.empty(0, dtype=np.int64)


def _distance(point, polyline):
    """From a point to a closed polyline (k, 2), or to several open ones (n, k, 2)."""
    if polyline.ndim == 2:
        start, end = polyline, np.roll(polyline, -1, axis=0)
    else:
        start, end = polyline[:, :-1].reshape(-1, 2), polyline[:, 1:].reshape(-1, 2)
    along = end - start
    part = np.einsum("ij,ij->i", point - start, along) / np.einsum("ij,ij->i", along, along)
    foot = start + np.clip(part, 0.0, 1.0)[:, None] * along
    return float(np.hypot(*(point - foot).T).min())
