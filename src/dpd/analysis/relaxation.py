"""Relaxation of chains: end-to-end correlation, relaxation times, diffusion, exponents."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import diffusion_constant, displacements, resampled
from dpd.analysis.statistics import linear_fit

if TYPE_CHECKING:
    from dpd.analysis.diffusion import Resampled

TAIL_LOW, TAIL_HIGH = 0.15, 0.6  # of C(t) / C(0), where its slowest mode alone is left
EARLY, LATE = (0.3, TAIL_HIGH), (TAIL_LOW, 0.4)  # parts of the tail
FEWEST = 4  # lags that a line is fitted to
TEN = 10.0  # relaxation times that a run has to last
SETTLED = 2.0  # and to settle before: of a wrong R^2 at the start 2 to 14 % are left
# Relaxation times between which D is taken, of chains of any length: a run of ten has these lags.
DIFFUSES, LATER = (0.5, 1.0), (1.0, 2.0)
# What `chain_dynamics` gives, with units.
FOUND = {
    "tau": "tau", "tau_error": "tau", "diffusion": "r_c^2 / tau", "diffusion_error": "r_c^2 / tau",
    "diffusion_later": "r_c^2 / tau", "diffusion_later_error": "r_c^2 / tau", "duration": "tau",
    "long_enough": "1",
}  # fmt: skip


def end_to_end(runs: xr.Dataset) -> tuple[Resampled, float]:
    """<R(t) . R(0)> of the replicas of one point with ``end_to_end``, and <R^2>, in r_c^2."""
    found = resampled(
        runs, "end_lag", "chain", "end_lag_time", "end_correlation", "end_sums", "end_samples"
    )
    return found, float(runs.end_square.mean())


def in_tail(share: np.ndarray, low: float = TAIL_LOW, high: float = TAIL_HIGH) -> np.ndarray:
    """Whether each lag lies in the tail, given C(t) / C(0) by increasing lag."""
    inside = (share < high) & (share > low)
    # The first lag below the tail ends it, whatever noise does later.
    ended = np.flatnonzero(share <= low)
    if len(ended):
        inside[ended[0] :] = False
    return inside


def relaxation_time(found: Resampled, square: float) -> tuple[float, float]:
    """tau of exp(-t / tau), and its error, from the straight part of ln C(t).

    Lags reach to a tenth of a run, so the tail is cut at C(t) / C(0) = 0.30 where a run lasts for
    ten tau. Of ideal chains, tau comes out 0.9 % too small there, and 0.4 % with the whole tail.
    NaN where C(t) has fewer than four lags in the tail.
    """
    inside = in_tail(found.value / square)
    if inside.sum() < FEWEST:
        return np.nan, np.nan
    value, error = found.derived(lambda c: _tau(found.time, c, inside))
    return float(value), float(error)


def straightness(found: Resampled, square: float) -> tuple[float, float]:
    """tau from the early part of the tail over tau from its late part, with its error.

    1 of an exponential; NaN where a part has fewer than four lags.
    """
    early, late = (in_tail(found.value / square, *limits) for limits in (EARLY, LATE))
    if min(early.sum(), late.sum()) < FEWEST:
        return np.nan, np.nan
    value, error = found.derived(lambda c: _tau(found.time, c, early) / _tau(found.time, c, late))
    return float(value), float(error)


def _tau(time, correlation, inside):
    """From a straight line through ln C(t) at some lags."""
    return -1.0 / np.polyfit(time[inside], np.log(np.maximum(correlation[inside], 1e-9)), 1)[0]


def chain_dynamics(sweep: xr.Dataset) -> xr.Dataset:
    """Relaxation times and diffusion constants over chain length, `FOUND`.

    ``diffusion`` is from lags of half a tau to one, ``diffusion_later`` the same at one tau to two
    where the run has them; ``long_enough`` is 1 where ``duration`` of a run is ten tau or more,
    after two or more to settle. ``sweep``: with the axes ``length`` and ``replica``.
    """
    rows = []
    for length in sweep.length.values:
        at = sweep.sel(length=length)
        scene = first_scene(at)
        duration = scene.steps.sample * scene.dt
        tau, tau_error = relaxation_time(*end_to_end(at))
        before = scene.steps.equilibrate * scene.dt
        enough = duration >= TEN * tau and before >= SETTLED * tau
        constant = later = (np.nan, np.nan)
        if enough:
            centre = displacements(at, "centre")
            constant, later = (
                diffusion_constant(centre, scene.dimension, low * tau, high * tau)
                for low, high in (DIFFUSES, LATER)
            )
            if duration < TEN * LATER[1] * tau:
                later = (np.nan, np.nan)
        rows.append((tau, tau_error, *constant, *later, duration, float(enough)))
    data = xr.Dataset(coords={"length": sweep.length.astype(float)})
    for (name, unit), column in zip(FOUND.items(), np.array(rows).T):
        data[name] = ("length", column, {"units": unit, "long_name": name.replace("_", " ")})
    return data


class Power(NamedTuple):
    """value ~ N^exponent, as ln value = height + exponent ln N."""

    exponent: float
    error: float
    height: float
    p_value: float  # probability of points that lie worse about the law, if it is right


def power(
    length: np.ndarray, value: np.ndarray, error: np.ndarray, low: float, high: float,
    exponent: float | None = None,
) -> Power:  # fmt: skip
    """Exponent of value ~ N^x for low <= N <= high, of (n,) lengths, values and standard errors.

    ``exponent``: given, it is not fitted. NaN with fewer than three lengths, as any two lie on a
    power law; with a given exponent one is enough.
    """
    use = (length >= low) & (length <= high) & np.isfinite(value) & (error > 0)
    if use.sum() < (3 if exponent is None else 1):
        return Power(*(np.nan,) * 4)
    x, y, spread = np.log(length[use]), np.log(value[use]), error[use] / value[use]
    if exponent is not None:
        fit = linear_fit([np.ones_like(x)], y - exponent * x, spread)
        return Power(exponent, 0.0, float(fit.values[0]), fit.p_value)
    fit = linear_fit([np.ones_like(x), x], y, spread)
    (height, free), (_, free_error) = fit.values, fit.errors
    return Power(float(free), float(free_error), float(height), fit.p_value)
