"""Mean-square displacements by multiple-tau correlation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.following import Followed
from dpd.observe.common.multitau import MultipleTau
from dpd.page import Change, Observable, interval_setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Displacement(Observable, key="displacement"):
    """Mean-square displacement of innermost beads and of centres of mass.

    By multiple-tau correlation (`dpd.observe.common.multitau`), of displacements as
    `dpd.observe.common.following.Followed` has them: relative to the centre of mass of all beads.
    "Innermost" is the bead in the middle of the longest way through a molecule, two of them for an
    even number.
    """

    stands = frozenset(Change) - {Change.PACE}
    interval = 0.1

    every: int = interval_setting("Steps between samples, the shortest time.")

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        inner = np.repeat(
            [kind.middle for kind in scene.molecules],
            [kind.count for kind in scene.molecules], axis=0,
        )  # fmt: skip
        self._inner = np.cumsum(scene.lengths) - scene.lengths + inner.T
        self._followed = Followed(scene, system)
        shape = system.dimension, 3, len(scene.lengths)
        self.averages = MultipleTau(scene.steps.sample // self.every, shape, 2)
        self.arrays = self.averages.arrays | self._followed.arrays

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        self.averages.add(self._tracked(simulation), squares)

    def _tracked(self, simulation):
        """(dimension, 3, molecules): two innermost beads and the centre of mass, unwrapped."""
        moved = self._followed.sample(simulation, first=self.arrays["taken"][0] == 0)
        centre = self._followed.centres(moved)
        return np.concatenate([moved[:, self._inner], centre[:, None]], axis=1)

    def variables(self) -> Variables:
        """Displacements of each molecule, and sums in parts of the run, by increasing lag."""
        lag, means, counts, sums = self.averages.results()
        along = ("lag", "molecule")
        parts = ("part", "lag")
        return {
            "lag_time": (("lag",), lag * self.every * self._system.dt, "tau", "time apart"),
            "msd_inner": (along, means[:, 0], "r_c^2", "displacement of innermost beads, squared"),
            "msd_centre": (along, means[:, 1], "r_c^2", "displacement of centres of mass, squared"),
            "lag_samples": (parts, counts, "1", "pairs of samples ending in each part of the run"),
            "msd_inner_sums": (
                parts, sums[..., 0], "r_c^2",
                "their squared displacements of innermost beads, mean over molecules, summed",
            ),
            "msd_centre_sums": (
                parts, sums[..., 1], "r_c^2",
                "their squared displacements of centres of mass, mean over molecules, summed",
            ),
        }  # fmt: skip


def squares(now: np.ndarray, then: np.ndarray) -> np.ndarray:
    """Squared displacements: mean of the two innermost beads, and centre of mass."""
    found = ((now - then) ** 2).sum(axis=1)
    return np.stack([0.5 * (found[:, 0] + found[:, 1]), found[:, 2]], axis=1)
