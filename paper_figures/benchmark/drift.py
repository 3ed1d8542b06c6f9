"""How runs fail as the time step grows, and at which step."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.analysis.statistics import linear_fit, over_replicas

if TYPE_CHECKING:
    import numpy.typing as npt

STABLE, OFF, FAR, LOST = range(4)
WITHIN, FAR_FROM = 0.02, 0.1  # of kT, the limits between the first three
SURE = 2.0  # standard errors from such a limit
INTERPOLATED = 0.05  # of a step that was found between two others: heating is no exact power
LEAST_POINTS, LEAST_CHANCE = 3, 0.05  # of a power law that is worth a line


class Outcome(NamedTuple):
    """What became of runs; all arrays have the shape of the sweep without its replicas.

    - ``kind``: `STABLE`, `OFF`, `FAR` or `LOST`: kT at most 2 % from 1, at most 10 %, further, or
      the run blew up.
    - ``sure``: whether kT is further than two standard errors from both limits; not so where the
      run is too short for an error.
    - ``excess``, ``error``: kT - 1 and its standard error; NaN for what blew up.
    - ``lost``: time in tau at which the first replica blew up; NaN where none did.
    """

    kind: np.ndarray
    sure: np.ndarray
    excess: np.ndarray
    error: np.ndarray
    lost: np.ndarray


def outcome(
    kT: npt.ArrayLike, kT_error: npt.ArrayLike, lost_step: np.ndarray, dt: npt.ArrayLike
) -> Outcome:
    """How runs went.

    ``kT``, ``kT_error``, ``lost_step``: (..., replicas) arrays; temperature, its standard error,
    and the step that broke the run, or -1. ``dt``: time step in tau, broadcast against (...).
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


def edge(dt: np.ndarray, kind: npt.ArrayLike, sure: npt.ArrayLike) -> tuple[float, float]:
    """Where one column of a map stops being stable.

    ``dt``: (n,) array; ascending. ``kind``: (n,) array of int. ``sure``: (n,) array of bool.
    Returns ``stable``, ``beyond``: the largest stable step below which no run surely fails, and the
    next one that was tried; NaN where there is none.
    """
    stable, sure = np.asarray(kind) == STABLE, np.asarray(sure)
    good = np.flatnonzero(stable & np.logical_and.accumulate(stable | ~sure))
    after = good[-1] + 1 if len(good) else 0
    return (
        float(dt[after - 1]) if after else np.nan, float(dt[after]) if after < len(dt) else np.nan
    )  # fmt: skip


def crossing(dt: np.ndarray, excess: np.ndarray, error: np.ndarray) -> tuple[float, float]:
    """Step at which kT is 10 % off, in one column of a map.

    Between the last step below that and the next it follows from a power law through both.
    Where the next run blew up it is anywhere between.

    ``dt``: (n,) array; ascending. ``excess``, ``error``: (n,) arrays; kT - 1 and its standard
    error; NaN for what blew up. Returns ``value``, ``error``: the error is that of ln value; NaN
    where no step is further off, or none is nearer.
    """
    away = np.abs(excess)
    count = int(np.logical_and.accumulate(away <= FAR_FROM).sum())
    if count in (0, len(dt)):
        return np.nan, np.nan
    below, above = count - 1, count
    width = np.log(dt[above] / dt[below])
    if not np.isfinite(away[above]):
        return float(np.sqrt(dt[above] * dt[below])), width / np.sqrt(12.0)
    # What is lost in noise is taken for as large as the noise; without an error the step has none.
    y = np.log(np.fmax(away[[below, above]], error[[below, above]]) / FAR_FROM)
    spread = (error / np.fmax(away, error))[[below, above]]
    rise = y[1] - y[0]
    value = dt[below] * np.exp(-width * y[0] / rise)
    noise = width / rise**2 * np.hypot(y[1] * spread[0], y[0] * spread[1])
    return float(value), float(np.hypot(noise, INTERPOLATED))


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
    def holds(self) -> bool:
        """Whether it describes its points and says more than that y is level."""
        enough = self.points >= LEAST_POINTS and self.chance > LEAST_CHANCE
        return bool(enough and abs(self.exponent) > SURE * self.error)


NO_POWER = Power(np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, 0)


def power_law(x: npt.ArrayLike, y: npt.ArrayLike, error: npt.ArrayLike) -> Power:
    """Fit a power law to the points that are finite and positive.

    ``x``, ``y``: (n,) arrays. ``error``: (n,) array; standard errors of ln y. Result: `NO_POWER`
    for fewer than three points.
    """
    x, y, error = (np.asarray(part, dtype=float) for part in (x, y, error))
    use = np.isfinite(y) & np.isfinite(error) & (np.nan_to_num(y) > 0)
    if use.sum() < LEAST_POINTS:
        return NO_POWER
    log_x = np.log(x[use])
    fit = linear_fit([np.ones_like(log_x), log_x], np.log(y[use]), error[use])
    (height, slope), (_, slope_error) = fit.values, fit.errors
    low, high = x[use].min(), x[use].max()
    return Power(
        float(np.exp(height)), float(slope), float(slope_error), fit.p_value,
        float(low), float(high), int(use.sum()),
    )  # fmt: skip


def falling(x: np.ndarray, limit: npt.ArrayLike, error: npt.ArrayLike) -> Power:
    """The power law with which a limit falls as something grows stiffer.

    Left out is what comes before the last limit that cannot be told from the largest (two
    standard errors), and that itself: there something else sets it.

    ``x``: (n,) array; ascending. ``limit``, ``error``: (n,) arrays; the error is that of ln limit;
    NaN where there is no limit.
    """
    limit, error = np.asarray(limit), np.asarray(error)
    limit = np.where(np.isfinite(error), limit, np.nan)  # one without an error bounds nothing
    if not np.isfinite(limit).any():
        return NO_POWER
    largest = np.nanargmax(limit)
    level = np.log(limit[largest] / limit) <= SURE * np.hypot(error, error[largest])
    after = np.flatnonzero(level)[-1] + 1
    return power_law(x[after:], limit[after:], error[after:])
