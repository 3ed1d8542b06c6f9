"""Layers across an axis, for profiles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from dpd.engine.state import System


class Layers:
    """Equal layers across an axis: of the box, or from behind one wall to behind the other.

    Parameters
    ----------
    system : System
    axis : int
    thickness : float
        Largest thickness of a layer in r_c.

    Attributes
    ----------
    count : int
    middle : (count,) array
        Middles of the layers in r_c, counted from the lower end of the box, or from the lower wall.
    volume : float
        Of a layer.
    """

    def __init__(self, system: System, axis: int, thickness: float) -> None:
        walls = system.walls
        reach = 0.0 if walls is None or axis not in walls.axis else walls.reach
        extent = system.extent[axis]
        self._axis, self._low = axis, system.origin[axis] - reach
        self._length = extent + 2 * reach
        self.count = int(np.ceil(self._length / thickness))
        self.middle = (np.arange(self.count) + 0.5) * (self._length / self.count) - reach
        self.volume = system.volume * (self._length / extent) / self.count

    def of(self, position: np.ndarray) -> np.ndarray:
        """(n,) int64 array: the layer of each of some beads, whose positions are (dimension, n)."""
        place = position[self._axis] - self._low
        layer = (place * (self.count / self._length)).astype(np.int64)
        return np.minimum(layer, self.count - 1, out=layer)
