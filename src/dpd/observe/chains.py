from typing import Any

import numpy as np

from dpd.page import Change, Given, Observable


class Chains(Observable, key="chains"):
    """Squared radius of gyration and end-to-end distance, for each kind of molecule.

    The end-to-end distance is that of linear molecules. If the scene has branched ones, the mean
    over all pairs of ends, which are beads with a single bond, is measured as well.
    """

    stands = frozenset(Change)
    gives = {
        "gyration_square": (("block", "kind"), "r_c^2", "squared radius of gyration"),
        "end_to_end_square": (("block", "kind"), "r_c^2", "squared end-to-end distance"),
        "ends_square": (("block", "kind"), "r_c^2", "squared distance of ends, mean over pairs"),
    }

    def given(self, scene: Any) -> dict[str, Given]:
        found = super().given(scene)
        if all(kind.is_linear for kind in scene.molecules):
            del found["ends_square"]
        return found

    def measure(self, now: Any) -> Any:
        found = np.zeros((3, len(now.scene.molecules)))  # 0 for single beads
        for place, (kind, beads) in enumerate(zip(now.scene.molecules, now.in_one_piece)):
            if len(kind.beads) > 1:
                ends = kind.ends if len(kind.ends) > 1 else (0, -1)  # of which rings have none
                found[:, place] = *sizes(beads, ends), ends_square(beads[:, :, ends])
        return dict(zip(("gyration_square", "end_to_end_square", "ends_square"), found))

    def finish(self, scene: Any, found: dict[str, Any]) -> Any:
        found["end_to_end_square"][:, [not kind.is_linear for kind in scene.molecules]] = np.nan
        if "ends_square" in found:
            without = [len(kind.ends) < 2 <= len(kind.beads) for kind in scene.molecules]
            found["ends_square"][:, without] = np.nan
        return found


def sizes(molecules: np.ndarray, ends: Any = (0, -1)) -> tuple[float, float]:
    """Mean squared radius of gyration, and end-to-end distance, of (dimension, molecules, length).

    Molecules are in one piece; ends are numbers of beads.
    """
    spread = molecules - molecules.mean(axis=2, keepdims=True)
    across = molecules[:, :, ends[-1]] - molecules[:, :, ends[0]]
    gyration = (spread**2).sum(axis=0).mean()
    return float(gyration), float((across**2).sum(axis=0).mean())


def ends_square(ends: np.ndarray) -> float:
    """Mean squared distance of all pairs of ends, a (dimension, molecules, n) array."""
    # It is twice that from their common centre, times n / (n - 1).
    n = ends.shape[2]
    spread = ends - ends.mean(axis=2, keepdims=True)
    return float((spread**2).sum(axis=0).mean() * 2 * n / (n - 1))
