"""The one exception that reaches a user as a plain sentence."""


class UserError(Exception):
    """Something the user can mend: a wrong key, a bad value, a run that blew up.

    The command line prints its text alone, without a traceback, and exits with 1.
    """
