"""Harmonic angles between two bonds that share a bead.

With theta the angle between the bonds from the middle bead to the other two (pi for a straight
chain), as most models of surfactants and lipids have it:

u(theta)   =  k (theta - theta_0)^2 / 2
F(theta)   = -k (theta - theta_0), which opens the angle where it is positive
u''(theta) =  k
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dpd.jit import inlined, method

# What a kernel calls with a law or a table of laws.
force, energy, curvature = map(method, ("force", "energy", "curvature"))


class Angle(NamedTuple):
    """A harmonic angle: one law for all angles, whatever their number.

    Attributes
    ----------
    stiffness, angle : float
        k in kT / rad^2, and the angle theta_0 at rest in radians.
    """

    stiffness: float
    angle: float

    def force(self, theta: float, place: int = 0) -> float:
        """Minus the derivative of the energy by the angle, in kT / rad."""
        return -self.stiffness * (theta - self.angle)

    def energy(self, theta: float, place: int = 0) -> float:
        """Energy u."""
        return 0.5 * self.stiffness * (theta - self.angle) ** 2

    def curvature(self, theta: float, place: int = 0) -> float:
        """Second derivative u''."""
        return self.stiffness


class AngleTable(NamedTuple):
    """Harmonic angles of several kinds.

    Attributes
    ----------
    stiffness, angle : (laws,) arrays
        As `Angle` has them.
    number : (angles,) uint16 array
        The place of each angle's law.
    """

    stiffness: np.ndarray
    angle: np.ndarray
    number: np.ndarray

    def force(self, theta: float, place: int) -> float:
        """Minus the derivative of the energy of an angle."""
        return force(law_of(self, place), theta)

    def energy(self, theta: float, place: int) -> float:
        """Energy of an angle."""
        return energy(law_of(self, place), theta)

    def curvature(self, theta: float, place: int) -> float:
        """Second derivative of the energy of an angle."""
        return curvature(law_of(self, place), theta)


@inlined()
def law_of(table, place):
    """The law of an angle in a table."""
    number = table.number[place]
    return Angle(table.stiffness[number], table.angle[number])
