"""Each kind of molecule in a slab of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dpd.start.random import Random

if TYPE_CHECKING:
    import numpy as np


class Slabs(Random, key="slabs"):
    """Each kind of molecule in a slab of its own along the longest axis."""

    def positions(self, scene: Any, rng: np.random.Generator) -> np.ndarray:
        """Random flights."""
        from dpd.start.common.flights import flights

        return flights(scene, rng, in_slabs=True)
