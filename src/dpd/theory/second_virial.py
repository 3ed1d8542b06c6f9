"""Second virial coefficients of soft beads and of chains of them.

The closed form for single beads is `dpd.theory.virial.second_virial`. Here are that of chains, from
samples of two chains and as the paper fits it, and an older fit for single beads. The paper is
Minkara et al., J. Chem. Phys. 150, 124104 (2019). Lengths are in units of r_c, and the repulsion a
in kT / r_c.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from dpd.theory.checks import above_zero, bead_numbers, not_negative
from dpd.theory.virial import second_virial

if TYPE_CHECKING:
    import numpy.typing as npt

GAMMA, A, DELTA = 0.926, 1.954, 1.57  # of Eq. 24
OLDER_FIT = (9.755e-2, -4.912e-3, 1.556e-4, -2.585e-6, 1.705e-8)  # Liyana-Arachchi et al. 2015
WALKERS = 64  # independent samples, from which the standard error comes
SETTLING = 200  # sweeps before a walker is measured; conformations forget theirs in about ten
SHIFTS = 4  # distances of two chains for each pair of conformations


class Estimate(NamedTuple):
    """A sampled number and its standard error."""

    value: float
    error: float


def older_second_virial(a: npt.ArrayLike) -> np.ndarray:
    """B2 of single beads by the polynomial of Liyana-Arachchi et al. 2015, good below a = 50.

    Parameters
    ----------
    a : float or array
        Repulsion, above 0.

    Returns
    -------
    array
        In r_c^3.

    Raises
    ------
    ValueError
        If a repulsion is not above 0.
    """
    strength = above_zero("repulsion a", a)
    return strength * np.polynomial.polynomial.polyval(strength, OLDER_FIT)


def chain_second_virial(
    a: npt.ArrayLike, m: npt.ArrayLike, length: npt.ArrayLike
) -> float | np.ndarray:
    """B2 of two chains by the paper's fit, Eqs. 18, 22 and 24.

    Parameters
    ----------
    a : float or array
        Repulsion, above 0.
    m : int or array
        Beads of a chain.
    length : float or array
        Of a bond, 0 or more.

    Returns
    -------
    float or array
        In r_c^3. The paper says that it is right within 1.6 % on average. Here it lies below
        `sampled_second_virial`, by 12 % of that on average over the paper's chains, by 4 to 19 %.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """
    strength, beads = above_zero("repulsion a", a), bead_numbers("number of beads", m)
    bond = not_negative("bond length", length)
    stronger = beads ** (2 / (bond + 1) ** 3)
    larger = A * ((1 - GAMMA) * beads**2 + GAMMA * beads - 1) * bond**DELTA + 1
    return larger * second_virial(stronger * strength)


def sampled_second_virial(
    a: float, m: int, length: float, samples: int = 100_000, seed: int = 1
) -> Estimate:
    """B2 of two flexible chains with rigid bonds, by direct sampling.

    The conformations of each chain come from Metropolis moves that turn one bond; all pairs of its
    beads repel each other. The integral of the Mayer function exp(-U) - 1 over the vector between
    two chains is sampled where the function is not 0: a pair of beads, one of each chain, and the
    vector between them in the unit sphere are drawn at random. Such a vector is drawn once for each
    of the n pairs of beads that then overlap, so that the sample counts 1 / n.

    Parameters
    ----------
    a : float
        Repulsion, above 0.
    m : int
        Beads of a chain.
    length : float
        Of a bond, 0 or more.
    samples : int
        Pairs of conformations, at least one for each of 64 walkers. The default gives a standard
        error below 0.3 % for chains of up to 8 beads.
    seed : int

    Returns
    -------
    Estimate
        In r_c^3.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """
    above_zero("repulsion a", a)
    bead_numbers("number of beads", m)
    not_negative("bond length", length)
    if samples < WALKERS:
        raise ValueError(f"samples: {samples} are too few; allowed: {WALKERS} or more")
    streams = np.random.default_rng(seed).spawn(WALKERS)
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
