"""A shallow roof under a dead load beyond its limit point: dynamic increments carry it to the far side."""

from dataclasses import replace

import numpy as np
import pytest

from plugins.bench_shell import build
from plugins.shell_problems import PROBLEMS
from solver import Implicit, form

ROOF = PROBLEMS["hinged roof"]
FULL = 750.0  # N on the quarter at load share 1


def pushed(**loads):
    return form(roof(**loads), Implicit(), frames=10)


def roof(**loads):
    return build(replace(ROOF, loads=loads), "lattice", 0)


def test_a_roof_snaps_through_and_settles_in_equilibrium():
    share, fallen = np.array(ROOF.curve).T
    limit = share[fallen < 15.0].max()
    load = 1.2 * limit
    snapped = pushed(forces={"A": (0.0, 0.0, -FULL * load)})
    frames = snapped.frames
    tip = int(np.argmin(frames[-1].points[:, 2] - frames[0].points[:, 2]))
    fall = frames[0].points[tip, 2] - frames[-1].points[tip, 2]
    # The published curve has this load on its last, rising branch; the mesh is the coarsest of the benchmark.
    far = fallen > 20.0
    assert fall == pytest.approx(np.interp(load, share[far], fallen[far]), rel=0.05)
    # The same place reached by pushing the node there holds the same force: it has come to rest.
    held = pushed(moved={"A": (None, None, -fall)})
    assert -held.history["reaction_A_z"][-1] == pytest.approx(FULL * load, rel=1e-3)
    # What the snap sets free is dissipated, and counted.
    assert any(snapped.history["dynamic"]) and not any(held.history["dynamic"])
    energy = snapped.energy
    assert 0.0 < energy["damping"] < energy["external"]
    assert abs(energy["imbalance"]) < 0.05 * energy["external"]
    assert any("snaps" in remark for remark in snapped.remarks())
    assert held.remarks() == []


def test_a_run_stopped_while_it_snaps_goes_on_from_there(tmp_path):
    share, fallen = np.array(ROOF.curve).T
    scene = roof(forces={"A": (0.0, 0.0, -1.2 * FULL * share[fallen < 15.0].max())})
    whole = form(scene, frames=10)
    moving = np.flatnonzero(whole.history["dynamic"])

    def stop(progress):
        if progress.increment == moving[-1] + 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        form(scene, save=tmp_path / "roof.pvd", frames=10, watch=stop)
    rest = form(scene, save=tmp_path / "roof.pvd", frames=10, resume=True)
    assert rest.finished and not rest.history["dynamic"][-1]
    assert rest.frames[-1].points == pytest.approx(whole.frames[-1].points, abs=1e-3 * fallen.max())
