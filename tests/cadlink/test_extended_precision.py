"""Distances to B-spline faces against the same patches in extended precision, where neither formula nor round-off of
another code limits what is seen: searched and tracked within 1e-12 mm."""

from math import comb

import numpy as np
import pytest

from cadlink import read_step
from cadlink.skin import ON_LEAF
from tests.cadlink import shapes
from tests.cadlink.occ_truth import part_of
from tests.cadlink.test_projection_properties import points_round
from tests.cadlink.test_real_files import SHARED

EXACT = np.longdouble
NEWTON = 8  # steps from a foot that is right to 1e-7 mm

pytestmark = pytest.mark.skipif(np.finfo(EXACT).eps > 1e-18, reason="needs long doubles longer than doubles")


def bernstein(degree, s, order):
    """Bernstein polynomials at s (n,), or their derivatives of an order: (n, degree + 1)."""
    if order > degree:
        return np.zeros((len(s), degree + 1), dtype=s.dtype)
    if order == 0:
        return np.stack([comb(degree, i) * s**i * (1 - s) ** (degree - i) for i in range(degree + 1)], axis=1)
    lower = np.pad(bernstein(degree - 1, s, order - 1), ((0, 0), (1, 1)))
    return degree * (lower[:, :-1] - lower[:, 1:])


def over_weight(net, s, t):
    """S, S_s, S_t, S_ss, S_st, S_tt (n, 3) of a rational patch by the quotient rule. net : (p + 1, q + 1, 4)"""
    along, across = net.shape[0] - 1, net.shape[1] - 1

    def homogeneous(i, j):
        value = np.einsum("ni,nix->nx", bernstein(along, s, i), np.einsum("nj,ijx->nix", bernstein(across, t, j), net))
        return value[:, :3], value[:, 3:]

    (a, w), (a_s, w_s), (a_t, w_t) = homogeneous(0, 0), homogeneous(1, 0), homogeneous(0, 1)
    (a_ss, w_ss), (a_st, w_st), (a_tt, w_tt) = homogeneous(2, 0), homogeneous(1, 1), homogeneous(0, 2)
    x = a / w
    x_s, x_t = (a_s - w_s * x) / w, (a_t - w_t * x) / w
    x_ss, x_tt = (a_ss - 2 * w_s * x_s - w_ss * x) / w, (a_tt - 2 * w_t * x_t - w_tt * x) / w
    return x, x_s, x_t, x_ss, (a_st - w_s * x_t - w_t * x_s - w_st * x) / w, x_tt


def true_distance(net, points, s, t):
    """Distance (n,) to a patch at the foot near (s, t)."""
    for _ in range(NEWTON):
        x, x_s, x_t, x_ss, x_st, x_tt = over_weight(net, s, t)
        r = x - points
        g, h = (r * x_s).sum(axis=1), (r * x_t).sum(axis=1)
        ss, tt = (x_s * x_s + r * x_ss).sum(axis=1), (x_t * x_t + r * x_tt).sum(axis=1)
        st = (x_s * x_t + r * x_st).sum(axis=1)
        det = ss * tt - st * st
        s, t = s - (tt * g - st * h) / det, t - (ss * h - st * g) / det
    return np.sqrt(((over_weight(net, s, t)[0] - points) ** 2).sum(axis=1))


def errors(surface, points, hit):
    """|distance - the true one| of the points whose foot is inside a patch."""
    skin, item = surface.skin, hit.seed[:, 0].astype(int)
    rows = np.flatnonzero(skin.items["kind"][item] == ON_LEAF)
    patch_of = skin.leaves["patch"][skin.items["ref"][item[rows]]]
    found = []
    for number in np.unique(patch_of):
        patch, here = skin.patches[number], rows[patch_of == number]
        p, q = patch["degree"] + 1
        net = skin.ctrl[patch["ctrl"] : patch["ctrl"] + p * q].reshape(p, q, 4).astype(EXACT)
        true = true_distance(
            net, points[here].astype(EXACT), hit.seed[here, 1].astype(EXACT), hit.seed[here, 2].astype(EXACT)
        )
        found.append(np.abs(np.abs(hit.distance[here]) - true))
    return np.concatenate(found).astype(float)


def nacelle():
    path = SHARED / "nacelle.stp"
    if not path.exists():
        pytest.skip(f"needs {path}")
    return next(iter(read_step(path).values()))


PARTS = {
    "torus": lambda: part_of(shapes.as_nurbs(shapes.torus()), "torus"),
    "bumpy": lambda: part_of(shapes.bumpy_solid(rational=True), "bumpy"),
    "nacelle, 3 m long": nacelle,
}


@pytest.mark.parametrize("name", PARTS)
def test_searched_and_tracked_within_1e_12(name):
    part = PARTS[name]()
    surface, rng = part.surface(), np.random.default_rng(8)
    points = points_round(part, 3000, rng)
    hit = surface.project(points)
    cold = errors(surface, points, hit)
    assert len(cold) > 100
    assert cold.max() < 1e-12
    for size in (1e-3, 0.05, 0.05, 0.05):
        points = points + size * rng.uniform(-1.0, 1.0, points.shape)
        hit = surface.project(points, hit.seed)
        assert errors(surface, points, hit).max() < 1e-12
