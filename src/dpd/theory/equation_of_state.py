"""Second virial coefficients of soft beads and of chains, and three equations of state.

- GW: Groot and Warren, J. Chem. Phys. 107, 4423 (1997).
- rGW, revised: Liyana-Arachchi et al., J. Chem. Phys. 142, 044902 (2015). It has the right second
  virial coefficient at low density.
- crGW, chain-revised: Minkara et al., J. Chem. Phys. 150, 124104 (2019), here "the paper". It knows
  how many beads a chain has, and how long its bonds are.

Lengths are in units of r_c, energies in kT, the repulsion a in kT / r_c, pressures in kT / r_c^3.
Arguments are numbers or arrays; arrays are broadcast against each other.
"""

from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import erf

from dpd.theory.integral_equations import R, at_distances, checked, solve

# Pressure coefficient alpha when g(r) = 1: -1 / (2 d) times the integral of r u'(r) / a.
MEAN_FIELD = {2: np.pi / 24.0, 3: np.pi / 30.0}
ALPHA = 0.101  # of GW, Eq. 1 of the paper
C1, C2 = 0.0802, 0.7787  # of F_alpha, Eq. 4
GAMMA, A, DELTA = 0.926, 1.954, 1.57  # of Eq. 24
ETA, BETA = 41.083, 1.967  # of the term of the bonds, below Eq. 14
DENSITY_STEP = 0.05  # of the central difference d ln y / d rho, below Eq. 10
LARGEST = 1000.0  # the inverses look among powers of 2 up to the first above this repulsion
SMALLEST = 1e-3  # below this repulsion they take the pressure as linear in it
_above_zero = partial(checked, good=lambda x: x > 0, allowed="numbers above 0")


def second_virial(repulsion: npt.ArrayLike, dimension: int = 3) -> float | np.ndarray:
    """B2 = -1/2 times the integral of exp(-u) - 1 over space, u = a (1 - r)^2 / 2, a > 0.

    In r_c^dimension, of 2 or 3. Groot and Warren 1997, below Fig. 4, give B2 / a.
    """
    a = np.asarray(repulsion, dtype=float)
    i0 = np.sqrt(np.pi / (2.0 * a)) * erf(np.sqrt(a / 2.0))
    i1 = (1.0 - np.exp(-a / 2.0)) / a
    if dimension == 2:
        return np.pi * (0.5 - (i0 - i1))
    i2 = (i0 - np.exp(-a / 2.0)) / a
    return 2.0 * np.pi * (1.0 / 3.0 - (i0 - 2.0 * i1 + i2))


def chain_second_virial(
    a: npt.ArrayLike, m: npt.ArrayLike, length: npt.ArrayLike
) -> float | np.ndarray:
    """B2 of two chains of m beads in r_c^3 by the paper's fit, Eqs. 18, 22 and 24.

    The paper says that it is right within 1.6 %; it lies 4 to 19 % below our samples of two chains.
    """
    beads, bond = np.asarray(m, dtype=float), np.asarray(length, dtype=float)
    stronger = beads ** (2 / (bond + 1) ** 3)
    larger = A * ((1 - GAMMA) * beads**2 + GAMMA * beads - 1) * bond**DELTA + 1
    return larger * second_virial(stronger * np.asarray(a, dtype=float))


def virial_switch(density: npt.ArrayLike) -> np.ndarray:
    """F_B2 of Eq. 3, from 1 at density 0 to 0."""
    return 1 / (1 + np.asarray(density, dtype=float) ** 3)


def quadratic_switch(density: npt.ArrayLike) -> np.ndarray:
    """F_alpha of Eq. 4, from 0 at density 0 to about the 0.101 of GW."""
    square = np.asarray(density, dtype=float) ** 2
    return C1 * square / (1 + C2 * square)


def gw(density: npt.ArrayLike, a: npt.ArrayLike) -> float | np.ndarray:
    """Pressure of a density of beads, also of chains, by Groot and Warren, Eq. 1 of the paper."""
    rho, strength = _above_zero("density", density), _above_zero("repulsion a", a)
    return rho + ALPHA * strength * rho**2


