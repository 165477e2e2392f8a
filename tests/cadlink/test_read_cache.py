"""A STEP file is read once; an edit of the file, or a broken entry, has it read again."""

import numpy as np
import pytest

from cadlink import CadError, read_cache, read_step, step

CUP = "examples/square_cup/square_cup.step"


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the example, with a cache of its own and a count of readings."""
    monkeypatch.setenv("CADLINK_READ_CACHE", str(tmp_path / "cache"))
    path = tmp_path / "cup.step"
    with open(CUP, "rb") as source:
        path.write_bytes(source.read())
    readings = []
    real = step.read_in_child
    monkeypatch.setattr(step, "read_in_child", lambda *a: readings.append(a) or real(*a))
    return path, readings


def test_second_reading_comes_from_the_cache(copy):
    path, readings = copy
    first, second = read_step(path), read_step(path)
    assert len(readings) == 1
    assert list(first) == list(second)
    points = np.random.default_rng(0).normal(size=(50, 3)) * 50.0
    a, b = (assembly["DIE"].surface().project(points) for assembly in (first, second))
    assert (a.distance == b.distance).all()


def test_edited_file_and_broken_entry_are_read(copy, tmp_path):
    path, readings = copy
    read_step(path)
    path.write_bytes(path.read_bytes() + b"\n")
    read_step(path)
    assert len(readings) == 2
    for entry in (tmp_path / "cache").glob("*.pickle"):
        entry.write_bytes(entry.read_bytes()[:100])
    read_step(path)
    assert len(readings) == 3


def test_failure_is_not_kept(copy, monkeypatch):
    path, _ = copy
    monkeypatch.setattr(step, "read_in_child", lambda *a: {"error": "OpenCASCADE crashed"})
    for _ in range(2):
        with pytest.raises(CadError, match="crashed"):
            read_step(path)
    assert not read_cache.folder().exists()
