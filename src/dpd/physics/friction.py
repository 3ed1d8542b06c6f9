"""Friction and noise between pairs, the thermostat of dissipative particle dynamics.

Along the line e between two beads that approach each other with e . v_ij (Groot and Warren 1997,
Eqs. 5, 6 and 8), with w = 1 - r and random numbers theta of zero mean and unit variance:

    F_D = -gamma w^2 (e . v_ij)
    F_R =  sigma w theta dt^(-1/2),     sigma^2 = 2 gamma kT

The two belong together: with that sigma they hold the temperature kT, and since they act on both
beads of a pair they conserve momentum.
"""

from typing import NamedTuple


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
    """

    gamma: float
    amplitude: float
    gaussian: bool

    def force(self, approach: float, inverse: float, w: float, theta: float) -> float:
        """Force F_D + F_R on a pair with r . v_ij = approach and 1 / r = inverse."""
        drag = self.gamma * w * approach * inverse
        return w * (self.amplitude * theta - drag)
