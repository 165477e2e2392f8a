"""Vectors of three numbers as tuples: they stay in registers, where an array inside a loop would be allocated."""

from numba import njit

from ..kernels import POINT


@njit(**POINT)
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**POINT)
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(**POINT)
def scaled(s, a):
    """s a"""
    return s * a[0], s * a[1], s * a[2]


@njit(**POINT)
def plus(a, s, b):
    """a + s b"""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@njit(**POINT)
def minus(a, b):
    """a - b"""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
