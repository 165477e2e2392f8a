"""Runs that are stopped by their user and go on from their checkpoint."""

import pytest

from solver import form


class Stopped(Exception):
    """What a user's watch raises to stop a run."""


def interrupt(scene, method, save, frames, when):
    """Run a scene until when(Progress) says so, with checkpoints beside the path `save`."""

    def stop(progress):
        if when(progress):
            raise Stopped

    with pytest.raises(Stopped):
        form(scene, method, save=save, frames=frames, watch=stop)


def interrupted(scene, method, save, frames, when):
    """Results of a run that is stopped where when(Progress) says so, and resumed."""
    interrupt(scene, method, save, frames, when)
    return form(scene, method, save=save, frames=frames, resume=True)
