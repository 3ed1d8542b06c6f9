"""Refusal of arguments for which a theory means nothing: one sentence with name and value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt


def above_zero(name: str, values: npt.ArrayLike) -> np.ndarray:
    """The values as an array of floats, all of them above 0.

    Parameters
    ----------
    name : str
        What the message calls them.
    values : float or array

    Returns
    -------
    array

    Raises
    ------
    ValueError
        With the first that is not above 0, or not finite, or if they are no numbers.
    """
    found = _numbers(name, values)
    return _checked(name, found, found > 0, "numbers above 0")


def not_negative(name: str, values: npt.ArrayLike) -> np.ndarray:
    """The values as an array of floats, none of them below 0; else as `above_zero`."""
    found = _numbers(name, values)
    return _checked(name, found, found >= 0, "0 and numbers above")


def bead_numbers(name: str, values: npt.ArrayLike) -> np.ndarray:
    """The values as an array of floats, all of them 1, 2, ...; else as `above_zero`."""
    found = _numbers(name, values)
    return _checked(name, found, (found >= 1) & (found == np.round(found)), "1, 2, 3, ...")


def _numbers(name, values):
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: {values!r} is not a number, nor an array of numbers") from None


def _checked(name, values, good, allowed):
    bad = np.atleast_1d(values)[np.atleast_1d(~good | ~np.isfinite(values))]
    if bad.size:
        raise ValueError(f"{name}: {bad[0]:g} is out of range; allowed: {allowed}")
    return values
