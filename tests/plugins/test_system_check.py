"""The one line that names missing system packages."""

import subprocess
import sys
from pathlib import Path

from plugins import system_check

SCRIPT = Path(system_check.__file__)


def loader_without(*absent):
    """A stand-in for ctypes.CDLL on a machine that lacks some libraries."""

    def load(library):
        if library in absent:
            raise OSError(f"{library}: cannot open shared object file")

    return load


def test_only_the_missing_packages_are_named():
    load = loader_without("libGLU.so.1", "libgomp.so.1")
    assert system_check.missing_packages(load) == ["libglu1-mesa", "libgomp1"]


def test_nothing_missing():
    assert system_check.missing_packages(loader_without()) == []


def test_python_without_ensurepip_names_the_venv_package():
    def find(module):
        return None if module == "ensurepip" else True

    major, minor = sys.version_info[:2]
    assert system_check.missing_packages(loader_without(), find) == [f"python{major}.{minor}-venv"]


def test_one_line_and_status_1(capsys, monkeypatch):
    monkeypatch.setattr(system_check, "missing_packages", lambda: ["libegl1", "libxft2"])
    assert system_check.main([]) == 1
    line = capsys.readouterr().err
    assert line == "cadlink needs system packages: apt-get install --no-install-recommends libegl1 libxft2\n"
    assert system_check.main(["--packages"]) == 1
    assert capsys.readouterr().out == "libegl1 libxft2\n"


def test_script_runs_on_a_bare_interpreter():
    done = subprocess.run([sys.executable, "-I", SCRIPT], capture_output=True, text=True)
    assert done.returncode in (0, 1) and done.stderr.count("\n") == done.returncode
