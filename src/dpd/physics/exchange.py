"""Friction and noise as exchanges of momentum, one pair after the other.

Where the thermostat is split from the other forces, each pair's relative velocity along its
line is advanced on its own, with velocities that the pairs before it have left. Momentum is
kept by every exchange.
"""

import numpy as np

from dpd.engine.vectors.rows import difference_along, push_apart
from dpd.jit import part
from dpd.physics.noise import gaussian_noise, pair_word, uniform_noise
from dpd.physics.schemes import EXACT, SHARDLOW

PER_WORD = 1.0 / 2**32  # a 32-bit word to [0, 1)


@part()
def exchange_momentum(velocity, identity, kept, exchange, gaussian, dt, keys, box):
    """Let pairs exchange momentum, in the order in which they were found.

    Parameters
    ----------
    velocity : array with a row for each bead
    kept : Kept
        With sqrt(gamma) w e of each pair.
    exchange : None or (kind, gamma, kT)
    gaussian : bool
        For Shardlow's scheme; the others take normal noise, without which they are not exact.
    keys : (uint32, uint32)
        Of the step.
    """
    if exchange is None:
        return
    kind, gamma, kT = exchange
    count = kept.phase[-1]
    low, high, theta = np.empty(count, np.uint32), np.empty(count, np.uint32), np.empty(count)
    for p in range(count):
        a, b = identity[kept.ends[0, p]], identity[kept.ends[1, p]]
        low[p], high[p] = min(a, b), max(a, b)
    if gaussian or kind != SHARDLOW:
        gaussian_noise(theta, low, high, count, keys[0], keys[1])
    else:
        uniform_noise(theta, low, high, count, keys[0], keys[1])
    for p in range(count):
        i, j = kept.ends[0, p], kept.ends[1, p]
        square, u = 0.0, difference_along(velocity, i, j, kept.drag, p, box)
        for k in range(len(box)):
            square += kept.drag[k, p] * kept.drag[k, p]
        if square == 0.0:
            continue
        root = np.sqrt(square)
        chance = PER_WORD * pair_word(low[p], high[p], keys[1], keys[0])
        kick = 0.5 * change(u / root, kind, square * dt, kT, theta[p], chance < gamma * dt) / root
        push_apart(velocity, i, j, kick, kept.drag, p, box)


@part()
def change(u, kind, g, kT, theta, drawn):
    """Change of a relative velocity u, whose variance is 2 kT at rest."""
    if kind == SHARDLOW:
        push = np.sqrt(2.0 * kT * g) * theta
        return (u - g * u + 2.0 * push) / (1.0 + g) - u
    if kind == EXACT:
        decay = np.exp(-2.0 * g)
        return u * decay + np.sqrt(2.0 * kT * (1.0 - decay * decay)) * theta - u
    return np.sqrt(2.0 * kT) * theta - u if drawn else 0.0
