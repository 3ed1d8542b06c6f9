"""HOW beads move: cells, pair forces, bonds, noise, integrators, run loop, checkpoints.

Knows NumPy and Numba only: no paper, no file format of the pipeline, no Snakemake.

Numba's disk cache does not notice that a called function changed in another file, so
the cache folder is named after the digest of the engine's sources. LLVM's higher levels of
optimisation make compilation a fifth longer and no kernel faster: loops vectorise at level 1.
Both have to be set before Numba is imported, which is why they stand here.
"""

import os

from dpd.digest import cache_folder, stage_digest

os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder(stage_digest("engine"))))
os.environ["NUMBA_OPT"] = "1"  # not a default: it decides the last bits of results
