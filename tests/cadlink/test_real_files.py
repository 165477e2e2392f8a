"""CAD files from elsewhere against OpenCASCADE: distance, side, warm start, and derivatives."""

from pathlib import Path

import numpy as np
import pytest

from cadlink import read_step
from tests.cadlink.occ_truth import compare, points_around

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "step"
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NAMES = [
    "M6-1x12-countersunk-screw.step",
    "NIST_MBE_PMI_3.stp",
    "as1-oc-214.stp",
    "cube-in.step",
    "cube-m.step",
    "cube-mm.step",
    "frame.step",
    "linkrods.step",
    "nacelle.stp",
    "nist_ctc_01_asme1_ap242-e1.stp",
    "part.step",
]
OWN = sorted(p.relative_to(EXAMPLES).as_posix() for p in EXAMPLES.glob("*/*.st*p"))


@pytest.fixture(scope="module")
def assemblies():
    """Assemblies by file name, each read once."""

    class Read(dict):
        def __missing__(self, name):
            path = EXAMPLES / name if "/" in name else SHARED / name
            if not path.exists():
                pytest.skip(f"needs {path}")
            self[name] = read_step(path)
            return self[name]

    return Read()


def check(part, n):
    found = compare(part, n)
    gaps = part.gap_report()
    print(
        f"{part.path.name} {part.name}: {n} points, |d - occ| away from edges {found.away_error:.1e}, "
        f"near edges {found.near_error:.1e} (gap {max(gaps.edge, gaps.vertex):.1e}), "
        f"wrong side {len(found.wrong_side)}, unexplained {len(found.unexplained)}, "
        f"OpenCASCADE missed {found.occ_missed}, its classifier wrong {found.occ_wrong_side}"
    )
    assert not len(found.unexplained), found
    assert not len(found.wrong_side), found
    assert found.away_error <= 1e-9
    assert found.near_error <= 1e-9 + max(gaps.edge, gaps.vertex)


@pytest.mark.parametrize("name", NAMES + OWN)
def test_distance_and_side_agree_with_opencascade(assemblies, name):
    # Few points where OpenCASCADE takes 20 ms for one, or where the parts are many.
    n = 100 if name.startswith("M6") else 300
    parts = assemblies[name].values()
    for part in parts:
        check(part, n if len(parts) == 1 else 60)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES + OWN)
def test_ten_thousand_points_agree_with_opencascade(assemblies, name):
    for part in assemblies[name].values():
        check(part, 10_000)


@pytest.mark.parametrize("name", NAMES)
def test_warm_equals_cold_and_normals_are_gradients(assemblies, name):
    part = list(assemblies[name].values())[-1]
    surface = part.surface()
    size = np.ptp(part.bounding_box, axis=0).max()
    points = points_around(surface, part.bounding_box, 2000, seed=3)
    hit = surface.project(points)
    rng = np.random.default_rng(8)
    moved = points + rng.normal(size=points.shape) * 1e-3 * size
    cold, warm = surface.project(moved), surface.project(moved, hit.seed)
    assert np.abs(cold.distance - warm.distance).max() < 2e-12 + 1e-15 * size
    # m = d n away from smooth edges, where the foot may lie beyond the trim by the gap.
    gaps = part.gap_report()
    off = points - hit.point - hit.distance[:, None] * hit.normal
    assert np.linalg.norm(off, axis=1).max() < 1e-9 * size + 10.0 * max(gaps.edge, gaps.vertex)
    assert np.linalg.norm(hit.normal, axis=1) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("name", ["nist_ctc_01_asme1_ap242-e1.stp", "linkrods.step", "frame.step"])
def test_building_is_quick(assemblies, name):
    """Well below a second for dies of tens to hundreds of faces."""
    import time

    part = list(assemblies[name].values())[0]
    part.surface()
    start = time.process_time()
    part.surface()
    assert time.process_time() - start < 1.0


def test_two_minima_in_one_patch(assemblies):
    """A degree 5 patch bends round this point between two feet: the nearer one is at 63.4659 mm."""
    surface = assemblies["nacelle.stp"]["Nacelle"].surface()
    hit = surface.project(np.array([[207.20972282, -184.24417734, 483.50542024]]))
    assert hit.distance == pytest.approx([-63.465863805], abs=1e-6)
