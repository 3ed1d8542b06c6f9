"""The longest stretch of time over which a displacement follows a power law."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

if TYPE_CHECKING:
    from dpd.analysis.diffusion import Resampled

PER_DECADE = 1000  # points at which a level stretch may begin or end


class Plateau(NamedTuple):
    """The longest stretch of time over which g / t^x is level.

    - ``first``, ``last``: where it begins and ends, in tau.
    - ``decades``, ``error``: log10 of last / first, and its standard error.
    - ``low``, ``high``: g at both ends, in r_c^2.
    """

    first: float
    last: float
    decades: float
    error: float
    low: float
    high: float


def plateau(found: Resampled, power: float, within: float, low: float, high: float) -> Plateau:
    """The longest stretch over which g / t^x differs from its middle by no more than a share.

    It is looked for where g lies between two values: outside the subdiffusive window the slope
    passes through every x on its way. Every curve has one, though it may be short. A law t^y keeps
    to it over ln((1 + share) / (1 - share)) / |x - y| units of ln t.

    ``power``: x. ``within``: the share. ``low``, ``high``: of g, in r_c^2. Result: all NaN where
    there are fewer than four lags.
    """
    inside = (found.value >= low) & (found.value <= high)
    if inside.sum() < 4:
        return Plateau(*(np.nan,) * 6)
    logarithm = np.log(found.time[inside])
    count = int(PER_DECADE * (logarithm[-1] - logarithm[0]) / np.log(10)) + 2
    x = np.linspace(logarithm[0], logarithm[-1], count)  # finer than the lags, or errors were 0
    band = np.log((1 + within) / (1 - within))

    def stretch(g):
        y = np.interp(x, logarithm, np.log(g[inside]) - power * logarithm)
        return _longest_level(y, band)

    def decades(g):
        first, last = stretch(g)
        return (x[last] - x[first]) / np.log(10)

    length, error = found.derived(decades)
    error = np.hypot(error, 1 / (PER_DECADE * np.sqrt(6)))  # both ends lie on the grid
    ends = x[list(stretch(found.value))]
    first, last = np.exp(ends)
    squares = np.exp(np.interp(ends, logarithm, np.log(found.value[inside])))
    return Plateau(first, last, float(length), float(error), squares[0], squares[1])


def _longest_level(y, band):
    """First and last index of the longest stretch in which y varies by no more than a band."""

    def widths(size):
        middles = slice(size // 2, size // 2 + len(y) - size + 1)  # of stretches that are whole
        return (maximum_filter1d(y, size) - minimum_filter1d(y, size))[middles]

    size = bisect_left(range(1, len(y) + 1), True, key=lambda size: widths(size).min() > band)
    first = int(np.argmax(widths(size) <= band))
    return first, first + size - 1
