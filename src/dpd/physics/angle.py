"""Harmonic angles between two bonds that share a bead.

With theta the angle between the bonds from the middle bead to the other two (pi for a straight
chain), as most models of surfactants and lipids have it:

u(theta)   =  k (theta - theta_0)^2 / 2
F(theta)   = -k (theta - theta_0), which opens the angle where it is positive
u''(theta) =  k
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from dpd.page import OneOrTable, Refusals, Section, Term, Triple, check_laws, setting

if TYPE_CHECKING:
    import numpy as np


class AngleLaw(Section):
    """A harmonic angle."""

    stiffness: float = setting("Stiffness k.", unit="kT / rad^2", ge=0, le=1e7)
    angle: float = setting("Angle at rest in degrees; 180 is straight.", 180.0, ge=0, le=180)


class HarmonicAngles(Term, key="angle"):
    """Harmonic angles between bonds that share a bead; their energy counts in bond_energy.

    The energy is stiffness times (theta - angle)^2 / 2. One law for all, {stiffness: 5, angle:
    180}, or a law for each triple of species, {A A A: {stiffness: 5}}; triples that are not named
    feel none.
    """

    bare = "law"
    law: OneOrTable[AngleLaw, Triple] = setting("One law, or one for each three species.")

    def untried(self) -> str:
        """Without angles is how schemes were measured."""
        return "schemes were measured without angles; take gw-vv and a dt of 0.02 or less"

    def refuses(self, scene: Any) -> Refusals:
        """Angles that no molecule has."""
        if not any(len(kind.triples) for kind in scene.molecules):
            yield "", "no molecule has three beads in a row; remove the key"
        if isinstance(self.law, dict):
            yield from check_laws(self.law, scene.angled_species)


class Angle(NamedTuple):
    """A harmonic angle.

    Attributes
    ----------
    stiffness, angle : float, or (laws,) arrays
        k in kT / rad^2, and the angle theta_0 at rest in radians; of all laws where there are
        several.
    number : None or (angles,) uint16 array
        The place of each angle's law, where there are several.
    """

    stiffness: Any
    angle: Any
    number: np.ndarray | None = None

    def force(self, theta: float) -> Any:
        """Minus the derivative of the energy by the angle, in kT / rad."""
        return -self.stiffness * (theta - self.angle)

    def energy(self, theta: float) -> Any:
        """Energy u."""
        return 0.5 * self.stiffness * (theta - self.angle) ** 2

    def curvature(self, theta: float) -> Any:
        """Second derivative u''."""
        return self.stiffness
