"""HOW beads move: cells, pair forces, bonds, noise, integrators, run loop, checkpoints.

Knows NumPy and Numba only: no paper, no file format of the pipeline, no Snakemake.

Numba's disk cache does not notice that a called function changed in another file, so
the cache folder is named after the digest of the engine's sources. It has to be set
before Numba is imported, which is why it stands here.
"""

import os

from dpd.digest import cache_folder, stage_digest

os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder(stage_digest("engine"))))
