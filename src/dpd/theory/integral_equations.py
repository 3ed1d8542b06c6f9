"""Structure of a fluid of soft beads from the Ornstein-Zernike equation with the HNC closure.

Beads of species i and j repel each other with u_ij(r) = a_ij (1 - r)^2 / 2 below r = 1. Lengths are
in units of r_c, energies in kT, and a_ij in kT / r_c. The Ornstein-Zernike equation

    h_ij(r) = c_ij(r) + sum_k rho_k integral c_ik(|r - s|) h_kj(s) ds

defines the direct correlation function c by h = g - 1, and the *hypernetted chain* (HNC) closure
g = exp(-u + h - c) closes it. The unknown here is gamma = h - c, which is smooth, and in HNC the
logarithm of the cavity function y = exp(u) g.

Grids of `POINTS` distances and wave numbers leave out 0, as the sine transform does:

    f(k) = 4 pi / k integral r f(r) sin(k r) dr,
    f(r) = 1 / (2 pi^2 r) integral k f(k) sin(k r) dk

With half of the spacing, or of the range, pressures change by less than 2e-5 up to a = 130.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.fft import dst
from scipy.interpolate import CubicSpline
from scipy.optimize import NoConvergence, newton_krylov

SPACING = 0.01  # of distances, in r_c; that where the potential ends is a point of the grid
POINTS = 2047  # a power of two less one, for which the sine transform is fastest
RANGE = (POINTS + 1) * SPACING
R = SPACING * np.arange(1, POINTS + 1)
K = np.pi / RANGE * np.arange(1, POINTS + 1)
TOLERANCE = 1e-9  # largest error of gamma
MOST_STEPS = 25  # of Newton's method; a solution that is there needs three to eight
LARGEST_PART = 1 / 16  # of the repulsions, by which they are raised where this is hard
CLOSEST = 1 / 64  # how near the last state is that converged, where there is no solution
SMALLEST_PART = 2.0**-20  # of the repulsions, if they are far too large


class Structure(NamedTuple):
    """Solution of the integral equation for n species, at the distances `R`."""

    densities: np.ndarray  # (n,), beads per r_c^3
    repulsions: np.ndarray  # (n, n), a_ij
    gamma: np.ndarray  # (POINTS, n, n), h - c
    c: np.ndarray  # (POINTS, n, n), the direct correlation function

    @property
    def h(self) -> np.ndarray:
        """Total correlation function, shape (POINTS, n, n)."""
        return self.gamma + self.c

    @property
    def g(self) -> np.ndarray:
        """Radial distribution functions, shape (POINTS, n, n)."""
        return 1 + self.h

    def ln_y(self, distance: npt.ArrayLike) -> np.ndarray:
        """Logarithm of the cavity functions y = exp(u) g, (*distance.shape, n, n)."""
        return at_distances(self.gamma, distance)


def solve(
    densities: npt.ArrayLike, repulsions: npt.ArrayLike, start: Structure | None = None
) -> Structure:
    """Solve the Ornstein-Zernike equation with the HNC closure.

    Newton's method starts from the structure of a similar fluid, or from the random phase
    approximation c = -u; where this leads nowhere the repulsions are raised from 0 in steps.

    ``densities``: float or (n,) array; beads of each species per r_c^3. Those of a solute may be 0.
    ``repulsions``: float or (n, n) array; a_ij = a_ji, 0 or more. Raises `ValueError` if
    none was found, as of a mixture that separates, or of a number below 0.

    Examples
    --------
    >>> fluid = solve(3, 25)
    >>> round(float(fluid.g[0, 0, 0]), 3)  # at the distance R[0] = 0.01
    0.001
    """
    rho = np.atleast_1d(checked("density", densities))
    a = np.atleast_2d(checked("repulsion", repulsions))
    first = _gamma_of(-potentials(a), rho) if start is None else start.gamma
    if (found := _converged(rho, a, first)) is not None:
        return found
    # The repulsions are raised from 0 in steps, each from the structure before it. Small ones:
    # beyond states without a solution there may be some that do not belong to the fluid.
    last = Structure(rho, 0 * a, potentials(0 * a), potentials(0 * a))
    reached, part = 0.0, LARGEST_PART
    while reached < 1:
        aim = min(reached + part, 1.0)
        found = _converged(rho, aim * a, last.gamma)
        if found is not None:
            last, reached = found, aim
        elif part > max(CLOSEST * reached, SMALLEST_PART):
            part /= 2
        else:
            fluid = ", ".join(f"{value:.5g}" for value in rho)
            each = ", ".join(f"{value:.5g}" for value in a[np.triu_indices(len(rho))])
            raise ValueError(
                f"HNC has no solution at density {fluid} and repulsion {each}; the last state that "
                f"converged has repulsions {reached:.4g} times these"
            )
    return last


def checked(
    name: str, values: npt.ArrayLike, good: Callable = lambda x: x >= 0, allowed: str = "0 or more"
) -> np.ndarray:
    """Values as floats. Raises `ValueError` if one is not finite, or not good."""
    found = np.asarray(values, dtype=float)
    bad = found[~good(found) | ~np.isfinite(found)]
    if bad.size:
        raise ValueError(f"{name}: {bad.flat[0]:g} is out of range; allowed: {allowed}")
    return found


def transform(values: np.ndarray) -> np.ndarray:
    """Three-dimensional Fourier transforms, at `K`, of functions at `R`, shape (POINTS, n, n)."""
    r, k = R[:, None, None], K[:, None, None]
    return 2 * np.pi * SPACING / k * dst(r * values, type=1, axis=0)


def potentials(repulsions: np.ndarray) -> np.ndarray:
    """u_ij at the distances `R`, shape (POINTS, n, n)."""
    return 0.5 * np.maximum(1 - R, 0)[:, None, None] ** 2 * repulsions


def at_distances(values: np.ndarray, distance: npt.ArrayLike) -> np.ndarray:
    """Even functions, (POINTS, ...) at `R`, at other distances on the grid, by cubic splines."""
    points = checked("distance", distance, lambda r: (r >= 0) & (r <= R[-1]), f"0 to {R[-1]:g}")
    both_sides = np.concatenate([-R[::-1], R])
    return CubicSpline(both_sides, np.concatenate([values[::-1], values]))(points)


def _gamma_of(c, rho):
    """gamma from the direct correlation functions, by the Ornstein-Zernike equation."""
    ck = transform(c)
    matrices = np.eye(len(rho)) - ck * rho  # (1 - c rho) h = c for each wave number
    # For a single species a division, which is much faster.
    hk = ck / matrices if len(rho) == 1 else np.linalg.solve(matrices, ck)
    r, k = R[:, None, None], K[:, None, None]
    return 1 / (4 * np.pi * RANGE * r) * dst(k * (hk - ck), type=1, axis=0)  # back to distances


def _closure(gamma, u):
    """The direct correlation functions of HNC, exp(-u + gamma) - 1 - gamma."""
    return np.expm1(gamma - u) - gamma


def _converged(rho, a, start):
    """The structure that Newton's method finds from a start; None if that is none."""
    u = potentials(a)
    upper = np.triu_indices(len(rho))  # gamma_ij = gamma_ji: each pair of species once

    def full(pairs):
        gamma = np.empty_like(u)
        gamma[:, *upper] = gamma[:, *upper[::-1]] = pairs
        return gamma

    def residual(pairs):
        gamma = full(pairs)
        return (_gamma_of(_closure(gamma, u), rho) - gamma)[:, *upper]

    try:
        with np.errstate(all="ignore"):  # a step that is too long; Newton's method takes it back
            pairs = newton_krylov(
                residual, start[:, *upper], method="gmres", f_tol=TOLERANCE, maxiter=MOST_STEPS
            )
    except (NoConvergence, ValueError, OverflowError, np.linalg.LinAlgError):
        return None
    gamma = full(pairs)
    found = Structure(rho, a, gamma, _closure(gamma, u))
    # It is stable if all fluctuations of densities cost free energy: 1 - c sqrt(rho rho) > 0.
    root = np.sqrt(rho)
    matrices = np.eye(len(root)) - root[:, None] * transform(found.c) * root
    stable = np.isfinite(matrices).all() and np.linalg.eigvalsh(matrices).min() > 0
    return found if stable else None
