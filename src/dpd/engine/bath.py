"""A thermostat that acts on each bead on its own, and does not conserve momentum.

F_i = -gamma v_i + sigma zeta_i dt^(-1/2) along each axis, with sigma^2 = 2 gamma kT: Langevin
dynamics. Beside pair friction it tells what conserved momentum does to a system.
"""

import numpy as np
from numba import uint32

from dpd.engine.jit import part
from dpd.engine.noise import gaussian_noise, uniform_noise

LAST = 0xFFFFFFFF  # the noise of a bead is that of a pair with a partner that no bead is


@part()
def add_bath_forces(force, velocity, identity, bath, gaussian, box, keys):
    """Add friction and noise on every bead.

    Parameters
    ----------
    force, velocity : (dimension, n) arrays
        The velocity is the one that the friction sees.
    bath : None or (gamma, sigma / sqrt(dt))
    keys : (uint32, uint32)
        Of the step.
    """
    if bath is None:
        return
    friction, noise = bath
    n = len(identity)
    theta = np.empty(n)
    partner = np.empty(n, np.uint32)
    for k in range(len(box)):
        partner[:] = uint32(LAST - k)
        if gaussian:
            gaussian_noise(theta, identity, partner, n, keys[0], keys[1])
        else:
            uniform_noise(theta, identity, partner, n, keys[0], keys[1])
        for i in range(n):
            force[k, i] += noise * theta[i] - friction * velocity[k, i]
