"""Pressure, energy and chemical potential of a fluid from its structure in HNC.

Units as in `dpd.theory.integral_equations`: lengths in r_c, energies in kT.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import simpson

from dpd.theory.integral_equations import SPACING, R, solve

if TYPE_CHECKING:
    import numpy.typing as npt

    from dpd.theory.integral_equations import Structure

INSIDE = round(1 / SPACING)  # grid points up to the end of the potential


def pressure(structure: Structure) -> float:
    """Virial pressure, in kT / r_c^3.

    rho - 2 pi / 3 sum_ij rho_i rho_j integral r^3 u_ij'(r) g_ij(r) dr.
    """
    return float(structure.densities.sum() + _sum_over_pairs(structure, R**3 * (1 - R)) / 3)


def energy(structure: Structure) -> float:
    """Potential energy per volume, in kT / r_c^3.

    2 pi sum_ij rho_i rho_j integral r^2 u_ij(r) g_ij(r) dr.
    """
    return float(_sum_over_pairs(structure, R**2 * (1 - R) ** 2 / 2))


def excess_chemical_potentials(structure: Structure) -> np.ndarray:
    """Excess chemical potential of each species, in kT, shape (n,).

    The closed form of HNC, sum_j rho_j integral (h_ij gamma_ij / 2 - c_ij) over space. For a
    species of density 0 it is that of a solute at infinite dilution.
    """
    integrals = _over_space(structure.h * structure.gamma / 2 - structure.c)
    return integrals @ structure.densities


def inverse_compressibility(structure: Structure) -> float:
    """dp / d rho at constant composition, from the structure at small wave numbers.

    1 - sum_ij rho_i rho_j / rho integral c_ij over space, in kT. In HNC it is not quite the slope
    of the virial pressure: theories of this kind are not consistent in that.
    """
    rho = structure.densities
    return float(1 - rho @ _over_space(structure.c) @ rho / rho.sum())


def compressibility_pressure(
    densities: npt.ArrayLike, repulsions: npt.ArrayLike, points: int = 16
) -> float:
    """Pressure by integration of the inverse compressibility from density 0 on, in kT / r_c^3.

    The densities (n,) of the species keep their ratio on the way there; ``points`` is the number of
    densities of the Gauss-Legendre rule, each a solution of the integral equation.
    """
    rho = np.atleast_1d(densities)
    nodes, weights = np.polynomial.legendre.leggauss(points)
    slopes = [inverse_compressibility(solve((node + 1) / 2 * rho, repulsions)) for node in nodes]
    return float(weights @ slopes / 2 * rho.sum())


def _sum_over_pairs(structure, weight):
    """2 pi sum_ij rho_i rho_j a_ij integral of weight g_ij from 0 to 1."""
    values = (weight[:, None, None] * structure.g)[:INSIDE]
    at_zero = np.zeros((1, *values.shape[1:]))  # the weights have powers of the distance
    integrals = simpson(np.concatenate([at_zero, values]), dx=SPACING, axis=0)
    rho = structure.densities
    return 2 * np.pi * rho @ (structure.repulsions * integrals) @ rho


def _over_space(values):
    """4 pi integral r^2 f(r) dr of functions that vanish at the end of the grid."""
    return 4 * np.pi * SPACING * np.tensordot(R**2, values, axes=1)
