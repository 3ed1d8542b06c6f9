"""Bonds that cannot be longer than R: finitely extensible nonlinear elastic ones.

Kremer and Grest 1990, Eq. 2, without the repulsion of their beads, which is that of the scene here:

u(r) = -k R^2 / 2 ln(1 - (r / R)^2)
F(r) = -k r / (1 - (r / R)^2)

Near R both go on along a straight line from a force of about k R / (2 `END`), which no bond stands.
"""

import math
from typing import Any

from dpd.page import BondForce, PerPair, Positive, part, setting

END = 1e-8  # 1 - r / R


@part
def within(r: float, longest: float) -> float:
    """The length, or the longest for which the formulas hold."""
    return min(r, (1.0 - END) * longest)


class Fene(BondForce, key="fene"):
    """Bonds that get no longer than a length (FENE), without the repulsion of other models."""

    stiffness: PerPair[Positive] = setting("Spring constant k of short bonds.", unit="kT / r_c^2")
    length: PerPair[Positive] = setting("The length R that no bond reaches.", unit="r_c")

    def force(self: Any, r: float) -> float:
        r = within(r, self.length)
        return -self.stiffness * r / (1.0 - (r / self.length) ** 2)

    def energy(self: Any, r: float) -> float:
        short, square = within(r, self.length), self.length**2
        energy = -0.5 * self.stiffness * square * math.log(1.0 - short * short / square)
        return energy + self.stiffness * short / (1.0 - short * short / square) * (r - short)

    def curvature(self: Any, r: float) -> float:
        square = (within(r, self.length) / self.length) ** 2
        return self.stiffness * (1.0 + square) / (1.0 - square) ** 2

    def at_rest(self: Any) -> float:
        """As far as beads like to be apart, but well within R: that of least energy is 0."""
        return min(0.8, 0.5 * self.length)
