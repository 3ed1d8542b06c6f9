"""Density of each species along an axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.blocks import BlockSums
from dpd.observe.common.layers import Layers
from dpd.page import Axis, Change, Observable, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Profile(Observable, key="profile"):
    """Number density of each species in slices across an axis.

    At constant pressure the slices are stretched with the box, and their places are those in the
    mean box.
    """

    stands = frozenset(Change)
    bins_of = "box"

    bin: float = setting("Bin width, at most the longest edge.", 0.2, unit="r_c", ge=0.001)
    axis: Axis | None = setting("The axis; if not given, as for velocity_profile.", None, of="axis")

    def _start(self, scene: Scene, system: System) -> None:
        self._names = scene.species
        self._slices = Layers(system, scene.axis_of_profile(self.axis), self.bin)
        shape = len(self._names), self._slices.count
        self.averages = BlockSums(shape)
        self.arrays = self.averages.arrays
        if system.pressure is not None:
            # The edge along the axis, summed over the samples.
            self.arrays = self.arrays | {"length": np.zeros(1)}

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        state, bins = simulation.state, self._slices.count
        slices = self._slices.of(simulation)
        if state.species is not None:
            slices += bins * state.species.astype(np.int64)
        counts = np.bincount(slices, minlength=len(self._names) * bins)
        counts = counts.reshape(len(self._names), bins)
        self.averages.add(counts * self._slices.crowding(simulation))
        if "length" in self.arrays:
            self.arrays["length"][0] += simulation.box[self._slices.axis]

    def variables(self) -> Variables:
        """Profiles in blocks for the file."""
        length = None
        if "length" in self.arrays and self.averages.taken:
            length = self.arrays["length"][0] / self.averages.taken
        middle = self._slices.middle(length)
        return {
            "z": (("z",), middle, "r_c", "position along the axis of the profile"),
            "species": (("species",), np.array(self._names), "1", "species"),
            "density_profile": (
                ("block", "species", "z"), self.averages.means() / self._slices.volume,
                "1 / r_c^dimension", "number density in blocks of the run",
            ),
        }  # fmt: skip
