"""Harmonic bonds (Groot and Warren 1997, Eq. 25; with a rest length, Nikunen et al. 2007, Eq. 5).

u(r)   =  C (r - l)^2 / 2
F(r)   = -C (r - l)
u''(r) =  C
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dpd.jit import inlined, method

# What a kernel calls with a law or a table of laws.
force_over_r, energy, curvature = map(method, ("force_over_r", "energy", "curvature"))


class Bond(NamedTuple):
    """A harmonic bond: one law for all bonds, whatever their number.

    Attributes
    ----------
    stiffness, length : float
        C in kT / r_c^2, and the rest length l in r_c.
    """

    stiffness: float
    length: float

    def force_over_r(self, r: float, bond: int = 0) -> float:
        """Force over distance, F / r."""
        return -self.stiffness * (1.0 - self.length / r)

    def energy(self, r: float, bond: int = 0) -> float:
        """Energy u."""
        return 0.5 * self.stiffness * (r - self.length) ** 2

    def curvature(self, r: float, bond: int = 0) -> float:
        """Second derivative u''."""
        return self.stiffness


class BondTable(NamedTuple):
    """Harmonic bonds of several kinds.

    Attributes
    ----------
    stiffness, length : (laws,) arrays
        As `Bond` has them.
    number : (bonds,) uint16 array
        The place of each bond's law.
    """

    stiffness: np.ndarray
    length: np.ndarray
    number: np.ndarray

    def force_over_r(self, r: float, bond: int) -> float:
        """Force over distance of a bond."""
        return force_over_r(law_of(self, bond), r)

    def energy(self, r: float, bond: int) -> float:
        """Energy of a bond."""
        return energy(law_of(self, bond), r)

    def curvature(self, r: float, bond: int) -> float:
        """Second derivative of the energy of a bond."""
        return curvature(law_of(self, bond), r)


@inlined()
def law_of(table, bond):
    """The law of a bond in a table."""
    number = table.number[bond]
    return Bond(table.stiffness[number], table.length[number])
