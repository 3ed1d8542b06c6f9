"""Integrators as rows of one table.

Every scheme here evaluates the force once a step. Those that take friction and noise as
forces are the predictor-corrector

    r  += dt v + c dt^2 f
    v~  = v + lambda dt f          (the velocity that the friction sees)
    f'  = f(r, v~)
    v  += dt [ (1 - b) f + b f' ]

with their own acceleration term c, prediction lambda and correction b. DPD-VV then takes
the friction in f' once more, with the velocity v that it has led to.

The others split friction and noise off: pairs exchange momentum (`dpd.physics.exchange`) after
a step of the conservative forces alone, or in its middle.
"""

from typing import NamedTuple

from dpd.physics.exchange import EXACT, LOWE, SHARDLOW


class Scheme(NamedTuple):
    """One scheme.

    Attributes
    ----------
    acceleration, correction : float
        c and b.
    prediction : float or None
        lambda. None where what is predicted is the velocity with the first share of its kick,
        1 - b, or nothing.
    renewal : True or None
        Whether friction is taken once more at the end of a step.
    exchange : int or None
        Kind of the exchange of momentum.
    middle : True or None
        Whether force and exchange come after half a drift, the other half at the end.
    """

    acceleration: float
    prediction: float | None
    correction: float
    renewal: bool | None = None
    exchange: int | None = None
    middle: bool | None = None


# The schemes of Groot and Warren 1997, Sec. III: Eq. 7, without and with dt^2 f / 2, and Eq. 9,
# with and without; that of Nikunen et al. 2007 (Besold et al. 2000); velocity Verlet followed by
# Shardlow's exchange, or by that of Lowe; and drift, kick, exact exchange, kick, drift in halves.
SCHEMES = {
    "euler": lambda prediction: Scheme(0.0, 1.0, 0.0),
    "euler-acceleration": lambda prediction: Scheme(0.5, 1.0, 0.0),
    "gw-vv": lambda prediction: Scheme(0.5, prediction, 0.5),
    "verlet-no-acceleration": lambda prediction: Scheme(0.0, prediction, 0.5),
    "dpd-vv": lambda prediction: Scheme(0.5, 0.5, 0.5, renewal=True),
    "shardlow": lambda prediction: Scheme(0.5, None, 0.5, exchange=SHARDLOW),
    "lowe-andersen": lambda prediction: Scheme(0.5, None, 0.5, exchange=LOWE),
    "aboba": lambda prediction: Scheme(0.0, None, 1.0, exchange=EXACT, middle=True),
}
WITHOUT_EXCHANGE = ", ".join(name for name, of in SCHEMES.items() if of(0.5).exchange is None)


def scheme_named(name: str, prediction: float = 0.5) -> Scheme:
    """A scheme by name.

    Parameters
    ----------
    name : str
        A key of `SCHEMES`.
    prediction : float
        Lambda of ``gw-vv`` and ``verlet-no-acceleration``; the others have their own, or none.

    Returns
    -------
    Scheme

    Raises
    ------
    KeyError
        For a name that is not in the table.
    """
    chosen = SCHEMES[name](prediction)
    if chosen.prediction == 1.0 - chosen.correction:
        return chosen._replace(prediction=None)
    return chosen
