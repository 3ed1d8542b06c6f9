"""Thermostats that do not act through pair forces: on single beads, or by exchanging momentum."""

import numpy as np
from numba import uint32

from dpd.engine.vectors.rows import add_rows, difference_along, push_apart
from dpd.jit import part
from dpd.physics.exchange import SHARDLOW
from dpd.physics.forces import change, drag, random
from dpd.physics.noise import Keys, gaussian_noise, pair_word, uniform_noise

LAST = 0xFFFFFFFF  # the noise of a bead is that of a pair with a partner that no bead is
PER_WORD = 1.0 / 2**32  # a 32-bit word to [0, 1)


@part()
def add_langevin_forces(total, velocity, identity, mine, langevin, space, keys):
    """Add friction and noise on a thread's share of the beads.

    Parameters
    ----------
    total, velocity : arrays with a row for each bead
        The force; the velocity that the friction sees.
    langevin : None or Langevin
    keys : Keys
        Of the step.
    """
    if langevin is None:
        return
    n = mine.end - mine.first
    ours = identity[mine.first : mine.end]
    zeta = np.empty(n)
    partner = np.empty(n, np.uint32)
    for k in range(len(space.edges)):
        partner[:] = uint32(LAST - k)
        if langevin.gaussian:
            gaussian_noise(zeta, ours, partner, n, keys)
        else:
            uniform_noise(zeta, ours, partner, n, keys)
        for i in range(n):
            s = mine.first + i
            total[s, k] += random(langevin, zeta[i]) - drag(langevin, velocity[s, k])


@part()
def renew_langevin_friction(total, lost, mine, langevin):
    """Replace the friction in a force by that of the velocities now.

    Parameters
    ----------
    lost : array with a row for each bead
        What velocities have lost since, see `dpd.engine.second_friction`.
    """
    if langevin is not None:
        add_rows(total, lost, langevin.gamma, mine)


@part()
def exchange_momentum(velocity, identity, touching, exchange, dt, keys, space):
    """Let pairs exchange momentum, one after the other, in the order in which they were found.

    Each sees the velocities that the pairs before it have left.

    Parameters
    ----------
    velocity : array with a row for each bead
    touching : Touching
        The pairs, with sqrt(gamma) w e of each.
    exchange : None or Exchange
    keys : Keys
        Of the step.
    """
    if exchange is None:
        return
    count = touching.phase[-1]
    low, high, theta = np.empty(count, np.uint32), np.empty(count, np.uint32), np.empty(count)
    for p in range(count):
        a, b = identity[touching.ends[0, p]], identity[touching.ends[1, p]]
        low[p], high[p] = min(a, b), max(a, b)
    if exchange.gaussian or exchange.kind != SHARDLOW:
        gaussian_noise(theta, low, high, count, keys)
    else:
        uniform_noise(theta, low, high, count, keys)
    swapped = Keys(keys.second, keys.first)  # numbers that the noise has not drawn
    for p in range(count):
        i, j = touching.ends[0, p], touching.ends[1, p]
        square, u = 0.0, difference_along(velocity, i, j, touching.drag, p, space)
        for k in range(len(space.edges)):
            square += touching.drag[k, p] * touching.drag[k, p]
        if square == 0.0:
            continue
        root = np.sqrt(square)
        drawn = PER_WORD * pair_word(low[p], high[p], swapped) < exchange.gamma * dt
        kick = 0.5 * change(exchange, u / root, square * dt, theta[p], drawn) / root
        push_apart(velocity, i, j, kick, touching.drag, p, space)
