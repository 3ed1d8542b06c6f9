"""Harmonic angles between two bonds that share a bead.

With theta the angle between the bonds from the middle bead to the other two (pi for a straight
chain), as most models of surfactants and lipids have it:

u(theta)   =  k (theta - theta_0)^2 / 2
F(theta)   = -k (theta - theta_0), which opens the angle where it is positive
u''(theta) =  k
"""

from typing import NamedTuple


class Angle(NamedTuple):
    """A harmonic angle, or a table of several.

    Attributes
    ----------
    stiffness, angle : float; in a table (laws,) arrays
        k in kT / rad^2, and the angle theta_0 at rest in radians.
    """

    stiffness: float
    angle: float

    def force(self, theta: float) -> float:
        """Minus the derivative of the energy by the angle, in kT / rad."""
        return -self.stiffness * (theta - self.angle)

    def energy(self, theta: float) -> float:
        """Energy u."""
        return 0.5 * self.stiffness * (theta - self.angle) ** 2

    def curvature(self, theta: float) -> float:
        """Second derivative u''."""
        return self.stiffness
