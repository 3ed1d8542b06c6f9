"""Lengths of harmonic bonds between beads that repel each other."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from dpd.theory.checks import above_zero, not_negative

POINTS = 4001  # of the quadrature
WIDTHS = 8.0  # standard deviations of the bond's length that it covers on either side


def mean_length(stiffness: float, rest: float, repulsion: float = 0.0) -> float:
    """Mean length of a bond in three dimensions, without the other beads of the fluid.

    The weight of a length r is r^2 exp(-stiffness (r - rest)^2 / 2 - a max(1 - r, 0)^2 / 2).

    Parameters
    ----------
    stiffness : float
        Spring constant in kT / r_c^2.
    rest : float
        Length at rest in r_c.
    repulsion : float
        a of its two beads, in kT / r_c.

    Returns
    -------
    float
        In r_c.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """
    above_zero("stiffness", stiffness)
    not_negative("rest length", rest)
    not_negative("repulsion a", repulsion)
    farthest = max(rest, 1.0) + WIDTHS / np.sqrt(stiffness)
    r = np.linspace(0.0, farthest, POINTS)
    energy = 0.5 * stiffness * (r - rest) ** 2 + 0.5 * repulsion * np.maximum(1 - r, 0) ** 2
    weight = r**2 * np.exp(energy.min() - energy)
    return float(np.sum(r * weight) / np.sum(weight))


def rest_length(stiffness: float, repulsion: float, length: float) -> float:
    """The rest length with which a bond has a mean length: the inverse of `mean_length`.

    Parameters
    ----------
    stiffness, repulsion : float
        As in `mean_length`.
    length : float
        The mean, in r_c.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If the mean is larger than that even with the rest length 0, or an argument is out of its
        range.
    """
    above_zero("bond length", length)
    shortest = mean_length(stiffness, 0.0, repulsion)
    if length < shortest:
        raise ValueError(
            f"bond length: with a stiffness of {stiffness:g} and a repulsion of {repulsion:g} a "
            f"mean of {length:g} needs a rest length below 0; allowed: {shortest:.4g} and above, "
            "or a larger stiffness"
        )
    return brentq(lambda rest: mean_length(stiffness, rest, repulsion) - length, 0.0, length + 1)
