"""Friction and noise as exchanges of momentum, for schemes that split them off the forces.

Each pair's relative velocity u = e . v_ij along its line is advanced by a step on its own, while
the pair stands still. With g = gamma w^2 dt and a random number theta of unit variance it becomes

    Shardlow (2003), half explicit and half implicit:
        u' = (u - g u + 2 sqrt(2 kT g) theta) / (1 + g)
    exact, as the Ornstein-Uhlenbeck process that it is (Serrano, De Fabritiis, Espanol and
    Coveney 2006):
        u' = u exp(-2 g) + sqrt(2 kT (1 - exp(-4 g))) theta
    Lowe (1999), with probability gamma dt:
        u' = sqrt(2 kT) theta

and half of the change goes to each bead. At rest u has the variance 2 kT.

This is for masses of 1. Two beads with the reduced mass mu exchange the momentum mu (u' - u), and
u / s, with s = 1 / sqrt(2 mu), follows the same equations with g / (2 mu) in the place of g.
"""

from typing import NamedTuple

import numpy as np

SHARDLOW, EXACT, LOWE = 0, 1, 2


class Exchange(NamedTuple):
    """Exchange of momentum between pairs."""

    kind: int  # `SHARDLOW`, `EXACT` or `LOWE`
    # friction, or for Lowe's the rate of exchanges in 1 / tau; and temperature
    gamma: float
    kT: float
    # Gaussian instead of uniform random numbers, for Shardlow's; the others always take Gaussian
    # ones, without which they are not exact
    gaussian: bool
    # (species, species): gamma_ij / gamma where pairs of species differ
    shares: np.ndarray | None = None

    def change(self, u: float, g: float, theta: float, drawn: bool) -> float:
        """Change of a relative velocity u; ``drawn`` says whether Lowe's pair is due."""
        if self.kind == SHARDLOW:
            push = np.sqrt(2.0 * self.kT * g) * theta
            return (u - g * u + 2.0 * push) / (1.0 + g) - u
        if self.kind == EXACT:
            decay = np.exp(-2.0 * g)
            return u * decay + np.sqrt(2.0 * self.kT * (1.0 - decay * decay)) * theta - u
        return np.sqrt(2.0 * self.kT) * theta - u if drawn else 0.0
