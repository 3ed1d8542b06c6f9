"""Standard output and error that nobody may read: closed, full, or a pipe whose reader has left.

What a command prints is not its result. It goes on in silence.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from io import TextIOWrapper


# What names of files may hold, and a terminal would obey: all but tabs and ends of lines.
COMMANDS = {
    code: f"\\x{code:02x}" for code in (*range(9), 11, 12, *range(14, 32), *range(127, 160))
}


class Steady:
    """A text stream that is silent from the moment when it cannot be written.

    It shows control characters and does not send them.
    """

    def __init__(self, stream: TextIOWrapper) -> None:
        stream.reconfigure(errors="backslashreplace")  # names of files need not be UTF-8
        self._stream = stream
        self.problem: OSError | None = None  # the OSError that silenced it

    def write(self, text: str) -> int:
        """As of any text stream."""
        return self._try(self._stream.write, text.translate(COMMANDS)) or 0

    def flush(self) -> None:
        """As of any text stream."""
        self._try(self._stream.flush)

    def _try(self, call, *arguments):
        try:
            return call(*arguments)
        except OSError as problem:
            self.problem = self.problem or problem
            _point_nowhere(self._stream.fileno())  # what is left in its buffer goes there too

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _point_nowhere(number):
    nowhere = os.open(os.devnull, os.O_RDWR)
    if nowhere != number:
        os.dup2(nowhere, number)
        os.close(nowhere)


def make_steady() -> None:
    """Let no print of this process fail; to be called before it opens any file.

    The first file that is opened would otherwise take the place of a stream that is closed.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            _point_nowhere(number)
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name) or open(number, "w", buffering=1, closefd=False)  # noqa: SIM115
        setattr(sys, name, Steady(stream))


def is_heard() -> bool:
    """Whether standard output can still be written."""
    return getattr(sys.stdout, "problem", None) is None


def unprinted() -> OSError | None:
    """Why standard output was not written in full, or None; a reader who has left is no reason."""
    sys.stdout.flush()
    problem = getattr(sys.stdout, "problem", None)
    return None if isinstance(problem, BrokenPipeError) else problem
