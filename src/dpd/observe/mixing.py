"""How well species are mixed, over time."""

from itertools import combinations
from typing import Any

import numpy as np

from dpd.page import Change, Observable, Refusals

NEAR = 1.0  # r_c, the range of the forces: within it beads are neighbours


class Mixing(Observable, key="mixing"):
    """Short-range order of each pair of species: 0 if mixed at random, 1 if apart.

    The order parameter of Warren and Cowley (Cowley, Phys. Rev. 77, 669 (1950)), for a fluid:
    alpha_ab = 1 - n_ab / <n_ab>. Here n_ab of all n pairs of beads within r_c are of the species a
    and b, and <n_ab> = 2 N_a N_b / (N (N - 1)) n are, if the same beads had their species by lot.
    It is below 0 where unlike beads prefer each other. Bonded pairs count as any other, so that
    blocks of a chain give a little order even where chains are mixed.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    gives = {
        "short_range_order": (
            ("sample", "unlike_pair"), "1",
            "Warren-Cowley order of neighbours within r_c: 0 mixed at random, 1 apart",
        ),
    }  # fmt: skip

    def refuses(self, scene: Any) -> Refusals:
        """A single species."""
        if len(scene.species) < 2:
            yield "", "'mixing' has nothing to measure: there is a single species"

    def axes(self, scene: Any) -> Any:
        names = [f"{one} {other}" for one, other in combinations(scene.species, 2)]
        return {"unlike_pair": (np.array(names), "1", "pair of species")}

    def measure(self, now: Any) -> Any:
        """Of the neighbours of this moment; 0 where no two beads are near each other."""
        from dpd.engine.queries.pairs import neighbour_pairs

        kinds, species = now.scene.kinds, len(now.scene.species)
        number = np.bincount(kinds, minlength=species).astype(float)
        by_lot = 2 * np.outer(number, number) / (now.beads * (now.beads - 1))
        pairs = neighbour_pairs(now.coordinates, kinds, now.lattice, NEAR, species)
        total = np.triu(pairs).sum()
        return [
            1 - pairs[a, b] / (by_lot[a, b] * total) if total else 0.0
            for a, b in combinations(range(species), 2)
        ]
