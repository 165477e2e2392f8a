"""Set before numba is imported: a cache folder per state of the sources.

Numba's disk cache notices an edit in the file of a kernel, but not in the files of the functions
inlined into it.
"""

import hashlib
import os
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = 8  # cache folders left from earlier states of the sources


def hash_of_sources():
    """Twelve hex digits that change with any kernel source."""
    digest = hashlib.sha256()
    for package in ("cadlink", "solver"):
        for source in sorted((ROOT / package).rglob("*.py")):
            digest.update(source.relative_to(ROOT).as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:12]


def choose_numba_cache():
    """The cache folder of this state of the sources; the oldest others are removed."""
    folders = ROOT / ".numba_cache"
    chosen = folders / hash_of_sources()
    chosen.mkdir(parents=True, exist_ok=True)
    os.utime(chosen)
    others = sorted((f for f in folders.iterdir() if f != chosen), key=lambda f: f.stat().st_mtime)
    for old in others[:-KEPT]:
        shutil.rmtree(old, ignore_errors=True)
    return chosen


os.environ["NUMBA_CACHE_DIR"] = str(choose_numba_cache())
