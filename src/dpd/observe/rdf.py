from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from dpd.errors import UserError
from dpd.observe.common.bins import Binned, species_pairs
from dpd.page import Change, Given, Refusals, once, setting

COST = 0.55  # steps of a run that the pairs within each range^dimension take as long as


class RadialDistribution(Binned, key="rdf"):
    """g(r) of all beads: the n_k pairs found in a shell over those of an ideal gas.

    With the volume v_k of a shell, g_k = n_k V / (v_k N (N - 1) / 2). Programs that have N^2 in
    place of N (N - 1) find less, by a factor 1 - 1/N. Bonded pairs count like any other.

    Of two species, N (N - 1) / 2 is N_A N_B, or N_A (N_A - 1) / 2 of one of them: these are the
    weights with which their mean is g(r). A species with a single bead has no g(r) of its own.
    """

    stands = frozenset(Change)
    cannot = {
        Change.ENDS: "compares with a fluid that is alike everywhere, which none is near a wall"
    }
    whole = round
    gives = {
        "rdf": (("block", "r"), "1", "radial distribution function g(r)"),
        "rdf_of_pair": (("block", "rdf_pair", "r"), "1", "g(r) of two species"),
    }

    range: float = setting(
        "Largest distance, at most half the smallest edge.", 3.0, unit="r_c", gt=0
    )
    bin: float = setting("Bin width.", 0.02, unit="r_c", ge=0.0001, le=1)
    species: bool = setting("Whether each pair of species has a g(r) too, `rdf_of_pair`.", False)

    def cost_in(self, scene: Any) -> float:
        return COST * float(self.range) ** scene.dimension

    def given(self, scene: Any) -> dict[str, Given]:
        found = super().given(scene)
        return found if self.species else {"rdf": found["rdf"]}

    def axes(self, scene: Any) -> Any:
        found = {"r": (self.middles(), "r_c", "distance")}
        if self.species:
            found["rdf_pair"] = species_pairs(scene, self.pairs(scene))
        return found

    def refuses(self, scene: Any) -> Refusals:
        room = min(min(scene.box) / 2, *scene.room)
        if scene.beads < 2:
            yield "", "'rdf' has nothing to measure: there is a single bead"
        if self.range > room:
            text = f"{self.range:g} is more than half the smallest edge, or than a shear allows"
            yield "range", f"{text}; allowed: <= {room:.4g}"

    @once
    def pairs(self, scene: Any) -> dict[tuple[int, int], float]:
        """How many pairs of beads each two species have, where they have any."""
        beads = np.bincount(scene.kinds)
        found = {
            (i, j): beads[i] * beads[j] if i != j else beads[i] * (beads[i] - 1) / 2
            for i, j in combinations_with_replacement(range(len(beads)), 2)
        }
        return {pair: count for pair, count in found.items() if count}

    def measure(self, now: Any) -> Any:
        from dpd.engine.measure import pair_histogram

        smallest, edges, scene = min(now.box), self.edges, now.scene
        if self.range > smallest / 2:
            raise UserError(
                f"observe.rdf.range: {self.range:g} is more than half the smallest edge of the "
                f"box, which has become {smallest:.4g} at step {now.step}; take a shorter range"
            )
        shells = np.diff({2: np.pi, 3: 4.0 * np.pi / 3.0}[scene.dimension] * edges**scene.dimension)
        kinds = now.state.species if self.species else None  # None: there is one species alone
        counts = pair_histogram(now.state.position, now.lattice, self.range, len(shells), kinds)
        each = [()] if kinds is None else self.pairs(scene)
        counts = np.array([counts[pair] for pair in each])
        all_pairs = now.beads * (now.beads - 1) / 2
        found = {"rdf": counts.sum(axis=0) * (now.volume / (all_pairs * shells))}
        if self.species:
            pairs = np.array(list(self.pairs(scene).values()))[:, None]
            found["rdf_of_pair"] = counts * (now.volume / (pairs * shells))
        return found
