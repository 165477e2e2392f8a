"""The process that has OpenCASCADE loaded and forks a child for each job: loading takes a second, a fork milliseconds.

Without Python's garbage collector, which finds nothing among the classes of the binding, loading takes an eighth less.

Requests come one a line, [module, arguments, file for error messages]; the child runs main(*arguments) of the module
and may crash. The reply is its exit code, negative for a signal. The process ends with its parent, or when idle.
"""

import gc
import json
import os
import select
import sys
import traceback
from importlib import import_module

LOADED = ("cadlink.assembly_tree", "cadlink.tessellation", "cadlink.plane_cut")  # before the first fork
IDLE = 300.0  # s


def serve_jobs():
    # What a job prints must not look like a reply.
    replies = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    gc.disable()
    for module in LOADED:
        import_module(module)
    gc.freeze()
    gc.enable()
    os.write(replies, b"ready\n")
    while select.select([0], [], [], IDLE)[0]:
        line = sys.stdin.readline()
        if not line:
            return
        pid = os.fork()
        if pid == 0:
            os._exit(run(*json.loads(line)))
        _, status = os.waitpid(pid, 0)
        os.write(replies, b"%d\n" % os.waitstatus_to_exitcode(status))


def run(module, arguments, errors):
    """0, or 1 with the reason in the file of error messages."""
    os.dup2(os.open(errors, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600), 2)
    try:
        import_module(module).main(*arguments)
        return 0
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        return 1


if __name__ == "__main__":
    serve_jobs()
