"""Exceptions that reach a user as a plain sentence, and how that shows a value."""

import errno

LONGEST_SHOWN = 100  # characters of a value


class UserError(Exception):
    """Something the user can mend: a wrong key, a bad value, a run that blew up.

    The command line prints its text alone, without a traceback, and exits with 1.
    """


class Stopped(UserError):
    """A run that was asked to stop."""


class LostTrack(UserError):
    """Beads moved too far between two samples to be followed, at a ``step`` of the run."""

    def __init__(self, text, step):
        super().__init__(text)
        self.step = step


def reason(problem):
    """Why the system refused something, in few words."""
    return getattr(problem, "strerror", None) or str(problem)


def remedy(problem, folder):
    """What to do where the system did not let us write into a folder."""
    full = getattr(problem, "errno", None) in (errno.ENOSPC, errno.EDQUOT)
    return f"{'make room there' if full else f'make {folder} writable'} or choose another place"


def shown(value, form=repr):
    """A value as a message shows it: on one line, and not at any length."""
    text = " ".join(form(value).split())
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."
