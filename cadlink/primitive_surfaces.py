"""Tools without a CAD file: whole planes, cylinders, spheres, cones and tori, with the call of ToolSurface.

Each is the surface without end; its material is inside (below a plane), or outside where `hollow` says so. Formulas and
kernels are those of primitives.py.
"""

from math import pi, sqrt

import numpy as np
from numba import njit, prange

from cadlink.errors import CadError
from cadlink.feet import Feet
from cadlink.lipschitz import stays_far
from cadlink.primitives import foot_on_form, shape_on_form
from cadlink.projection import checked_points, empty_projection
from cadlink.records import CONE, CYLINDER, PLANE, SPHERE, TORUS

SHARP = 1e12  # 1/mm, stands for the curvature of an apex
# As a face's record has them, in another order: of one that begins like it numba would take it for a kind, and warn.
FORM = np.dtype([("sense", "f8"), ("form", "i8"), ("frame", "f8", (4, 3)), ("size", "f8", 2)])


@njit
def at_apex(face, p):
    """Signed distance, normal and a direction across it where the apex of a cone is nearest."""
    frame = face.frame
    m = p[0] - frame[0, 0], p[1] - frame[0, 1], p[2] - frame[0, 2]
    h = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2])
    if h > 0.0:
        n = m[0] / h, m[1] / h, m[2] / h
    else:
        n = -frame[3, 0], -frame[3, 1], -frame[3, 2]
    c = n[0] * frame[1, 0] + n[1] * frame[1, 1] + n[2] * frame[1, 2]
    k = 1 if abs(c) < 0.7 else 2
    c = n[0] * frame[k, 0] + n[1] * frame[k, 1] + n[2] * frame[k, 2]
    e = frame[k, 0] - c * n[0], frame[k, 1] - c * n[1], frame[k, 2] - c * n[2]
    size = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    s = face.sense
    return s * h, (s * n[0], s * n[1], s * n[2]), (e[0] / size, e[1] / size, e[2] / size)


@njit(forceinline=True)
def answer_on_form(whole, p):
    """The answer at a point on a whole surface.

    whole : record FORM; p : (3,) mm
    returns : signed distance [mm], foot (3,) [mm], normal (3,), curvatures k1, k2 [1/mm], direction (3,) of k1
    """
    exists, u, v, q = foot_on_form(whole, p, 0)
    if exists:
        n, k1, k2, e = shape_on_form(whole, u, v)
        d = (p[0] - q[0]) * n[0] + (p[1] - q[1]) * n[1] + (p[2] - q[2]) * n[2]
    else:
        d, n, e = at_apex(whole, p)
        q = (whole.frame[0, 0], whole.frame[0, 1], whole.frame[0, 2])
        k1 = k2 = whole.sense * SHARP
    return d, q, n, k1, k2, e


@njit(parallel=True, cache=True)
def project_on_form(faces, points, distance, point, normal, curvature, direction, face, seed):
    """Fill the fields of a Projection on one whole surface."""
    for i in prange(len(points)):
        d, q, n, k1, k2, e = answer_on_form(faces[0], (points[i, 0], points[i, 1], points[i, 2]))
        distance[i], face[i] = d, 0
        for c in range(3):
            point[i, c], normal[i, c], direction[i, c], seed[i, c] = q[c], n[c], e[c], 0.0
        curvature[i, 0], curvature[i, 1] = k1, k2


@njit(cache=True)
def follow_form(faces, points, shift, reach, place, distance, normal, curvature, direction, face, near):
    """Project those of n points that may lie nearer than their reach, in place; returns how many they are.

    faces : (1,) FORM; points : (m, 3) mm, the first n are looked at; shift : (3,) mm; reach, distance : (n,) mm
    place, normal, direction : (n, 3); curvature : (n, 2) 1/mm; face : (n,); near : (n,), filled with their numbers
    """
    count = 0
    for i in range(len(reach)):
        p = (points[i, 0] - shift[0], points[i, 1] - shift[1], points[i, 2] - shift[2])
        if stays_far(p, place, i, distance[i] - reach[i]):
            continue
        place[i, 0], place[i, 1], place[i, 2] = p
        near[count] = i
        count += 1
        distance[i], _, n, curvature[i, 0], curvature[i, 1], e = answer_on_form(faces[0], p)
        face[i] = 0
        for c in range(3):
            normal[i, c], direction[i, c] = n[c], e[c]
    return count


