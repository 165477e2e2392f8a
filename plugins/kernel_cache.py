"""Where numba keeps compiled kernels: a folder per state of the sources.

Numba's own disk cache notices an edit in the file of a kernel, but not in the files of the functions inlined
into it: an old kernel would go on computing in silence. Choose the folder before numba is imported.
"""

import hashlib
import os
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = 8  # folders left from earlier states of the sources


def hash_of_sources():
    """Twelve hex digits that change with any kernel source."""
    digest = hashlib.sha256()
    for package in ("cadlink", "solver"):
        for source in sorted((ROOT / package).rglob("*.py")):
            digest.update(source.relative_to(ROOT).as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:12]


def user_cache():
    """The user's cache folder of this program."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "cadlink" / "kernels"


def choose_kernel_cache(folders=None):
    """Point numba to the folder of this state of the sources, unless NUMBA_CACHE_DIR is set.

    folders : where the folders live, the user's cache by default. The oldest others are removed. Where nothing can
    be written numba keeps its own way.
    """
    if os.environ.get("NUMBA_CACHE_DIR"):
        return
    folders = folders or user_cache()
    chosen = folders / hash_of_sources()
    try:
        chosen.mkdir(parents=True, exist_ok=True)
        os.utime(chosen)
        others = sorted((f for f in folders.iterdir() if f != chosen), key=lambda f: f.stat().st_mtime)
    except OSError:
        return
    for old in others[:-KEPT]:
        shutil.rmtree(old, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(chosen)
