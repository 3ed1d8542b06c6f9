"""Friction and noise between pairs, the thermostat of dissipative particle dynamics.

Along the line e between two beads that approach each other with e . v_ij (Groot and Warren 1997,
Eqs. 5, 6 and 8), with w = 1 - r and random numbers theta of zero mean and unit variance:

    F_D = -gamma w^2 (e . v_ij)
    F_R =  sigma w theta dt^(-1/2),     sigma^2 = 2 gamma kT

The two belong together: with that sigma they hold the temperature kT, and since they act on both
beads of a pair they conserve momentum. Where pairs of species differ in their friction, gamma and
sigma are those of the pair, gamma_ij = gamma_ji.
"""

from typing import NamedTuple

import numpy as np


class Friction(NamedTuple):
    """Friction and noise between pairs.

    Attributes
    ----------
    gamma : float
        Friction in kT tau / r_c^2.
    amplitude : float
        sigma dt^(-1/2), in kT / r_c.
    gaussian : bool
        Gaussian instead of uniform random numbers.
    shares : None or (species, species) array
        gamma_ij / gamma where pairs of species differ. The approach of a pair then comes multiplied
        by its share, and theta by the root of that.
    """

    gamma: float
    amplitude: float
    gaussian: bool
    shares: np.ndarray | None = None

    def force(self, approach: float, inverse: float, w: float, theta: float) -> float:
        """Force F_D + F_R on a pair with r . v_ij = approach and 1 / r = inverse."""
        drag = self.gamma * w * approach * inverse
        return w * (self.amplitude * theta - drag)
