from typing import Any

import numpy as np

from dpd.observe.common.bins import Layered
from dpd.page import Change


class Profile(Layered, key="profile"):
    """Number density of each species in slices across an axis."""

    stands = frozenset(Change)
    along = "z"
    gives = {
        "z": (("run", "z"), "r_c", "position along the axis"),
        "density_profile": (("block", "species", "z"), "1 / r_c^dimension", "number density"),
    }
    only_with = {"z": Change.STRETCHES}  # the mean box; another stays

    def measure(self, now: Any) -> Any:
        layers, species, kinds = self.layers(now.whole), now.state.species, len(now.scene.species)
        place = layers.of(now)
        if species is not None:
            place += layers.count * species.astype(np.int64)
        counts = np.bincount(place, minlength=kinds * layers.count).reshape(kinds, -1)
        return {"z": layers.middles(now), "density_profile": counts * layers.per_volume(now)}
