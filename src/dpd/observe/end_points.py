from typing import Any

import numpy as np

from dpd.observe.common.bins import Binned
from dpd.page import Change, setting


class EndPoints(Binned, key="end_points"):
    """Distribution of the end-to-end distance, for each kind of molecule.

    Of a branched molecule all pairs of ends count: of beads with a single bond. The integral of a
    distribution over the distance is 1, less the share beyond the range, which is kept beside it.
    """

    stands = frozenset(Change)
    interval, needs_bonds = 1.6, True
    gives = {
        "end_density": (("block", "kind", "end_distance"), "1 / r_c", "density of the distance"),
        "end_beyond": (("block", "kind"), "1", "share of distances beyond the range"),
    }

    range: float = setting("End of the distribution.", 20.0, unit="r_c", gt=0, le=10000)
    bin: float = setting("Largest width of a bin.", 0.1, unit="r_c", ge=0.0001, le=10)

    def axes(self, scene: Any) -> Any:
        return {"end_distance": (self.middles(), "r_c", "distance between two ends")}

    def measure(self, now: Any) -> Any:
        kinds = now.scene.molecules
        shares, beyond = np.zeros((len(kinds), len(self.edges) - 1)), np.zeros(len(kinds))
        for k, beads in enumerate(now.in_one_piece):
            if len(kinds[k].ends) > 1:
                one, other = np.triu_indices(len(kinds[k].ends), 1)
                ends = beads[:, :, kinds[k].ends]
                apart = np.sqrt(((ends[:, :, one] - ends[:, :, other]) ** 2).sum(axis=0))
                shares[k], beyond[k] = self.density(apart), (apart > self.range).mean()
        return {"end_density": shares, "end_beyond": beyond}

    def finish(self, scene: Any, found: dict[str, Any]) -> Any:
        for means in found.values():
            means[:, [len(kind.ends) < 2 for kind in scene.molecules]] = np.nan
        return found
