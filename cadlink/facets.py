"""A tool given as a collection of elements: the same call as on exact faces, with the normals of one's choice."""

from functools import partial

import numpy as np

from cadlink import facet_feet
from cadlink.errors import CadError
from cadlink.facet_closest import ELEMENT, NAGATA, NODAL, TIE, FacetSkin, project_on_facets
from cadlink.facet_mesh import (
    area_vectors,
    check_mesh,
    corner_angles,
    corner_normals,
    edge_normals,
    edges_of,
    point_normals,
    reversed_where,
    split,
    triangle_normals,
    turned_alike,
    unit,
    weld,
)
from cadlink.facet_tree import build_facet_tree
from cadlink.feet import further_feet
from cadlink.nagata import bulge_and_bend, corner_frames, patch_boxes, patch_coefficients, side_curves
from cadlink.projection import checked_points, checked_seed, empty_projection

KINDS = {"element": ELEMENT, "nodal": NODAL, "nagata": NAGATA}
CREASE = 40.0  # degrees: Nagata patches that meet at more keep their edge


class FacetSurface:
    """The skin of a mesh of triangles and quadrilaterals, normals out of the material.

    points : (n, 3) mm
    cells : (m, 3) or (m, 4) point numbers, or a list of both
    normals : how the facets are seen
        "element"  flat, each with its own normal
        "nodal"    flat, with the average of the element normals at each node (seed Eq. 14), interpolated
        "nagata"   curved, the quadratic patches that have those normals at their corners (Nagata 2005)
    crease : degrees; neighbours that meet at a larger angle do not share normals at their nodes. By default 40 for
        "nagata"; none for "nodal", where Eq. 14 averages over all elements at a node
    flip : the material is on the other side
    corner_normals : (m, k, 3) unit normals of the cells at their corners, where they are known (`Part.facets` knows
        them), in place of averages; neighbours that disagree by more than a degree then meet at a crease
    labels : (m,) what `Projection.face` tells of each cell, by default its number

    Points that coincide become one; facets are turned to agree with their neighbours, closed pieces outwards, open ones
    the way most of their area is given. A quadrilateral that is not flat is the two triangles on either side of its
    shorter diagonal, with the normal of its mean plane.
    `turned` (m,) tells which cells were turned; `dropped` how many had collapsed.
    raises : CadError, one line, for input that is no surface
    """

    def __init__(self, points, cells, normals="nodal", *, crease=None, flip=False, corner_normals=None, labels=None):
        if normals not in KINDS:
            raise CadError(f"facets: normals {normals!r}, expected one of {', '.join(KINDS)}")
        if crease is not None and not 0.0 < crease <= 180.0:
            raise CadError(f"facets: crease {crease!r}, expected an angle in degrees between 0 and 180")
        self.normals, self.kind = normals, KINDS[normals]
        self.part, self.on_faces = None, np.empty((0, 3))
        if crease is None and normals == "nagata":
            crease = CREASE
        self.crease = crease
        points, corners = check_mesh(points, cells)
        n_cells = len(corners)
        known = check_normals(corner_normals, corners)
        points, corners, kept, column = weld(points, corners)
        corners, turned = turned_alike(points, corners, edges_of(corners))
        turned, everywhere = turned ^ flip, np.full(len(corners), bool(flip))
        corners = reversed_where(corners, everywhere)
        if known is not None:
            known = known[kept[:, None], reversed_where(column, turned)]
        self.points, self.corners = points, corners
        self.turned = np.zeros(n_cells, bool)
        self.turned[kept] = turned
        self.dropped = n_cells - len(kept)
        labels = np.arange(n_cells) if labels is None else np.asarray(labels)
        if labels.shape != (n_cells,):
            raise CadError(f"facets: labels of shape {labels.shape}, expected ({n_cells},)")
        self.skin = build_facet_skin(points, corners, labels[kept], self.kind, crease, known)
        self.tie = TIE * float(np.ptp(points, axis=0).max())
        self.closed = bool((edges_of(corners).count == 2).all())

    def __repr__(self):
        body = "closed" if self.closed else "open"
        return f"<FacetSurface: {len(self.corners)} facets, {body}, {self.normals} normals>"

    @classmethod
    def read(cls, path, normals="nodal", *, scale=1.0, **options):
        """The surface of a mesh file: STL, OBJ, PLY, VTK, or whatever else meshio reads.

        path : file name; scale : mm per unit of the file; options : as for FacetSurface
        raises : CadError, one line that names the file
        """
        from cadlink.mesh_files import read_mesh  # meshio loads only when a file is read

        points, cells = read_mesh(path)
        try:
            return cls(points * scale, cells, normals, **options)
        except CadError as error:
            raise CadError(f"{path}: {error}") from None

    def triangles(self):
        """points (n, 3) [mm] and cells (t, 3) for pictures; normals leave the material."""
        return self.points, split(self.points, self.corners)[0]

    def misfit(self):
        """Largest distance found from the faces of the part these facets stand for [mm], 0 where they stand for none.

        Asked at points of the faces amid each triangle and its sides, as OpenCASCADE divided them.
        """
        return float(np.abs(self.project(self.on_faces).distance).max(initial=0.0))

    def project(self, points, seed=None):
        """Closest points on the facets.

        points : (n, 3) mm; seed : what the last call returned for these points, or None
        returns : Projection. `distance` is that to the facets (of Nagata patches: to the patches), signed, whatever
            the normals are. `normal` and `curvature` are the facet's own and 0 ("element"), interpolated with the bend
            of that field ("nodal"), or the patch's ("nagata"). On rims and creases, which no facet continues, they are
            those of a sharp edge. `face` is the cell's number, or its
            label
        """
        points = checked_points(points)
        seed = checked_seed(seed, len(points), 3, -1.0)
        hit = empty_projection(len(points), 3)
        if len(points):
            project_on_facets(self.skin, self.kind, self.tie, points, seed, *hit)
        return hit

    def feet(self, points, hit, reach):
        """Feet beside the nearest, as `ToolSurface.feet` tells them."""
        side = np.where(hit.distance >= 0.0, 1.0, -1.0)
        return further_feet(self, partial(facet_feet.propose, self.skin, self.kind, side), points, hit, reach)

    def tightest(self, side=1.0):
        """Smallest radius [mm] of the hollows, as `ToolSurface.tightest` tells it; 0 where facets meet at 9 degrees."""
        return facet_feet.tightest(self.points, self.corners, side)


