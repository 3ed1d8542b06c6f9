"""Repulsion between two species of chains, and chemical potentials of chains in a solvent.

Equations are those of Minkara et al., J. Chem. Phys. 150, 124104 (2019), "the paper". Those of
chemical potentials (Eqs. 30, 34 to 36) are fits that hold for fluids at the pressure 41.89 alone.
Lengths are in units of r_c, energies in kT, repulsions in kT / r_c.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import brentq

from dpd.theory.checks import above_zero, bead_numbers, not_negative

if TYPE_CHECKING:
    import numpy.typing as npt

REFERENCE_DENSITY = 5.0  # of the paper's reference, at the pressure 41.89
PER_DENSITY, PER_BEAD = 0.00323, 0.00439  # of Eq. 30
LARGEST, SATURATION = 50.9, 0.790  # of Eq. 30
C1, C2, C3 = 1.4851, 0.46562, 2.8239  # of Eqs. 35 and 36
MOST_REPULSION = 1000.0  # far above those at which Eq. 30 was fitted


class Fluid(NamedTuple):
    """A pure fluid of chains whose beads are all alike.

    Attributes
    ----------
    density : float
        Chains per r_c^3.
    repulsion : float
        a of its beads.
    beads : int
        Of a chain.
    length : float
        Of a bond.
    """

    density: float
    repulsion: float
    beads: int = 1
    length: float = 0.0

    @property
    def bead_density(self) -> float:
        """Beads per r_c^3."""
        return self.beads * self.density


def athermal(one: Fluid, other: Fluid, pressures: tuple[float, float] | None = None) -> float:
    """a_ij at which two fluids mix without heat, Eqs. 25 to 27 of the paper.

    The excess pressure of a pure fluid over that of an ideal gas of its chains is written as h_i =
    alpha_i a_i x_i^2, with the density x_i of beads. Then

        a_ij = (h_i + h_j) / (2 alpha x_i x_j)

    with the geometric mean alpha of alpha_i and alpha_j. With the pressures of each equation at the
    printed repulsions this gives all numbers of Table I. Without pressures both alpha are taken as
    equal, which is Eq. 26.

    Parameters
    ----------
    one, other : Fluid
    pressures : pair of floats, optional
        Of both pure fluids by an equation of state; that of the paper is
        `dpd.theory.equation_of_state.crgw`. Those of GW and rGW go with fluids of single beads.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If a value of a fluid is out of its range, or a pressure not above that of an ideal gas.

    Examples
    --------
    >>> round(athermal(Fluid(3.432, 34.9), Fluid(3.432, 8.54, 2, 0.39)), 2)
    17.27
    """
    fluids = (_checked(one), _checked(other))
    squares = [fluid.repulsion * fluid.bead_density**2 for fluid in fluids]
    product = one.bead_density * other.bead_density
    if pressures is None:
        return sum(squares) / (2 * product)
    excess = [p - fluid.density for p, fluid in zip(pressures, fluids, strict=True)]
    above_zero("pressure above that of an ideal gas", excess)
    alpha = np.sqrt(np.prod(excess) / np.prod(squares))
    return float(sum(excess) / (2 * alpha * product))


def monomer_potential(a: npt.ArrayLike, density: npt.ArrayLike) -> float | np.ndarray:
    """Excess chemical potential of a bead in a fluid at the pressure 41.89, Eq. 30 of the paper.

    Parameters
    ----------
    a : float or array
        Repulsion of the bead and those of the fluid, 0 or more.
    density : float or array
        Beads of the fluid per r_c^3, above 0.

    Returns
    -------
    float or array
        In kT.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """
    strength, x = not_negative("repulsion a", a), above_zero("density", density)
    coupling = -np.expm1(-strength * (PER_DENSITY * x + PER_BEAD))
    return coupling * LARGEST * x / (1 + SATURATION * x)


def chain_potential(
    a: npt.ArrayLike, density: npt.ArrayLike, m: npt.ArrayLike = 1, length: npt.ArrayLike = 0.0
) -> float | np.ndarray:
    """Excess chemical potential of a chain in a fluid at the pressure 41.89, Eq. 34 of the paper.

    Between that of m beads far from each other and that of one bead with m times the repulsion.

    Parameters
    ----------
    a : float or array
        Repulsion of the beads of the chain and those of the fluid, 0 or more.
    density : float or array
        Beads of the fluid per r_c^3, above 0.
    m : int or array
        Beads of the chain; for m = 1 it is `monomer_potential`.
    length : float or array
        Of a bond, 0 or more; the paper fitted 0.25 to 0.6.

    Returns
    -------
    float or array
        In kT; the paper says that it is right within 2.1 % on average, and 3.7 % at most.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """
    beads, bond = bead_numbers("number of beads", m), not_negative("bond length", length)
    single = monomer_potential(a, density)
    apart = C1 * bond**2 / (1 + C2 * bond**2)
    together = 1 / (1 + C3 * bond**3)
    chain = beads * single * apart + monomer_potential(beads * np.asarray(a), density) * together
    return np.where(beads == 1, single, chain)[()]


def flory_huggins(
    one: Fluid, other: Fluid, a: float, reference_density: float = REFERENCE_DENSITY
) -> float:
    """chi of two fluids at the pressure 41.89, of which unlike beads repel each other with a.

    Eq. 29 of the paper, from the chemical potential of a chain of each in the other and in its own.

    Parameters
    ----------
    one, other : Fluid
    a : float
        a_ij, 0 or more.
    reference_density : float

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """
    above_zero("reference density", reference_density)
    fluids = (_checked(one), _checked(other))
    transfers = [_transfer(fluid, into, a) for fluid, into in (fluids, fluids[::-1])]
    return float(sum(transfers) / (2 * reference_density))


def thermal(
    one: Fluid, other: Fluid, chi: float, reference_density: float = REFERENCE_DENSITY
) -> float:
    """a_ij at which two fluids at the pressure 41.89 have a chi: the inverse of `flory_huggins`.

    Parameters
    ----------
    one, other : Fluid
    chi : float
    reference_density : float

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If an argument is out of its range, or no repulsion gives that chi; the message says which
        are allowed.
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


def _transfer(fluid, into, a):
    """Density times free energy of moving a chain of a fluid from its own into another one."""
    beads, length = fluid.beads, fluid.length
    there = chain_potential(a, into.bead_density, beads, length)
    at_home = chain_potential(fluid.repulsion, fluid.bead_density, beads, length)
    return fluid.density * (there - at_home)


def _checked(fluid):
    above_zero("density of chains", fluid.density)
    above_zero("repulsion a", fluid.repulsion)
    bead_numbers("number of beads", fluid.beads)
    not_negative("bond length", fluid.length)
    return fluid
