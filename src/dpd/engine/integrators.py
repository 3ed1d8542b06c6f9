"""Integrators as rows of one table.

Every scheme here evaluates the force once a step and is the predictor-corrector

    r  += dt v + c dt^2 f
    v~  = v + lambda dt f          (the velocity that the friction sees)
    f'  = f(r, v~)
    v  += dt [ (1 - b) f + b f' ]

with its own acceleration term c, prediction lambda and correction b. DPD-VV then takes
the friction in f' once more, with the velocity v that it has led to.
"""

from typing import NamedTuple


class Coefficients(NamedTuple):
    """One scheme: ``acceleration`` c, ``prediction`` lambda, ``correction`` b.

    ``again`` is True if friction is evaluated once more, or None.
    """

    acceleration: float
    prediction: float
    correction: float
    again: bool | None = None


# The schemes of Groot and Warren 1997, Fig. 1: Eq. 7, Eq. 9, and Eq. 9 without dt^2 f / 2;
# and that of Nikunen et al. 2007 (Besold et al. 2000).
SCHEMES = {
    "euler": lambda prediction: Coefficients(0.0, 1.0, 0.0),
    "gw-vv": lambda prediction: Coefficients(0.5, prediction, 0.5),
    "verlet-no-acceleration": lambda prediction: Coefficients(0.0, prediction, 0.5),
    "dpd-vv": lambda prediction: Coefficients(0.5, 0.5, 0.5, True),
}


def coefficients(scheme, prediction=0.5):
    """Coefficients of a scheme by name.

    Parameters
    ----------
    scheme : str
        A key of `SCHEMES`.
    prediction : float
        Lambda; ``euler`` and ``dpd-vv`` have their own.

    Raises
    ------
    KeyError
        For a name that is not in the table.
    """
    return SCHEMES[scheme](prediction)
