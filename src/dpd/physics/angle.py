"""Harmonic angles between two bonds that share a bead.

With theta the angle between the bonds from the middle bead to the other two (pi for a straight
chain), as most models of surfactants and lipids have it:

u(theta)   =  k (theta - theta_0)^2 / 2
F(theta)   = -k (theta - theta_0), which opens the angle where it is positive
u''(theta) =  k
"""

from math import radians
from typing import Any

from dpd.page import BondedForce, OneOrTable, Section, Triple, setting


class Angle(Section):
    """A harmonic angle; in formulas and kernels the one at rest is in radians."""

    stiffness: float = setting("Stiffness k.", unit="kT / rad^2", ge=0, le=1e7)
    angle: float = setting("Angle at rest in degrees; 180 is straight.", 180.0, ge=0, le=180)

    def force(self, theta: float) -> Any:
        """Minus the derivative of the energy by the angle, in kT / rad."""
        return -self.stiffness * (theta - self.angle)

    def energy(self, theta: float) -> Any:
        return 0.5 * self.stiffness * (theta - self.angle) ** 2

    def curvature(self, theta: float) -> Any:
        return self.stiffness


class HarmonicAngles(BondedForce, key="angle"):
    """Harmonic angles between bonds that share a bead; their energy counts in bond_energy.

    The energy is stiffness times (theta - angle)^2 / 2. One law for all, {stiffness: 5, angle:
    180}, or a law for each triple of species, {A A A: {stiffness: 5}}; triples that are not named
    feel none.
    """

    caption = "angles of stiffness k = {stiffness} kT/rad^2, at rest at {angle} degrees"
    bare = "law"
    joins = 3
    usual = ""
    nowhere = "no molecule has three beads in a row; remove the key"
    untried = "schemes were measured without angles; take gw-vv and a dt of 0.02 or less"
    law: OneOrTable[Angle, Triple] = setting("One law, or one for each three species.")

    def laws(self, scene: Any) -> dict[str, Any]:
        laws = super().laws(scene).items()
        return {key: Angle(stiffness=law.stiffness, angle=radians(law.angle)) for key, law in laws}

    def lammps(self, scene: Any) -> list[str] | str:
        laws = enumerate(super().laws(scene).values(), 1)  # K (theta - theta_0)^2, in degrees
        coefficients = [f"angle_coeff {n} {law.stiffness / 2} {law.angle}" for n, law in laws]
        return ["angle_style harmonic", *coefficients]
