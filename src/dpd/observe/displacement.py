"""Mean-square displacements by multiple-tau correlation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.following import in_box_of, moved_between
from dpd.observe.multitau import MultipleTau

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Displacement:
    """Mean-square displacement of innermost beads and of centres of mass.

    By multiple-tau correlation (`dpd.observe.multitau`). Positions are unwrapped from sample
    to sample and taken relative to the centre of mass of all beads, so a drift of the box
    does not count. At constant pressure it does not count either that beads are moved with the
    box. "Innermost" is the middle bead of a molecule, two of them for an even number.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples: the shortest lag.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: System, every: int) -> None:
        self.every = every
        self._system = system
        lengths = scene.lengths
        self._first = np.cumsum(lengths) - lengths
        self._lengths = lengths
        self._inner = np.stack([self._first + (lengths - 1) // 2, self._first + lengths // 2])
        d, molecules = system.dimension, len(lengths)
        self.averages = MultipleTau(scene.steps.sample // every, (d, 3, molecules), 2)
        self.arrays = self.averages.arrays | {
            "last": np.zeros((d, scene.beads)),
            "moved": np.zeros((d, scene.beads)),
        }

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        self.averages.add(self._tracked(simulation), squares)

    def _tracked(self, simulation):
        """(dimension, 3, molecules): two innermost beads and the centre of mass, unwrapped."""
        arrays, state, box = self.arrays, simulation.state, self._system.box
        position = in_box_of(state.by_identity(state.position), simulation.box, box)
        if arrays["taken"][0]:
            moved = moved_between(
                arrays["last"], position, box, state.step, "displacement", self.every
            )
            arrays["moved"] += in_box_of(moved, box, simulation.box)
        arrays["last"][...] = position
        moved = arrays["moved"] - arrays["moved"].mean(axis=1, keepdims=True)
        centre = np.add.reduceat(moved, self._first, axis=1) / self._lengths
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
    found = ((now - then) ** 2).sum(axis=0)
    return np.stack([0.5 * (found[0] + found[1]), found[2]])
