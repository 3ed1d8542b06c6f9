"""Flory-Huggins theory of two polymers of equal length (Groot and Warren 1997, Sec. V)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt


def free_energy(phi: npt.ArrayLike, chi: float, length: float = 1) -> float | np.ndarray:
    """F / kT per site, Eq. 17, for N_A = N_B = ``length``; phi is the fraction of A."""
    phi = np.asarray(phi, dtype=float)
    mixing = (phi * np.log(phi) + (1 - phi) * np.log(1 - phi)) / length
    return mixing + chi * phi * (1 - phi)


def chemical_potential(phi: npt.ArrayLike, chi: float, length: float = 1) -> float | np.ndarray:
    """dF/dphi / kT of Eq. 17."""
    phi = np.asarray(phi, dtype=float)
    return np.log(phi / (1 - phi)) / length + chi * (1 - 2 * phi)


def critical_chi(length_a: float = 1, length_b: float = 1) -> float:
    """chi at the critical point, Eq. 19."""
    return 0.5 * (1 / np.sqrt(length_a) + 1 / np.sqrt(length_b)) ** 2


def binodal(chi: float, length: float = 1) -> float:
    """Minority fraction of the coexisting phases.

    Raises `ValueError` if chi is not above the critical point, where there is one phase.
    """
    from scipy.optimize import brentq  # takes 0.3 s to import, and most figures need none

    _above_critical(chi, length)
    lowest = np.exp(-2.0 * chi * length)  # the fraction is exp(-chi N) for large chi N
    spinodal_point = spinodal(chi, length)
    return brentq(lambda phi: float(chemical_potential(phi, chi, length)), lowest, spinodal_point)


def spinodal(chi: float, length: float = 1) -> float:
    """Smaller fraction at which d^2 F / dphi^2 = 0.

    Raises `ValueError` if chi is not above the critical point.
    """
    _above_critical(chi, length)
    return 0.5 * (1 - np.sqrt(1 - 2 / (chi * length)))


def _above_critical(chi, length):
    if chi * length <= 2:
        raise ValueError(f"chi N = {chi * length:g}: the mixture is one phase; allowed: > 2")
