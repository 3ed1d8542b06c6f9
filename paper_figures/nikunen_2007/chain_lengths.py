"""What follows from several chain lengths: end effects, exponents, and where two regimes meet."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import likelihood, linear_fit, scatter

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt


class LongChains(NamedTuple):
    """A property of beads or bonds at a chain length that was not simulated.

    - ``value``, ``error``: there, with the standard error of the fit; NaN from fewer than three
      lengths.
    - ``slope``, ``slope_error``: change per share of ends.
    - ``p_value``: probability of points that lie worse about a straight line, if it is right.
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

    ``share``: (n,) array; 1 / N or 1 / (N - 1). ``value``, ``error``: (n,) arrays; with standard
    errors > 0. ``at``: the share to extrapolate to.
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


class Crossover(NamedTuple):
    """Where one power law of the chain length goes over into another.

    - ``length``, ``error``: NaN with too few lengths; the error is NaN where the lengths do not
      bound it on both sides.
    - ``p_value``: probability of points that lie worse about two power laws, if two are right.
    - ``straight``: the same of a single power law with a free exponent.
    """

    length: float
    error: float
    p_value: float
    straight: float


PLACES = 400  # at which the laws may meet


def crossover(
    length: np.ndarray,
    value: np.ndarray,
    error: np.ndarray,
    exponents: Sequence[float | None] = (None, None),
) -> Crossover:
    """Fit two power laws that meet to all lengths, whichever side of their meeting they are on.

    ``length``, ``value``, ``error``: (n,) arrays; errors are standard errors. ``exponents``: of
    short and of long chains; None for one that is fitted. Result: its place is where chi-square is
    least, its error half the width over which that rises by one, or by the reduced chi-square where
    that is larger than errors explain.
    """
    use = np.isfinite(value) & (error > 0)
    order = np.argsort(length[use])
    x, y = (np.log(values[use][order]) for values in (length, value))
    spread = (error[use] / value[use])[order]
    fitted = sum(exponent is None for exponent in exponents)
    degrees = len(x) - 2 - fitted  # a height and the place are fitted too
    if degrees < 1:
        return Crossover(*(np.nan,) * 4)
    # A free exponent takes two lengths on its side of the place.
    low, high = (x[int(exponents[0] is None)], x[-1 - int(exponents[1] is None)])
    places = np.linspace(low, high, PLACES)
    worse = _bent(places[:, np.newaxis], x, y, spread, exponents)
    best = int(worse.argmin())
    there = float(np.exp(places[best]))
    height = worse[best] + scatter(float(worse[best]), degrees) ** 2
    shorter = _reaches(places[best::-1], worse[best::-1], height)
    longer = _reaches(places[best:], worse[best:], height)
    straight = linear_fit([np.ones_like(x), x], y, spread).p_value
    half = 0.5 * (longer - shorter)
    return Crossover(there, there * half, likelihood(float(worse[best]), degrees), straight)


def _reaches(places, worse, height):
    """The first place at which chi-square reaches a height; NaN if it does not."""
    above = np.flatnonzero(worse >= height)
    if not len(above):
        return np.nan
    k = above[0]
    return float(np.interp(height, worse[k - 1 : k + 1], places[k - 1 : k + 1]))


def _bent(place, x, y, spread, exponents):
    """Chi-square of two lines that meet at a place, for a column of places at once."""
    sides = [np.minimum(x - place, 0), np.maximum(x - place, 0)]
    rest = y - sum(e * side for e, side in zip(exponents, sides) if e is not None)
    free = [side for e, side in zip(exponents, sides) if e is None]
    rest = (rest + np.zeros_like(sides[0])) / spread
    basis, _ = np.linalg.qr(np.stack([np.ones_like(sides[0]), *free], axis=-1) / spread[:, None])
    taken = basis @ (np.swapaxes(basis, -1, -2) @ rest[..., None])
    return ((rest - taken[..., 0]) ** 2).sum(axis=-1)
