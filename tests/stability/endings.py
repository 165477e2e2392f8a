"""How a run may end: in a converged result, or in one clear line with the last good state saved."""

import numpy as np
import pytest

from solver import StepFailed, form
from solver.implicit.method import Newton

MOST_INCREMENTS = 1500  # of one stage; more is a run that does not come on


def ends_well(scene, folder, method=None):
    """Results of a run that ended well, and the StepFailed it ended in or None. Anything else fails the test."""
    results, failure = run(scene, folder, method)
    check_numbers(results)
    if failure:
        check_line(str(failure))
        # The last good state is there, and leads no less far.
        again, _ = run(scene, folder, method, resume=True)
        assert again.history["stroke"][-1] >= results.history["stroke"][-1]
    else:
        assert results.finished
        still = results.in_equilibrium()
        assert np.array(results.history["residual"])[still].max() <= Newton().residual
        assert still[-1]
        check_forces(scene, results)
    return results, failure


def run(scene, folder, method=None, resume=False):
    """Results, and the StepFailed or None; too many increments fail the test."""

    def watch(progress):
        if progress.increment > MOST_INCREMENTS:
            pytest.fail(f"{progress.increment} increments, {100 * progress.fraction:.0f} % of the stroke done")

    try:
        return form(scene, method, save=folder / "cup.pvd", frames=2, watch=watch, resume=resume), None
    except StepFailed as failure:
        return failure.results, failure


def check_numbers(results):
    """Everything that is told is a number, and every thickness one of a sheet."""
    for name, column in results.history.items():
        if name != "stage":
            assert np.isfinite(column).all(), name
    for frame in results.frames:
        assert np.isfinite(frame.points).all()
        for name, field in {**frame.point_fields, **frame.cell_fields}.items():
            assert np.isfinite(field).all(), name
    assert min(results.history["thickness_min"], default=1.0) > 0.0
    assert all(np.isfinite(value) for value in results.energy.values())


def check_line(message):
    """One line that says where, why, and what to do."""
    assert "\n" not in message
    assert "stage 'draw' at" in message and "; " in message


def check_forces(scene, results):
    """The punch is pushed by no more than the sheet can carry round the die's opening: its plane-strain strength at a
    logarithmic strain of 1, which it never has at once in its full thickness."""
    material = scene.blank.material
    strongest = material.hardening(1.0) * (1.0 + 1.77) / np.sqrt(1.0 + 2.0 * 1.77)
    die = scene.tools["DIE"].surface
    limit = 2.0 * np.pi * (die.spine - die.radius) * scene.blank.thickness * strongest
    assert results.largest_forces()["max_force_PUNCH"] < limit
