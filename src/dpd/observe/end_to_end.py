from typing import Any

import numpy as np

from dpd.page import Change, Observable, Refusals


class EndToEnd(Observable, key="end_to_end"):
    """Autocorrelation of the end-to-end vector, <R(t) . R(0)> (Nikunen et al. 2007, Fig. 4b).

    By multiple-tau correlation, for each linear molecule of two beads or more.
    """

    stands = frozenset(Change) - {Change.VARIES}
    needs_bonds = True
    compared = "axis", "chain"
    over = {"lag": ("end_lag", "end_lag_time")}
    gives = {
        "end_correlation": (("lag", "chain"), "r_c^2", "<R(t) . R(0)> of each chain"),
        "end_square": (("run", "chain"), "r_c^2", "<R^2> of each chain"),
        "end_samples": (("part", "lag"), "1", "pairs of samples ending in each part of the run"),
        "end_sums": (("part", "lag"), "r_c^2", "their products, mean over molecules, summed"),
    }

    def refuses(self, scene: Any) -> Refusals:
        if not any(map(_is_chain, scene.molecules)):
            yield "", "'end_to_end' has nothing to measure: no molecule is linear"

    def axes(self, scene: Any) -> Any:
        return {"chain": sum(kind.count for kind in scene.molecules if _is_chain(kind))}

    def measure(self, now: Any) -> Any:
        vectors = [
            beads[:, :, kind.ends[1]] - beads[:, :, kind.ends[0]]
            for kind, beads in zip(now.scene.molecules, now.in_one_piece)
            if _is_chain(kind)
        ]
        vector = np.concatenate(vectors, axis=1)
        return {"compared": vector, "end_square": (vector**2).sum(axis=0)}

    def compare(self, now: np.ndarray, then: np.ndarray) -> np.ndarray:
        return (now * then).sum(axis=1)[:, None]


def _is_chain(kind):
    return len(kind.beads) > 1 and kind.is_linear
