"""Density of each species along an axis."""

from typing import Any

import numpy as np

from dpd.observe.common.layers import Layered
from dpd.page import Change


class Profile(Layered, key="profile"):
    """Number density of each species in slices across an axis."""

    stands = frozenset(Change)
    gives = {
        "z": (("run", "z"), "r_c", "position along the axis of the profile"),
        "density_profile": (
            ("block", "species", "z"), "1 / r_c^dimension", "number density in blocks of the run",
        ),
    }  # fmt: skip
    only_with = {"z": Change.STRETCHES}  # the mean box; another stays

    def axes(self, scene: Any) -> Any:
        return {"z": (self.layers(scene).middles(), *self.gives["z"][1:])}

    def measure(self, now: Any) -> Any:
        slices, species, kinds = self.layers(now.scene), now.state.species, len(now.scene.species)
        place = slices.of(now)
        if species is not None:
            place += slices.count * species.astype(np.int64)
        counts = np.bincount(place, minlength=kinds * slices.count).reshape(kinds, -1)
        density = counts * (slices.crowding(now) / slices.volume)
        return {"z": slices.middles_in(now), "density_profile": density}
