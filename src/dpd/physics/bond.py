"""Harmonic bonds (Groot and Warren 1997, Eq. 25; with a rest length, Nikunen et al. 2007, Eq. 5).

u(r)   =  C (r - l)^2 / 2
F(r)   = -C (r - l)
u''(r) =  C
"""

from typing import NamedTuple


class Bond(NamedTuple):
    """A harmonic bond, or a table of several.

    Attributes
    ----------
    stiffness, length : float; in a table (laws,) arrays
        C in kT / r_c^2, and the rest length l in r_c.
    """

    stiffness: float
    length: float

    def force_over_r(self, r: float) -> float:
        """Force over distance, F / r."""
        return -self.stiffness * (1.0 - self.length / r)

    def energy(self, r: float) -> float:
        """Energy u."""
        return 0.5 * self.stiffness * (r - self.length) ** 2

    def curvature(self, r: float) -> float:
        """Second derivative u''."""
        return self.stiffness
