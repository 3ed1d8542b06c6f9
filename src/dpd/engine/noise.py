"""Pair noise as a pure function of (seed, step, pair of bead identities).

The same pair at the same step draws the same number, whatever the order in which pairs
are found, and whether or not the run was interrupted in between.
"""

import numpy as np
from numba import uint32, uint64

from dpd.engine.jit import part

UNIFORM_WIDTH = np.sqrt(3.0)  # U(-sqrt 3, sqrt 3) has unit variance
PER_WORD = 1.0 / 2**31  # a signed 32-bit word to (-1, 1)


@part()
def mix32(h):
    """Mix 32 bits so that each input bit flips half of the output bits.

    Multiplicative xorshift hash, constants found by C. Wellons' search for low bias.
    """
    h = uint32(h ^ (h >> uint32(16)))
    h = uint32(h * uint32(0x7FEB352D))
    h = uint32(h ^ (h >> uint32(15)))
    h = uint32(h * uint32(0x846CA68B))
    return uint32(h ^ (h >> uint32(16)))


@part()
def step_keys(seed, step):
    """Two 32-bit keys of a step: one SplitMix64 output for the pair (seed, step)."""
    z = uint64(uint64(seed) * uint64(0xD1342543DE82EF95) + uint64(step))
    z = uint64(z * uint64(0x9E3779B97F4A7C15))
    z = uint64((z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9))
    z = uint64((z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB))
    z = uint64(z ^ (z >> uint64(31)))
    return uint32(z & uint64(0xFFFFFFFF)), uint32(z >> uint64(32))


@part()
def pair_word(low, high, key0, key1):
    """32 random bits of the pair (low < high) under a step's keys."""
    return mix32(uint32(uint32(mix32(uint32(low ^ key0)) + high) ^ key1))


@part()
def uniform_noise(theta, low, high, n, key0, key1):
    """Fill ``theta[:n]`` with uniform noise of zero mean and unit variance."""
    for p in range(n):
        word = pair_word(low[p], high[p], key0, key1)
        theta[p] = UNIFORM_WIDTH * ((np.int32(word) + 0.5) * PER_WORD)


@part()
def gaussian_noise(theta, low, high, n, key0, key1):
    """Fill ``theta[:n]`` with normal noise of zero mean and unit variance (Box-Muller)."""
    for p in range(n):
        word = pair_word(low[p], high[p], key0, key1)
        angle = mix32(uint32(uint32(word ^ uint32(0x5BF03635)) + key0))
        radius = np.sqrt(-2.0 * np.log((word + 0.5) * (0.5 * PER_WORD)))
        theta[p] = radius * np.cos(np.pi * (np.int32(angle) * PER_WORD))
