"""What follows from several chain lengths: end effects, exponents, and where two regimes meet."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import linear_fit

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt


class LongChains(NamedTuple):
    """A property of beads or bonds at a chain length that was not simulated.

    Attributes
    ----------
    value, error : float
        There, with the standard error of the fit; NaN from fewer than three lengths.
    slope, slope_error : float
        Change per share of ends.
    p_value : float
        Probability of points that lie worse about a straight line, if it is right.
    """

    value: float
    error: float
    slope: float
    slope_error: float
    p_value: float


def end_effect(share: npt.ArrayLike, value: np.ndarray, error: np.ndarray, at: float) -> LongChains:
    """Extrapolate a mean over beads or bonds in the share of chain ends.

    A bond next to an end has another mean than one far from both ends. Of the N - 1 bonds of a
    chain a fixed number feels the ends, so a mean over bonds, of lengths or of a histogram, is a
    constant plus a term in 1 / (N - 1), and nothing else, as soon as the two ends do not feel each
    other. For a mean over beads, such as g(r), the same holds with 1 / N. A place where a
    histogram has a given height moves in proportion as long as it moves little.

    Parameters
    ----------
    share : (n,) array
        1 / N or 1 / (N - 1).
    value, error : (n,) arrays
        With standard errors > 0.
    at : float
        The share to extrapolate to.

    Returns
    -------
    LongChains
    """
    use = np.isfinite(value) & (error > 0)
    if use.sum() < 3:
        return LongChains(*(np.nan,) * 5)
    shift = np.asarray(share)[use] - at  # so that the constant is the value there
    fit = linear_fit([np.ones_like(shift), shift], value[use], error[use])
    (there, slope), (there_error, slope_error) = fit.values, fit.errors
    return LongChains(
        float(there), float(there_error), float(slope), float(slope_error), fit.p_value
    )


class Power(NamedTuple):
    """value ~ N^exponent, as ln value = height + exponent (ln N - ln middle)."""

    exponent: float
    error: float
    height: float
    height_error: float


def power(
    length: np.ndarray,
    value: np.ndarray,
    error: np.ndarray,
    low: float,
    high: float,
    exponent: float | None = None,
    about: float = 1.0,
) -> Power:
    """Exponent of value ~ N^x for low <= N <= high.

    Parameters
    ----------
    length, value, error : (n,) arrays
        Errors are standard errors.
    low, high : float
    exponent : float or None
        Given, it is not fitted.
    about : float
        The length at which ``height``, the logarithm of the value, is given.

    Returns
    -------
    Power
        NaN with fewer than three lengths, as any two lie on a power law; with a given exponent
        one is enough.
    """
    use = (length >= low) & (length <= high) & np.isfinite(value) & (error > 0)
    if use.sum() < (3 if exponent is None else 1):
        return Power(*(np.nan,) * 4)
    x, y, spread = np.log(length[use] / about), np.log(value[use]), error[use] / value[use]
    if exponent is not None:
        fit = linear_fit([np.ones_like(x)], y - exponent * x, spread)
        (height,), (height_error,) = fit.values, fit.errors
        return Power(exponent, 0.0, float(height), float(height_error))
    fit = linear_fit([np.ones_like(x), x], y, spread)
    (height, free), (height_error, free_error) = fit.values, fit.errors
    return Power(float(free), float(free_error), float(height), float(height_error))


def meeting(
    length: np.ndarray,
    value: np.ndarray,
    error: np.ndarray,
    regimes: Sequence[tuple[float, float]],
    exponents: Sequence[float | None] = (None, None),
) -> tuple[float, float]:
    """Chain length at which the power laws of two regimes meet.

    Parameters
    ----------
    length, value, error : (n,) arrays
    regimes : pair of (low, high)
        Lengths that each law is fitted to; no length may lie in both.
    exponents : pair of float or None
        Exponents that are given; None for those that are fitted.

    Returns
    -------
    length, error : float
        NaN where a regime has too few lengths. The error is that of both lines where they meet,
        over the difference of their slopes: first-order propagation, without approximation of
        how height and slope of a line go together.
    """

    def laws(about):
        return [
            power(length, value, error, low, high, exponent, about)
            for (low, high), exponent in zip(regimes, exponents)
        ]

    short, long = laws(1.0)
    steeper = long.exponent - short.exponent
    if not np.isfinite(steeper) or steeper == 0:
        return np.nan, np.nan
    there = float(np.exp((short.height - long.height) / steeper))
    if not 0 < there < np.inf:
        return np.nan, np.nan
    short, long = laws(there)
    apart = np.hypot(short.height_error, long.height_error)
    return there, float(there * apart / abs(steeper))
