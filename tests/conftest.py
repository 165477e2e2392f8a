"""Set before numba is imported: kernels cached by the state of the sources in the checkout; no cache of files read."""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from plugins.kernel_cache import choose_kernel_cache  # noqa: E402

os.environ["CADLINK_READ_CACHE"] = "off"  # tests read their files
os.environ.pop("NUMBA_CACHE_DIR", None)
choose_kernel_cache(ROOT / ".numba_cache")
