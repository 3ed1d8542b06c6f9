"""The soft repulsion of dissipative particle dynamics.

Two beads closer than the cutoff, r < 1, push each other apart (Groot and Warren 1997, Eq. 3):

    u(r)   =  a_ij (1 - r)^2 / 2        energy
    F(r)   =  a_ij (1 - r)              force, -u'
    u''(r) =  a_ij                      curvature

The methods are given w = max(0, 1 - r) as well, which is zero from the cutoff on.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from dpd.page import PairTable, Refusals, Term, check_table, setting


class SoftRepulsion(Term, key="repulsion"):
    """Largest repulsion a_ij for every pair of species, 'A B' for both orders.

    With `many_body` it may be below 0, an attraction.
    """

    caption = None
    bare = "pairs"
    not_in_lammps = ""  # the pair style of the thermostat has it
    pairs: PairTable[Annotated[float, Field(ge=-1e6, le=1e6)]] = setting(
        "Largest repulsion a_ij.", unit="kT / r_c"
    )

    def repulsions(self, scene: Any) -> dict[str, float]:
        return self.pairs

    def unknown(self, scene: Any) -> Refusals:
        yield from check_table(scene.repulsions, scene, scene.pairs, 25)

    def refuses(self, scene: Any) -> Refusals:
        for pair, value in self.pairs.items():
            if value < 0 and not any(term.keeps_apart for term in scene.terms.values()):
                allowed = "allowed: >= 0, or any number with 'many_body'"
                yield pair, f"{value:g} draws beads onto each other; {allowed}"


class Soft(NamedTuple):
    repulsion: np.ndarray  # (species, species): a_ij in kT / r_c

    def force(self, a: float, r: float, w: float) -> float:
        """Force F at distance r, for a pair with the repulsion a."""
        return a * w

    def energy(self, a: float, r: float, w: float) -> float:
        return 0.5 * a * w * w

    def curvature(self, a: float, r: float, w: float) -> float:
        return a
