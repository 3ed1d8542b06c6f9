"""Mean-square displacements over time: local slopes, exponents, diffusion constants."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene, padded
from dpd.analysis.resampling import resampled

if TYPE_CHECKING:
    from dpd.analysis.resampling import Resampled

SLOPE_OVER = 4.0  # ratio of the times that a local slope is taken over
TWO_BONDS = 4.0  # of the mean square bond length: where the subdiffusive window begins
# What `subdiffusion` gives, with units: over lags, and one per point.
CURVES = {
    "time": "tau", "inner": "r_c^2", "inner_error": "r_c^2", "centre": "r_c^2",
    "centre_error": "r_c^2", "slope": "1", "slope_error": "1",
}  # fmt: skip
NUMBERS = {
    "exponent": "1", "exponent_error": "1", "first": "tau", "last": "tau", "low": "r_c^2",
    "high": "r_c^2", "lowest": "1", "lowest_error": "1", "lowest_time": "tau",
    "lowest_square": "r_c^2", "duration": "tau", "box_edge": "r_c", "beads": "1",
    "friction": "kT tau / r_c^2",
}  # fmt: skip


HALF = 5.0  # parts of a run, which are tenths


def displacements(runs: xr.Dataset, kind: str, reach: float = 1.0) -> Resampled:
    """Displacements of the replicas of one point, taken together.

    ``runs``: one point of a collected sweep with the observable ``displacement``, with the
    dimension ``replica``. ``kind``: ``inner`` or ``centre``. ``reach``: length that lags may have,
    in tenths of the run, see `dpd.analysis.resampling.resampled`. Result: in r_c^2.
    """
    return resampled(
        runs, "lag", "molecule", "lag_time", f"msd_{kind}", f"msd_{kind}_sums", "lag_samples",
        reach,
    )  # fmt: skip


def local_slope(time: np.ndarray, value: np.ndarray) -> np.ndarray:
    """d ln g / d ln t at each time: a straight line over a factor `SLOPE_OVER` about it.

    NaN where the data do not reach half that factor to both sides.

    ``time``, ``value``: (n,) arrays; times increasing, values > 0. Result: (n,) array.
    """
    x, y = np.log(time), np.log(value)
    reach = 0.5 * np.log(SLOPE_OVER) + 1e-9
    slope = np.full(len(x), np.nan)
    for k in range(len(x)):
        if x[k] - reach < x[0] - 2e-9 or x[k] + reach > x[-1] + 2e-9:
            continue
        near = np.abs(x - x[k]) <= reach
        if near.sum() >= 3:
            slope[k] = exponent(x[near], y[near])
    return slope


def exponent(x: np.ndarray, y: np.ndarray) -> float:
    """Slope of a straight line, every stretch of x with the weight of its length."""
    weight = np.gradient(x) if len(x) > 1 else np.ones(1)
    x, y = x - np.average(x, weights=weight), y - np.average(y, weights=weight)
    return float((weight * x * y).sum() / (weight * x * x).sum())


class Exponent(NamedTuple):
    """An exponent with its standard error, and the times between which the line was laid.

    All are NaN where there are fewer than four lags.
    """

    value: float
    error: float
    first: float
    last: float


def exponent_between(found: Resampled, low: float, high: float) -> Exponent:
    """Exponent of g ~ t^x where g lies between two values.

    ``low``, ``high``: of g, in r_c^2.
    """
    inside = (found.value >= low) & (found.value <= high)
    if inside.sum() < 4:
        return Exponent(*(np.nan,) * 4)
    x = np.log(found.time[inside])
    value, error = found.derived(lambda g: exponent(x, np.log(g[inside])))
    first, *_, last = found.time[inside]
    return Exponent(value, float(error), float(first), float(last))


class LowestSlope(NamedTuple):
    """The smallest local slope with its standard error, its time, and the displacement then."""

    value: float
    error: float
    time: float
    square: float


def lowest_slope(found: Resampled) -> LowestSlope:
    """Smallest local slope, if the slope rises again within the times that there are.

    Result: all NaN if the slope falls to the end.
    """
    slope = local_slope(found.time, found.value)
    if not np.isfinite(slope).any():
        return LowestSlope(*(np.nan,) * 4)
    at, last = int(np.nanargmin(slope)), int(np.flatnonzero(np.isfinite(slope))[-1])
    if found.time[at] > 0.5 * found.time[last]:
        return LowestSlope(*(np.nan,) * 4)
    value, error = found.derived(lambda g: local_slope(found.time, g)[at])
    return LowestSlope(value, float(error), found.time[at], found.value[at])


def diffusion_constant(
    found: Resampled, dimension: int, after: float, before: float = np.inf
) -> tuple[float, float]:
    """D from the slope of g = 2 d D t + c between two times.

    Returns ``value``, ``error``: NaN with fewer than four lags there.
    """
    between = (found.time >= after) & (found.time <= before)
    if between.sum() < 4:
        return np.nan, np.nan
    time = found.time[between]

    def slope(g):
        return np.polyfit(time, g[between], 1)[0] / (2 * dimension)

    value, error = found.derived(slope)
    return float(value), float(error)


def subdiffusion(sweep: xr.Dataset, axis: str) -> xr.Dataset:
    """Displacements, local slopes and exponents of the points of a sweep of chains.

    The subdiffusive window is where a bead has moved more than two bonds and less than the
    chain's size: 4 <l^2> < g_i < R_g^2. Below it beads fly freely or feel only their
    neighbours, above it the whole chain diffuses.

    ``sweep``: collected, with ``displacement``, ``bonds`` and ``chains`` observed. ``axis``: the
    one axis besides ``replica``. Result: over the axis and ``lag``: ``time``, ``inner``,
    ``centre``, ``slope`` (of inner), each but the first with ``_error`` (standard error). Over the
    axis: ``exponent`` of inner in the window and its error, ``first`` and ``last`` time and ``low``
    and ``high`` square displacement of the window; ``lowest``, the smallest local slope, at
    ``lowest_time`` and ``lowest_square``; ``duration``, ``box_edge``, ``beads`` of the longest
    chain and ``friction`` of the run.
    """
    points = [_of_chains(sweep.sel({axis: place})) for place in sweep[axis].values]
    data = xr.Dataset(coords={axis: sweep[axis]})
    for name, unit in CURVES.items():
        rows = np.stack(padded([point[name] for point in points]))
        data[name] = ((axis, "lag"), rows, _named(name, unit))
    # Numbered lags: sweeps of other lengths have others, and are filled up where they are joined.
    data["lag"] = np.arange(data.sizes["lag"])
    for name, unit in NUMBERS.items():
        data[name] = (axis, [point[name] for point in points], _named(name, unit))
    return data


def _named(name, unit):
    return {"units": unit, "long_name": name.replace("_", " ")}


def _of_chains(at):
    """What `subdiffusion` finds at one point, by name."""
    inner, centre = (displacements(at, kind, HALF) for kind in ("inner", "centre"))
    low = TWO_BONDS * float(at.bond_mean_square.mean())
    high = float(at.gyration_square.mean())
    window = exponent_between(inner, low, high)
    lowest = lowest_slope(inner)
    scene = first_scene(at)
    found = {
        "time": inner.time, "exponent": window.value, "exponent_error": window.error,
        "first": window.first, "last": window.last, "low": low, "high": high,
        "lowest": lowest.value, "lowest_error": lowest.error, "lowest_time": lowest.time,
        "lowest_square": lowest.square,
        "duration": scene.steps.sample * scene.dt,
        "box_edge": min(scene.box), "beads": max(scene.lengths),
        "friction": scene.data["thermostat"]["gamma"],
    }  # fmt: skip
    slope = partial(local_slope, inner.time)
    for name, (value, error) in {
        "inner": inner.derived(lambda g: g),
        "centre": centre.derived(lambda g: g),
        "slope": inner.derived(slope),
    }.items():
        found[name], found[f"{name}_error"] = value, error
    return found
