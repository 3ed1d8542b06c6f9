"""How long chains remember where they point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import nearest
from dpd.observe.multitau import MultipleTau

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.scene import Scene


class EndToEnd:
    """Autocorrelation of the end-to-end vector, <R(t) . R(0)> (Nikunen et al. 2007, Fig. 4b).

    By multiple-tau correlation (`dpd.observe.multitau`), for each chain of two beads
    or more.

    Parameters
    ----------
    scene : Scene
        With bonds shorter than half the box.
    system : System
    every : int
        Steps between samples: the shortest lag.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: BondedSystem, every: int) -> None:
        self.every = every
        self._system = system
        lengths = scene.lengths[scene.lengths > 1]
        self._bonds_first = np.cumsum(lengths - 1) - (lengths - 1)
        samples = scene.steps.sample // every
        self.averages = MultipleTau(samples, (system.dimension, len(lengths)), 1)
        self.arrays = self.averages.arrays | {"square": np.zeros(len(lengths))}

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        state, members = simulation.state, self._system.members
        position = state.by_identity(state.position)
        bonds = nearest(position[:, members[:, 1]] - position[:, members[:, 0]], simulation.box)
        vector = np.add.reduceat(bonds, self._bonds_first, axis=1)
        self.arrays["square"] += (vector**2).sum(axis=0)
        self.averages.add(vector, product)

    def variables(self) -> Variables:
        """Correlations of each molecule, and sums in parts of the run, by increasing lag."""
        lag, means, counts, sums = self.averages.results()
        taken = max(1, int(self.arrays["taken"][0]))
        return {
            "end_lag_time": (("end_lag",), lag * self.every * self._system.dt, "tau", "time apart"),
            "end_correlation": (
                ("end_lag", "chain"), means[:, 0], "r_c^2", "<R(t) . R(0)> of each chain",
            ),
            "end_square": (
                ("chain",), self.arrays["square"] / taken, "r_c^2", "<R^2> of each chain",
            ),
            "end_samples": (
                ("part", "end_lag"), counts, "1", "pairs of samples ending in each part of the run",
            ),
            "end_sums": (
                ("part", "end_lag"), sums[..., 0], "r_c^2",
                "their products, mean over molecules, summed",
            ),
        }  # fmt: skip


def product(now: np.ndarray, then: np.ndarray) -> np.ndarray:
    """Scalar products of vectors."""
    return (now * then).sum(axis=0)[None]
