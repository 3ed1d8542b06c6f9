"""Radial distribution function."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.errors import UserError
from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable, Refusals, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class RadialDistribution(Observable, key="rdf"):
    """g(r) of all beads: the n_k pairs found in a shell over those of an ideal gas.

    A shell of bin k holds the volume v_k between its two radii (4 pi r^3 / 3 in three
    dimensions, pi r^2 in two); N beads without interaction have N (N-1) / 2 v_k / V pairs
    there, which is what g(r) = 1 stands for:

        g_k = n_k V / (v_k N (N - 1) / 2)

    Programs that have N^2 in place of N (N - 1) find less, by a factor 1 - 1/N: 0.9 for ten beads.
    Bonded pairs count like any other. At constant pressure V is the volume at each sample.
    """

    stands = frozenset(Change)
    cannot = {
        Change.ENDS: "compares with a fluid that is alike everywhere, which none is near a wall"
    }
    bins_of = "range"

    range: float = setting(
        "Largest distance, at most half the smallest edge.", 3.0, unit="r_c", gt=0
    )
    bin: float = setting("Bin width.", 0.02, unit="r_c", ge=0.0001, le=1)

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        bins = max(1, round(self.range / self.bin))
        self._edges = np.linspace(0.0, self.range, bins + 1)
        self.averages = BlockSums((bins,))
        self.arrays = self.averages.arrays
        self._beads = scene.beads

    def refuses(self, scene: Scene) -> Refusals:
        """A single bead, and distances at which one meets images."""
        farthest, half = self.range, min(scene.box) / 2
        room = min(half, *scene.room)
        if scene.beads < 2:
            yield "", "'rdf' has nothing to measure: there is a single bead"
        if farthest > half:
            text = f"{farthest:g} is more than half the smallest edge; allowed: <= {half:g}"
            yield "range", text
        elif farthest > room:
            yield (
                "range",
                f"{farthest:g} reaches further than images under shear allow; allowed: <= "
                f"{room:.4g}",
            )

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.queries.pairs import pair_histogram

        box, farthest = simulation.box, self._edges[-1]
        if farthest > min(box) / 2:
            raise UserError(
                f"observe.rdf.range: {farthest:g} is more than half the smallest edge of the box, "
                f"which has become {min(box):.4g} at step {simulation.state.step}; take a shorter "
                "range"
            )
        counts = pair_histogram(simulation.state.position, box, farthest, len(self._edges) - 1)
        self.averages.add(counts * (simulation.volume / self._system.volume))

    def variables(self) -> Variables:
        """g(r) in blocks for the file."""
        d = self._system.dimension
        ball = {2: np.pi, 3: 4.0 * np.pi / 3.0}[d] * self._edges**d
        pairs = self._beads * (self._beads - 1) / 2
        ideal = pairs * np.diff(ball) / self._system.volume
        middle = 0.5 * (self._edges[1:] + self._edges[:-1])
        return {
            "r": (("r",), middle, "r_c", "distance"),
            "rdf": (
                ("block", "r"), self.averages.means() / ideal, "1",
                "radial distribution function g(r) in blocks of the run",
            ),
        }  # fmt: skip
