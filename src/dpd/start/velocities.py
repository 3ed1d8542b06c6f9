"""First velocities."""

import numpy as np


def thermal_velocities(shape: tuple[int, ...], kT: float, rng: np.random.Generator) -> np.ndarray:
    """Maxwellian velocities in r_c / tau, at rest as a whole.

    Parameters
    ----------
    shape : (int, int)
        Dimension and beads.
    kT : float
    rng : numpy.random.Generator

    Returns
    -------
    (dimension, n) array
    """
    velocity = rng.normal(scale=np.sqrt(kT), size=shape)
    return velocity - velocity.mean(axis=1, keepdims=True)
