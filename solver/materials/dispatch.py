"""One kernel for every locus and every hardening law, compiled only for the pair a scene uses.

Each locus and each hardening law carries its numbers in a NamedTuple of its own. Numba compiles a kernel anew for each
type of its arguments, and here the type also chooses the point functions; the compiled pairs are kept on disk,
which numba does not do for functions passed as arguments.

    locus(data, x, n, h) -> phi
        equivalent stress of x (3,) [11, 22, 12], homogeneous of degree 1, even; fills its gradient n (3,) with respect
        to [11, 22, 12], conjugate to [H11, H22, 2 H12], and its second derivative h (3, 3)
    backstress(data, past, alpha)
        fills alpha (3,) [MPa], the centre of the yield surface, from a row of the history
    begin(data, shape, past, m, n, h) -> float
        what an increment decides once, from the direction m of the trial state and the locus there
    harden(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work) -> size, slope
        size of the yield surface [MPa] and its slope after dg more of equivalent plastic strain flowed towards m, where
        phi(m) = 1; n (3,), h (3, 3) the locus at m; fills alpha and its derivatives with respect to dg and m
    remember(data, shape, ep, past, begun, dg, m, n, h, now, work)
        fills a row of the new history
"""

from typing import Any

from numba.extending import overload

from ..kernels import POINT

POINTS = {}  # {(name, type of the data): point function}


def locus(data, x, n, h) -> Any: ...


def backstress(data, past, alpha) -> Any: ...


def begin(data, shape, past, m, n, h) -> Any: ...


def harden(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work) -> Any: ...


def remember(data, shape, ep, past, begun, dg, m, n, h, now, work) -> Any: ...


@overload(locus, jit_options=POINT)
def _locus(data, x, n, h):
    point = POINTS["locus", data.instance_class]

    def chosen(data, x, n, h):
        return point(data, x, n, h)

    return chosen


@overload(backstress, jit_options=POINT)
def _backstress(data, past, alpha):
    point = POINTS["backstress", data.instance_class]

    def chosen(data, past, alpha):
        return point(data, past, alpha)

    return chosen


@overload(begin, jit_options=POINT)
def _begin(data, shape, past, m, n, h):
    point = POINTS["begin", data.instance_class]

    def chosen(data, shape, past, m, n, h):
        return point(data, shape, past, m, n, h)

    return chosen


@overload(harden, jit_options=POINT)
def _harden(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work):
    point = POINTS["harden", data.instance_class]

    def chosen(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work):
        return point(data, shape, ep, past, begun, dg, m, n, h, alpha, alpha_g, alpha_m, work)

    return chosen


@overload(remember, jit_options=POINT)
def _remember(data, shape, ep, past, begun, dg, m, n, h, now, work):
    point = POINTS["remember", data.instance_class]

    def chosen(data, shape, ep, past, begun, dg, m, n, h, now, work):
        return point(data, shape, ep, past, begun, dg, m, n, h, now, work)

    return chosen