def check_normals(normals, corners):
    """(m, 4, 3) unit normals at the corners, or None. Raises CadError for another shape or zero vectors."""
    if normals is None:
        return None
    normals = np.asarray(normals, float)
    width = 3 if (corners[:, 3] < 0).all() else 4
    if normals.shape not in ((len(corners), width, 3), (len(corners), 4, 3)):
        raise CadError(f"facets: corner_normals of shape {normals.shape}, expected ({len(corners)}, {width}, 3)")
    padded = np.zeros((len(corners), 4, 3))
    padded[:, : normals.shape[1]] = normals
    size = np.linalg.norm(padded, axis=2)
    if not (np.isfinite(size) & ((size > 0.0) | (corners < 0))).all():
        raise CadError("facets: corner_normals that are zero, nan or inf, expected unit vectors")
    return unit(padded)


def build_facet_skin(points, corners, label, kind, crease, known):
    """FacetSkin of checked, welded elements that agree in their sense.

    label : (m,) number of each element in the user's list; crease : degrees or None; known : (m, 4, 3) or None
    """
    m = len(corners)
    triangle = corners[:, 3] < 0
    sides = np.where(triangle, 3, 4)
    edges = edges_of(corners)
    triangles, element, place = split(points, corners)
    triangle_edges = edges_of(triangles)
    flat, thin = triangle_normals(points, triangles, triangle_edges)
    own = unit(area_vectors(points, corners))
    lost = ~own.any(axis=1)
    own[lost] = flat[np.searchsorted(element, np.flatnonzero(lost))]

    # Corner normals, and the coefficients of what is interpolated from them.
    limit = None if crease is None else np.radians(crease)
    nodal, sharp = corner_normals(points, corners, edges, own, limit, weighted=kind == NAGATA)
    if known is not None:
        # They leave the material as the elements do.
        nodal = known * np.where(np.einsum("mkc,mc->mk", known, own) < 0.0, -1.0, 1.0)[..., None]
        sharp = (edges.count != 2) | disagreeing(corners, nodal, edges)
    straight = np.zeros((m, 4, 3))
    field = np.zeros((m, 8, 3))
    if kind == NODAL:
        field = patch_coefficients(nodal, triangle, straight)
    else:
        field[:, 0] = own
    curves = side_curves(points, corners, unit(nodal), edges) if kind == NAGATA else straight
    patch = patch_coefficients(points[corners], triangle, curves)

    # What is searched: elements that are curved patches, triangles otherwise.
    if kind == NAGATA:
        items, own_element, normal = corners, np.arange(m), own
        at_corner, angle = corner_frames(patch, sides)
        total = np.zeros((len(points) + 1, 3))
        np.add.at(total, corners.ravel(), (angle[..., None] * at_corner).reshape(-1, 3))
        point_normal = unit(total[:-1])
        low, high = patch_boxes(patch, sides)
        side_edge, thin = edges.side_edge, np.zeros(m, bool)
        side_sharp, side_normal = sharp, edge_normals(edges, own)
        neighbour = neighbours(edges)
        place = np.zeros((m, 3), int)
    else:
        items, own_element, normal = np.column_stack([triangles, np.full(len(triangles), -1)]), element, flat
        point_normal = point_normals(len(points), triangles, flat, corner_angles(points, triangles))
        low, high = points[triangles].min(axis=1), points[triangles].max(axis=1)
        side_edge = np.column_stack([triangle_edges.side_edge, np.full(len(triangles), -1)])
        side_sharp, side_normal = triangle_edges.count == 1, edge_normals(triangle_edges, flat)
        neighbour = np.full((len(triangles), 4, 2), -1)
    size = float(np.ptp(points, axis=0).max())
    pad = 1e-12 * size
    point_sharp = np.zeros(len(points), bool)
    ends = edges.ends[sharp if kind == NAGATA else edges.count == 1]
    point_sharp[ends.ravel()] = True
    tree = build_facet_tree(low - pad, high + pad)
    return FacetSkin(
        tree.low,
        tree.high,
        tree.order,
        points,
        np.ascontiguousarray(items),
        own_element,
        place,
        np.ascontiguousarray(normal),
        thin,
        np.where(side_edge[..., None] >= 0, side_normal[side_edge], 0.0),
        (side_edge >= 0) & side_sharp[side_edge],
        neighbour,
        point_normal,
        point_sharp,
        patch,
        field,
        sides,
        *bulge_and_bend(points[corners], triangle, curves),
        np.asarray(label, np.int64),
    )


def disagreeing(corners, normals, edges):
    """(e,) whether the corner normals on both sides of an edge differ by more than a degree at either end."""
    n_sides = np.where(corners[:, 3] < 0, 3, 4)
    f, g = edges.owner.T
    i, j = edges.slot.T
    i1, j1 = (i + 1) % n_sides[f], (j + 1) % n_sides[g]
    first = np.einsum("ec,ec->e", normals[f, i], normals[g, j1])
    last = np.einsum("ec,ec->e", normals[f, i1], normals[g, j])
    return np.minimum(first, last) < np.cos(np.radians(1.0))


def neighbours(edges):
    """(m, 4, 2) element across each side and its side there; -1 for none, or for more than one."""
    m, width = edges.side_edge.shape
    found = np.full((m, width, 2), -1)
    two = np.flatnonzero(edges.count == 2)
    (f, g), (i, j) = edges.owner[two].T, edges.slot[two].T
    found[f, i], found[g, j] = np.column_stack([g, j]), np.column_stack([f, i])
    return found
