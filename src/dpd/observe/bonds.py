"""Bond lengths."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import nearest
from dpd.observe.blocks import BlockSums

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.scene import Scene

LONGEST = 5.0  # end of the histogram in r_c; the mean takes every bond


class BondLengths:
    """Mean, mean square and longest bond length in blocks, and their distribution.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    bin : float
        Bin width in r_c.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: BondedSystem, every: int, bin: float) -> None:
        self.every = every
        self._system = system
        self._edges = np.linspace(0.0, LONGEST, round(LONGEST / bin) + 1)
        # The first two places hold the sums of r and r^2.
        self._blocks = BlockSums((len(self._edges) + 1,), scene.steps.sample // every)
        self._longest = np.zeros(self._blocks.count)
        self.arrays = self._blocks.arrays | {"longest": self._longest}

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        members = self._system.members
        position = simulation.state.by_identity(simulation.state.position)
        apart = nearest(position[:, members[:, 0]] - position[:, members[:, 1]], self._system.box)
        length = np.sqrt((apart**2).sum(axis=0))
        into = self._blocks.open()
        block = self._blocks.current
        self._longest[block] = max(self._longest[block], length.max())
        into[0] += length.mean()
        into[1] += (length**2).mean()
        into[2:] += np.histogram(length, self._edges)[0] / (len(length) * self._edges[1])

    def variables(self) -> Variables:
        """Bond lengths in blocks for the file."""
        means = self._blocks.means()
        middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        return {
            "bond_mean": (("block",), means[:, 0], "r_c", "mean bond length"),
            "bond_mean_square": (("block",), means[:, 1], "r_c^2", "mean square bond length"),
            "bond_longest": (("block",), self._longest, "r_c", "longest bond met in each block"),
            "bond_length": (("bond_length",), middle, "r_c", "bond length"),
            "bond_density": (
                ("block", "bond_length"),
                means[:, 2:],
                "1 / r_c",
                "density of lengths",
            ),
        }
