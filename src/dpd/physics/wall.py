"""Soft walls: planes that push beads away, and the friction of beads with them.

A bead at the distance z < 1 from a plane feels the pair force of Groot and Warren 1997 (Eq. 4),
with the plane in the place of the other bead:

    u(z)   =  a_w (1 - z)^2 / 2        energy
    F(z)   =  a_w (1 - z)              force along the normal into the box, -u'
    u''(z) =  a_w                      curvature

Behind the plane, at z < 0, the same line goes on, so the deeper a bead gets the harder it is
pushed back. A wall with friction also takes hold of the velocity v of a bead, in all directions
and with the noise that belongs to it, with w = 1 - z (and w = 1 behind the plane):

    F = -gamma w^2 (v - v_wall) + sigma w zeta dt^(-1/2),     sigma^2 = 2 gamma kT
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class WallFriction(NamedTuple):
    """Friction and noise between beads and walls.

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

    def random(self, zeta: float, w: float) -> float:
        """Noise along an axis."""
        return self.amplitude * w * zeta

    def drag(self, velocity: float, w: float) -> float:
        """Friction along an axis at a velocity relative to the wall; the force takes it off."""
        return self.gamma * w * w * velocity


class Walls(NamedTuple):
    """Planes at both ends of some axes: of each axis the lower one, then the upper one.

    Attributes
    ----------
    repulsion : (species,) array
        a_w in kT / r_c.
    axis : (walls,) int64 array
        The axis that each plane is normal to.
    place : (walls,) array
        Where the plane is on that axis, in r_c.
    inward : (walls,) array
        1.0 for a lower plane, whose beads are above it; -1.0 for an upper one.
    velocity : (walls, dimension) array
        Of the wall, in r_c / tau.
    reach : float
        How far behind a plane a bead may get, in r_c. The box has room for that and a cutoff
        more, so that beads behind opposite planes never feel each other.
    friction : WallFriction or None
    """

    repulsion: np.ndarray
    axis: np.ndarray
    place: np.ndarray
    inward: np.ndarray
    velocity: np.ndarray
    reach: float
    friction: WallFriction | None = None

    def force(self, a: float, z: float) -> float:
        """Force F at the distance z, for a bead with the repulsion a."""
        return a * max(0.0, 1.0 - z)

    def energy(self, a: float, z: float) -> float:
        """Energy u."""
        return 0.5 * a * max(0.0, 1.0 - z) ** 2

    def curvature(self, a: float, z: float) -> float:
        """Second derivative u''."""
        return a if z < 1.0 else 0.0

    def weight(self, z: float) -> float:
        """The weight w of the friction."""
        return min(1.0, max(0.0, 1.0 - z))
