"""A run that goes on from a shorter one: what observables keep for that, and how they go on.

Most arrays of an observable do not depend on how long the run is planned to be, or are series that
become longer. Averages over parts of the run do depend on it: those observables hold them in
``averages`` (`BlockSums`, `MultipleTau`), which can remember what has to be added up anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np

MOST_REMEMBERED = 2**28  # bytes of samples that a run keeps for a longer one


def bytes_to_remember(observers: Iterable[Any]) -> int:
    """Bytes that `remember` adds to what observables keep; they grow with the run's length."""
    return sum(each.averages.remembered for each in observers if hasattr(each, "averages"))


def remember(observers: Iterable[Any]) -> None:
    """Let observables keep what a longer run needs; before their first sample."""
    for observer in observers:
        if hasattr(observer, "averages"):
            observer.averages.remember()
            observer.arrays.update(observer.averages.arrays)


def go_on_from(observer: Any, former: Any, step: int) -> None:
    """Put an observable where that of a run that was planned as long would be at a step.

    Parameters
    ----------
    observer : observable
        Of the longer run, before its first sample.
    former : observable
        The same of the shorter run, at its end, with what it remembered, and its own file.
    step : int
        Steps that the shorter one has looked at.

    Raises
    ------
    ValueError
        If the two take their samples at other steps, of which some are over.
    """
    if observer.every != former.every:
        if observer.every <= step:
            raise ValueError(f"samples every {observer.every} steps cannot follow {former.every}")
        return  # the longer run would not have looked yet
    averages = getattr(observer, "averages", None)
    if averages is not None:
        averages.go_on_from(former.arrays)
    file = getattr(observer, "file", None)
    if file is not None:
        file.go_on_after(former.file.path, int(former.arrays["taken"][0]), former.arrays["digests"])
    own = averages.arrays if averages is not None else {}
    for name, array in observer.arrays.items():
        if name not in own:
            _put(array, former.arrays[name])


def _put(array: np.ndarray, former: np.ndarray) -> None:
    """Fill the beginning of an array; series grow along their first axis, others do not."""
    array[: len(former)] = former
