from typing import Any

import numpy as np

from dpd.errors import UserError
from dpd.page import Change, Observable

MOST = 8  # pairs of crossing bonds per bond that are kept in mind


class Crossings(Observable, key="crossings"):
    """Pairs of bonds that cross, over time.

    Where chains cannot pass through each other there is none at any time.
    """

    stands = frozenset(Change)
    interval, cost, dimensions, needs_bonds = 0.2, 25.0, (2,), True
    over = {"sample": ("crossing_sample", "crossing_time")}
    gives = {
        "crossings": (("sample",), "1", "pairs of bonds that cross"),
        "crossings_begun": (("sample",), "1", "those that did not cross at the sample before"),
    }

    def keeps(self, scene: Any) -> Any:
        return {"pairs": np.full(MOST * len(scene.bonded), -1, np.int64)}  # by number; -1 for none

    def measure(self, now: Any) -> Any:
        from dpd.engine.crossings import crossing_bonds

        members, former = now.scene.bonded, now.kept["pairs"]
        one, other = crossing_bonds(now.coordinates, members, now.lattice)
        pairs = one.astype(np.int64) * len(members) + other
        if len(pairs) > len(former):
            raise UserError(
                f"{len(pairs)} pairs of {len(members)} bonds cross: too many to follow; "
                "take 'crossings' out of observe"
            )
        begun = np.isin(pairs, former, invert=True).sum()
        former[:] = -1
        former[: len(pairs)] = pairs
        return {"crossings": len(pairs), "crossings_begun": begun}
