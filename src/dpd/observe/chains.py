"""Sizes of chains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import nearest
from dpd.observe.blocks import BlockSums

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Chains:
    """Squared radius of gyration and end-to-end distance, for each kind of molecule.

    A chain is followed from bead to bead over nearest images, so bonds have to be shorter
    than half the box.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: System, every: int) -> None:
        self.every = every
        self._kinds = [(kind.count, len(kind.beads)) for kind in scene.molecules]
        self.averages = BlockSums((len(self._kinds), 2), scene.steps.sample // every)
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        state = simulation.state
        position = state.by_identity(state.position)
        found, first = [], 0
        for count, length in self._kinds:
            beads = position[:, first : first + count * length].reshape(-1, count, length)
            found.append(sizes(unwrapped(beads, simulation.box)))
            first += count * length
        self.averages.add(np.array(found))

    def variables(self) -> Variables:
        """Sizes in blocks for the file."""
        means = self.averages.means()
        along = ("block", "kind")
        return {
            "gyration_square": (along, means[..., 0], "r_c^2", "squared radius of gyration"),
            "end_to_end_square": (along, means[..., 1], "r_c^2", "squared end-to-end distance"),
        }


def unwrapped(beads: np.ndarray, box: tuple[float, ...]) -> np.ndarray:
    """Chains in one piece: each bead at the image nearest to the one before.

    Parameters
    ----------
    beads : (dimension, chains, length) array
        In the box.
    box : tuple
    """
    steps = nearest(np.diff(beads, axis=2), box)
    return np.concatenate([beads[:, :, :1], steps], axis=2).cumsum(axis=2)


def sizes(chains: np.ndarray) -> tuple[float, float]:
    """Mean squared radius of gyration and end-to-end distance of unwrapped chains."""
    spread = chains - chains.mean(axis=2, keepdims=True)
    across = chains[:, :, -1] - chains[:, :, 0]
    gyration = (spread**2).sum(axis=0).mean()
    return float(gyration), float((across**2).sum(axis=0).mean())
