"""How the tension of interfaces depends on chi and on the length of chains.

Groot and Warren (1997, Eqs. 33 and 36) describe their tensions by

    sigma / (rho kT r_c)  =  k chi^alpha (1 - critical / (chi N))^mu

Here any of the four numbers can be held, and the others are fitted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import likelihood, scatter

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

# Where a fit begins: mean-field theory, of which only the numbers that are held are believed.
BEGIN = {"alpha": 0.5, "critical": 2.0, "mu": 1.5}
FIRST_HEIGHT = -0.5  # logarithm of a height
NEAREST = 1e-3  # of chi N to the critical point in a fit: below, there is no interface
CONVERGED = (1, 2, 3, 4)  # what MINPACK returns then
DOUBLINGS = 8  # of a first guess at an error
CLOSE = 1e-4  # of that guess, within which an error is found


class Fitted(NamedTuple):
    """A number of a fit and its standard error, 0 if it was held."""

    value: float
    error: float


NOTHING = Fitted(np.nan, np.nan)


class TensionLaw(NamedTuple):
    """The numbers of the law above.

    - ``prefactor``, ``alpha``, ``critical``, ``mu``: standard errors, widened as by
      `dpd.analysis.statistics.scatter`.
    - ``reduced_chi_square``: NaN without degrees of freedom.
    - ``points``, ``degrees``: how many were fitted, and how many degrees of freedom they have.
    """

    prefactor: Fitted
    alpha: Fitted
    critical: Fitted
    mu: Fitted
    reduced_chi_square: float
    points: int
    degrees: int

    @property
    def p_value(self) -> float:
        """Probability of points that lie worse about the law, if it is right; NaN without any."""
        return likelihood(self.reduced_chi_square * self.degrees, self.degrees)

    def at(self, chi: npt.ArrayLike, length: npt.ArrayLike = 1) -> np.ndarray:
        """Tension over rho kT r_c."""
        k, alpha, critical, mu = (part.value for part in self[:4])
        of_bead, beads = _broadcast(chi, length)
        return k * of_bead**alpha * _near_critical(of_bead * beads, critical, mu)


class Collapse(NamedTuple):
    """Tensions of groups with one chi each, brought to one curve of chi N.

    - ``prefactors``: of each group: its tensions are prefactor (1 - critical / (chi N))^mu.
    - ``critical``, ``mu``: of all groups.
    """

    prefactors: list[Fitted]
    critical: Fitted
    mu: Fitted
    reduced_chi_square: float
    points: int
    degrees: int

    @property
    def p_value(self) -> float:
        """As of `TensionLaw`."""
        return likelihood(self.reduced_chi_square * self.degrees, self.degrees)


def tension_law(
    chi: npt.ArrayLike, length: npt.ArrayLike, tension: npt.ArrayLike, error: npt.ArrayLike,
    **held: float,
) -> TensionLaw:  # fmt: skip
    """Fit the law to tensions.

    ``chi``, ``length``, ``tension``, ``error``: (n,) arrays; chi for each bead, beads N of a chain,
    and the tension over rho kT r_c with its standard error. Points without an error, or with chi N
    below a held critical point, are left out. ``**held``: ``alpha``, ``critical`` or ``mu`` where
    they are not fitted. Result: NaN with fewer points than numbers to fit, or without convergence.
    """
    each = _broadcast(chi, length, tension, error)
    use = _usable(each[0] * each[1], each[3], held)
    of_bead, beads, y, spread = (part[use] for part in each)
    x = of_bead * beads

    def model(heights, given):
        of_chi = of_bead ** given["alpha"]
        return heights[0] * of_chi * _near_critical(x, given["critical"], given["mu"])

    found = _fitted(model, 1, list(BEGIN), held, _Points(y, spread))
    shape = {name: found.shape[name] for name in BEGIN}
    return TensionLaw(
        found.heights[0], **shape, reduced_chi_square=found.quality, points=len(y),
        degrees=found.degrees,
    )  # fmt: skip


def collapse(
    group: npt.ArrayLike, segregation: npt.ArrayLike, tension: npt.ArrayLike,
    error: npt.ArrayLike, groups: int, **held: float,
) -> Collapse:  # fmt: skip
    """Bring groups of tensions to one curve of chi N.

    ``group``: (n,) array of int; from 0: which group a point belongs to. ``segregation``,
    ``tension``, ``error``: (n,) arrays; chi N, the tension and its standard error, left out as in
    `tension_law`. ``groups``: how many there are. ``**held``: ``critical`` or ``mu`` where they are
    not fitted. Result: NaN as in `tension_law`, and for a group without points.
    """
    each = _broadcast(segregation, tension, error)
    use = _usable(each[0], each[2], held)
    x, y, spread = (part[use] for part in each)
    of_point = np.asarray(group)[use]
    present = [g for g in range(groups) if (of_point == g).any()]
    place = np.searchsorted(present, of_point)

    def model(heights, given):
        return heights[place] * _near_critical(x, given["critical"], given["mu"])

    found = _fitted(model, len(present), ["critical", "mu"], held, _Points(y, spread))
    prefactors = [NOTHING] * groups
    for g, height in zip(present, found.heights):
        prefactors[g] = height
    return Collapse(
        prefactors, found.shape["critical"], found.shape["mu"], found.quality, len(y), found.degrees
    )


class _Points(NamedTuple):
    """What is fitted."""

    y: np.ndarray
    error: np.ndarray


class _Best(NamedTuple):
    """Heights and numbers of the shape, with errors, reduced chi-square, degrees of freedom."""

    heights: list[Fitted]
    shape: dict[str, Fitted]
    quality: float
    degrees: int


class _Minimum(NamedTuple):
    """Parameters of the least squares, their covariance, and chi-square."""

    values: np.ndarray
    covariance: np.ndarray
    chi_square: float


def _fitted(
    model: Callable[..., np.ndarray], heights: int, names: list[str], held: dict[str, float],
    points: _Points,
) -> _Best:  # fmt: skip
    """Fit heights, which are positive, and what is not held of the numbers of a shape."""
    free = [name for name in names if name not in held]
    shape = {name: Fitted(held[name], 0.0) if name in held else NOTHING for name in names}
    degrees = len(points.y) - heights - len(free)
    best = None
    if degrees >= 0 and len(points.y):
        best = _least_squares(model, heights, free, held, points)
    if best is None:
        return _Best([NOTHING] * heights, shape, np.nan, 0)
    quality = best.chi_square / degrees if degrees else np.nan
    widened = scatter(best.chi_square, degrees)
    errors = widened * np.sqrt(np.diagonal(best.covariance))
    for name, value, error in zip(free, best.values[heights:], errors[heights:]):

        def rise(at, name=name):
            rest = [other for other in free if other != name]
            begin = np.delete(best.values, heights + free.index(name))
            there = _least_squares(model, heights, rest, held | {name: at}, points, begin)
            return np.inf if there is None else there.chi_square - best.chi_square - widened**2

        shape[name] = Fitted(float(value), _reach(rise, float(value), float(error)))
    tops = np.exp(best.values[:heights])
    found = [Fitted(float(k), float(k * error)) for k, error in zip(tops, errors)]
    return _Best(found, shape, quality, degrees)


def _reach(rise: Callable[[float], float], value: float, error: float) -> float:
    """Half of the width over which a number can be.

    At both ends chi-square with this number held and all others fitted has risen by one: near a
    critical point no parabola describes it, and the error of a linear fit would be too small. The
    farther end alone would be too much: the rms z of two such fits was 0.6 to 0.8.
    """
    from scipy.optimize import brentq  # most jobs need no SciPy

    if not rise(value) < 0:
        return np.nan  # the fit has not found its minimum
    ends = []
    for side in (-1, 1):
        step = error
        for _ in range(DOUBLINGS):
            if rise(value + side * step) > 0:
                break
            step *= 2
        else:
            return np.nan  # nothing limits it

        def rises(distance, side=side):
            return min(rise(value + side * distance), 1e9)

        ends.append(brentq(rises, 0, step, xtol=CLOSE * step))
    return float(sum(ends) / 2)


def _near_critical(segregation, critical, mu):
    """(1 - critical / (chi N))^mu, and nearly 0 below the critical point."""
    return np.maximum(1 - critical / segregation, NEAREST) ** mu


def _broadcast(*parts):
    return np.broadcast_arrays(*(np.asarray(part, dtype=float) for part in parts))


def _usable(segregation, error, held):
    above = segregation > held.get("critical", 0.0) * (1 + NEAREST)
    return above & np.isfinite(error) & (error > 0)


def _least_squares(
    model: Callable[..., np.ndarray], heights: int, free: list[str], held: dict[str, float],
    points: _Points, begin: np.ndarray | None = None,
) -> _Minimum | None:  # fmt: skip
    """The best parameters: logarithms of heights, then numbers; None where there are none."""
    from scipy.optimize import leastsq  # which finds slopes itself: a fifth of the time

    def misses(parameters):
        given = held | dict(zip(free, parameters[heights:]))
        return (model(np.exp(parameters[:heights]), given) - points.y) / points.error

    if begin is None:
        begin = np.array([*np.full(heights, FIRST_HEIGHT), *(BEGIN[name] for name in free)])
    with np.errstate(over="ignore", invalid="ignore"):  # steps too far, from which it returns
        found, covariance, rest, _, code = leastsq(misses, begin, full_output=True)
    if covariance is None or code not in CONVERGED:
        return None
    return _Minimum(found, covariance, float((rest["fvec"] ** 2).sum()))
