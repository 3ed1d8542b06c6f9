"""Layers across an axis, for profiles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from dpd.engine.simulation import Snapshot
    from dpd.engine.state import System


class Layers:
    """Equal layers across an axis: of the box, or from behind one wall to behind the other.

    At constant pressure they are stretched with the box.

    Parameters
    ----------
    system : System
    axis : int
    thickness : float
        Largest thickness of a layer in r_c.

    Attributes
    ----------
    count : int
    axis : int
    volume : float
        Of a layer of the system's box.
    """

    def __init__(self, system: System, axis: int, thickness: float) -> None:
        self._low, self._length, self.count = system.layers(axis, thickness)
        self.axis, self._reach = axis, system.origin[axis] - self._low
        self._edge, self._volume = system.box[axis], system.volume
        self.volume = system.volume * (self._length / system.extent[axis]) / self.count

    def of(self, simulation: Snapshot) -> np.ndarray:
        """(n,) int64 array: the layer of each bead, in storage order."""
        layer = self.places(simulation).astype(np.int64)
        return np.minimum(layer, self.count - 1, out=layer)

    def places(self, simulation: Snapshot) -> np.ndarray:
        """(n,) array: where each bead is, in layers from the lower end of the first one."""
        place = simulation.state.position[self.axis] - self._low
        return place * (self.count / self._length_in(simulation))

    def bounds(self, simulation: Snapshot) -> tuple[float, float]:
        """Where in the engine's box the first layer begins, and the last one ends, in r_c."""
        return float(self._low), float(self._low + self._length_in(simulation))

    def _length_in(self, simulation):
        """All layers together, in the box as it is now."""
        edge = simulation.box[self.axis]
        return self._length if edge == self._edge else edge  # stretched: no walls

    def crowding(self, simulation: Snapshot) -> float:
        """Volume of the system's box over that of the box now, which densities go with."""
        return self._volume / simulation.volume

    def middle(self, edge: float | None = None) -> np.ndarray:
        """(count,) array: middles of the layers, from the lower end of the box or the lower wall.

        Parameters
        ----------
        edge : float or None
            Edge of a stretched box in r_c.
        """
        length = self._length if edge is None else edge
        return (np.arange(self.count) + 0.5) * (length / self.count) - self._reach
