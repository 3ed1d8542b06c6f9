"""Bond lengths of each pair of species."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.scene import Scene


class PairBondLengths(Observable, key="bond_lengths"):
    """Distribution and mean of bond lengths, for each pair of species that is bonded.

    The integral of a distribution over the length is 1, less the share beyond the range. The mean
    takes every bond.
    """

    stands = frozenset(Change)
    needs_bonds, bins_of = True, "range"

    range: float = setting("End of the distribution.", 5.0, unit="r_c", gt=0, le=1000)
    bin: float = setting("Largest width of a bin.", 0.02, unit="r_c", ge=0.0001, le=1)

    def _start(self, scene: Scene, system: BondedSystem) -> None:
        self._system = system
        ends = np.sort(scene.kinds[system.members].astype(np.int64), axis=1)
        pairs, self._pair = np.unique(ends, axis=0, return_inverse=True)
        self._pair = self._pair.ravel()
        self._names = [f"{scene.species[i]} {scene.species[j]}" for i, j in pairs]
        self._edges = np.linspace(0.0, self.range, int(np.ceil(self.range / self.bin)) + 1)
        # The last place holds the mean.
        shape = (len(pairs), len(self._edges))
        self.averages = BlockSums(shape)
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.space import nearest

        members = self._system.members
        position = simulation.state.by_identity(simulation.state.position)
        apart = nearest(position[:, members[:, 0]] - position[:, members[:, 1]], simulation.box)
        length = np.sqrt((apart**2).sum(axis=0))
        found = np.empty(self.arrays["sums"].shape[1:])
        for pair, row in enumerate(found):
            mine = length[self._pair == pair]
            row[:-1] = np.histogram(mine, self._edges)[0] / (len(mine) * self._edges[1])
            row[-1] = mine.mean()
        self.averages.add(found)

    def variables(self) -> Variables:
        """Bond lengths in blocks for the file."""
        means = self.averages.means()
        middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        return {
            "bond_pair": (("bond_pair",), np.array(self._names), "1", "species at the ends"),
            "pair_bond_length": (("pair_bond_length",), middle, "r_c", "bond length"),
            "pair_bond_density": (
                ("block", "bond_pair", "pair_bond_length"), means[..., :-1], "1 / r_c",
                "density of bond lengths of each pair of species",
            ),
            "pair_bond_mean": (
                ("block", "bond_pair"), means[..., -1], "r_c",
                "mean bond length of each pair of species",
            ),
        }  # fmt: skip
