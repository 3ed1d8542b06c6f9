"""Bond lengths."""

from typing import Any

import numpy as np

from dpd.observe.common.bins import density, middles
from dpd.page import Change, Observable, setting

LONGEST = 5.0  # end of the histogram in r_c; the mean takes every bond


class BondLengths(Observable, key="bonds"):
    """Mean, mean square and longest bond length in blocks, and their distribution."""

    stands = frozenset(Change)
    needs_bonds = True
    gives = {
        "bond_mean": (("block",), "r_c", "mean bond length"),
        "bond_mean_square": (("block",), "r_c^2", "mean square bond length"),
        "bond_longest": (("largest",), "r_c", "longest bond met in each block"),
        "bond_density": (("block", "bond_length"), "1 / r_c", "density of lengths"),
    }

    bin: float = setting("Bin width.", 0.01, unit="r_c", ge=0.0001, le=1)

    def bins(self) -> np.ndarray:
        return np.linspace(0.0, LONGEST, round(LONGEST / self.bin) + 1)

    def axes(self, scene: Any) -> Any:
        return {"bond_length": (middles(self.bins()), "r_c", "bond length")}

    def measure(self, now: Any) -> Any:
        length = now.bond_lengths
        return {
            "bond_mean": length.mean(),
            "bond_mean_square": (length**2).mean(),
            "bond_longest": length.max(),
            "bond_density": density(length, self.bins()),
        }
