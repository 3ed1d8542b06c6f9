"""Normal and tangential pressure along an axis."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.blocks import BlockSums
from dpd.observe.common.layers import Layers
from dpd.observe.common.thermal import ThermalMotion
from dpd.page import Axis, Change, Observable, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class StressProfile(Observable, key="stress_profile"):
    """Pressure normal to an axis's slices, and tangential to them, slice by slice.

    The pressure tensor of conservative forces, (sum_i m_i c_i c_i + sum r_ij F_ij) / V, is divided
    among the slices: the kinetic part of a bead belongs to the slice that it is in, and what a pair
    adds is spread evenly along the straight line between its beads, also across the edge of the box
    (Irving and Kirkwood 1950). Bonds are pairs, and angles act along their two bonds, see
    `dpd.engine.queries.stress.virial_in_slices`. In each sample, the mean over all slices is the
    pressure tensor of the box, as `thermo` has it. Tangential is the mean over the other axes.

    Where a fluid is at rest, its normal pressure is the same everywhere. Between walls across the
    axis it falls to zero at the walls, whose force is an external one: what a wall does to the
    beads further in is given apart, and the sum of both is the same everywhere, the force per area
    on each wall. Velocities c are those of `thermo`, about the flow.

    At constant pressure the slices are stretched with the box, and their places are those in the
    mean box.

    A sample takes as long as 3.0, 3.6 and 4.2 steps with slices of 0.5, 0.2 and 0.1 r_c, measured
    for 3840 beads of density 3 on one core: it sorts the beads, finds all pairs as a step does, and
    cuts each line at each edge of a slice.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    interval, bins_of = 0.4, "box"

    bin: float = setting("Width of a slice, at most the longest edge.", 0.2, unit="r_c", ge=0.001)
    axis: Axis | None = setting("The axis; if not given, as for velocity_profile.", None, of="axis")

    def _start(self, scene: Scene, system: System) -> None:
        self._system, self._thermal = system, ThermalMotion(scene, system)
        self._layers = Layers(system, scene.axis_of_profile(self.axis), self.bin)
        self._walled = system.walls is not None and self._layers.axis in system.walls.axis
        # Normal and tangential; with walls across the axis, what they add to the normal one.
        shape = 3 if self._walled else 2, self._layers.count
        self.averages = BlockSums(shape)
        self.arrays = self.averages.arrays
        if system.pressure is not None:
            # The edge along the axis, summed over the samples.
            self.arrays = self.arrays | {"length": np.zeros(1)}

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.queries.stress import Slices, virial_in_slices, wall_virial_in_slices

        system, state = replace(simulation.system, box=simulation.box), simulation.state
        slices = Slices(self._layers.axis, self._layers.count, *self._layers.bounds(simulation))
        sample = virial_in_slices(system, state, slices) + self._kinetic(simulation)
        if self._walled:
            sample = np.vstack([sample, wall_virial_in_slices(system, state, slices)])
        self.averages.add(sample * self._layers.crowding(simulation))
        if "length" in self.arrays:
            self.arrays["length"][0] += simulation.box[self._layers.axis]

    def _kinetic(self, simulation):
        """(2, slices) array: sum of m c c along the axis, and its mean over the others."""
        layer, axis, state = self._layers.of(simulation), self._layers.axis, simulation.state
        thermal = self._system.mass_of(state.species) * self._thermal.velocities(simulation) ** 2
        each = [np.bincount(layer, one, self._layers.count) for one in thermal]
        normal = each.pop(axis)
        return np.array([normal, np.mean(each, axis=0)])

    def variables(self) -> Variables:
        """Profiles in blocks for the file."""
        means, along = self.averages.means() / self._layers.volume, ("block", "slice")
        length, unit = None, "kT / r_c^dimension"
        if "length" in self.arrays and self.averages.taken:
            length = self.arrays["length"][0] / self.averages.taken
        middle = self._layers.middle(length)
        found = {
            "slice": (("slice",), middle, "r_c", "position along the axis of pressures"),
            "normal_pressure_profile": (
                along, means[:, 0], unit,
                "pressure along the axis in a slice, conservative forces, in blocks of the run",
            ),
            "tangential_pressure_profile": (
                along, means[:, 1], unit,
                "pressure across the axis in a slice, conservative forces, in blocks of the run",
            ),
        }  # fmt: skip
        if self._walled:
            found["wall_pressure_profile"] = (
                along, means[:, 2], unit,
                "what walls add to the pressure along the axis in a slice, in blocks of the run",
            )  # fmt: skip
        return found
