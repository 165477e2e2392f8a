"""Edges of STEP parts as polylines."""

import numpy as np
import pytest

from cadlink import CadError, read_step

CUP = "examples/square_cup/square_cup.step"


@pytest.fixture(scope="module")
def die():
    return read_step(CUP)["DIE"]


def test_an_edge_is_found_by_a_point_near_it_and_followed_within_the_chord(die):
    lines = [die.edge([number], chord=0.01) for number in range(len(die.record["skin"]["edges"]))]
    straight = [line for line in lines if len(line) == 2]
    bent = [line for line in lines if len(line) > 4]
    assert straight and bent
    for line in (straight[0], bent[0]):
        middle = 0.5 * (line[0] + line[1])
        assert die.edge(through=[middle], chord=0.01) == pytest.approx(line)
    # Corners of a polyline lie on the skin of the part.
    hit = die.surface().project(np.concatenate(lines))
    assert np.abs(hit.distance).max() < 1e-6


def test_a_finer_chord_comes_closer_to_a_circle_s_length(die):
    number = max(range(len(die.record["skin"]["edges"])), key=lambda k: len(die.edge([k], chord=0.01)))
    lengths = [np.linalg.norm(np.diff(die.edge([number], chord=c), axis=0), axis=1).sum() for c in (0.1, 1e-3, 1e-5)]
    assert lengths[0] <= lengths[1] <= lengths[2]
    assert lengths[1] == pytest.approx(lengths[2], rel=1e-3)


def test_edges_that_meet_form_a_chain_whichever_way_they_run(die):
    edges = [die.edge([k], chord=0.01) for k in range(len(die.record["skin"]["edges"]))]
    ends = {k: (line[0], line[-1]) for k, line in enumerate(edges)}

    def meet(a, b):
        return min(np.linalg.norm(p - q) for p in ends[a] for q in ends[b]) < 1e-9

    pairs = [(a, b) for a in ends for b in ends if a < b and meet(a, b) and not np.allclose(*ends[a])]
    a, b = next(p for p in pairs if not np.allclose(*ends[p[1]]))
    length = sum(np.linalg.norm(np.diff(edges[k], axis=0), axis=1).sum() for k in (a, b))
    for chain in ([a, b], [b, a]):
        found = die.edge(chain, chord=0.01)
        assert np.linalg.norm(np.diff(found, axis=0), axis=1).sum() == pytest.approx(length)
    apart = next(k for k in ends if k not in (a, b) and not meet(a, k))
    with pytest.raises(CadError, match="edges of a chain are .* mm apart, expected ones that meet"):
        die.edge([a, apart])


@pytest.mark.parametrize(
    "picks, message",
    [
        ({"numbers": [9999]}, "has edges 0 to .*, found 9999"),
        ({"numbers": []}, "an empty list of edges, expected numbers or points"),
        ({"through": [(0.0, 1.0)]}, "expected a point, 3 numbers in mm"),
        ({"numbers": [0], "chord": 0.0}, "chord 0.0, expected a length in mm above 0"),
    ],
)
def test_a_wrong_pick_is_one_line(die, picks, message):
    with pytest.raises(CadError, match=message) as caught:
        die.edge(**picks)
    assert "\n" not in str(caught.value)


def test_faces_are_picked_as_a_projection_tells_them(die):
    assert np.array_equal(die.pick([3, 1]), [1, 3])
