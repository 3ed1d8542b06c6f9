"""Bond lengths."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.scene import Scene

LONGEST = 5.0  # end of the histogram in r_c; the mean takes every bond


class BondLengths(Observable, key="bonds"):
    """Mean, mean square and longest bond length in blocks, and their distribution."""

    stands = frozenset(Change)
    needs_bonds = True

    bin: float = setting("Bin width.", 0.01, unit="r_c", ge=0.0001, le=1)

    def _start(self, scene: Scene, system: BondedSystem) -> None:
        self._system = system
        self._edges = np.linspace(0.0, LONGEST, round(LONGEST / self.bin) + 1)
        # The first two places hold the sums of r and r^2.
        samples = scene.steps.sample // self.every
        self.averages = BlockSums((len(self._edges) + 1,))
        self.arrays = self.averages.arrays | {"longest": np.full(samples, np.nan)}

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.space import nearest

        members = self._system.members
        position = simulation.state.by_identity(simulation.state.position)
        apart = nearest(position[:, members[:, 0]] - position[:, members[:, 1]], simulation.box)
        length = np.sqrt((apart**2).sum(axis=0))
        density = np.histogram(length, self._edges)[0] / (len(length) * self._edges[1])
        self.arrays["longest"][self.averages.taken] = length.max()
        self.averages.add(np.concatenate([[length.mean(), (length**2).mean()], density]))

    def variables(self) -> Variables:
        """Bond lengths in blocks for the file."""
        means = self.averages.means()
        middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        return {
            "bond_mean": (("block",), means[:, 0], "r_c", "mean bond length"),
            "bond_mean_square": (("block",), means[:, 1], "r_c^2", "mean square bond length"),
            "bond_longest": (
                ("block",), self.averages.largest(self.arrays["longest"]), "r_c",
                "longest bond met in each block",
            ),
            "bond_length": (("bond_length",), middle, "r_c", "bond length"),
            "bond_density": (
                ("block", "bond_length"), means[:, 2:], "1 / r_c", "density of lengths",
            ),
        }  # fmt: skip
