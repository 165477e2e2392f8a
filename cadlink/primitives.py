"""Closest point, normal and curvature on planes, cylinders, cones, spheres and tori.

    x, y, z   point in the frame of the surface [mm]
    u, v      parameters of the foot, as OpenCASCADE defines them
    R, r      radius (large radius of a torus), small radius [mm]
    a         half angle of a cone [rad]
    k         curvature of the outward side, > 0 where the material bulges out [1/mm]
    c, s      cosine and sine

Only feet where the distance has a minimum are returned: on cones and on tori that cut their own
axis there may be two, in the half plane of the point (branch 0) and from beyond the axis
(branch 1). Formulas are elementary geometry in the meridian plane.
"""

from math import atan2, cos, pi, sin, sqrt

from numba import njit

from cadlink.kernels import POINT
from cadlink.records import CONE, CYLINDER, PLANE, SPHERE


@njit(forceinline=True, **POINT)
def into_frame(frame, px, py, pz):
    """Coordinates of a point in an orthonormal frame (origin, x, y, z)."""
    dx, dy, dz = px - frame[0, 0], py - frame[0, 1], pz - frame[0, 2]
    return (
        dx * frame[1, 0] + dy * frame[1, 1] + dz * frame[1, 2],
        dx * frame[2, 0] + dy * frame[2, 1] + dz * frame[2, 2],
        dx * frame[3, 0] + dy * frame[3, 1] + dz * frame[3, 2],
    )


@njit(forceinline=True, **POINT)
def out_of_frame(frame, x, y, z):
    return (
        frame[0, 0] + x * frame[1, 0] + y * frame[2, 0] + z * frame[3, 0],
        frame[0, 1] + x * frame[1, 1] + y * frame[2, 1] + z * frame[3, 1],
        frame[0, 2] + x * frame[1, 2] + y * frame[2, 2] + z * frame[3, 2],
    )


@njit(forceinline=True, **POINT)
def turned(frame, x, y, z):
    """A direction given in the frame, in space."""
    return (
        x * frame[1, 0] + y * frame[2, 0] + z * frame[3, 0],
        x * frame[1, 1] + y * frame[2, 1] + z * frame[3, 1],
        x * frame[1, 2] + y * frame[2, 2] + z * frame[3, 2],
    )


@njit(forceinline=True, **POINT)
def foot_cone(rho, z, R, a):
    """Distance along the generator and signed radius there of the foot on r = R + v sin a."""
    v = (rho - R) * sin(a) + z * cos(a)
    return v, R + v * sin(a)


@njit(forceinline=True, **POINT)
def foot_torus(rho, z, R, r):
    """Angle on the tube and signed distance of the foot from the axis."""
    v = atan2(z, rho - R)
    return v, R + r * cos(v)


@njit(**POINT)
def foot_on_form(face, p, branch):
    """Foot of a point on an untrimmed surface.

    returns : exists, u, v, foot in space
    """
    form, frame, size = face.form, face.frame, face.size
    x, y, z = into_frame(frame, p[0], p[1], p[2])
    if form == PLANE:
        fx, fy, fz = out_of_frame(frame, x, y, 0.0)
        return branch == 0, x, y, (fx, fy, fz)
    # Meridian plane of the point; on the axis every meridian is as good: take the first.
    rho = sqrt(x * x + y * y)
    cu, su = (x / rho, y / rho) if rho > 0.0 else (1.0, 0.0)
    u = atan2(su, cu)
    exists = branch == 0
    if form == CYLINDER:
        v, radius, height = z, size[0], z
    elif form == SPHERE:
        v = atan2(z, rho)
        h = sqrt(rho * rho + z * z)
        cv, sv = (rho / h, z / h) if h > 0.0 else (1.0, 0.0)
        radius, height = size[0] * cv, size[0] * sv
    elif form == CONE:
        if branch == 0:
            v, radius = foot_cone(rho, z, size[0], size[1])
            exists = radius >= 0.0
        else:
            v, radius = foot_cone(-rho, z, size[0], size[1])
            exists = radius <= 0.0
            u, radius = u + pi, -radius
        height = v * cos(size[1])
    else:
        if branch == 0:
            v, radius = foot_torus(rho, z, size[0], size[1])
            exists = radius >= 0.0
        else:
            v, radius = foot_torus(-rho, z, size[0], size[1])
            exists = radius <= 0.0
            u, radius = u + pi, -radius
        height = size[1] * sin(v)
    fx, fy, fz = out_of_frame(frame, radius * cu, radius * su, height)
    return exists, u, v, (fx, fy, fz)


@njit(**POINT)
def shape_on_form(face, u, v):
    """Outward normal, curvatures k1 >= k2 and the direction of k1 at (u, v).

    returns : n (3), k1, k2, e (3)
    """
    form, frame, size, sense = face.form, face.frame, face.size, face.sense
    if form == PLANE:
        nx, ny, nz = turned(frame, 0.0, 0.0, sense)
        return (nx, ny, nz), 0.0, 0.0, (frame[1, 0], frame[1, 1], frame[1, 2])
    cu, su = cos(u), sin(u)
    # Along the parallel (direction e_u) the curvature is ku, along the meridian kv.
    if form == CYLINDER:
        nr, nh, ku, kv = 1.0, 0.0, 1.0 / size[0], 0.0
        er, eh = 0.0, 1.0
    elif form == CONE:
        ca, sa = cos(size[1]), sin(size[1])
        r = size[0] + v * sa
        side = 1.0 if r >= 0.0 else -1.0
        nr, nh = side * ca, -side * sa
        ku, kv = ca / max(abs(r), 1e-300), 0.0
        er, eh = sa, ca
    elif form == SPHERE:
        nr, nh, ku, kv = cos(v), sin(v), 1.0 / size[0], 1.0 / size[0]
        er, eh = -sin(v), cos(v)
    else:
        cv, sv = cos(v), sin(v)
        w = size[0] + size[1] * cv
        side = 1.0 if w >= 0.0 else -1.0
        nr, nh = side * cv, side * sv
        ku, kv = cv / max(abs(w), 1e-300), side / size[1]
        er, eh = -sv, cv
    nx, ny, nz = turned(frame, sense * nr * cu, sense * nr * su, sense * nh)
    ku, kv = sense * ku, sense * kv
    if ku >= kv:
        ex, ey, ez = turned(frame, -su, cu, 0.0)
        return (nx, ny, nz), ku, kv, (ex, ey, ez)
    ex, ey, ez = turned(frame, er * cu, er * su, eh)
    return (nx, ny, nz), kv, ku, (ex, ey, ez)
