"""OpenCASCADE begins to load before a file is read: for commands that know early what they will read.

Loading takes about a second in a process of its own (forks.py). A command that says at once which file it will read has
that second pass while it loads its own libraries. Nothing is started for a file whose reading is kept (read_cache.py),
and a process that gets no job ends with the one that started it.
"""

from pathlib import Path

from cadlink import child, read_cache

SEW = 1e-3  # mm
MARK, HEAD = b"ISO-10303-21", 4096  # stands among the first bytes of a STEP file


def expect_step(path, *, sew=SEW):
    """Say that `read_step` will be asked for a file; returns at once, whatever the file is.

    path, sew : as for read_step, which tells what is wrong with them
    """
    path = Path(path)
    try:
        with open(path, "rb") as stream:
            if MARK not in stream.read(HEAD):
                return
        if read_cache.holds(read_cache.key_of(path, sew)):
            return
    except OSError:  # read_step has the line for it
        return
    begin_to_load()


def begin_to_load():
    """Start the process that loads OpenCASCADE, where there is such a process and it does not run yet."""
    if child.FORKS:
        child.FORKED.begin()
