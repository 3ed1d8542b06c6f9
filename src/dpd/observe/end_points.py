"""How far apart the ends of molecules are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.chains import in_one_piece
from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable, Refusals, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene

MOST_PAIRS = 10**7  # of ends, in each sample: half a gigabyte


class EndPoints(Observable, key="end_points"):
    """Distribution of the end-to-end distance, for each kind of molecule.

    Of a branched molecule all pairs of ends count: of beads with a single bond. The integral of a
    distribution over the distance is 1, less the share beyond the range, which is kept beside it.
    """

    stands = frozenset(Change)
    needs_bonds, bins_of = True, "range"

    range: float = setting("End of the distribution.", 20.0, unit="r_c", gt=0, le=10000)
    bin: float = setting("Largest width of a bin.", 0.1, unit="r_c", ge=0.0001, le=10)

    def _start(self, scene: Scene, system: System) -> None:
        self._kinds = scene.molecules
        self._edges = np.linspace(0.0, self.range, int(np.ceil(self.range / self.bin)) + 1)
        # The last place holds the share beyond the range.
        shape = (len(self._kinds), len(self._edges))
        self.averages = BlockSums(shape)
        self.arrays = self.averages.arrays

    def refuses(self, scene: Scene) -> Refusals:
        """Too many pairs of ends."""
        pairs = sum(k.count * len(k.ends) * (len(k.ends) - 1) // 2 for k in scene.molecules)
        if pairs > MOST_PAIRS:
            yield (
                "",
                f"'end_points' would look at {pairs:.3g} pairs of ends of branched molecules; "
                f"allowed: <= {MOST_PAIRS}",
            )

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        state = simulation.state
        whole = in_one_piece(self._kinds, state.by_identity(state.position), simulation.box)
        found = np.zeros(self.arrays["sums"].shape[1:])
        for row, kind, beads in zip(found, self._kinds, whole):
            if len(kind.beads) > 1:
                one, other = np.triu_indices(len(kind.ends), 1)
                ends = beads[:, :, kind.ends]
                apart = np.sqrt(((ends[:, :, one] - ends[:, :, other]) ** 2).sum(axis=0))
                counts = np.histogram(apart, self._edges)[0]
                row[:-1] = counts / (apart.size * self._edges[1])
                row[-1] = 1 - counts.sum() / apart.size
        self.averages.add(found)

    def variables(self) -> Variables:
        """Distributions in blocks for the file; NaN for kinds that are single beads."""
        means = self.averages.means()
        means[:, [len(kind.beads) == 1 for kind in self._kinds]] = np.nan
        middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        return {
            "end_distance": (("end_distance",), middle, "r_c", "distance between two ends"),
            "end_density": (
                ("block", "kind", "end_distance"), means[..., :-1], "1 / r_c",
                "density of the distance between two ends of a molecule",
            ),
            "end_beyond": (
                ("block", "kind"), means[..., -1], "1", "share of distances beyond the range",
            ),
        }  # fmt: skip
