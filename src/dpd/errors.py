"""Exceptions that reach a user as a plain sentence."""


class UserError(Exception):
    """Something the user can mend: a wrong key, a bad value, a run that blew up.

    The command line prints its text alone, without a traceback, and exits with 1.
    """


class LostTrack(UserError):
    """Beads moved too far between two samples to be followed, at a ``step`` of the run."""

    def __init__(self, text, step):
        super().__init__(text)
        self.step = step
