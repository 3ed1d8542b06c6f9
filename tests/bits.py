"""Whether runs keep their bits: a list of digests of all variables of all runs of a study.

    python tests/bits.py results/quick > before.txt
    ...                                              # rebuild, run again
    python tests/bits.py results/quick before.txt    # what differs; exit code 1 if anything does

The list `tests/bits_quick.txt` is that of three papers in the quick study. Another compiler (Numba,
LLVM) or another kind of processor may round differently; the same machine must not.
"""

import hashlib
import sys
from pathlib import Path

import netCDF4
import numpy as np


def digests(folder):
    """A line for each variable of each run: its digest, the run, its name."""
    for path in sorted(Path(folder).rglob("run.nc")):
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            for name in sorted(file.variables):
                values = np.asarray(file[name][...])
                if values.dtype == object:  # text
                    values = values.astype(str)
                digest = hashlib.sha256(values.tobytes()).hexdigest()[:12]
                yield f"{digest} {path.parent.relative_to(folder)} {name}"


def main(folder, before=None):
    found = list(digests(folder))
    if before is None:
        print("\n".join(found))
        return 0
    expected = Path(before).read_text().splitlines()
    differing = sorted(set(found) ^ set(expected), key=lambda line: line.split(" ", 1)[1])
    print("\n".join(differing) or f"the same {len(found)} variables")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