class PrimitiveSurface:
    """A whole surface in closed form; what its kinds have in common."""

    def __init__(self, form, at, axis, size, hollow):
        frame = np.vstack([vector(at, type(self).__name__, "a point"), frame_of(axis, type(self).__name__)])
        self.form = np.zeros(1, FORM)
        self.form[0] = -1.0 if hollow else 1.0, form, frame, size

    def project(self, points, seed=None):
        """Closest points as Projection. points : (n, 3) mm; seed : not needed, taken for the sake of the call."""
        points = checked_points(points)
        hit = empty_projection(len(points), 3)
        if len(points):
            project_on_form(self.form, points, *hit)
        return hit

    def follow(self, points, shift, reach, place, hit, near):
        """Projects those points that may lie nearer than their reach, in place: ToolSurface.follow, whose arrays it
        takes. Seeds stay as they are: none is needed."""
        *fields, _ = hit
        return follow_form(self.form, points, shift, reach, place, *fields, near)

    def feet(self, points, hit, reach):
        """None: the distance to a whole surface of these kinds has one minimum only."""
        return Feet(np.zeros(0, np.int64), empty_projection(0, 3))

    def tightest(self, side=1.0):
        """inf [mm]: no point has a second foot, however small the radius."""
        return np.inf


class PlaneSurface(PrimitiveSurface):
    """A plane through `point` [mm]; `normal` leaves the material."""

    def __init__(self, point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0)):
        super().__init__(PLANE, point, normal, (0.0, 0.0), False)


class CylinderSurface(PrimitiveSurface):
    """A cylinder without ends about the axis through `point`; hollow: a bore. Lengths in mm."""

    def __init__(self, radius, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), *, hollow=False):
        super().__init__(CYLINDER, point, axis, (length(radius, "CylinderSurface radius"), 0.0), hollow)


class SphereSurface(PrimitiveSurface):
    """A sphere about `center`; hollow: a bowl. Lengths in mm."""

    def __init__(self, radius, center=(0.0, 0.0, 0.0), *, hollow=False):
        super().__init__(SPHERE, center, (0.0, 0.0, 1.0), (length(radius, "SphereSurface radius"), 0.0), hollow)


class ConeSurface(PrimitiveSurface):
    """A cone that opens from its `apex` along `axis`; half_angle in degrees between axis and side; hollow: a funnel."""

    def __init__(self, half_angle, apex=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), *, hollow=False):
        if not 0.0 < half_angle < 90.0:
            raise CadError(f"ConeSurface half_angle: found {half_angle!r}, expected degrees between 0 and 90")
        super().__init__(CONE, apex, axis, (0.0, half_angle * pi / 180.0), hollow)


class TorusSurface(PrimitiveSurface):
    """A ring: a tube of radius `tube` whose middle runs at `radius` round the axis through `center`. Lengths in mm."""

    def __init__(self, radius, tube, center=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), *, hollow=False):
        if length(tube, "TorusSurface tube") >= length(radius, "TorusSurface radius"):
            raise CadError(f"TorusSurface tube: found {tube!r}, expected less than the radius {radius!r}")
        super().__init__(TORUS, center, axis, (radius, tube), hollow)


def length(value, what):
    """A length above 0 [mm]."""
    if not (np.ndim(value) == 0 and np.isfinite(value) and value > 0.0):
        raise CadError(f"{what}: found {value!r}, expected a length in mm above 0")
    return float(value)


def vector(value, what, expected):
    found = np.asarray(value, float)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise CadError(f"{what}: found {value!r}, expected {expected} (x, y, z)")
    return found


def frame_of(axis, what):
    """(3, 3) rows x, y, z of a right-handed frame with z along an axis."""
    z = vector(axis, what, "a direction")
    size = np.linalg.norm(z)
    if size == 0.0:
        raise CadError(f"{what}: found a direction of length 0, expected one that points somewhere")
    z = z / size
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])
