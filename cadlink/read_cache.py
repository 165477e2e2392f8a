"""What reading a STEP file gave last time, kept in the user's cache folder.

Reading starts a process that loads OpenCASCADE (1 to 2 s); a scene is run many times between two changes
of its file. A file is known by the hash of its bytes, of the reading code and of the OpenCASCADE binding,
so an edit of any of them reads anew. Files that refer to other files are always read. Set
CADLINK_READ_CACHE to another folder, or to "off".
"""

import hashlib
import os
import pickle
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

KEPT = 64  # files, the oldest are dropped
LARGEST = 64 << 20  # bytes of one entry


def folder():
    """Where results are kept; None where that is switched off."""
    chosen = os.environ.get("CADLINK_READ_CACHE")
    if chosen:
        return None if chosen.lower() == "off" else Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "cadlink" / "parts"


def key_of(path, sew):
    """Name of a file's entry, read with a sewing tolerance [mm], or None for one that must be read."""
    content = path.read_bytes()
    if b"DOCUMENT_FILE" in content or b"EXTERNAL_SOURCE" in content:
        return None
    digest = hashlib.sha256(content)
    digest.update(repr(float(sew)).encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    try:
        digest.update(version("cadquery-ocp").encode())
    except PackageNotFoundError:
        return None
    return digest.hexdigest()


def holds(key):
    """Whether something is kept under a key."""
    home = folder()
    return home is not None and key is not None and (home / f"{key}.pickle").is_file()


def recall(key):
    """The result kept under a key, or None."""
    home = folder()
    if home is None or key is None:
        return None
    entry = home / f"{key}.pickle"
    try:
        with open(entry, "rb") as stream:
            result = pickle.load(stream)
        os.utime(entry)
        return result
    except Exception:  # missing, cut short, from another release: read the file
        return None


def keep(key, data):
    """Keep the pickle of a result; where nothing can be written, do without."""
    home = folder()
    if home is None or key is None or len(data) > LARGEST:
        return
    try:
        home.mkdir(parents=True, exist_ok=True, mode=0o700)
        part = home / f"{key}.{os.getpid()}.part"
        part.write_bytes(data)
        part.replace(home / f"{key}.pickle")
        entries = sorted(home.glob("*.pickle"), key=lambda entry: entry.stat().st_mtime)
        for old in entries[:-KEPT]:
            old.unlink(missing_ok=True)
    except OSError:
        return
