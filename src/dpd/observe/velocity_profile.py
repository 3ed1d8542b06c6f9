"""Mean velocity, temperature and density in layers across an axis."""

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


class VelocityProfile(Observable, key="velocity_profile"):
    """Mean velocity of the beads in layers across an axis, and their temperature about it.

    The temperature of a layer is <m (v - u)^2> / dimension, with u the mean velocity of its beads
    in the whole run, weighted by mass: what flows is no heat. It is given for the degrees of
    freedom that conserved momentum leaves, as kT of `thermo`. Across the gradient of a shear the
    velocity is that in the laboratory; across other axes, that about the flow. A layer in which no
    bead was has neither.
    """

    stands = frozenset(Change)
    interval, bins_of = 0.2, "box"

    bin: float = setting(
        "Thickness of a layer, at most the longest edge.", 0.2, unit="r_c", ge=0.001
    )
    axis: Axis | None = setting(
        "The axis; if not given, the one across which walls, a body force that turns round, or a "
        "shear make the fluid change, or the longest.",
        None,
        of="axis",
    )

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        coordinates = np.float64(scene.dimension * scene.beads)
        with np.errstate(divide="ignore"):
            self._per_freedom = coordinates / (coordinates - len(scene.momentum_axes))
        self._layers = Layers(system, scene.axis_of_profile(self.axis), self.bin)
        # Of each layer: beads, their mass, sum of m v along each axis, sum of m v^2.
        shape = 3 + system.dimension, self._layers.count
        self.averages = BlockSums(shape)
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        state = simulation.state
        layer, velocity = self._layers.of(simulation), state.velocity
        momenta = self._system.momenta(state)
        mass = np.broadcast_to(self._system.mass_of(state.species), layer.shape)
        each = [None, mass, *momenta, (velocity * momenta).sum(axis=0)]
        self.averages.add([np.bincount(layer, one, self._layers.count) for one in each])

    def _sheared(self, velocity):
        """Velocities in the laboratory: those of a state under shear are about its flow."""
        shear = self._system.shear
        if shear is not None and shear.gradient == self._layers.axis:
            velocity[:, shear.flow] += shear.rate * self._layers.middle()
        return velocity

    def variables(self) -> Variables:
        """Profiles in blocks for the file."""
        means, d = self.averages.means(), self._system.dimension
        beads, mass, momentum, square = means[:, 0], means[:, 1], means[:, 2 : 2 + d], means[:, -1]
        with np.errstate(invalid="ignore", divide="ignore"):
            flow = np.nansum(momentum, axis=0) / np.nansum(mass, axis=0)
            velocity = momentum / mass[:, None]
            square = square - mass * (2 * (flow * velocity).sum(axis=1) - (flow**2).sum(axis=0))
            about = square / beads * self._per_freedom
        along = ("block", "layer")
        middle = self._layers.middle()
        return {
            "layer": (("layer",), middle, "r_c", "position along the axis of layers"),
            "velocity_profile": (
                ("block", "axis", "layer"), self._sheared(velocity), "r_c / tau",
                "mean velocity of the beads of a layer in blocks of the run",
            ),
            "temperature_profile": (
                along, about / d, "kT",
                "their temperature <m (v - u)^2>/dimension about the mean velocity u of the run",
            ),
            "bead_profile": (
                along, beads / self._layers.volume, "1 / r_c^dimension",
                "number density of all beads in a layer in blocks of the run",
            ),
        }  # fmt: skip
