"""cadlink -> solver -> plugins: the linter refuses an import against the direction."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def lint(source, pretended_path):
    """ruff's verdict on `source` as if it stood at `pretended_path`."""
    command = [sys.executable, "-m", "ruff", "check", "--no-cache", "--stdin-filename", pretended_path, "-"]
    return subprocess.run(command, input=source, capture_output=True, text=True, cwd=ROOT)


@pytest.mark.parametrize(
    "path, module",
    [
        ("cadlink/surface.py", "solver.form"),
        ("cadlink/surface.py", "plugins"),
        ("cadlink/blank.py", "gmsh"),
        ("solver/form.py", "cadlink"),
        ("solver/form.py", "plugins.vtk_files"),
        ("solver/contact/friction.py", "OCP.gp"),
        ("solver/contact/friction.py", "cadquery"),
        ("solver/implicit/newton.py", "gmsh"),
        ("solver/results.py", "vtk"),
        ("solver/results.py", "vtkmodules.vtkIOXML"),
        ("solver/results.py", "pyvista"),
    ],
)
def test_import_against_the_direction_is_refused(path, module):
    for source in (
        f'"""A module."""\n\nimport {module}\n\nprint({module})\n',
        f'"""A module."""\n\nfrom {module} import thing\n\nprint(thing)\n',
        f'"""A module."""\n\n\ndef late():\n    import {module}\n\n    return {module}\n',
    ):
        verdict = lint(source, path)
        assert verdict.returncode == 1 and "TID251" in verdict.stdout, verdict.stdout + verdict.stderr


@pytest.mark.parametrize(
    "path, module",
    [
        ("cadlink/surface.py", "OCP.gp"),
        ("cadlink/blank_worker.py", "gmsh"),
        ("solver/form.py", "scipy.sparse"),
        ("plugins/command_line.py", "cadlink"),
        ("plugins/command_line.py", "solver"),
        ("plugins/command_line.py", "pyvista"),
        ("tests/cadlink/test_surface.py", "solver"),
    ],
)
def test_import_along_the_direction_passes(path, module):
    verdict = lint(f'"""A module."""\n\nimport {module}\n\nprint({module})\n', path)
    assert verdict.returncode == 0, verdict.stdout + verdict.stderr


def test_the_other_rules_still_hold_inside_the_packages():
    for package in ("cadlink", "solver"):
        verdict = lint('"""A module."""\n\nimport math\n', f"{package}/module.py")
        assert "F401" in verdict.stdout
