"""Morse bonds, which weaken as they get long (Morse 1929).

With e = exp(-alpha (r - l)):

u(r)   =  D (1 - e)^2
F(r)   = -2 alpha D (1 - e) e
u''(r) =  2 alpha^2 D (2 e - 1) e
"""

import math
from typing import Any

from dpd.page import BondForce, PerPair, Positive, part, setting


@part
def decay(alpha: float, length: float, r: float) -> float:
    """How far the energy has come of its last value, which is 1 at rest and 0 far away."""
    return math.exp(-alpha * (r - length))


class MorseBonds(BondForce, key="morse_bond"):
    """Morse bonds, which near rest are harmonic with the stiffness 2 depth alpha^2."""

    depth: PerPair[Positive] = setting("Energy D of a bond that is torn.", unit="kT")
    alpha: PerPair[Positive] = setting("Steepness alpha.", unit="1 / r_c")
    length: PerPair[Positive] = setting("Rest length l.", unit="r_c")

    def force(self: Any, r: float) -> float:
        e = decay(self.alpha, self.length, r)
        return -2.0 * self.alpha * self.depth * (1.0 - e) * e

    def energy(self: Any, r: float) -> float:
        return self.depth * (1.0 - decay(self.alpha, self.length, r)) ** 2

    def curvature(self: Any, r: float) -> float:
        e = decay(self.alpha, self.length, r)
        return 2.0 * self.alpha**2 * self.depth * (2.0 * e - 1.0) * e

    def at_rest(self: Any) -> float:
        return self.length
