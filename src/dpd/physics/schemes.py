"""Integrators as rows of one table.

Every scheme here evaluates the force once a step. Those that take friction and noise as
forces are the predictor-corrector

    r  += dt v + c dt^2 f
    v~  = v + lambda dt f          (the velocity that the friction sees)
    f'  = f(r, v~)
    v  += dt [ (1 - b) f + b f' ]

with their own acceleration term c, prediction lambda and correction b. DPD-VV then takes
the friction in f' once more, with the velocity v that it has led to.

The others split them off: pairs exchange momentum (`dpd.physics.exchange`) after a step of
the conservative forces alone, or in its middle.
"""

from typing import NamedTuple

# How a pair's relative velocity u = e . v_ij changes in dt, with g = gamma w^2 dt:
# half explicitly and half implicitly (Shardlow 2003); exactly, as the Ornstein-Uhlenbeck
# process that it is while the pair stands still (Serrano, De Fabritiis, Espanol and
# Coveney 2006); or drawn anew with probability gamma dt (Lowe 1999).
SHARDLOW, EXACT, LOWE = 0, 1, 2


class Coefficients(NamedTuple):
    """One scheme: ``acceleration`` c, ``prediction`` lambda, ``correction`` b.

    The prediction is None where what is predicted is the velocity with the first share of its
    kick, 1 - b, or nothing. ``again`` is True if friction is evaluated once more, or None.
    ``exchange`` is the kind of the exchange of momentum, or None. ``middle`` is True if force
    and exchange come after half a drift, the other half at the end, or None.
    """

    acceleration: float
    prediction: float | None
    correction: float
    again: bool | None = None
    exchange: int | None = None
    middle: bool | None = None


# The schemes of Groot and Warren 1997, Fig. 1: Eq. 7, Eq. 9, and Eq. 9 without dt^2 f / 2;
# that of Nikunen et al. 2007 (Besold et al. 2000); velocity Verlet followed by Shardlow's
# exchange, or by that of Lowe; and drift, kick, exact exchange, kick, drift in halves.
SCHEMES = {
    "euler": lambda prediction: Coefficients(0.0, 1.0, 0.0),
    "gw-vv": lambda prediction: Coefficients(0.5, prediction, 0.5),
    "verlet-no-acceleration": lambda prediction: Coefficients(0.0, prediction, 0.5),
    "dpd-vv": lambda prediction: Coefficients(0.5, 0.5, 0.5, True),
    "shardlow": lambda prediction: Coefficients(0.5, None, 0.5, None, SHARDLOW),
    "lowe-andersen": lambda prediction: Coefficients(0.5, None, 0.5, None, LOWE),
    "aboba": lambda prediction: Coefficients(0.0, None, 1.0, None, EXACT, True),
}


def coefficients(scheme, prediction=0.5):
    """Coefficients of a scheme by name.

    Parameters
    ----------
    scheme : str
        A key of `SCHEMES`.
    prediction : float
        Lambda of ``gw-vv`` and ``verlet-no-acceleration``; the others have their own, or none.

    Raises
    ------
    KeyError
        For a name that is not in the table.
    """
    chosen = SCHEMES[scheme](prediction)
    if chosen.prediction == 1.0 - chosen.correction and not chosen.again:
        return chosen._replace(prediction=None)
    return chosen
