"""Second virial coefficient of the soft repulsion u(r) = a (1 - r)^2 / 2, and mean field."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import quad
from scipy.special import erf

if TYPE_CHECKING:
    import numpy.typing as npt

# Pressure coefficient alpha when g(r) = 1: -1/(2 d) times the integral of r u'(r) / a.
MEAN_FIELD = {2: np.pi / 24.0, 3: np.pi / 30.0}


def second_virial(
    repulsion: npt.ArrayLike, dimension: int = 3, kT: float = 1.0
) -> float | np.ndarray:
    """B2 = -1/2 times the integral of exp(-u/kT) - 1 over space.

    Parameters
    ----------
    repulsion : float or array
        a in kT / r_c, > 0.
    dimension : int
        2 or 3.
    kT : float

    Returns
    -------
    float or array
        In r_c^dimension. Groot and Warren 1997, below Fig. 4, give B2 / a.
    """
    a = np.asarray(repulsion, dtype=float) / kT
    i0 = np.sqrt(np.pi / (2.0 * a)) * erf(np.sqrt(a / 2.0))
    i1 = (1.0 - np.exp(-a / 2.0)) / a
    if dimension == 2:
        return np.pi * (0.5 - (i0 - i1))
    i2 = (i0 - np.exp(-a / 2.0)) / a
    return 2.0 * np.pi * (1.0 / 3.0 - (i0 - 2.0 * i1 + i2))


def core_limits(repulsion: float, radius: float, force: float) -> tuple[float, float]:
    """B2 / a, and the pressure coefficient for g(r) = 1, of discs with rigid cores.

    The force is ``force`` below 2 ``radius`` and a (1 - r) from there on (Liu et al. 2008,
    Eq. 5), kT = 1, in two dimensions.

    Parameters
    ----------
    repulsion, radius, force : float

    Returns
    -------
    virial, mean_field : float
        In r_c^3; without a core B2 / a of `second_virial`, and pi / 24.
    """
    a, d = repulsion, 2.0 * radius

    def potential(r):
        if r < d:
            return force * (d - r) + 0.5 * a * (1.0 - d) ** 2
        return 0.5 * a * (1.0 - r) ** 2

    virial = sum(
        quad(lambda r: np.pi * r * -np.expm1(-potential(r)), low, high)[0]
        for low, high in ((0.0, d), (d, 1.0))
    )
    inside = force * d**3 / 3.0
    outside = a * ((1.0 - d**3) / 3.0 - (1.0 - d**4) / 4.0)
    return virial / a, 0.5 * np.pi * (inside + outside) / a
