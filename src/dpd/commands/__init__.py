"""Commands: one module for each group; here how they are declared, and options that they share."""

from __future__ import annotations

import math
import os
import signal
import sys
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from dpd.runs.run import Options

Option = tuple[tuple[str, ...], dict[str, Any]]  # as `ArgumentParser.add_argument` takes it


class Command(NamedTuple):
    """What can be called by its name; the docstring of the function is its help."""

    function: Callable[[Namespace], None]
    arguments: tuple[Option, ...]
    output: str  # its suffix is that of every path after -o


COMMANDS: dict[str, Command] = {}  # in the order in which --help lists them


def option(*names: str, **settings: Any) -> Option:
    """An argument of a command."""
    return names, settings


def command(*arguments: str | Option, output: str = "") -> Callable:
    """Declare a function as a command; it writes its ``output`` to the path after ``-o``."""

    def declare(function):
        wanted = [option(each) if isinstance(each, str) else each for each in arguments]
        if output:
            wanted.append(option("-o", "--output", required=True, type=Path, help=output))
        COMMANDS[function.__name__.strip("_")] = Command(function, tuple(wanted), output)
        return function

    return declare


def positive(text: str) -> float:
    """A number above 0."""
    if not 0 < (found := float(text)) < math.inf:
        raise ArgumentTypeError(f"{text!r} is out of range; allowed: numbers above 0")
    return found


THREADS = option(
    "--threads", type=int, default=1, metavar="N",
    help="threads that share the work (default 1); the results are the same bits",
)  # fmt: skip
CHECKPOINTS = option(
    "--checkpoint-every", type=float, default=60.0, metavar="SECONDS",
    help="wall clock between checkpoints (default 60; 0: as often as the run looks at the clock); "
    "the same command resumes from one",
)  # fmt: skip
OVERWRITE = option(
    "--overwrite", action="store_true",
    help="replace what is in the place of the output; without it, that stays",
)  # fmt: skip


def options_of(options: Namespace, **more: Any) -> Options:
    """How a run is carried out, as a command's options and some more say."""
    from dpd.runs.run import Options

    return Options(
        options.threads, options.checkpoint_every, getattr(options, "overwrite", False),
        signals=(signal.SIGINT, signal.SIGTERM, signal.SIGHUP), **more,
    )  # fmt: skip


def called() -> str:
    """The command as it was typed: an installed program ``dpd``, or a module of Python."""
    return "dpd" if os.path.basename(sys.argv[0]) == "dpd" else "python -m dpd"
