"""Repulsion between two species of chains, and chemical potentials of chains in a solvent.

Equations are the paper's. Those of chemical potentials (Eqs. 30, 34 to 36) are fits that hold for
fluids at the pressure 41.89 alone. Lengths are in units of r_c, energies in kT, repulsions in
kT / r_c.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import brentq

from dpd.theory.equation_of_state import crgw, gw, rgw

if TYPE_CHECKING:
    import numpy.typing as npt

REFERENCE_DENSITY = 5.0  # of the paper's reference, at the pressure 41.89
PER_DENSITY, PER_BEAD = 0.00323, 0.00439  # of Eq. 30
LARGEST, SATURATION = 50.9, 0.790  # of Eq. 30
C1, C2, C3 = 1.4851, 0.46562, 2.8239  # of Eqs. 35 and 36
MOST_REPULSION = 1000.0  # far above those at which Eq. 30 was fitted


class Fluid(NamedTuple):
    """A pure fluid of chains whose beads are all alike; its density is that of the chains."""

    density: float
    repulsion: float
    beads: int = 1
    length: float = 0.0

    @property
    def bead_density(self) -> float:
        """Beads per r_c^3."""
        return self.beads * self.density


def athermal(one: Fluid, other: Fluid, pressures: tuple[float, float] | None = None) -> float:
    """a_ij at which two fluids mix without heat, Eqs. 25 to 27.

    The excess pressure of a pure fluid over that of an ideal gas of its chains is written as h_i =
    alpha_i a_i x_i^2, with the density x_i of beads. Then

        a_ij = (h_i + h_j) / (2 alpha x_i x_j)

    with the geometric mean alpha of alpha_i and alpha_j. Without pressures of both pure fluids both
    alpha are taken as equal, which is Eq. 26.

    Examples
    --------
    >>> round(athermal(Fluid(3.432, 34.9), Fluid(3.432, 8.54, 2, 0.39)), 2)
    17.27
    """
    squares = [fluid.repulsion * fluid.bead_density**2 for fluid in (one, other)]
    product = one.bead_density * other.bead_density
    if pressures is None:
        return sum(squares) / (2 * product)
    excess = [p - fluid.density for p, fluid in zip(pressures, (one, other), strict=True)]
    alpha = np.sqrt(np.prod(excess) / np.prod(squares))
    return float(sum(excess) / (2 * alpha * product))


def athermal_by(equation: str | None, one: Fluid, other: Fluid) -> float:
    """`athermal` with the pressures of an equation: all numbers of Table I.

    GW and rGW take a chain for as many single beads.
    """
    if equation is None:
        return athermal(one, other)
    if equation == "crGW":
        fluids = one, other
        pressures = [crgw(each.density, each.repulsion, each.beads, each.length) for each in fluids]
    else:
        fluids = [Fluid(each.bead_density, each.repulsion) for each in (one, other)]
        of_beads = {"rGW": rgw, "GW": gw}[equation]
        pressures = [of_beads(each.density, each.repulsion) for each in fluids]
    return athermal(*fluids, pressures)


def monomer_potential(a: npt.ArrayLike, density: npt.ArrayLike) -> float | np.ndarray:
    """Excess chemical potential of a bead in a fluid of a density of beads, in kT, Eq. 30.

    The repulsion is that of the bead and those of the fluid.
    """
    x = np.asarray(density)
    coupling = -np.expm1(-np.asarray(a) * (PER_DENSITY * x + PER_BEAD))
    return coupling * LARGEST * x / (1 + SATURATION * x)


def chain_potential(
    a: npt.ArrayLike, density: npt.ArrayLike, m: npt.ArrayLike = 1, length: npt.ArrayLike = 0.0
) -> float | np.ndarray:
    """The same of a chain of m beads, Eq. 34; the paper fitted bonds from 0.25 to 0.6.

    Between that of m beads far from each other and that of one bead with m times the repulsion. The
    paper says that it is right within 2.1 % on average, and 3.7 % at most.
    """
    beads, bond = np.asarray(m), np.asarray(length)
    single = monomer_potential(a, density)
    apart = C1 * bond**2 / (1 + C2 * bond**2)
    together = 1 / (1 + C3 * bond**3)
    chain = beads * single * apart + monomer_potential(beads * np.asarray(a), density) * together
    return np.where(beads == 1, single, chain)[()]


def flory_huggins(
    one: Fluid, other: Fluid, a: float, reference_density: float = REFERENCE_DENSITY
) -> float:
    """chi of two fluids of which unlike beads repel each other with a, Eq. 29.

    From the chemical potential of a chain of each in the other and in its own.
    """
    transfers = 0.0
    for fluid, into in ((one, other), (other, one)):
        beads, length = fluid.beads, fluid.length
        there = chain_potential(a, into.bead_density, beads, length)
        at_home = chain_potential(fluid.repulsion, fluid.bead_density, beads, length)
        transfers += fluid.density * (there - at_home)
    return float(transfers / (2 * reference_density))


def thermal(
    one: Fluid, other: Fluid, chi: float, reference_density: float = REFERENCE_DENSITY
) -> float:
    """a_ij at which two fluids at the pressure 41.89 have a chi: the inverse of `flory_huggins`.

    Raises `ValueError` if no repulsion gives that chi, with which are allowed.
    """
    lowest, highest = (
        flory_huggins(one, other, a, reference_density) for a in (0.0, MOST_REPULSION)
    )
    if not lowest < chi < highest:
        raise ValueError(
            f"chi: no repulsion gives {chi:g}; allowed: {lowest:.4g} to {highest:.4g}, at "
            f"a_ij = 0 and {MOST_REPULSION:g}"
        )
    return brentq(
        lambda a: flory_huggins(one, other, a, reference_density) - chi, 0.0, MOST_REPULSION
    )
