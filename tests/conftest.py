"""Set before numba is imported: a kernel cache per state of the sources, inside the checkout."""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from plugins.kernel_cache import choose_kernel_cache  # noqa: E402

os.environ.pop("NUMBA_CACHE_DIR", None)
choose_kernel_cache(ROOT / ".numba_cache")
