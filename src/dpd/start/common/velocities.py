"""First velocities."""

import numpy as np


def thermal_velocities(
    shape: tuple[int, ...], kT: float, rng: np.random.Generator, mass: float | np.ndarray = 1.0
) -> np.ndarray:
    """Maxwellian velocities in r_c / tau, at rest as a whole.

    Parameters
    ----------
    shape : (int, int)
        Dimension and beads.
    kT : float
    rng : numpy.random.Generator
    mass : float or (n,) array
        Of all beads, or of each.

    Returns
    -------
    (dimension, n) array
    """
    velocity = rng.normal(scale=np.sqrt(kT / mass), size=shape)
    weights = mass if np.ndim(mass) else None
    return velocity - np.average(velocity, axis=1, weights=weights, keepdims=True)
