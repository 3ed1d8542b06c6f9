"""How well species are mixed, over time."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from dpd.page import Change, Observable, Refusals

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene

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
    is_series = True

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        self._names = scene.species
        self._pairs = list(combinations(range(len(self._names)), 2))
        self._kinds = scene.kinds
        number = np.bincount(self._kinds, minlength=len(self._names)).astype(float)
        beads = number.sum()
        self._by_lot = 2 * np.outer(number, number) / (beads * (beads - 1))
        samples = scene.steps.sample // self.every
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "order": np.full((samples, len(self._pairs)), np.nan),
        }

    def refuses(self, scene: Scene) -> Refusals:
        """A single species."""
        if len(scene.species) < 2:
            yield "", "'mixing' has nothing to measure: there is a single species"

    def sample(self, simulation: Simulation) -> None:
        """Take one sample; 0 where no two beads are near each other."""
        from dpd.engine.queries.pairs import neighbour_pairs

        state = simulation.state
        position = state.by_identity(state.position)
        pairs = neighbour_pairs(position, self._kinds, simulation.box, NEAR, len(self._names))
        total = np.triu(pairs).sum()
        at = int(self.arrays["taken"][0])
        self.arrays["order"][at] = [
            1 - pairs[a, b] / (self._by_lot[a, b] * total) if total else 0.0 for a, b in self._pairs
        ]
        self.arrays["taken"][0] += 1

    def variables(self) -> Variables:
        """The order over time for the file."""
        time = self.times(1 + np.arange(len(self.arrays["order"])))
        names = [f"{self._names[a]} {self._names[b]}" for a, b in self._pairs]
        return {
            "mixing_time": (
                ("mixing_sample",), time, "tau", "time since the end of equilibration",
            ),
            "unlike_pair": (("unlike_pair",), np.array(names), "1", "pair of species"),
            "short_range_order": (
                ("mixing_sample", "unlike_pair"), self.arrays["order"], "1",
                "Warren-Cowley order of neighbours within r_c: 0 mixed at random, 1 apart",
            ),
        }  # fmt: skip
