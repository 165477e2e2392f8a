"""A surface moved out by a clearance, or with its material on the other side.

    d, n, k    signed distance, normal and curvatures on the surface given
    c          clearance [mm], + out of the material

    d' = d - c,   n' = n,   foot' = foot + c n,   k' = k / (1 + c k)

is the level set d = c: faces move along their normals, convex edges become rounds of radius c. Every pair of k', d'
has the same grad and hess as k, d, since k' / (1 + k' d') = k / (1 + k d). Outside the moved surface d' is the distance
to it for c > 0; inside, near concave shapes narrower than c, it is the depth along the normal of the surface given.

The other side:  d' = -d,   n' = -n,   k1' = -k2,   k2' = -k1.
"""

import numpy as np

from cadlink.errors import CadError

FLATTEST = 1e-12  # of 1 + c k: at a centre of curvature the moved surface has no curvature of its own


class ShiftedSurface:
    """A surface of the same call, moved or turned inside out.

    surface : anything with `project`
    offset : mm along the normal of the result, + away from its material
    flip : the material is on the other side of the surface
    raises : CadError for an offset that is not a finite length
    """

    def __init__(self, surface, offset=0.0, flip=False):
        if not np.isfinite(offset):
            raise CadError(f"offset {offset!r}, expected a length in mm")
        self.surface, self.offset, self.flip = surface, float(offset), bool(flip)

    def __repr__(self):
        side = ", other side" if self.flip else ""
        return f"<{self.surface!r} moved by {self.offset:g} mm{side}>"

    @property
    def part(self):
        """The part of the surface given, or None."""
        return getattr(self.surface, "part", None)

    def misfit(self):
        """That of the surface given [mm]."""
        return self.surface.misfit()

    def triangles(self):
        """points (n, 3) and cells (m, 3) of the surface given, for pictures."""
        source = self.part if self.part is not None else self.surface
        return source.triangles()

    def project(self, points, seed=None):
        """Closest points as Projection; points (n, 3) mm, seed as of the last call."""
        return self.shift(self.surface.project(points, seed))

    def shift(self, hit):
        """Projection on this surface of one on the surface given."""
        if self.flip:
            hit = turned_inside_out(hit)
        return moved_out(hit, self.offset) if self.offset else hit

    def feet(self, points, hit, reach):
        """Feet beside the nearest, as `ToolSurface.feet` tells them: those of the surface given, moved along."""
        given = hit._replace(distance=hit.distance + self.offset)
        if self.flip:
            given = given._replace(distance=-given.distance, normal=-given.normal)
        found = self.surface.feet(points, given, reach + abs(self.offset))
        moved = self.shift(found.hit)
        near = np.abs(moved.distance) <= np.broadcast_to(reach, len(points))[found.owner]
        return found._replace(owner=found.owner[near], hit=type(moved)(*(values[near] for values in moved)))

    def tightest(self, side=1.0):
        """Smallest radius [mm] of the hollows, as `ToolSurface.tightest` tells it: less by what fills them."""
        radius = self.surface.tightest(-side if self.flip else side)
        return max(0.0, radius - side * self.offset)


def shifted(surface, offset=0.0, flip=False):
    """The surface itself where nothing is to be done, a ShiftedSurface otherwise."""
    return ShiftedSurface(surface, offset, flip) if offset or flip else surface


def turned_inside_out(hit):
    """The Projection where the material is on the other side."""
    return hit._replace(
        distance=-hit.distance,
        normal=-hit.normal,
        curvature=-hit.curvature[:, ::-1],
        direction=np.cross(hit.normal, hit.direction),
    )


def moved_out(hit, offset):
    """The Projection on the surface moved by an offset along its normals."""
    bend = 1.0 + offset * hit.curvature
    bend = np.where(np.abs(bend) < FLATTEST, FLATTEST, bend)
    k = hit.curvature / bend
    # Past a centre of curvature the larger may come second.
    swapped = k[:, 0] < k[:, 1]
    across = np.cross(hit.normal, hit.direction)
    return hit._replace(
        distance=hit.distance - offset,
        point=hit.point + offset * hit.normal,
        curvature=np.where(swapped[:, None], k[:, ::-1], k),
        direction=np.where(swapped[:, None], across, hit.direction),
    )
