"""Exceptions that reach a user as a plain sentence, and how that shows a value."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

FAILED = "error: "  # begins the sentence of a command that failed
LONGEST_SHOWN = 100  # characters of a value
NEAR = 0.65  # likeness of names, above which one may be meant: charge is no core, owm is own


class UserError(Exception):
    """Something the user can mend: a wrong key, a bad value, a run that blew up.

    The command line prints its text alone, without a traceback, and exits with 1.
    """


class Stopped(UserError):
    """A run that was asked to stop, by a ``signal``."""

    def __init__(self, text: str, signal: int) -> None:
        super().__init__(text)
        self.signal = signal


class Occupied(UserError):
    """A file that is there would be replaced unasked; the command line says how to ask for it."""

    def __str__(self) -> str:
        return f"{self.args[0]}; overwrite=True replaces it"


class LostRun(UserError):
    """A run that makes no sense from a ``step`` on."""

    def __init__(self, text: str, step: int) -> None:
        super().__init__(text)
        self.step = step


def reason(problem: BaseException) -> str:
    """Why the system refused something, in few words."""
    return getattr(problem, "strerror", None) or str(problem)


def shown(value: object, form: Callable[[object], str] = repr) -> str:
    """A value as a message shows it: on one line, and not at any length."""
    text = " ".join(form(value).split())
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def suggestion(name: object, allowed: Collection[object]) -> str:
    """Allowed names and the nearest of them, as the end of a message about a name."""
    if not allowed:
        return "there are none"
    near = difflib.get_close_matches(str(name), [str(each) for each in allowed], 1, NEAR)
    guess = f"; did you mean {near[0]!r}?" if near else ""
    return f"allowed: {', '.join(map(str, allowed))}{guess}"
