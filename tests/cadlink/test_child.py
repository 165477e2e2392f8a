"""Jobs in a process of their own: crashes, hangs and ends of that process each give a line, and the next job runs."""

import os
import pickle
import signal
import time

import pytest

import cadlink.child as child
from cadlink.child import FORKED, FORKS, run_module

JOBS = """
import os, pickle, signal, sys, time

def main(what, out):
    if what == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if what == "hang":
        time.sleep(60.0)
    if what == "fail":
        raise ValueError("no such luck")
    print("lines of a job are no replies")
    result = {"error": "no part"} if what == "error" else {"said": what, "parent": os.getppid()}
    with open(out, "wb") as stream:
        pickle.dump(result, stream)

if __name__ == "__main__":
    main(*sys.argv[1:])
"""


def group_exists(number):
    try:
        os.killpg(number, 0)
    except ProcessLookupError:
        return False
    return True


def wait_for(claim, limit=30.0):
    """Whether a claim comes true within the limit [s]."""
    end = time.monotonic() + limit
    while not claim() and time.monotonic() < end:
        time.sleep(0.01)
    return claim()


@pytest.fixture
def jobs(tmp_path, monkeypatch):
    """The name of a module of jobs that a child finds."""
    (tmp_path / "some_jobs.py").write_text(JOBS)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    FORKED.stop()  # one that was started before knows nothing of it
    yield "some_jobs"
    FORKED.stop()


@pytest.fixture(params=["forked", "alone"])
def way(request, monkeypatch):
    if request.param == "forked" and not FORKS:
        pytest.skip("no safe fork on this platform")
    monkeypatch.setattr(child, "FORKS", request.param == "forked")


def test_a_job_answers(jobs, way):
    assert run_module(jobs, ["hello"], 60.0, "trying")["said"] == "hello"


def test_only_a_result_without_error_is_kept(jobs, way):
    kept = []
    for what in ("error", "crash", "hello"):
        run_module(jobs, [what], 60.0, "trying", kept.append)
    assert [pickle.loads(data)["said"] for data in kept] == ["hello"]


@pytest.mark.parametrize(("what", "why"), [("crash", f"signal {int(signal.SIGSEGV)}"), ("fail", "no such luck")])
def test_a_crash_is_a_line_and_the_next_job_runs(jobs, way, what, why):
    error = run_module(jobs, [what], 60.0, "trying")["error"]
    assert error.startswith("OpenCASCADE crashed while trying (") and why in error and "\n" not in error
    assert run_module(jobs, ["hello"], 60.0, "trying")["said"] == "hello"


def test_a_hang_is_a_line_and_leaves_no_process(jobs, way):
    run_module(jobs, ["hello"], 60.0, "trying")
    before = FORKED.process
    start = time.monotonic()
    assert run_module(jobs, ["hang"], 0.5, "trying") == {"error": "OpenCASCADE did not finish within 0.5 s"}
    assert time.monotonic() - start < 30.0
    if child.FORKS:
        assert before.poll() == -signal.SIGKILL
        assert wait_for(lambda: not group_exists(before.pid))
    assert run_module(jobs, ["hello"], 60.0, "trying")["said"] == "hello"


@pytest.mark.skipif(not FORKS, reason="no safe fork on this platform")
def test_one_process_forks_all_jobs_and_is_replaced_when_it_dies(jobs):
    first, second = (run_module(jobs, [word], 60.0, "trying")["parent"] for word in ("one", "two"))
    assert first == second == FORKED.process.pid
    os.kill(first, signal.SIGKILL)
    FORKED.process.wait()
    assert run_module(jobs, ["three"], 60.0, "trying")["parent"] == FORKED.process.pid != first


def test_the_line_of_a_kernel_that_cannot_be_loaded(jobs, monkeypatch):
    if not FORKS:
        pytest.skip("no safe fork on this platform")
    monkeypatch.setattr(child, "FORKER", "no_such_module")
    assert "no_such_module" in run_module(jobs, ["hello"], 60.0, "trying")["error"]
