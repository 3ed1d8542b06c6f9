"""Second virial coefficient of two chains of soft beads by samples, and an older fit for beads.

Lengths are in units of r_c, and the repulsion a in kT / r_c.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

if TYPE_CHECKING:
    import numpy.typing as npt

OLDER_FIT = (9.755e-2, -4.912e-3, 1.556e-4, -2.585e-6, 1.705e-8)  # Liyana-Arachchi et al. 2015
WALKERS = 64  # independent samples, from which the standard error comes
SETTLING = 200  # sweeps before a walker is measured; conformations forget theirs in about ten
SHIFTS = 4  # distances of two chains for each pair of conformations


class Estimate(NamedTuple):
    """A sampled number and its standard error."""

    value: float
    error: float


def older_second_virial(a: npt.ArrayLike) -> np.ndarray:
    """B2 of single beads by the polynomial of Liyana-Arachchi et al. 2015, good below a = 50."""
    return np.asarray(a) * np.polynomial.polynomial.polyval(a, OLDER_FIT)


def sampled_second_virial(
    a: float, m: int, length: float, samples: int = 100_000, seed: int = 1
) -> Estimate:
    """B2 of two flexible chains with rigid bonds, by direct sampling.

    The conformations of each chain come from Metropolis moves that turn one bond; all pairs of its
    beads repel each other. The integral of the Mayer function exp(-U) - 1 over the vector between
    two chains is sampled where the function is not 0: a pair of beads, one of each chain, and the
    vector between them in the unit sphere are drawn at random. Such a vector is drawn once for each
    of the n pairs of beads that then overlap, so that the sample counts 1 / n.

    There are ``samples`` pairs of conformations, at least one for each of 64 walkers. The default
    gives a standard error below 0.3 % for chains of up to 8 beads.

    Raises `ValueError` if there are too few samples.
    """
    if samples < WALKERS:
        raise ValueError(f"samples: {samples} are too few; allowed: {WALKERS} or more")
    # Other chains have other numbers: a mean over several would else not know its error.
    streams = np.random.default_rng([seed, m, round(1e6 * length), round(1e6 * a)]).spawn(WALKERS)
    means = np.array([
        _walk(float(a), int(m), float(length), samples // WALKERS, stream) for stream in streams
    ])  # fmt: skip
    return Estimate(float(means.mean()), float(means.std(ddof=1) / np.sqrt(WALKERS)))


@njit(nogil=True)
def _walk(a, m, length, samples, stream):  # pragma: no cover
    """Mean B2 along a random walk of two chains."""
    bonds, beads, new = np.zeros((2, m - 1, 3)), np.zeros((2, m, 3)), np.zeros(3)
    for chain in range(2):
        for bond in range(m - 1):
            _point(bonds[chain, bond], length, stream)
            for axis in range(3):
                beads[chain, bond + 1, axis] = beads[chain, bond, axis] + bonds[chain, bond, axis]
    total, shift = 0.0, np.zeros(3)
    for sample in range(-SETTLING, samples):
        for chain in range(2):
            _turn_bonds(bonds[chain], beads[chain], new, shift, a, length, stream)
        if sample >= 0:
            for _ in range(SHIFTS):
                total += _overlap(beads[0], beads[1], shift, a, stream)
    return total / (samples * SHIFTS)


@njit(nogil=True)
def _point(vector, length, stream):  # pragma: no cover
    """Give a vector a length and a random direction."""
    height, angle = 2 * stream.random() - 1, 2 * np.pi * stream.random()
    across = np.sqrt(1 - height**2)
    vector[0] = length * across * np.cos(angle)
    vector[1] = length * across * np.sin(angle)
    vector[2] = length * height


@njit(nogil=True)
def _repel(one, other, shift, a):  # pragma: no cover
    """Energy of a bead and another that is shifted; 0 if they do not overlap."""
    square = 0.0
    for axis in range(3):
        square += (one[axis] - other[axis] - shift[axis]) ** 2
    return 0.5 * a * (1 - np.sqrt(square)) ** 2 if square < 1 else 0.0


@njit(nogil=True)
def _turn_bonds(bonds, beads, new, shift, a, length, stream):  # pragma: no cover
    """Try a new direction for each bond; what is behind it moves along, without turning."""
    m, nothing = len(beads), np.zeros(3)
    for bond in range(m - 1):
        _point(new, length, stream)
        for axis in range(3):
            shift[axis] = new[axis] - bonds[bond, axis]
        change = 0.0
        for back in range(bond + 1, m):
            for front in range(bond + 1):
                change += _repel(beads[front], beads[back], shift, a)
                change -= _repel(beads[front], beads[back], nothing, a)
        if change <= 0 or stream.random() < np.exp(-change):
            for axis in range(3):
                bonds[bond, axis] += shift[axis]
                for back in range(bond + 1, m):
                    beads[back, axis] += shift[axis]


@njit(nogil=True)
def _overlap(one, other, shift, a, stream):  # pragma: no cover
    """A sample of B2 for two conformations."""
    m = len(one)
    first, second = int(m * stream.random()), int(m * stream.random())
    _point(shift, stream.random() ** (1 / 3), stream)
    for axis in range(3):
        shift[axis] += one[first, axis] - other[second, axis]
    energy, overlapping = 0.0, 0
    for i in range(m):
        for j in range(m):
            pair = _repel(one[i], other[j], shift, a)
            energy += pair
            overlapping += pair > 0
    sphere = 4 * np.pi / 3
    return -0.5 * np.expm1(-energy) * sphere * m**2 / max(overlapping, 1)
