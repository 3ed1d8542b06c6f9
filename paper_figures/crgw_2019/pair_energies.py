from typing import Any

import numpy as np

from dpd.observe.common.bins import species_pairs
from dpd.page import Change, Observable


class PairEnergies(Observable, key="pair_energies"):
    """Energy of the soft repulsion between the beads of each two species.

    Where the repulsion of two species is a, the derivative of the free energy by a is this energy
    over a. Their sum is the pair energy of `thermo`, unless other forces act between beads.
    """

    stands = frozenset(Change)
    interval, cost = 2.0, 6.5
    cannot = {Change.JUMPS: "knows the soft repulsion alone"}
    gives = {"energy_of_pair": (("block", "energy_pair"), "kT", "energy of the soft repulsion")}

    def axes(self, scene: Any) -> Any:
        pairs = np.transpose(np.triu_indices(len(scene.species)))
        return {"energy_pair": species_pairs(scene, pairs)}

    def measure(self, now: Any) -> Any:
        repulsion = now.scene.repulsion
        squares = now.by_species(1.0, lambda r: (1 - r) ** 2)
        return (0.5 * repulsion * squares)[np.triu_indices(len(repulsion))]
