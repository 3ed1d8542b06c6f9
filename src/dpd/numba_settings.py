"""What Numba reads when it is imported; so this comes before it, with `dpd.jit`.

A program that has imported Numba before has it read them again.

Numba's disk cache does not notice that a called function changed in another file, so its folder is
named after the digest of the kernels' sources. LLVM's higher levels of optimisation make
compilation a fifth longer and no kernel faster: loops vectorise at level 1.
"""

import os
import sys

from dpd.digest import cache_folder
from dpd.sources import kernel_digest

os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder(kernel_digest())))
os.environ["NUMBA_OPT"] = "1"  # not a default: it decides the last bits of results
if "numba" in sys.modules:
    sys.modules["numba"].core.config.reload_config()
