"""Energy of the pairs of each two species, as thermodynamic integration needs it."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class PairEnergies(Observable, key="pair_energies"):
    """Energy of the soft repulsion between the beads of each two species.

    Where the repulsion of two species is a, the derivative of the free energy by a is this energy
    over a. Their sum is the pair energy of `thermo`, unless other forces act between beads.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    cannot = {Change.JUMPS: "knows the soft repulsion alone"}

    def _start(self, scene: Scene, system: System) -> None:
        self._kinds = scene.kinds
        self._names = scene.species
        self._pairs = list(combinations_with_replacement(range(len(self._names)), 2))
        self.averages = BlockSums((len(self._pairs),))
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.queries.pairs import soft_energies

        state = simulation.state
        position = state.by_identity(state.position)
        repulsion = simulation.system.pair.repulsion
        found = soft_energies(position, self._kinds, simulation.box, repulsion)
        self.averages.add([found[i, j] for i, j in self._pairs])

    def variables(self) -> Variables:
        """Energies in blocks for the file."""
        names = [f"{self._names[i]} {self._names[j]}" for i, j in self._pairs]
        return {
            "energy_pair": (("energy_pair",), np.array(names), "1", "pair of species"),
            "energy_of_pair": (
                ("block", "energy_pair"), self.averages.means(), "kT",
                "energy of the soft repulsion of two species, in blocks of the run",
            ),
        }  # fmt: skip
