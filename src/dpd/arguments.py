"""What arguments of commands may be: numbers with limits, refused in one sentence."""

from __future__ import annotations

import math
import os
import sys
from argparse import ArgumentTypeError
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

THREADS_PER_CORE = 4  # more only wait for each other
ABOVE_ZERO, MOST = 5e-324, sys.float_info.max  # the least number, and the largest


def number(kind: Any, low: float, high: float, allowed: str) -> Callable[[str], Any]:
    """A converter of text to a number of a kind, from the lowest to the highest that is allowed."""

    def convert(text: str) -> Any:
        try:
            found = kind(text)
        except ValueError:
            found = math.nan
        if not low <= found <= high:
            raise ArgumentTypeError(f"{text!r} is out of range; allowed: {allowed}")
        return found

    return convert


def count(text: str) -> int:
    """A number of threads."""
    cores = len(os.sched_getaffinity(0))
    most = THREADS_PER_CORE * cores
    allowed = f"1 to {most}, {THREADS_PER_CORE} for each of {cores} cores"
    return int(number(int, 1, most, allowed)(text))


seconds = number(float, 0, MOST, "0, 60, ... seconds")
pause = number(float, 0.5, MOST, "0.5 seconds or more")  # more often slows down what is looked at
steps = number(int, 1, 10**12, f"whole numbers from 1 to {10**12}")
positive = number(float, ABOVE_ZERO, MOST, "numbers above 0")
no_less_than_zero = number(float, 0, MOST, "0 or more")
beads = number(int, 1, 10**9, "1, 2, ... beads")
