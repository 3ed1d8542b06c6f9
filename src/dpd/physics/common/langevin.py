"""Langevin friction and noise: a thermostat that acts on each bead on its own.

    F = -gamma v + sigma zeta dt^(-1/2),     sigma^2 = 2 gamma kT

along each axis. Each species may have a gamma of its own. The thermostat does not conserve
momentum: beside pair friction it tells what conserved momentum does to a system.
"""

from typing import NamedTuple

import numpy as np


class Langevin(NamedTuple):
    """Friction and noise on each bead."""

    gamma: float  # friction in kT tau / r_c^2
    amplitude: float  # sigma dt^(-1/2), in kT / r_c
    gaussian: bool  # Gaussian instead of uniform random numbers
    # (species,): gamma_i / gamma where species differ. The velocity then comes multiplied by the
    # share of its bead, and zeta by the root of that.
    shares: np.ndarray | None = None

    def random(self, zeta: float) -> float:
        return self.amplitude * zeta

    def drag(self, velocity: float) -> float:
        """Friction along an axis, which the force takes off."""
        return self.gamma * velocity
