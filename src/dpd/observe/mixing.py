from itertools import combinations
from typing import Any

import numpy as np

from dpd.observe.common.bins import species_pairs
from dpd.page import Change, Observable, Refusals


class Mixing(Observable, key="mixing"):
    """Short-range order of each pair of species: 0 if mixed at random, 1 if apart.

    The order parameter of Warren and Cowley (Cowley, Phys. Rev. 77, 669 (1950)), for a fluid:
    alpha_ab = 1 - n_ab / <n_ab>. Here n_ab of all n pairs of beads within r_c are of the species a
    and b, and <n_ab> = 2 N_a N_b / (N (N - 1)) n are, if the same beads had their species by lot.
    It is below 0 where unlike beads prefer each other. Bonded pairs count as any other, so that
    blocks of a chain give a little order even where chains are mixed.
    """

    stands = frozenset(Change)
    interval, cost = 2.0, 4.5
    gives = {"short_range_order": (("sample", "unlike_pair"), "1", "0 mixed at random, 1 apart")}

    def refuses(self, scene: Any) -> Refusals:
        if len(scene.species) < 2:
            yield "", "'mixing' has nothing to measure: there is a single species"

    def axes(self, scene: Any) -> Any:
        return {"unlike_pair": species_pairs(scene, combinations(range(len(scene.species)), 2))}

    def measure(self, now: Any) -> Any:
        number = np.bincount(now.scene.kinds, minlength=len(now.scene.species)).astype(float)
        by_lot = 2 * np.outer(number, number) / (now.beads * (now.beads - 1))
        total = np.triu(pairs := now.by_species(1.0, np.ones_like)).sum()
        return [
            1 - pairs[a, b] / (by_lot[a, b] * total) if total else 0.0
            for a, b in combinations(range(len(number)), 2)
        ]
