"""The exact skin of a tool: closest points, normals and curvatures of trimmed CAD faces."""

import zlib
from functools import partial

import numpy as np

from cadlink.closest import CHUNK, COLUMNS, ITEM, REACH, WITH_MODEL, A, B, Hints, project_points
from cadlink.feet import further_feet
from cadlink.follow import FEW, follow_few, follow_forms
from cadlink.pick import pick_faces
from cadlink.projection import checked_points, checked_seed, empty_projection
from cadlink.skin import build_skin
from cadlink.skin_feet import propose, tightest

CELLS = 4096  # of the grid of hints, about


class ToolSurface:
    """The trimmed skin of a part, normals out of the material.

    part : Part of an assembly read by `read_step`
    faces : numbers, names or colours of the faces to keep (pick.py), None for all

    Planes, cylinders, cones, spheres and tori are met in closed form; every other surface as the
    rational Bezier patches it is made of, by Newton from a tree of boxes. No facets anywhere.
    """

    def __init__(self, part, faces=None):
        if faces is not None:
            faces = pick_faces(part, faces)
        self.part = part
        self.skin = build_skin(part.record["skin"], faces)
        self.hints = None
        self.hollows = {}
        self.left = np.empty(0, np.int64)  # scratch of `follow`, and soon, point, counts
        # Tells its own seeds from those of other surfaces.
        self.stamp = float(zlib.crc32(self.skin.items.tobytes() + self.skin.faces.tobytes()))
        self.columns = WITH_MODEL if len(self.skin.leaves) else COLUMNS
        skin = self.skin
        self.forms = skin.items, skin.faces, skin.rims, skin.rasters, skin.pieces, skin.ctrl, self.stamp

    def misfit(self):
        """How far the faces of the part are met from where the file draws them [mm]: `Gaps.form`."""
        return self.part.gap_report().form

    def project(self, points, seed=None):
        """Closest points on the exact tool faces.

        points : (n, 3) mm, tool frame
        seed : what the last call returned for these points, or None; it shortens the search and
            changes nothing beyond round-off (between equally near feet it keeps the last one)
        returns : Projection; distance d, normal n and curvatures k satisfy grad d = n and
            hess d = sum k_i / (1 + k_i d) e_i e_i^T (theory 6)
        raises : ValueError for points or seeds of another shape or points that are not finite
        """
        points = checked_points(points)
        if np.shape(seed) == (len(points), COLUMNS + WITH_MODEL - self.columns):
            seed = None  # of a surface of the other kind
        seed = checked_seed(seed, len(points), self.columns, 0.0)
        if self.hints is None:
            self.hints = hint_grid(self)
        return project(self.skin, self.hints, self.stamp, points, seed)

    def follow(self, points, shift, reach, place, hit, near):
        """Projects those points that may lie nearer than their reach, in place: for loops that ask often and allocate
        nothing.

        points : (m, 3) mm, contiguous; the first n are looked at, and not checked: what is not finite is far
        shift : (3,) mm, how far the surface has been carried; reach : (n,) mm
        place : (n, 3) mm, where each was projected last, in the tool frame
        hit : there, distance, normal, curvature, direction, face and seed of a Projection by this surface, in this
            order; seeds of zeros are blank
        near : (n,) filled with the points of which place and hit have been overwritten; returns how many they are
        """
        n = len(reach)
        if len(self.left) < n:
            self.left, self.soon = np.empty(n, np.int64), np.empty(n, np.int64)
            self.point, self.counts = np.empty((n, 3)), np.empty((n // CHUNK + 1, 3), np.int64)
        rows = near, self.left, self.soon
        if n < FEW:
            n_near, n_left = follow_few(*self.forms, points, shift, reach, place, *hit, *rows)
        else:
            n_near, n_left = follow_forms(*self.forms, points, shift, reach, place, *hit, *rows, self.counts)
        if n_left:
            distance, *others = hit
            left, seed = self.left[:n_left], others[-1]
            project_points(self.skin, self.hints, self.stamp, left, place, seed, distance, self.point, *others)
        return n_near

    def feet(self, points, hit, reach):
        """Feet beside the nearest: where the distance has its other minima, two for each point at most.

        points : (n, 3) mm; hit : what `project` returned for them; reach : mm, one or (n,); farther ones are not told
        returns : Feet (feet.py): owner (k,), the points they belong to, and their Projection
        """
        return further_feet(self, partial(propose, self.skin), points, hit, reach)

    def tightest(self, side=1.0):
        """Smallest radius [mm] of the skin's hollows, 0 for a sharp corner, inf for none.

        side : +1 hollows as seen from outside the material, -1 from within
        """
        if side not in self.hollows:
            self.hollows[side] = tightest(self, side)
        return self.hollows[side]


def project(skin, hints, stamp, points, seed):
    """Projection of checked points."""
    hit = empty_projection(len(points), seed.shape[1])
    if len(points):
        project_points(skin, hints, stamp, np.arange(len(points)), points, seed, *hit)
    return hit


def hint_grid(surface):
    """The seed of a search at the middle of each cell of a coarse grid round the skin: where searches begin.

    Those that fill it begin at a coarser one.
    """
    low, high = surface.skin.items["low"].min(axis=0), surface.skin.items["high"].max(axis=0)
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    hints = Hints(low, np.zeros(3), np.full((1, 1, 1, 4), -1.0))
    for cells in (CELLS // 64, CELLS):
        hints.seed[..., 3] = 0.0  # all middles are searched for
        counts = np.maximum(1, np.round(size * (cells / size.prod()) ** (1.0 / 3.0))).astype(int)
        per_mm = counts / size
        middles = [low[c] + (np.arange(counts[c]) + 0.5) / per_mm[c] for c in range(3)]
        points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 3)
        found = project(surface.skin, hints, surface.stamp, points, np.zeros((len(points), COLUMNS)))
        hints = Hints(low, per_mm, found.seed[:, [ITEM, A, B, REACH]].reshape(*counts, 4))
    return hints
