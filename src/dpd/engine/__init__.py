"""HOW beads move: cells, pair forces, bonds, noise, integrators, run loop, checkpoints.

Knows NumPy and Numba only: no paper, no file format of the pipeline, no Snakemake.

Numba's disk cache does not notice that a called function changed in another file, so
the cache folder is named after the digest of the engine's sources. It has to be set
before Numba is imported, which is why it stands here.
"""

import os
from pathlib import Path

from dpd.digest import stage_digest


def cache_folder():
    """Folder of the compiled kernels that belong to these sources."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "dpd-papers" / stage_digest("engine")


os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))
