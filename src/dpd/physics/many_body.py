"""Many-body forces: beads are pushed apart the more, the more crowded they are (Warren 2003).

Beside the force of pairs, which may then attract, there is an energy of each bead that goes with
its local density (Phys. Rev. E 68, 066702; here x = 1 - r / r_d):

    rho_i   =  sum over j of w(r_ij),     w(r) = N x^2 for r < r_d, whose integral is 1
    U       =  c sum over i of rho_i^2,   c = B r_d / (4 N), in 3D pi r_d^4 B / 30
    F(r)    =  B (rho_i + rho_j) x        force of a pair, -dU/dr

The sum of rho_i^2 is that of w (rho_i + rho_j) over pairs, so the energy is one of pairs as well.
With another B for each pair of species there would be none (Phys. Rev. E 87, 045303, 2013).
"""

import math
from typing import Any, NamedTuple

from dpd.page import Positive, Term, setting

NORM = {2: 6 / math.pi, 3: 15 / (2 * math.pi)}  # N r_d^d


class ManyBodyForces(Term, key="many_body"):
    """Forces that grow with the density around beads, beside a repulsion that may be negative.

    An attraction, a repulsion of pairs below 0, then makes a liquid with a free surface (Warren
    2003): -40 and 25 one of density 6.07 and surface tension 7.6. Take a dt of 0.01 or less.
    """

    caption = "many-body forces of B = {repulsion}, r_d = {range} r_c"
    in_start = True
    keeps_apart = True
    untried = "schemes were measured without many-body forces; take gw-vv and dt 0.01"
    repulsion: Positive = setting(
        "B, the same for all pairs of species, whose force is B (rho_i + rho_j) (1 - r / range), "
        "with the local densities rho of the two beads.", unit="kT r_c^(dimension - 1)",
    )  # fmt: skip
    range: float = setting(
        "r_d, within which beads count in the local density.", 0.75, unit="r_c", gt=0, le=1
    )

    def records(self, scene: Any) -> dict[str, Any]:
        norm = NORM[scene.dimension] / self.range**scene.dimension
        return {"many_body": ManyBody(float(self.repulsion), float(self.range), norm)}


class ManyBody(NamedTuple):
    """Many-body forces; methods for a pair take rho_i + rho_j, the crowd."""

    repulsion: float  # B
    range: float  # r_d
    norm: float  # N

    def weight(self, r: float) -> float:
        """What beads at distance r add to each other's density."""
        x = max(0.0, 1.0 - r / self.range)
        return self.norm * x * x

    def energy(self, crowd: float, r: float) -> float:
        """The part of a pair in the energy."""
        x = max(0.0, 1.0 - r / self.range)
        return 0.25 * self.repulsion * self.range * crowd * x * x

    def force(self, crowd: float, r: float) -> float:
        return self.repulsion * crowd * max(0.0, 1.0 - r / self.range)

    def curvature(self, crowd: float, r: float) -> float:
        """Minus the slope of the force at a constant crowd."""
        return self.repulsion * crowd / self.range if r < self.range else 0.0

    def slope(self, r: float) -> float:
        """The root of 2 c times the slope of the weight.

        The Laplacian of U has the square of the gradient of each rho_i, by each bead, times 2 c.
        """
        steep = 2.0 * self.norm * self.repulsion / self.range
        return math.sqrt(steep) * max(0.0, 1.0 - r / self.range)
