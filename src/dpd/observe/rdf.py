"""Radial distribution function."""

from typing import Any

import numpy as np

from dpd.errors import UserError
from dpd.observe.common.bins import middles
from dpd.page import Change, Observable, Refusals, once, setting


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
    gives = {
        "rdf": (("block", "r"), "1", "radial distribution function g(r) in blocks of the run"),
    }

    range: float = setting(
        "Largest distance, at most half the smallest edge.", 3.0, unit="r_c", gt=0
    )
    bin: float = setting("Bin width.", 0.02, unit="r_c", ge=0.0001, le=1)

    def bins(self) -> np.ndarray:
        return np.linspace(0.0, self.range, max(1, round(self.range / self.bin)) + 1)

    def axes(self, scene: Any) -> Any:
        return {"r": (middles(self.bins()), "r_c", "distance")}

    def refuses(self, scene: Any) -> Refusals:
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

    @once
    def ideal(self, scene: Any) -> np.ndarray:
        """(bins,) array: pairs of an ideal gas in each shell, times the volume."""
        ball = {2: np.pi, 3: 4.0 * np.pi / 3.0}[scene.dimension] * self.bins() ** scene.dimension
        return scene.beads * (scene.beads - 1) / 2 * np.diff(ball)

    def measure(self, now: Any) -> Any:
        from dpd.engine.queries.pairs import pair_histogram

        smallest, ideal = min(now.box), self.ideal(now.scene)
        if self.range > smallest / 2:
            raise UserError(
                f"observe.rdf.range: {self.range:g} is more than half the smallest edge of the "
                f"box, which has become {smallest:.4g} at step {now.step}; take a shorter range"
            )
        return pair_histogram(now.state.position, now.lattice, self.range, len(ideal)) * (
            now.volume / ideal
        )
