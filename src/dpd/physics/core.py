"""A rigid core inside the soft repulsion.

Below the diameter d = 2 r_s the force between two beads is a constant, F_max (Liu et al. 2008,
Eq. 5); beyond it there is the soft repulsion:

    F(r)   =  F_max          r < d
           =  a_ij (1 - r)   d <= r < 1

The force jumps at d. With a width it goes over from F_max into the soft repulsion along a straight
line from d to d + width, so that schemes of second order keep their order.
"""

from typing import NamedTuple

import numpy as np

from dpd.jit import inlined


class Core(NamedTuple):
    """A rigid core and the soft repulsion around it.

    Attributes
    ----------
    repulsion : (species, species) array
        a_ij in kT / r_c.
    diameter, push : float
        2 r_s in r_c, and F_max in kT / r_c.
    width : float or None
        Of the straight line, in r_c; None for a jump.
    """

    repulsion: np.ndarray
    diameter: float
    push: float
    width: float | None = None

    def force(self, a: float, r: float, w: float) -> float:
        """Force F at distance r, for a pair with the repulsion a; w = max(0, 1 - r)."""
        return self.push if r < self.diameter else force_beyond(self, a, r, w, self.width)

    def energy(self, a: float, r: float, w: float) -> float:
        """Energy u, continuous at the core and zero from the cutoff on."""
        if r < self.diameter:
            edge = energy_beyond(self, a, self.diameter, 1.0 - self.diameter, self.width)
            return self.push * (self.diameter - r) + edge
        return energy_beyond(self, a, r, w, self.width)


@inlined()
def force_beyond(core, a, r, w, width):
    """The force from the diameter on."""
    if width is None:
        return a * w
    outer = a * (1.0 - core.diameter - width)
    slope = (outer - core.push) / width
    return core.push + slope * (r - core.diameter) if r < core.diameter + width else a * w


@inlined()
def energy_beyond(core, a, r, w, width):
    """The energy from the diameter on."""
    if width is None:
        return 0.5 * a * w * w
    left = core.diameter + width - r
    if left <= 0.0:
        return 0.5 * a * w * w
    outer = a * (1.0 - core.diameter - width)
    here = force_beyond(core, a, r, w, width)
    return 0.5 * (here + outer) * left + 0.5 * a * (1.0 - core.diameter - width) ** 2
