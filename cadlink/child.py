"""Work on CAD data in a process of its own: a crash or a hang of OpenCASCADE costs one line, not the session.

`in_child` starts `python -m MODULE ARGUMENTS OUT` and returns what it pickled; `serve` is what such a module runs.
"""

import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

from cadlink.errors import CadError


def run_module(module, arguments, timeout, doing):
    """What a module pickles to the file it is given last, or {"error": line} if it crashed or hung.

    arguments : list of str; timeout : s; doing : what it was doing, for the line
    """
    package = str(Path(__file__).resolve().parent.parent)
    environment = dict(os.environ)
    environment["PYTHONPATH"] = os.pathsep.join(p for p in (package, environment.get("PYTHONPATH", "")) if p)
    with tempfile.TemporaryDirectory(prefix="cadlink-") as folder:
        out = os.path.join(folder, "result.pickle")
        command = [sys.executable, "-m", module, *arguments, out]
        try:
            child = subprocess.run(
                command,
                env=environment,
                timeout=timeout,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return {"error": f"OpenCASCADE did not finish within {timeout:g} s"}
        if child.returncode != 0 or not os.path.exists(out):
            lines = child.stderr.decode("utf-8", "replace").strip().splitlines()
            why = f"signal {-child.returncode}" if child.returncode < 0 else (lines or ["no reason"])[-1]
            return {"error": f"OpenCASCADE crashed while {doing} ({why})"}
        with open(out, "rb") as stream:
            return pickle.load(stream)


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


def serve(work):
    """Runs work(job) on the pickled job in the file named first, pickles its result to the file named second."""
    with open(sys.argv[1], "rb") as stream:
        job = pickle.load(stream)
    try:
        result = work(job)
    except Exception as error:  # whatever went wrong must reach the parent as a line
        line = " ".join(str(error).split())
        result = {"error": line if isinstance(error, CadError) else f"{type(error).__name__}: {line}"}
    with open(sys.argv[2], "wb") as stream:
        pickle.dump(result, stream, protocol=5)
