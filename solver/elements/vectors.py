"""Vectors of three numbers as tuples: they stay in registers, where an array inside a loop would be allocated."""

from math import sqrt

from numba import njit

from ..kernels import FUSED_POINT


@njit(**FUSED_POINT)
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**FUSED_POINT)
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(**FUSED_POINT)
def scaled(s, a):
    """s a"""
    return s * a[0], s * a[1], s * a[2]


@njit(**FUSED_POINT)
def plus(a, s, b):
    """a + s b"""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@njit(**FUSED_POINT)
def minus(a, b):
    """a - b"""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(**FUSED_POINT)
def inverse_and_normal(a1, a2):
    """A11, A22, A12 of the inverse of the metric a_a.a_b, and the unit normal."""
    across = cross(a1, a2)
    d = 1.0 / dot(across, across)
    return dot(a2, a2) * d, dot(a1, a1) * d, -dot(a1, a2) * d, scaled(sqrt(d), across)
