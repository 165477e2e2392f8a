"""The last good state on disk, to go on from: one HDF5 file, replaced in one move.

It carries the state, where the march stands, the history and the energies; a file from another scene is refused.
"""

import hashlib
import json
import os

import h5py
import numpy as np

from .errors import SceneError
from .implicit.increments import March


def fingerprint(scene):
    """Text that differs between scenes a checkpoint must not be mixed between."""
    digest = hashlib.sha256()
    digest.update(np.ascontiguousarray(scene.blank.mesh.points, dtype=float).tobytes())
    digest.update(np.ascontiguousarray(scene.blank.mesh.cells, dtype=np.int64).tobytes())
    blank = scene.blank
    digest.update(repr((blank.thickness, blank.material, blank.element, tuple(blank.rolling), blank.clamped)).encode())
    for stage in scene.stages:
        duties = [(t.travel, t.to, t.force, t.gap, t.spring, t.stop, t.rides_on, t.tilts, t.at) for t in stage.tools]
        tools = [(t.name, t.friction, tuple(t.axis)) for t in stage.tools] + duties
        loads = (stage.pressure, dict(stage.forces), dict(stage.line_loads), dict(stage.moments))
        loads += (dict(stage.movements), stage.speed)
        beads = [
            (b.name, np.asarray(b.curve).tolist(), b.restraint, b.uplift, b.holder, b.axis) for b in stage.drawbeads
        ]
        loads += (None if stage.gravity is None else tuple(stage.gravity), beads)
        digest.update(repr((stage.name, loads, tools)).encode())
    return digest.hexdigest()


def save_checkpoint(path, scene, method, here, state, results, energy):
    """Write the state `here` = (stage index, March). Does nothing where path is None."""
    if path is None:
        return
    k, march = here
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    with h5py.File(partial, "w") as file:
        file.attrs["scene"] = fingerprint(scene)
        file.attrs["method"] = type(method).__name__
        file.attrs["march"] = json.dumps([k, march.fraction, march.width, march.rates, march.placed])
        file.attrs["history"] = json.dumps(results.history)
        file.attrs["energy"] = json.dumps(energy.sums)
        file.attrs["settles"] = march.settles
        if march.mass is not None and np.isfinite(march.mass):
            file.attrs["mass"] = march.mass
        file["rate"] = march.rate
        if march.relief is not None:
            file["relief"] = march.relief
        for key, value in (march.memory or {}).items():
            file[f"memory/{key}"] = value
        for name, group in state.groups().items():
            for key, value in group.arrays().items():
                file[f"{name}/{key}"] = value
    os.replace(partial, path)


def load_checkpoint(path, scene, method, state, results, energy):
    """Fill state, history and energies; returns (stage index, March).

    Raises SceneError for a missing or unreadable file and for one of another scene or method.
    """
    if path is None or not path.exists():
        raise SceneError(f"{path}: no checkpoint to resume from; run without resume first")
    try:
        with h5py.File(path, "r") as file:
            if file.attrs["scene"] != fingerprint(scene):
                raise SceneError(f"{path}: the checkpoint belongs to another scene; run without resume")
            if file.attrs["method"] != type(method).__name__:
                raise SceneError(f"{path}: found a checkpoint of {file.attrs['method']}(), expected the same method")
            for name, group in state.groups().items():
                for key, value in group.arrays().items():
                    value[...] = file[f"{name}/{key}"][()]
            k, fraction, width, rates, placed = json.loads(file.attrs["march"])
            results.history.update(json.loads(file.attrs["history"]))
            energy.sums.update(json.loads(file.attrs["energy"]))
            relief = file["relief"][()] if "relief" in file else None
            mass = float(file.attrs["mass"]) if "mass" in file.attrs else None
            settles = bool(file.attrs["settles"])
            memory = {key: value[()] for key, value in file["memory"].items()} if "memory" in file else None
            return k, March(fraction, width, file["rate"][()], rates, placed, relief, mass, settles, memory)
    except (OSError, KeyError) as error:
        raise SceneError(f"{path}: not a readable checkpoint ({error})") from None
