"""Work on CAD data in a process of its own: a crash or a hang of OpenCASCADE costs one line, not the session.

`in_child` runs main(JOB, OUT) of a module in a child and returns what it pickled; `serve` is what such a main does.
The first job of a session starts a process that loads OpenCASCADE (forks.py); it forks the children. Who knows that a
job will come starts it beforehand (ahead.py). Where a process cannot be forked safely, each job starts a Python of its
own.
"""

import atexit
import json
import os
import pickle
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from cadlink.errors import CadError

FORKS = sys.platform.startswith("linux")
FORKER = "cadlink.forks"


def run_module(module, arguments, timeout, doing, keep=None):
    """What main(*arguments, out) of a module pickles to out, or {"error": line} if it crashed or hung.

    arguments : list of str; timeout : s; doing : what it was doing, for the line
    keep : called with the pickle of a result without error, which so need not be made again
    """
    with tempfile.TemporaryDirectory(prefix="cadlink-") as folder:
        out, errors = os.path.join(folder, "result.pickle"), os.path.join(folder, "errors")
        work = FORKED.run if FORKS else run_alone
        code = work(module, [*arguments, out], errors, timeout)
        if code is None:
            return {"error": f"OpenCASCADE did not finish within {timeout:g} s"}
        if code != 0 or not os.path.exists(out):
            lines = Path(errors).read_text("utf-8", "replace").strip().splitlines() if os.path.exists(errors) else []
            why = f"signal {-code}" if code < 0 else (lines or ["no reason"])[-1]
            return {"error": f"OpenCASCADE crashed while {doing} ({why})"}
        data = Path(out).read_bytes()
        result = pickle.loads(data)
        if keep is not None and "error" not in result:
            keep(data)
        return result


def command_and_environment(module):
    """How a module of this package is started, with one thread: a process with idle threads is not forked."""
    package = str(Path(__file__).resolve().parent.parent)
    environment = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")
    environment["PYTHONPATH"] = os.pathsep.join(p for p in (package, environment.get("PYTHONPATH", "")) if p)
    return [sys.executable, "-m", module], environment


def run_alone(module, arguments, errors, timeout):
    """Exit code of a Python of its own that runs a module, None where it took longer than the timeout [s]."""
    command, environment = command_and_environment(module)
    with open(errors, "wb") as log:
        try:
            child = subprocess.run(
                command + arguments, env=environment, timeout=timeout, check=False,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return None
    return child.returncode


class Forked:
    """The forking process of this session: started by the first job or before it, and anew after a job that hung.

    loading : whether it has not said yet that OpenCASCADE is loaded; log : what it says on standard error
    """

    def __init__(self):
        self.process, self.owner, self.lock = None, None, threading.Lock()
        self.loading, self.log = False, None

    def begin(self):
        """Have it started, and return at once: OpenCASCADE loads while this process does something else."""
        with self.lock:
            if not self.runs():
                self.start()

    def run(self, module, arguments, errors, timeout):
        """The same as run_alone; a job at a time."""
        end = time.monotonic() + timeout
        request = json.dumps([module, arguments, errors]).encode() + b"\n"
        with self.lock:
            try:
                if not self.runs():
                    self.start()
                reply = self.reply(end) if self.loading else "ready"
                if reply == "ready":
                    self.loading = False
                    self.process.stdin.write(request)
                    reply = self.reply(end)
                if reply:
                    return int(reply)
                # It has ended, or must be.
                code = None if reply is None else self.process.wait() or 1
                if self.loading and code:
                    self.log.seek(0)
                    Path(errors).write_bytes(self.log.read())
                self.stop()
                return code
            except BaseException:
                self.stop()
                raise

    def runs(self):
        """Whether it runs; one that idled too long has ended."""
        return self.process is not None and self.owner == os.getpid() and self.process.poll() is None

    def start(self):
        self.stop()
        command, environment = command_and_environment(FORKER)
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log,
            bufsize=0, start_new_session=True,
        )  # fmt: skip
        self.owner, self.loading = os.getpid(), True

    def reply(self, end):
        """Its next line, "" where it has ended, None where that takes too long."""
        left = max(0.0, end - time.monotonic())
        if not select.select([self.process.stdout], [], [], left)[0]:
            return None
        return self.process.stdout.readline().decode().strip()

    def stop(self):
        """End it, with a job that it may have; the next job starts another."""
        process, self.process = self.process, None
        if process is None:
            return
        for stream in (process.stdin, process.stdout, self.log):
            stream.close()
        if self.owner == os.getpid():
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


FORKED = Forked()
atexit.register(FORKED.stop)


def in_child(module, job, timeout, doing, about):
    """The result of module.work(job), run in a child.

    job : anything that can be pickled; doing, about : for the line of an error
    raises : CadError, one line
    """
    with tempfile.TemporaryDirectory(prefix="cadlink-") as folder:
        path = os.path.join(folder, "job.pickle")
        with open(path, "wb") as stream:
            pickle.dump(job, stream, protocol=5)
        result = run_module(module, [path], timeout, doing)
    if "error" in result:
        raise CadError(f"{about}: {result['error']}")
    return result


def serve(work, path, out):
    """Runs work(job) on the pickled job in a file, pickles its result, or the line of its error, to out."""
    try:
        with open(path, "rb") as stream:
            result = work(pickle.load(stream))
    except Exception as error:  # whatever went wrong must reach the parent as a line
        line = " ".join(str(error).split())
        result = {"error": line if isinstance(error, CadError) else f"{type(error).__name__}: {line}"}
    with open(out, "wb") as stream:
        pickle.dump(result, stream, protocol=5)
