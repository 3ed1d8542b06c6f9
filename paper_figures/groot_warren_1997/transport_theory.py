"""Closed forms of diffusion and viscosity.

The theory of the DPD fluid without conservative forces is that of Marsh, Backx and Ernst, as Groot
and Warren (1997) have it in Sec. VII and in their appendix, for w = 1 - r and beads of mass 1.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

SUM_OF_IMAGES = 2.837297  # of a cubic lattice of point forces (Yeh and Hummer 2004)


def diffusion_constant(gamma: npt.ArrayLike, density: float, kT: float = 1.0) -> np.ndarray:
    """D = 45 kT / (2 pi gamma rho) in r_c^2 / tau.

    ``gamma``: friction in m / tau. ``density``: rho in 1 / r_c^3.
    """
    return 45 * kT / (2 * math.pi * np.asarray(gamma, dtype=float) * density)


def kinematic_viscosity(gamma: npt.ArrayLike, density: float, kT: float = 1.0) -> np.ndarray:
    """nu = D / 2 + 2 pi gamma rho / 1575 in r_c^2 / tau.

    The first part is momentum that beads carry along, the second one is that of the friction.

    ``gamma``, ``density``, ``kT``: as for `diffusion_constant`.
    """
    of_friction = 2 * math.pi * np.asarray(gamma, dtype=float) * density / 1575
    return diffusion_constant(gamma, density, kT) / 2 + of_friction


def schmidt_number(gamma: npt.ArrayLike, density: float, kT: float = 1.0) -> np.ndarray:
    """Sc = nu / D, Eq. 37 of Groot and Warren 1997.

    ``gamma``, ``density``, ``kT``: as for `diffusion_constant`.
    """
    return kinematic_viscosity(gamma, density, kT) / diffusion_constant(gamma, density, kT)


def slowed_by_images(
    edge: npt.ArrayLike, density: float, viscosity: npt.ArrayLike, diffusion: npt.ArrayLike,
    kT: float = 1.0,
) -> np.ndarray:  # fmt: skip
    """By how much D of a bead is smaller in a periodic cube than in an infinite box.

    A bead drags the fluid along, and with it its own images: D is smaller by

        2.837 kT / (6 pi rho (nu + D) L)

    The usual form has nu alone in the place of nu + D (Duenweg and Kremer 1993, Yeh and Hummer
    2004). It is for liquids in which momentum spreads much faster than beads do. Here both spread
    at about the same rate, and a bead leaves the flow that it has set up while this flow fades:
    then the sum of both counts, as in the long tail of the velocity autocorrelation (Ernst, Hauge
    and van Leeuwen 1970; Donev, Bell, de la Fuente and Garcia 2011).

    ``edge``: L in r_c. ``density``: rho in 1 / r_c^3. ``viscosity``: kinematic viscosity nu in
    r_c^2 / tau. ``diffusion``: D in r_c^2 / tau. Result: in r_c^2 / tau.
    """
    spreading = np.asarray(viscosity, dtype=float) + np.asarray(diffusion, dtype=float)
    length = np.asarray(edge, dtype=float)
    return SUM_OF_IMAGES * kT / (6 * math.pi * density * spreading * length)
