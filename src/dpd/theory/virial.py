"""Second virial coefficient of the soft repulsion u(r) = a (1 - r)^2 / 2, and mean field."""

import numpy as np
from scipy.special import erf

# Pressure coefficient alpha when g(r) = 1: -1/(2 d) times the integral of r u'(r) / a.
MEAN_FIELD = {2: np.pi / 24.0, 3: np.pi / 30.0}


def second_virial(repulsion, dimension=3, kT=1.0):
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
