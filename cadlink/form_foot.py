"""Distance, normal and curvature of planes, cylinders, cones, spheres and tori without angles.

    x, y, z   point in the frame of the surface [mm]
    rho       its distance from the axis;  m  from the centre of a sphere or of a torus' tube
    v         along the generator of a cylinder or cone
    d         signed distance, + on the side of the frame's own normal
    R, r      radius (large radius of a torus), small radius

The feet are those of primitives.py; here the point's own direction cosines x/rho, y/rho, .. stand
for the cosines of its parameters, which saves all trigonometric functions (and 60 ns).
"""

from math import sqrt

from numba import njit

from cadlink.kernels import POINT
from cadlink.primitives import into_frame, out_of_frame, turned
from cadlink.records import CONE, CYLINDER, PLANE, SPHERE

AXIS = 1e-6  # of the radius: nearer to an axis or centre than this, the foot is left to primitives.py


@njit(forceinline=True, **POINT)
def distance_to_form(face, rim, p):
    """Whether the foot is single, d, x, y, z, rho, m, v."""
    form, size = face.form, face.size
    x, y, z = into_frame(face.frame, p[0], p[1], p[2])
    if form == PLANE:
        return True, z, x, y, z, 0.0, 0.0, 0.0
    R = size[0]
    rho = sqrt(x * x + y * y)
    single = rho > AXIS * R
    if form == CYLINDER:
        return single, rho - R, x, y, z, rho, 0.0, z
    if form == CONE:
        ca, sa = rim.slope[0], rim.slope[1]
        v = (rho - R) * sa + z * ca
        radius = R + v * sa
        return single and radius > AXIS * rho, (rho - R) * ca - z * sa, x, y, z, rho, 0.0, v
    if form == SPHERE:
        m = sqrt(rho * rho + z * z)
        return single, m - R, x, y, z, rho, m, 0.0
    m = sqrt((rho - R) * (rho - R) + z * z)
    return single and m > AXIS * size[1], m - size[1], x, y, z, rho, m, 0.0


@njit(forceinline=True, **POINT)
def shape_of_form(face, rim, x, y, z, rho, m, v):
    """Foot, outward normal, curvatures k1 >= k2 and the direction of k1 of such a point."""
    form, frame, size, sense = face.form, face.frame, face.size, face.sense
    if form == PLANE:
        return (
            out_of_frame(frame, x, y, 0.0),
            (sense * frame[3, 0], sense * frame[3, 1], sense * frame[3, 2]),
            0.0,
            0.0,
            (frame[1, 0], frame[1, 1], frame[1, 2]),
        )
    cu, su = x / rho, y / rho
    # Radial and axial part of the normal, radius and height of the foot, curvature along the
    # parallel and along the meridian.
    if form == CYLINDER:
        nr, nh, radius, height, ku, kv = 1.0, 0.0, size[0], z, 1.0 / size[0], 0.0
    elif form == CONE:
        nr, nh = rim.slope[0], -rim.slope[1]
        radius, height = size[0] + v * rim.slope[1], v * rim.slope[0]
        ku, kv = nr / radius, 0.0
    elif form == SPHERE:
        nr, nh = rho / m, z / m
        radius, height = size[0] * nr, size[0] * nh
        ku, kv = 1.0 / size[0], 1.0 / size[0]
    else:
        nr, nh = (rho - size[0]) / m, z / m
        radius, height = size[0] + size[1] * nr, size[1] * nh
        ku, kv = nr / radius, 1.0 / size[1]
    foot = out_of_frame(frame, radius * cu, radius * su, height)
    normal = turned(frame, sense * nr * cu, sense * nr * su, sense * nh)
    ku, kv = sense * ku, sense * kv
    if ku >= kv:
        return foot, normal, ku, kv, turned(frame, -su, cu, 0.0)
    return foot, normal, kv, ku, turned(frame, -nh * cu, -nh * su, nr)
