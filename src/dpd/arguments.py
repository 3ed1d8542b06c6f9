"""What arguments of commands may be: numbers with limits, refused in one sentence."""

import argparse
import math
import os

THREADS_PER_CORE = 4  # more only wait for each other
MOST_STEPS = 10**12
SHORTEST_PAUSE = 0.5  # s: to look more often would slow down what is looked at


def count(text: str) -> int:
    """A number of threads."""
    cores = len(os.sched_getaffinity(0))
    most = THREADS_PER_CORE * cores
    if not text.isdecimal() or len(text) > 6 or not 1 <= int(text) <= most:
        raise argparse.ArgumentTypeError(
            f"{text!r} is out of range; allowed: 1 to {most}, {THREADS_PER_CORE} for each of "
            f"{cores} cores"
        )
    return int(text)


def seconds(text: str) -> float:
    """A time that is no less than zero."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not 0 <= found < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no time; allowed: 0, 60, ... seconds")
    return found


def steps(text: str) -> int:
    """A number of steps, at least one."""
    try:
        found = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
    if not 1 <= found <= MOST_STEPS:
        raise argparse.ArgumentTypeError(f"{text!r} is out of range; allowed: 1 to {MOST_STEPS}")
    return found


def pause(text: str) -> float:
    """A time between two looks."""
    found = seconds(text)
    if found < SHORTEST_PAUSE:
        raise argparse.ArgumentTypeError(
            f"{text!r} is out of range; allowed: {SHORTEST_PAUSE:g} seconds or more"
        )
    return found


def positive(text: str) -> float:
    """A number above zero."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not 0 < found < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is out of range; allowed: numbers above 0")
    return found


def no_less_than_zero(text: str) -> float:
    """A length, 0 or more."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not 0 <= found < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is out of range; allowed: 0 or more")
    return found


def beads(text: str) -> int:
    """A number of beads of a molecule, at least one."""
    if not text.isdecimal() or len(text) > 9 or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of beads; allowed: 1, 2, ...")
    return int(text)
