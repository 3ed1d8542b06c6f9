from typing import Any

import numpy as np

from dpd.observe.displacement import centres, displacements, followed
from dpd.page import Change, Observable


class Diffusion(Observable, key="diffusion"):
    """D(t) = <|r(t) - r(0)|^2> / (2 dimension t) of beads of each species, and of molecules.

    Displacements are those since the first sample, relative to the centre of mass of all beads; of
    a molecule, that of its centre of mass. D(t) tends to the diffusion coefficient where chains
    have moved their own size. For an error, see the observable ``displacement``.
    """

    stands = frozenset(Change) - {Change.VARIES}
    interval, cost, from_first = 1.2, 5.0, True
    gives = {
        "diffusion_bead": (("sample", "species"), "r_c^2 / tau", "D(t) of beads"),
        "diffusion_molecule": (("sample", "kind"), "r_c^2 / tau", "D(t) of centres of molecules"),
    }

    def keeps(self, scene: Any) -> Any:
        return followed(scene)

    def measure(self, now: Any) -> Any:
        moved, scene = displacements(now), now.scene
        kinds = np.repeat(np.arange(len(scene.molecules)), [k.count for k in scene.molecules])
        over = 2 * now.dimension * now.scene.dt * self.every * max(now.sample, 1)
        return {
            "diffusion_bead": _mean_squares(moved, scene.kinds.astype(np.int64)) / over,
            "diffusion_molecule": _mean_squares(centres(now, moved), kinds) / over,
        }

    def finish(self, scene: Any, found: dict[str, Any]) -> Any:
        for series in found.values():
            series[0] = np.nan
        return found


def _mean_squares(moved, kinds):
    """Mean squared displacement of each kind, by the number of the kind of each."""
    return np.bincount(kinds, (moved**2).sum(axis=0)) / np.bincount(kinds)
