"""Degrees of freedom of an error, whatever it was made from: by errors that scatter as theirs do.

What a figure makes of runs is made once and kept. Then its numbers are made again some times, from
the same values, with each error multiplied by the root of chi-square over its degrees of freedom.
How far the error at the end scatters says how many it has: of sums of variances this is what Welch
and Satterthwaite have, and it holds for fits and weights as well.
"""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    P = ParamSpec("P")
    R = TypeVar("R")
    Errors = Mapping[str, float]

DRAWS = 24
ROUNDING = 1e-10  # variance of the logarithm of an error that does not scatter


class _Tape:
    """What taped functions gave, in the order of their calls, with the degrees of their errors."""

    def __init__(self) -> None:
        self.made: list[tuple[str, Any, Any]] = []
        self.inside = False  # of a taped function: what it calls is not kept apart
        self.degrees: Any = np.inf
        self.rng = np.random.default_rng(1)
        self.at: int | None = None  # None while it records

    def scattered(self, degrees: Any) -> Any:
        """A factor on an error that has so many degrees of freedom."""
        many = np.clip(np.nan_to_num(degrees, nan=np.inf), 0.1, 1e9)
        return np.sqrt(self.rng.chisquare(many) / many)

    def call(self, name: str, function: Callable[[], Any]) -> Any:
        """What a function gives: for the first time, or again with another error."""
        if self.at is None:
            self.inside, self.degrees = True, np.inf
            try:
                found = function()
            finally:
                self.inside = False
            self.made.append((name, found, self.degrees))
            return found
        known, found, degrees = self.made[self.at]
        if known != name:
            raise LookupError("errors decided what was calculated")
        self.at += 1
        if not (isinstance(found, tuple) and len(found) == 2):
            return found
        value, error = found
        return value, error * self.scattered(np.broadcast_to(degrees, np.shape(error)))


_tape: _Tape | None = None


def taped(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function that gives a value and its error, or takes long, part of `degrees_of`."""

    @wraps(function)
    def played(*args: P.args, **kwargs: P.kwargs) -> R:
        if _tape is None or _tape.inside:
            return function(*args, **kwargs)
        return _tape.call(function.__qualname__, lambda: function(*args, **kwargs))

    return played


def widened_by(degrees: Any, factor: Any) -> Any:
    """Student's factor on an error; another one each time while `degrees_of` makes errors again."""
    if _tape is not None and _tape.at is None:
        _tape.degrees = degrees
    if _tape is not None and _tape.at is not None:
        factor = factor * _tape.scattered(degrees)
    return factor


def degrees_of(make: Callable[[Callable[[Any], Any]], tuple[R, Errors]]) -> tuple[R, Errors]:
    """What a function makes, and the degrees of freedom of the errors that it gives.

    ``make``: of a function that gives scattered factors for degrees of freedom, for errors that
    were made before; returns what is asked for, and errors by name. Returns ``made``. ``degrees``:
    infinite of errors that do not scatter; empty where errors decide what is calculated.
    """
    global _tape
    _tape = tape = _Tape()
    found: list[Errors] = []
    try:
        made, first = make(np.ones_like)
        for _ in range(DRAWS):
            tape.at = 0
            try:
                _, errors = make(tape.scattered)
            except Exception:
                continue
            found.append(errors)
    finally:
        _tape = None
    degrees = {}
    for name in first:
        drawn = np.array([draw.get(name, np.nan) for draw in found], dtype=float)
        logarithms = np.log(drawn[drawn > 0])
        if len(logarithms) > DRAWS / 2:
            spread = logarithms.var(ddof=1)
            degrees[name] = float(0.5 / spread) if spread > ROUNDING else np.inf
    return made, degrees
