"""Mean velocity, temperature and density in layers across an axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.blocks import BlockSums
from dpd.observe.layers import Layers
from dpd.scene.flow import profile_axis

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class VelocityProfile:
    """Mean velocity of the beads in layers across an axis, and their temperature about it.

    The temperature of a layer is <(v - u)^2> / dimension, with u the mean velocity of its beads in
    the whole run: what flows is no heat. A layer in which no bead was has neither.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    bin : float
        Largest thickness of a layer in r_c; the axis is cut into equal layers. Between walls they
        reach from behind one wall to behind the other.
    axis : str or None
        Its name; if not given, see `dpd.scene.flow.profile_axis`.
    """

    needs_forces = False

    def __init__(
        self, scene: Scene, system: System, every: int, bin: float, axis: str | None = None
    ) -> None:
        self.every = every
        self._dimension = system.dimension
        self._layers = Layers(system, profile_axis(scene, axis), bin)
        # Of each layer: number of beads, sum of v along each axis, sum of v^2.
        shape = 2 + system.dimension, self._layers.count
        self.averages = BlockSums(shape, scene.steps.sample // every)
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        state = simulation.state
        layer, velocity = self._layers.of(state.position), state.velocity
        each = [None, *velocity, (velocity**2).sum(axis=0)]
        self.averages.add([np.bincount(layer, one, self._layers.count) for one in each])

    def variables(self) -> Variables:
        """Profiles in blocks for the file."""
        means, d = self.averages.means(), self._dimension
        beads, momentum, square = means[:, 0], means[:, 1 : 1 + d], means[:, 1 + d]
        with np.errstate(invalid="ignore", divide="ignore"):
            flow = np.nansum(momentum, axis=0) / np.nansum(beads, axis=0)
            velocity = momentum / beads[:, None]
            about = square / beads - 2 * (flow * velocity).sum(axis=1) + (flow**2).sum(axis=0)
        along = ("block", "layer")
        return {
            "layer": (("layer",), self._layers.middle, "r_c", "position along the axis of layers"),
            "velocity_profile": (
                ("block", "axis", "layer"), velocity, "r_c / tau",
                "mean velocity of the beads of a layer in blocks of the run",
            ),
            "temperature_profile": (
                along, about / d, "kT",
                "their temperature <(v - u)^2>/dimension about the mean velocity u of the run",
            ),
            "bead_profile": (
                along, beads / self._layers.volume, "1 / r_c^dimension",
                "number density of all beads in a layer in blocks of the run",
            ),
        }  # fmt: skip
