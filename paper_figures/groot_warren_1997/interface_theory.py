"""Mean-field theory of the tension between two melts of chains (Groot and Warren 1997, Sec. VI)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

# k of 1 - k / (chi N), the first correction for chains of finite length, their Eq. 29.
BROSETA = math.pi**2 / 6  # Broseta, Fredrickson, Helfand and Leibler 1990
HELFAND = 2 * math.log(2)  # Helfand, Bhattacharjee and Fredrickson 1989


def tension_of_long_chains(
    chi: npt.ArrayLike, density: float = 1.0, segment: float = 1.0
) -> np.ndarray:
    """Tension between melts of infinitely long chains in kT / r_c^2: kT rho b (chi / 6)^(1/2).

    Helfand's result for small chi; with one bead per site of a cubic lattice, rho b = 1.

    ``chi``: for each bead. ``density``: rho, beads per r_c^3. ``segment``: b in r_c: a long chain
    of N beads has the mean square end-to-end distance N b^2.
    """
    return density * segment * np.sqrt(np.asarray(chi, dtype=float) / 6)


def finite_length(segregation: npt.ArrayLike, k: float) -> np.ndarray:
    """Tension over that of infinitely long chains, to first order: 1 - k / (chi N).

    ``segregation``: chi N. ``k``: `BROSETA` or `HELFAND`.
    """
    return 1 - k / np.asarray(segregation, dtype=float)
