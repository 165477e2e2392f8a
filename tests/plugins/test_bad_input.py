"""Wrong input through the whole line: one clear line on standard error, exit status 2, nothing written."""

from pathlib import Path

import pytest

from plugins.command_line import main

CUP = Path(__file__).parents[2] / "examples" / "square_cup"
EMPTY_STEP = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));
ENDSEC;
DATA;
ENDSEC;
END-ISO-10303-21;
"""


def one_line(arguments, capsys):
    """What the command says about wrong input."""
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("cadlink: ") and err.count("\n") == 1, err
    return err.strip()


@pytest.fixture
def scene(tmp_path):
    """Writes the aluminium cup's scene with some text replaced, in a folder of its own; returns its path."""

    def write(*changes):
        text = (CUP / "aluminium.toml").read_text().replace('"square_cup.step"', f'"{CUP}/square_cup.step"')
        text = text.replace("size = 2.5", "size = 15")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "cup.toml"
        path.write_text(text)
        return str(path)

    return write


def test_a_missing_step_file(capsys, scene, tmp_path):
    said = one_line(["inspect", str(tmp_path / "none.step")], capsys)
    assert "none.step: no such file, expected a STEP file" in said
    path = scene((f"{CUP}/square_cup.step", "none.step"))
    said = one_line(["run", path, "-o", str(tmp_path / "out")], capsys)
    assert said == f"cadlink: {path}: cad: {tmp_path / 'none.step'}: no such file, expected a STEP file"
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_not_step(capsys, scene, tmp_path):
    (tmp_path / "notes.step").write_text("solid cup\nendsolid cup\n")
    said = one_line(["inspect", str(tmp_path / "notes.step")], capsys)
    assert "notes.step: not a STEP file" in said and "expected" in said


def test_a_step_file_without_faces(capsys, tmp_path):
    (tmp_path / "empty.step").write_text(EMPTY_STEP)
    said = one_line(["inspect", str(tmp_path / "empty.step")], capsys)
    assert "empty.step: " in said and "expected solids, shells or faces" in said


def test_a_part_that_does_not_exist(capsys, scene):
    path = scene(("[tools.PUNCH]", "[tools.STAMP]"))
    said = one_line(["check", path], capsys)
    assert said.startswith(f"cadlink: {path}: tools.STAMP: ")
    assert "no part 'STAMP', expected one of: PUNCH, DIE, BLANK_HOLDER, BLANK" in said


def test_a_negative_thickness(capsys, scene):
    path = scene(("size = 15", "size = 15\nthickness = -0.81"))
    said = one_line(["check", path], capsys)
    assert said.startswith(f"cadlink: {path}: blank.thickness: found -0.81, expected a length above 0 in mm")


def test_a_misspelt_key(capsys, scene):
    path = scene(("travel = -40", "travle = -40"))
    said = one_line(["check", path], capsys)
    assert said == f"cadlink: {path}: tools.PUNCH.travle: unknown key; did you mean 'travel'?"


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_blank_that_misses_the_die(command, capsys, scene, tmp_path):
    outline = "outline = {rectangle = [60, 60], z = 0.405}\nthickness = 0.81"
    path = scene(('part = "BLANK"', outline))
    out = ["-o", str(tmp_path / "out")] if command == "run" else []
    said = one_line([command, path, *out], capsys)
    assert said.startswith(f"cadlink: {path}: stage 'draw', tool '")
    assert "never meets" in said or "misses" in said
    assert not (tmp_path / "out").exists()
