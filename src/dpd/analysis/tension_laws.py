"""How the tension of interfaces depends on chi and on the length of chains.

Groot and Warren (1997, Eqs. 33 and 36) describe their tensions by

    sigma / (rho kT r_c)  =  k chi^alpha (1 - critical / (chi N))^mu

Here any of the four numbers can be held, and the others are fitted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

# Where a fit begins: mean-field theory, of which only the numbers that are held are believed.
BEGIN = {"alpha": 0.5, "critical": 2.0, "mu": 1.5}
NEAREST = 1e-3  # of chi N to the critical point in a fit: below, there is no interface


class Fitted(NamedTuple):
    """A number of a fit and its standard error, 0 if it was held."""

    value: float
    error: float


NOTHING = Fitted(np.nan, np.nan)


class TensionLaw(NamedTuple):
    """The numbers of the law above.

    Attributes
    ----------
    prefactor, alpha, critical, mu : Fitted
        Standard errors, widened where points scatter more than their own errors allow.
    reduced_chi_square : float
        NaN without degrees of freedom.
    points : int
        That were fitted.
    """

    prefactor: Fitted
    alpha: Fitted
    critical: Fitted
    mu: Fitted
    reduced_chi_square: float
    points: int

    def at(self, chi: npt.ArrayLike, length: npt.ArrayLike = 1) -> np.ndarray:
        """Tension over rho kT r_c."""
        k, alpha, critical, mu = (part.value for part in self[:4])
        chi = np.asarray(chi, dtype=float)
        return k * chi**alpha * _near_critical(chi * length, critical, mu)


class Collapse(NamedTuple):
    """Tensions of groups with one chi each, brought to one curve of chi N.

    Attributes
    ----------
    prefactors : list of Fitted
        Of each group: its tensions are prefactor (1 - critical / (chi N))^mu.
    critical, mu : Fitted
        Of all groups.
    reduced_chi_square : float
    points : int
    """

    prefactors: list[Fitted]
    critical: Fitted
    mu: Fitted
    reduced_chi_square: float
    points: int


def tension_law(
    chi: npt.ArrayLike, length: npt.ArrayLike, tension: npt.ArrayLike, error: npt.ArrayLike,
    **held: float,
) -> TensionLaw:  # fmt: skip
    """Fit the law to tensions.

    Parameters
    ----------
    chi, length, tension, error : (n,) arrays
        chi for each bead, beads N of a chain, and the tension over rho kT r_c with its standard
        error. Points without an error, or with chi N below a held critical point, are left out.
    **held : float
        ``alpha``, ``critical`` or ``mu`` where they are not fitted.

    Returns
    -------
    TensionLaw
        NaN with fewer points than numbers to fit, or without convergence.
    """
    chi, length, tension, error = _broadcast(chi, length, tension, error)
    use = _usable(chi * length, error, held)
    chi, x, y, error = chi[use], (chi * length)[use], tension[use], error[use]
    free = [name for name in BEGIN if name not in held]

    def model(parameters):
        given = held | dict(zip(free, parameters[1:]))
        return (
            np.exp(parameters[0])
            * chi ** given["alpha"]
            * _near_critical(x, given["critical"], given["mu"])
        )

    found = _least_squares(model, [-0.5, *(BEGIN[name] for name in free)], y, error)
    if found is None:
        nothing = {name: _held(held, name) for name in BEGIN}
        return TensionLaw(NOTHING, **nothing, reduced_chi_square=np.nan, points=len(y))
    values, errors, quality = found
    parts = {name: Fitted(*pair) for name, *pair in zip(free, values[1:], errors[1:])}
    parts |= {name: Fitted(value, 0.0) for name, value in held.items()}
    return TensionLaw(
        _exponential(values[0], errors[0]), **parts, reduced_chi_square=quality, points=len(y)
    )


def collapse(
    group: npt.ArrayLike, segregation: npt.ArrayLike, tension: npt.ArrayLike,
    error: npt.ArrayLike, groups: int, **held: float,
) -> Collapse:  # fmt: skip
    """Bring groups of tensions to one curve of chi N.

    Parameters
    ----------
    group : (n,) array of int
        From 0: which group a point belongs to.
    segregation, tension, error : (n,) arrays
        chi N, the tension and its standard error, left out as in `tension_law`.
    groups : int
        How many there are.
    **held : float
        ``critical`` or ``mu`` where they are not fitted.

    Returns
    -------
    Collapse
        NaN as in `tension_law`, and for a group without points.
    """
    group = np.asarray(group)
    segregation, tension, error = _broadcast(segregation, tension, error)
    use = _usable(segregation, error, held)
    group, x, y, error = group[use], segregation[use], tension[use], error[use]
    present = [g for g in range(groups) if (group == g).any()]
    place = np.searchsorted(present, group)
    free = [name for name in ("critical", "mu") if name not in held]

    def model(parameters):
        given = held | dict(zip(free, parameters[len(present) :]))
        return np.exp(parameters[place]) * _near_critical(x, given["critical"], given["mu"])

    begin = [*np.zeros(len(present)), *(BEGIN[name] for name in free)]
    found = _least_squares(model, begin, y, error)
    prefactors = [NOTHING] * groups
    if found is None:
        return Collapse(prefactors, _held(held, "critical"), _held(held, "mu"), np.nan, len(y))
    values, errors, quality = found
    for g, *pair in zip(present, values, errors):
        prefactors[g] = _exponential(*pair)
    shape = {n: Fitted(*p) for n, *p in zip(free, values[len(present) :], errors[len(present) :])}
    shape |= {name: Fitted(value, 0.0) for name, value in held.items()}
    return Collapse(prefactors, shape["critical"], shape["mu"], quality, len(y))


def _near_critical(segregation, critical, mu):
    """(1 - critical / (chi N))^mu, and nearly 0 below the critical point."""
    return np.maximum(1 - critical / segregation, NEAREST) ** mu


def _broadcast(*parts):
    return np.broadcast_arrays(*(np.asarray(part, dtype=float) for part in parts))


def _usable(segregation, error, held):
    above = segregation > held.get("critical", 0.0) * (1 + NEAREST)
    return above & np.isfinite(error) & (error > 0)


def _least_squares(
    model: Callable[[np.ndarray], np.ndarray], begin: list[float], y: np.ndarray, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Values, errors and reduced chi-square; None where nothing can be fitted."""
    from scipy.optimize import least_squares  # most jobs need no SciPy

    degrees = len(y) - len(begin)
    if degrees < 0 or len(y) == 0:
        return None
    found = least_squares(lambda p: (model(np.asarray(p)) - y) / error, begin, method="lm")
    curvature = found.jac.T @ found.jac
    if not found.success or np.linalg.matrix_rank(curvature) < len(begin):
        return None
    quality = 2 * found.cost / degrees if degrees else np.nan
    widened = np.sqrt(max(1.0, quality)) if degrees else 1.0
    return found.x, widened * np.sqrt(np.diagonal(np.linalg.inv(curvature))), quality


def _exponential(logarithm, error):
    value = float(np.exp(logarithm))
    return Fitted(value, value * float(error))


def _held(held, name):
    return Fitted(held[name], 0.0) if name in held else NOTHING
