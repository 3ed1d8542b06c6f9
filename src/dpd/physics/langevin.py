"""A thermostat that acts on each bead on its own, and does not conserve momentum.

F_i = -gamma v_i + sigma zeta_i dt^(-1/2) along each axis, with sigma^2 = 2 gamma kT: Langevin
dynamics. Beside pair friction it tells what conserved momentum does to a system.
"""

import numpy as np
from numba import uint32

from dpd.engine.vectors.rows import add_rows
from dpd.jit import part
from dpd.physics.noise import gaussian_noise, uniform_noise

LAST = 0xFFFFFFFF  # the noise of a bead is that of a pair with a partner that no bead is


@part()
def add_bath_forces(force, velocity, identity, own, bath, gaussian, box, keys):
    """Add friction and noise on the beads from own[0] to own[1].

    Parameters
    ----------
    force, velocity : arrays with a row for each bead
        The velocity is the one that the friction sees.
    bath : None or (gamma, sigma / sqrt(dt))
    keys : (uint32, uint32)
        Of the step.
    """
    if bath is None:
        return
    friction, noise = bath
    n = own[1] - own[0]
    ours = identity[own[0] : own[1]]
    theta = np.empty(n)
    partner = np.empty(n, np.uint32)
    for k in range(len(box)):
        partner[:] = uint32(LAST - k)
        if gaussian:
            gaussian_noise(theta, ours, partner, n, keys[0], keys[1])
        else:
            uniform_noise(theta, ours, partner, n, keys[0], keys[1])
        for i in range(n):
            s = own[0] + i
            force[s, k] += noise * theta[i] - friction * velocity[s, k]


@part()
def renew_bath_friction(force, change, own, bath):
    """Replace the friction in a force by that of the velocities now.

    Parameters
    ----------
    change : array with a row for each bead
        What velocities have lost since, as for `dpd.engine.friction.renew_friction`.
    """
    if bath is not None:
        add_rows(force, change, bath[0], own)
