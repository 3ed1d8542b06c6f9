"""Lengths of harmonic bonds between beads that repel each other, in a fluid of such beads.

In the dense fluid the cavity function y draws two beads together, so that bonds are shorter than
the spring and the repulsion of its own two beads would make them. As in perturbation theory of the
first order, y is that of the fluid of single beads, from the Ornstein-Zernike equation with the HNC
closure. In a chain of three beads or more the others of the chain push the two apart: that force is
a fit to simulations. Lengths are in units of r_c, energies in kT.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from dpd.theory.integral_equations import R, solve

POINTS = 2001  # of the quadrature
WIDTHS = 8.0  # standard deviations of the bond's length that it covers beyond the rest length
# Force on a bond by the rest of its chain: PUSH a (1 - 2 / m)^LONGER exp(-density / THICKER -
# length / REACH). Fitted to the mean bonds of 136 fluids of chains of 3, 4 and 8 beads at densities
# 3 to 7, a 10 to 40, stiffness 1000 and lengths 0.27 to 0.6; from 0.3 on it is right within 1 %.
PUSH, LONGER, THICKER, REACH = 73.5, 1.29, 2.364, 0.118


def mean_length(
    stiffness: float, rest: float, repulsion: float = 0.0, density: float = 0.0
) -> float:
    """Mean length of a bond; with the density 0 its two beads are alone.

    The weight of a length r is r^2 y(r) exp(-stiffness (r - rest)^2 / 2 - a max(1 - r, 0)^2 / 2).

    Raises `ValueError` if the integral equation has no solution, or the bond reaches beyond its
    grid.
    """
    r = np.linspace(0.0, max(rest, 1.0) + WIDTHS / np.sqrt(stiffness), POINTS)
    if density and r[-1] > R[-1]:
        raise ValueError(
            f"bond length: with a stiffness of {stiffness:g} and a rest length of {rest:g} it "
            f"reaches {r[-1]:.4g}, beyond the grid of the integral equation; allowed: up to "
            f"{R[-1]:g}, with a larger stiffness or a shorter bond"
        )
    energy = 0.5 * stiffness * (r - rest) ** 2 + 0.5 * repulsion * np.maximum(1 - r, 0) ** 2
    if density:
        energy = energy - _fluid(density, repulsion).ln_y(r)[:, 0, 0]
    weight = r**2 * np.exp(energy.min() - energy)
    return float(np.sum(r * weight) / np.sum(weight))


def rest_length(
    stiffness: float, repulsion: float, length: float, density: float = 0.0, beads: int = 2
) -> float:
    """The rest length with which a bond has a mean length: of two beads, `mean_length` inverted.

    Raises `ValueError` as `mean_length`; or if the mean is larger than that even with the rest
    length 0.

    Examples
    --------
    >>> rest = rest_length(200, 25, 0.4, 5)
    >>> round(mean_length(200, rest, 25, 5), 6)
    0.4
    """
    chain = repulsion * (1 - 2 / max(beads, 2)) ** LONGER
    longer = PUSH * chain * np.exp(-density / THICKER - length / REACH) / stiffness
    shortest = mean_length(stiffness, longer, repulsion, density)
    if length < shortest:
        raise ValueError(
            f"bond length: with a stiffness of {stiffness:g} and a repulsion of {repulsion:g} a "
            f"mean of {length:g} needs a rest length below 0; allowed: {shortest:.4g} and above, "
            "or a larger stiffness"
        )

    def too_long(rest):
        return mean_length(stiffness, rest, repulsion, density) - length

    return brentq(too_long, longer, length + 1) - longer


@lru_cache(maxsize=64)
def _fluid(density, repulsion):
    """One fluid serves bonds of all lengths."""
    return solve(density, repulsion)
