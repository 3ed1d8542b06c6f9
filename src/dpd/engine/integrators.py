"""Integrators as rows of one table.

Every scheme here evaluates the force once a step and is the predictor-corrector

    r  += dt v + c dt^2 f
    v~  = v + lambda dt f          (the velocity that the friction sees)
    f'  = f(r, v~)
    v  += dt [ (1 - b) f + b f' ]

with its own acceleration term c, prediction lambda and correction b.
"""

from typing import NamedTuple


class Coefficients(NamedTuple):
    """One scheme: ``acceleration`` c, ``prediction`` lambda, ``correction`` b."""

    acceleration: float
    prediction: float
    correction: float


# The schemes of Groot and Warren 1997, Fig. 1: Eq. 7, Eq. 9, and Eq. 9 without dt^2 f / 2.
SCHEMES = {
    "euler": lambda prediction: Coefficients(0.0, 1.0, 0.0),
    "gw-vv": lambda prediction: Coefficients(0.5, prediction, 0.5),
    "verlet-no-acceleration": lambda prediction: Coefficients(0.0, prediction, 0.5),
}


def coefficients(scheme, prediction=0.5):
    """Coefficients of a scheme by name.

    Parameters
    ----------
    scheme : str
        A key of `SCHEMES`.
    prediction : float
        Lambda; the Euler scheme has none.

    Raises
    ------
    KeyError
        For a name that is not in the table.
    """
    return SCHEMES[scheme](prediction)
