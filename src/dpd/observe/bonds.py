from typing import Any, ClassVar

from dpd.observe.common.bins import Binned
from dpd.page import Change, setting


class BondLengths(Binned, key="bonds"):
    """Mean, mean square and longest bond length in blocks, and their distribution."""

    stands = frozenset(Change)
    needs_bonds, whole = True, round
    range: ClassVar[float] = 5.0  # r_c; the mean takes every bond
    gives = {
        "bond_mean": (("block",), "r_c", "mean bond length"),
        "bond_mean_square": (("block",), "r_c^2", "mean square bond length"),
        "bond_longest": (("largest",), "r_c", "longest bond met in each block"),
        "bond_density": (("block", "bond_length"), "1 / r_c", "density of lengths"),
    }

    bin: float = setting("Bin width.", 0.01, unit="r_c", ge=0.0001, le=1)

    def axes(self, scene: Any) -> Any:
        return {"bond_length": (self.middles(), "r_c", "bond length")}

    def measure(self, now: Any) -> Any:
        length = now.bond_lengths
        means = {"bond_mean": length.mean(), "bond_mean_square": (length**2).mean()}
        return means | {"bond_longest": length.max(), "bond_density": self.density(length)}
