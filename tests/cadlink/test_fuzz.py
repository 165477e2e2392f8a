"""Damaged files: an answer or one clear line each, never a crash of this process, never a hang."""

import time
from pathlib import Path

import numpy as np
import pytest

from cadlink import CadError, read_step

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "step"
EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "square_cup" / "square_cup.step"
SMALL = ["cube-in.step", "cube-m.step", "cube-mm.step", "part.step"]  # for the tests of seconds
LIMIT = 60.0  # s for one file
COPIES = 300


def mutated(data, rng):
    """A copy with one kind of damage: bytes flipped, lines cut or swapped, a number changed, the end missing."""
    kind = rng.integers(6)
    data = bytearray(data)
    if kind == 0:
        for at in rng.integers(len(data), size=rng.integers(1, 20)):
            data[at] ^= 1 << rng.integers(8)
    elif kind == 1:
        return bytes(data[: rng.integers(len(data))])
    elif kind == 2:
        lines = bytes(data).split(b"\n")
        cut = set(rng.integers(len(lines), size=rng.integers(1, 6)).tolist())
        return b"\n".join(line for k, line in enumerate(lines) if k not in cut)
    elif kind == 3:
        lines = bytes(data).split(b"\n")
        a, b = rng.integers(len(lines), size=2)
        lines[a], lines[b] = lines[b], lines[a]
        return b"\n".join(lines)
    elif kind == 4:
        for at in rng.integers(len(data), size=rng.integers(1, 20)):
            data[at] = rng.integers(256)
    else:
        digits = [k for k, c in enumerate(data) if 48 <= c <= 57]
        for at in rng.choice(digits, size=rng.integers(1, 10)):
            data[at] = 48 + rng.integers(10)
    return bytes(data)


def check(path):
    """Read a damaged file and use what comes: seconds taken, and the line or None."""
    start, line = time.monotonic(), None
    try:
        assembly = read_step(path, timeout=LIMIT)
    except CadError as error:
        line = str(error)
        assert "\n" not in line and path.name in line and len(line) < 500, line
    else:
        assert len(assembly)
        for part in list(assembly.values())[:3]:
            points = part.bounding_box[0] + np.random.default_rng(0).random((20, 3)) * np.ptp(part.bounding_box, axis=0)
            hit = part.surface().project(points)
            assert np.isfinite(hit.distance).all() and np.isfinite(hit.normal).all()
            part.gap_report(1.0)
    return time.monotonic() - start, line


def sources(names=None):
    """Files to be damaged: all of the reference folder, or those named, and the example's."""
    shared = sorted(SHARED.glob("*.st*p")) if names is None else [SHARED / name for name in names]
    return [path for path in (*shared, EXAMPLE) if path.exists()]


@pytest.mark.parametrize("number", range(4))
def test_a_few_damaged_files(tmp_path, number):
    files = sources(SMALL)
    path = tmp_path / "damaged.step"
    path.write_bytes(mutated(files[number % len(files)].read_bytes(), np.random.default_rng(1000 + number)))
    seconds, _ = check(path)
    assert seconds < LIMIT


@pytest.mark.slow
def test_three_hundred_damaged_files(tmp_path):
    """Fixed seed; a failure names the copy, which `mutated` makes again."""
    files, rng = sources(), np.random.default_rng(20)
    answers, slowest = 0, (0.0, "")
    for number in range(COPIES):
        source, path = files[number % len(files)], tmp_path / f"damaged-{number}.step"
        path.write_bytes(mutated(source.read_bytes(), rng))
        seconds, line = check(path)
        answers, slowest = answers + (line is None), max(slowest, (seconds, source.name))
        assert seconds < LIMIT, (number, source.name, seconds)
        path.unlink()
    seconds, name = slowest
    print(
        f"{COPIES} damaged files: {answers} answers, {COPIES - answers} lines, slowest {seconds:.1f} s, made of {name}"
    )
