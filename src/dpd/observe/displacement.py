"""Mean-square displacements by multiple-tau correlation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.following import flow_at, moved_between
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
    does not count; nor does the flow of a shear, in which a bead moves by the integral of its
    velocity about the flow, with the flow at the mean place between samples. "Innermost" is the
    bead in the middle of the longest way through a molecule, two of them for an even number.

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
        inner = np.repeat(
            [kind.middle for kind in scene.molecules],
            [kind.count for kind in scene.molecules], axis=0,
        )  # fmt: skip
        self._inner = self._first + inner.T
        species = None if len(scene.species) == 1 else scene.kinds
        self._mass = system.mass_of(species)
        each = np.broadcast_to(self._mass, scene.beads)
        self._of_molecule = np.add.reduceat(each, self._first)
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
        arrays, box, state = self.arrays, simulation.box, simulation.state
        position = state.by_identity(state.position)
        if arrays["taken"][0]:
            time = self.every * self._system.dt
            begun = arrays["last"] + time * flow_at(arrays["last"], box)
            moved = moved_between(begun, position, box, state.step, "displacement", self.every)
            arrays["moved"] += moved - 0.5 * time * flow_at(moved, box)
        arrays["last"][...] = position
        weights = self._mass if np.ndim(self._mass) else None
        whole = np.average(arrays["moved"], axis=1, weights=weights, keepdims=True)
        moved = arrays["moved"] - whole
        centre = np.add.reduceat(self._mass * moved, self._first, axis=1) / self._of_molecule
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
