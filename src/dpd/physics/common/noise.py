"""Pair noise as a function of (seed, step, pair of bead identities), whatever their order."""

from typing import NamedTuple

import numpy as np
from numba import uint32, uint64

from dpd.jit import inlined

UNIFORM_WIDTH = np.sqrt(3.0)  # U(-sqrt 3, sqrt 3) has unit variance
PER_WORD = 1.0 / 2**31  # a signed 32-bit word to (-1, 1)

# Logarithm and cosine are polynomials of our own, within 2e-10: the library's are called for one
# number at a time. Written out, as a loop over their terms keeps that over pairs from vectorising.
MANTISSA_BITS = np.uint64(52)
MANTISSA = np.uint64(2**52 - 1)
ROOT_HALF = np.sqrt(0.5).view(np.uint64)
TO_ROOT_HALF = np.uint64(np.float64(1.0).view(np.uint64) - ROOT_HALF)
LOG_2 = np.log(2.0)


class Keys(NamedTuple):
    first: int  # 32 bits, as the other
    second: int


@inlined()
def mix32(h):
    """Multiplicative xorshift hash, constants found by C. Wellons' search for low bias."""
    h = uint32(h ^ (h >> uint32(16)))
    h = uint32(h * uint32(0x7FEB352D))
    h = uint32(h ^ (h >> uint32(15)))
    h = uint32(h * uint32(0x846CA68B))
    return uint32(h ^ (h >> uint32(16)))


@inlined()
def step_keys(seed, step):
    """One SplitMix64 output for the pair (seed, step)."""
    z = uint64(uint64(seed) * uint64(0xD1342543DE82EF95) + uint64(step))
    z = uint64(z * uint64(0x9E3779B97F4A7C15))
    z = uint64((z ^ (z >> uint64(30))) * uint64(0xBF58476D1CE4E5B9))
    z = uint64((z ^ (z >> uint64(27))) * uint64(0x94D049BB133111EB))
    z = uint64(z ^ (z >> uint64(31)))
    return Keys(uint32(z & uint64(0xFFFFFFFF)), uint32(z >> uint64(32)))


@inlined()
def pair_word(one, other, keys):
    """32 random bits of two identities, in either order, under a step's keys."""
    low, high = min(one, other), max(one, other)
    return mix32(uint32(uint32(mix32(uint32(low ^ keys.first)) + high) ^ keys.second))


@inlined()
def fill_noise(theta, one, other, n, keys, gaussian):
    """Fill ``theta[:n]`` with noise of zero mean, unit variance: normal (Box-Muller) or uniform."""
    if gaussian:
        for p in range(n):
            word = pair_word(one[p], other[p], keys)
            angle = mix32(uint32(uint32(word ^ uint32(0x5BF03635)) + keys.first))
            theta[p] = np.sqrt(2.0 * minus_log(word)) * cos_pi(np.int32(angle) * PER_WORD)
    else:
        for p in range(n):
            word = pair_word(one[p], other[p], keys)
            theta[p] = UNIFORM_WIDTH * ((np.int32(word) + 0.5) * PER_WORD)


@inlined()
def minus_log(word):
    """-log u of the middle u = (word + 1/2) / 2^32 of one of 2^32 intervals from 0 to 1.

    word + 1/2 = 2^power m with m from sqrt(1/2) to sqrt(2), and log m = 2 artanh s with
    s = (m - 1) / (m + 1).
    """
    bits = uint64(np.float64(word + 0.5).view(np.uint64) + TO_ROOT_HALF)
    power = np.float64(np.int32(bits >> MANTISSA_BITS)) - (1023 + 32)
    m = np.uint64((bits & MANTISSA) + ROOT_HALF).view(np.float64)
    s = (m - 1.0) / (m + 1.0)
    z = s * s  # Chebyshev's for artanh(s) / s on 0 < z < 0.0295
    series = 0.1426749880893960 + z * 0.1180863327334036
    series = 1.0000000000042057 + z * (0.3333333262085406 + z * (0.2000019282741847 + z * series))
    return -power * LOG_2 - 2.0 * s * series


@inlined()
def cos_pi(x):
    """cos(pi x) = 1 - 2 sin^2(pi x / 2) for x from -1 to 1."""
    t = 0.5 * np.pi * x
    z = t * t  # Chebyshev's for sin(t) / t on 0 < z < (pi / 2)^2
    series = -1.9840861553637262e-4 + z * (2.7525287145771493e-6 - z * 2.3889498721778913e-8)
    series = -0.1666666661691738 + z * (0.008333330977507181 + z * series)
    sine = t * (0.9999999999829691 + z * series)
    return 1.0 - 2.0 * sine * sine