def rgw(density: npt.ArrayLike, a: npt.ArrayLike) -> float | np.ndarray:
    """Pressure by the revised equation, Eq. 2 of the paper."""
    rho, strength = _above_zero("density", density), _above_zero("repulsion a", a)
    factor = second_virial(strength) * virial_switch(rho) + strength * quadratic_switch(rho)
    return rho + factor * rho**2


def crgw(
    rho_chain: npt.ArrayLike, a: npt.ArrayLike, m: npt.ArrayLike = 1, length: npt.ArrayLike = 0.0
) -> float | np.ndarray:
    """Pressure by the chain-revised equation, Eq. 14 of the paper.

    The cavity function of single beads at the density of the chains' beads is from `solve`. For
    m = 1 the equation is that of `rgw`.

    ``rho_chain``: chains per r_c^3. ``m``, ``length``: beads of a chain, and the length of a bond.
    Raises `ValueError` if the integral equation has none.

    Examples
    --------
    >>> round(float(crgw(3.432, 8.57, 2, 0.39)), 1)
    42.0
    """
    rho, strength = _above_zero("density of chains", rho_chain), _above_zero("repulsion a", a)
    m = checked("number of beads", m, lambda m: (m >= 1) & (m == np.round(m)), "1, 2, 3, ...")
    length = checked("bond length", length, lambda x: (x >= 0) & (x <= R[-1]), f"0 to {R[-1]:g}")
    rho, strength, beads, bond = np.broadcast_arrays(rho, strength, m, length)
    x = beads * rho
    slope = ln_y_slope(x, strength, bond, where=beads > 1)
    bonds = ETA * (beads - 1) / (beads + BETA) * slope
    virial = virial_switch(rho) * chain_second_virial(strength, beads, bond) * rho**2
    return rho + virial + quadratic_switch(x) * x**2 * (strength - bonds)


def ln_y_slope(
    density: npt.ArrayLike, a: npt.ArrayLike, length: npt.ArrayLike, where: npt.ArrayLike = True
) -> np.ndarray:
    """d ln y(length) / d density of single beads, by a central difference; 0 but ``where``."""

    def slope(rho, a, distance, needed):
        return at_distances(_slopes(float(rho), float(a)), distance) if needed else 0.0

    return np.vectorize(slope, otypes=[float])(density, a, length, where)


def repulsion_of(
    pressure: npt.ArrayLike, equation: Callable, density: npt.ArrayLike, *chain: npt.ArrayLike
) -> float | np.ndarray:
    """The repulsion at which `gw`, `rgw` or `crgw` gives a pressure.

    ``density``, ``chain``: what the equation takes before and behind the repulsion. Raises
    `ValueError` if no repulsion does.

    Examples
    --------
    >>> round(float(repulsion_of(41.89, crgw, 3.432, 2, 0.39)), 2)
    8.54
    """
    p, rho = _above_zero("pressure", pressure), _above_zero("density", density)
    found = np.vectorize(partial(_repulsion, equation), otypes=[float])
    return found(p, rho, *chain)[()]


@lru_cache(maxsize=1024)
def _slopes(density, a):
    """d ln y / d density at the distances of the grid; one fluid serves chains of any bonds."""
    step = min(DENSITY_STEP, density / 2)
    lower = solve(density - step, a)
    upper = solve(density + step, a, start=lower)
    return (upper.gamma - lower.gamma)[:, 0, 0] / (2 * step)


def _repulsion(equation, wanted, ideal, *chain):
    """A repulsion that gives a pressure, found between powers of 2."""
    if wanted <= ideal:
        raise ValueError(
            f"pressure: no repulsion gives {wanted:g}; allowed: more than {ideal:g}, the pressure "
            "of an ideal gas of this density"
        )

    def pressure_of(a):
        return float(equation(ideal, a, *chain))

    weak = pressure_of(SMALLEST)
    if weak >= wanted:  # the pressure is linear there
        return SMALLEST * (wanted - ideal) / (weak - ideal)
    low, high = SMALLEST, 1.0
    while (most := pressure_of(high)) < wanted and high < LARGEST:
        low, high = high, 2 * high
    if most >= wanted:
        return brentq(lambda a: pressure_of(a) - wanted, low, high, xtol=1e-10)
    raise ValueError(
        f"pressure: no repulsion up to {high:g} gives {wanted:g}, and that gives {most:.5g}; "
        "allowed: less, or a higher density"
    )
