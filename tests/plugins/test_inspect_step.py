"""cadlink inspect: every file of the reference folder, in words and as plain values."""

import json
from pathlib import Path

import pytest

from plugins.command_line import main

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "step"
FILES = sorted(path.name for path in SHARED.glob("*.st*p"))


@pytest.mark.skipif(not FILES, reason="no reference files")
@pytest.mark.parametrize("name", FILES)
def test_every_reference_file_passes(name, capsys):
    assert main(["inspect", str(SHARED / name), "--thickness", "1.0"]) == 0
    said = capsys.readouterr().out
    assert main(["inspect", str(SHARED / name), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["parts"] and found["unit"] in ("mm", "cm", "m", "inch", "ft")
    for part in found["parts"]:
        assert part["faces"] == sum(part["kinds"].values()) > 0
        assert all(length >= 0.0 for length in part["size"]) and max(part["size"]) > 0.1
        assert 0.0 <= part["edge_gap"] < 0.1
    assert found["parts"][0]["name"].split()[0] in said
