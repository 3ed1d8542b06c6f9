"""Density of each species along an axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.blocks import BlockSums

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Profile:
    """Number density of each species in slices across the longest axis.

    At constant pressure the slices are stretched with the box, and their places are those in the
    mean box.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    bin : float
        Largest width of a slice in r_c; the axis is cut into equal slices.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: System, every: int, bin: float) -> None:
        self.every = every
        self._system = system
        self._names = scene.species
        self._axis = int(np.argmax(system.box))
        self._bins = int(np.ceil(system.box[self._axis] / bin))
        self.averages = BlockSums((len(self._names), self._bins), scene.steps.sample // every)
        self.arrays = self.averages.arrays
        if system.pressure is not None:
            # The longest edge, summed over the samples.
            self.arrays = self.arrays | {"length": np.zeros(1)}

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        state = simulation.state
        length = simulation.box[self._axis]
        slices = (state.position[self._axis] * (self._bins / length)).astype(np.int64)
        np.minimum(slices, self._bins - 1, out=slices)
        if state.species is not None:
            slices += self._bins * state.species.astype(np.int64)
        counts = np.bincount(slices, minlength=len(self._names) * self._bins)
        counts = counts.reshape(len(self._names), self._bins)
        self.averages.add(counts * (self._system.volume / simulation.volume))
        if "length" in self.arrays:
            self.arrays["length"][0] += length

    def variables(self) -> Variables:
        """Profiles in blocks for the file."""
        length = self._system.box[self._axis]
        if "length" in self.arrays and self.averages.taken:
            length = self.arrays["length"][0] / self.averages.taken
        slice_volume = self._system.volume / self._bins
        middle = (np.arange(self._bins) + 0.5) * (length / self._bins)
        return {
            "z": (("z",), middle, "r_c", "position along the longest axis"),
            "species": (("species",), np.array(self._names), "1", "species"),
            "density_profile": (
                ("block", "species", "z"), self.averages.means() / slice_volume,
                "1 / r_c^dimension", "number density in blocks of the run",
            ),
        }  # fmt: skip
