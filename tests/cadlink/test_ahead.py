"""OpenCASCADE loads ahead of a reading: only where a file will be read, and never beyond the process that asked."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cadlink import CadError, read_step
from cadlink.ahead import expect_step
from cadlink.child import FORKED, FORKS

CUP = Path("examples/square_cup/square_cup.step")
pytestmark = pytest.mark.skipif(not FORKS, reason="no safe fork on this platform")


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """Nothing kept, nothing loaded."""
    monkeypatch.setenv("CADLINK_READ_CACHE", str(tmp_path / "cache"))
    FORKED.stop()
    yield
    FORKED.stop()


def exists(pid):
    """Whether a process runs: one that has ended but was not waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_expected_file_is_read_by_the_process_started_for_it(fresh):
    expect_step(CUP)
    expect_step(CUP)
    started = FORKED.process.pid
    assert "DIE" in read_step(CUP) and FORKED.process.pid == started


def test_nothing_is_started_for_what_need_not_or_cannot_be_read(fresh, tmp_path):
    expect_step(tmp_path / "missing.step")
    expect_step(tmp_path)
    expect_step("README.md")
    assert FORKED.process is None
    read_step(CUP)
    FORKED.stop()
    expect_step(CUP)
    assert FORKED.process is None
    # Another tolerance is another reading.
    expect_step(CUP, sew=0.0)
    assert FORKED.process is not None


def test_one_that_dies_while_it_loads_is_replaced(fresh):
    expect_step(CUP)
    os.killpg(FORKED.process.pid, signal.SIGKILL)
    FORKED.process.wait()
    assert "DIE" in read_step(CUP)


def test_one_that_cannot_load_gives_a_line(fresh, monkeypatch):
    monkeypatch.setattr("cadlink.child.FORKER", "no_such_module")
    expect_step(CUP)
    with pytest.raises(CadError, match="no_such_module"):
        read_step(CUP)


@pytest.mark.parametrize("end", ["pass", "os._exit(0)", "os.kill(os.getpid(), signal.SIGKILL)"])
def test_it_ends_with_the_process_that_asked(fresh, end):
    """At a proper end at once; where the parent dies, when it finds nobody at the other end of its pipe."""
    ask = "import os, signal; from cadlink.ahead import expect_step; from cadlink.child import FORKED; "
    ask += f"expect_step({str(CUP)!r}); print(FORKED.process.pid, flush=True); {end}"
    done = subprocess.run([sys.executable, "-c", ask], stdout=subprocess.PIPE, text=True, timeout=60.0, check=False)
    pid, limit = int(done.stdout), time.monotonic() + 60.0
    while exists(pid) and time.monotonic() < limit:
        time.sleep(0.05)
    assert not exists(pid)


SAY = """
import sys
from plugins.command_line import main

main(sys.argv[1:])
child = sys.modules.get("cadlink.child")
print("started", child is not None and child.FORKED.process is not None)
"""


@pytest.mark.parametrize(
    "words", ["--help", "schema", "inspect missing.step", "inspect README.md", "run missing.toml -o x"]
)
def test_commands_that_read_nothing_start_nothing(fresh, words):
    command = [sys.executable, "-c", SAY, *words.split()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60.0, check=False)
    assert done.stdout.endswith("started False\n")
