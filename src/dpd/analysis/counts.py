"""Bounds on the mean of a count of rare, independent events, as crossings of bonds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

NONE_SEEN = 3.0  # mean count that is excluded at 95 % where none is seen: exp(-3) = 0.05


class Interval(NamedTuple):
    """Ends of a 95 % interval of the mean count."""

    low: np.ndarray
    high: np.ndarray


def interval(count: npt.ArrayLike) -> Interval:
    """95 % interval of the mean of a Poisson distribution, given one number drawn from it.

    At the lower end so many events or more have a probability of 2.5 %, at the upper end so many
    or fewer. Where none is seen there is no lower end to find, and the upper one has all 5 %; so
    means between 3.0 and 3.7 are covered a little less often, by 94 %.

    Parameters
    ----------
    count : array_like
        How many events were seen.

    Returns
    -------
    Interval
        Of arrays with the shape of ``count``.

    References
    ----------
    F. Garwood, Biometrika 28, 437 (1936).
    """
    from scipy.special import gammaincinv  # most jobs need no SciPy

    count = np.asarray(count, dtype=float)
    some = np.maximum(count, 1)
    seen = count > 0
    return Interval(
        np.where(seen, gammaincinv(some, 0.025), 0),
        np.where(seen, gammaincinv(some + 1, 0.975), NONE_SEEN),
    )
