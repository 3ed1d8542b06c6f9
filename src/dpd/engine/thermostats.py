"""Thermostats that do not act through pair forces: on single beads, or by exchanging momentum."""

import numpy as np
from numba import uint32

from dpd.engine.masses import inverse_of, push_masses_apart
from dpd.engine.shares import bead_share, pair_share
from dpd.engine.vectors.rows import add_rows, difference_along, push_apart
from dpd.jit import part
from dpd.physics.exchange import SHARDLOW
from dpd.physics.forces import change, drag, random
from dpd.physics.noise import Keys, gaussian_noise, pair_word, uniform_noise

LAST = 0xFFFFFFFF  # the noise of a bead is that of a pair with a partner that no bead is
PER_WORD = 1.0 / 2**32  # a 32-bit word to [0, 1)


@part()
def add_langevin_forces(total, velocity, beads, mine, langevin, space, keys):
    """Add friction and noise on a thread's share of the beads.

    Parameters
    ----------
    total, velocity : arrays with a row for each bead
        The force; the velocity that the friction sees.
    beads : Beads
    langevin : None or Langevin
    keys : Keys
        Of the step.
    """
    if langevin is None:
        return
    n = mine.end - mine.first
    ours = beads.identity[mine.first : mine.end]
    zeta = np.empty(n)
    partner = np.empty(n, np.uint32)
    for k in range(len(space.edges)):
        partner[:] = uint32(LAST - k)
        if langevin.gaussian:
            gaussian_noise(zeta, ours, partner, n, keys)
        else:
            uniform_noise(zeta, ours, partner, n, keys)
        add_bath(total, velocity, k, zeta, beads.species, mine, langevin, langevin.shares)


@part()
def add_bath(total, velocity, k, zeta, species, mine, langevin, shares):
    """Add friction and noise along axis k."""
    for i in range(mine.end - mine.first):
        s = mine.first + i
        if shares is None:
            total[s, k] += random(langevin, zeta[i]) - drag(langevin, velocity[s, k])
        else:
            share = bead_share(shares, species, s)
            push = random(langevin, np.sqrt(share) * zeta[i])
            total[s, k] += push - drag(langevin, share * velocity[s, k])


@part()
def renew_langevin_friction(total, lost, species, mine, langevin):
    """Replace the friction in a force by that of the velocities now.

    Parameters
    ----------
    lost : array with a row for each bead
        What velocities have lost since, see `dpd.engine.second_friction`.
    """
    if langevin is not None:
        add_lost_friction(total, lost, species, mine, langevin.gamma, langevin.shares)


@part()
def add_lost_friction(total, lost, species, mine, gamma, shares):
    """Add gamma times what velocities have lost."""
    if shares is None:
        add_rows(total, lost, gamma, mine)
    else:
        for s in range(mine.first, mine.end):
            friction = gamma * bead_share(shares, species, s)
            for k in range(total.shape[1]):
                total[s, k] += friction * lost[s, k]


@part()
def exchange_momentum(beads, touching, exchange, inverse_mass, dt, keys, space):
    """Let pairs exchange momentum, one after the other, in the order in which they were found.

    Each sees the velocities that the pairs before it have left.

    Parameters
    ----------
    beads : Beads
    touching : Touching
        The pairs, with sqrt(gamma) w e of each.
    exchange : None or Exchange
    inverse_mass : None or (species,) array
    keys : Keys
        Of the step.
    """
    if exchange is None:
        return
    velocity, identity, species = beads.velocity, beads.identity, beads.species
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
        rate = exchange.gamma * pair_share(exchange.shares, species, i, j)
        drawn = PER_WORD * pair_word(low[p], high[p], swapped) < rate * dt
        if inverse_mass is None:
            kick = 0.5 * change(exchange, u / root, square * dt, theta[p], drawn) / root
            push_apart(velocity, i, j, kick, touching.drag, p, space)
        else:
            a, b = inverse_of(inverse_mass, species, i), inverse_of(inverse_mass, species, j)
            mean = 0.5 * (a + b)  # 1 / (2 mu), with the reduced mass mu
            scale = np.sqrt(mean)
            gained = change(exchange, u / (root * scale), square * dt * mean, theta[p], drawn)
            kick = 0.5 * gained * scale / (mean * root)
            push_masses_apart(velocity, i, j, kick, a, b, touching.drag, p)
