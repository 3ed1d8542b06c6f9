"""How runs fail as the time step grows, and where they begin to."""

from typing import NamedTuple

import numpy as np

from dpd.analysis.statistics import linear_fit, over_replicas

STABLE, OFF, FAR, LOST = range(4)
WITHIN, FAR_FROM = 0.02, 0.1  # of kT, the limits between the first three
SURE = 2.0  # standard errors from such a limit
LEAST_POINTS, LEAST_CHANCE = 3, 0.05  # of a power law that is worth a line


class Outcome(NamedTuple):
    """What became of runs; all arrays have the shape of the sweep without its replicas.

    Attributes
    ----------
    kind : array of int
        `STABLE`, `OFF`, `FAR` or `LOST`: kT at most 2 % from 1, at most 10 %, further, or the
        run blew up.
    sure : array of bool
        Whether kT is further than two standard errors from both limits.
    excess, error : arrays
        kT - 1 and its standard error; NaN for what blew up.
    lost : array
        Time in tau at which the first replica blew up; NaN where none did.
    """

    kind: np.ndarray
    sure: np.ndarray
    excess: np.ndarray
    error: np.ndarray
    lost: np.ndarray


def outcome(kT, kT_error, lost_step, dt):
    """How runs went.

    Parameters
    ----------
    kT, kT_error, lost_step : (..., replicas) arrays
        Kinetic temperature, its standard error, and the step that broke the run, or -1.
    dt : array
        Time step in tau, broadcast against (...).

    Returns
    -------
    Outcome
    """
    broken = lost_step >= 0
    lost = np.where(broken, lost_step * np.asarray(dt)[..., None], np.inf).min(axis=-1)
    whole = np.isinf(lost)
    mean, error = over_replicas(np.asarray(kT), np.asarray(kT_error), -1)
    excess, error = np.where(whole, mean - 1, np.nan), np.where(whole, error, np.nan)
    away = np.abs(excess)
    kind = np.select([~whole, away > FAR_FROM, away > WITHIN], [LOST, FAR, OFF], STABLE)
    near = np.minimum(np.abs(away - WITHIN), np.abs(away - FAR_FROM))
    return Outcome(
        kind, ~whole | (near > SURE * error), excess, error, np.where(whole, np.nan, lost)
    )


class Edge(NamedTuple):
    """Where runs stop being stable: between two time steps that were tried.

    ``stable`` is the largest step up to which all runs are stable, ``beyond`` the next one
    tried; NaN where there is none.
    """

    stable: float
    beyond: float

    @property
    def middle(self):
        """Geometric mean of both."""
        return np.sqrt(self.stable * self.beyond)

    @property
    def error(self):
        """Standard error of ln middle: the edge is anywhere between both."""
        return np.log(self.beyond / self.stable) / np.sqrt(12.0)


def edge(dt, kind):
    """The edge of stability of one column of a map.

    Parameters
    ----------
    dt : (n,) array
        Ascending.
    kind : (n,) array of int

    Returns
    -------
    Edge
    """
    count = int(np.cumprod(np.asarray(kind) == STABLE).sum())
    return Edge(
        float(dt[count - 1]) if count else np.nan, float(dt[count]) if count < len(dt) else np.nan
    )


class Power(NamedTuple):
    """A law y = factor x^exponent, with the standard error of the exponent.

    ``chance`` is the probability of a worse fit if the law is right, NaN where no point is
    left to tell; ``low`` and ``high`` are the ends of what was fitted, ``points`` how many.
    """

    factor: float
    exponent: float
    error: float
    chance: float
    low: float
    high: float
    points: int

    @property
    def holds(self):
        """Whether it describes its points and says more than that y is level."""
        enough = self.points >= LEAST_POINTS and self.chance > LEAST_CHANCE
        return bool(enough and abs(self.exponent) > SURE * self.error)


NO_POWER = Power(*[np.nan] * 6, 0)


def power_law(x, y, error):
    """Fit a power law to the points that are finite and positive.

    Parameters
    ----------
    x, y : (n,) arrays
    error : (n,) array
        Standard errors of ln y.

    Returns
    -------
    Power
        `NO_POWER` for fewer than three points.
    """
    x, y, error = (np.asarray(part, dtype=float) for part in (x, y, error))
    use = np.isfinite(y) & np.isfinite(error) & (np.nan_to_num(y) > 0)
    if use.sum() < LEAST_POINTS:
        return NO_POWER
    log_x = np.log(x[use])
    fit = linear_fit([np.ones_like(log_x), log_x], np.log(y[use]), error[use])
    low, high = x[use].min(), x[use].max()
    return Power(
        float(np.exp(fit.values[0])), float(fit.values[1]), float(fit.errors[1]), fit.p_value,
        float(low), float(high), int(use.sum()),
    )  # fmt: skip


def falling(x, edges):
    """The power law with which the edge of stability falls as something grows stiffer.

    Columns up to the last one that has the largest edge of all are left out: there something
    else sets the limit.

    Parameters
    ----------
    x : (n,) array
        Ascending.
    edges : list of Edge

    Returns
    -------
    Power
    """
    middle = np.array([found.middle for found in edges])
    if not np.isfinite(middle).any():
        return NO_POWER
    last = np.flatnonzero(middle >= np.nanmax(middle) * (1 - 1e-9))[-1]
    error = np.array([found.error for found in edges])
    return power_law(x[last + 1 :], middle[last + 1 :], error[last + 1 :])
