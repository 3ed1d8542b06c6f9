from typing import Any

import numpy as np

from dpd.observe.common.bins import Binned, species_pairs
from dpd.page import Change, once, setting


class PairBondLengths(Binned, key="bond_lengths"):
    """Distribution and mean of bond lengths, for each pair of species that is bonded.

    The integral of a distribution over the length is 1, less the share beyond the range. The mean
    takes every bond.
    """

    stands = frozenset(Change)
    needs_bonds = True
    gives = {
        "pair_bond_density": (
            ("block", "bond_pair", "pair_bond_length"), "1 / r_c", "density of bond lengths",
        ),
        "pair_bond_mean": (("block", "bond_pair"), "r_c", "mean bond length"),
    }  # fmt: skip

    range: float = setting("End of the distribution.", 5.0, unit="r_c", gt=0, le=1000)
    bin: float = setting("Largest width of a bin.", 0.02, unit="r_c", ge=0.0001, le=1)

    @once
    def pairs(self, scene: Any) -> tuple[np.ndarray, np.ndarray]:
        """(pairs, 2) array of numbers of species, and (bonds,) array: the pair of each bond."""
        ends = np.sort(scene.kinds[scene.bonded].astype(np.int64), axis=1)
        pairs, pair = np.unique(ends, axis=0, return_inverse=True)
        return pairs, pair.ravel()

    def axes(self, scene: Any) -> Any:
        return {
            "bond_pair": species_pairs(scene, self.pairs(scene)[0], "species at the ends"),
            "pair_bond_length": (self.middles(), "r_c", "bond length"),
        }

    def measure(self, now: Any) -> Any:
        pairs, pair = self.pairs(now.scene)
        lengths = [now.bond_lengths[pair == number] for number in range(len(pairs))]
        return {
            "pair_bond_density": [self.density(each) for each in lengths],
            "pair_bond_mean": [each.mean() for each in lengths],
        }
