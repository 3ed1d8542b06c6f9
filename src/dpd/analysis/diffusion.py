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


def displacements(runs: xr.Dataset, kind: str) -> Resampled:
    """Displacements of the replicas of one point, taken together.

    Parameters
    ----------
    runs : xarray.Dataset
        One point of a collected sweep with the observable ``displacement``, with the
        dimension ``replica``.
    kind : str
        ``inner`` or ``centre``.

    Returns
    -------
    Resampled
        In r_c^2.
    """
    return resampled(
        runs, "lag", "molecule", "lag_time", f"msd_{kind}", f"msd_{kind}_sums", "lag_samples"
    )


def local_slope(time: np.ndarray, value: np.ndarray) -> np.ndarray:
    """d ln g / d ln t at each time: a straight line over a factor `SLOPE_OVER` about it.

    NaN where the data do not reach half that factor to both sides.

    Parameters
    ----------
    time, value : (n,) arrays
        Times increasing, values > 0.

    Returns
    -------
    (n,) array
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

    Parameters
    ----------
    found : Resampled
    low, high : float
        Of g, in r_c^2.

    Returns
    -------
    Exponent
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

    Returns
    -------
    LowestSlope
        All NaN if the slope falls to the end.
    """
    slope = local_slope(found.time, found.value)
    if not np.isfinite(slope).any():
        return LowestSlope(*(np.nan,) * 4)
    at, last = int(np.nanargmin(slope)), int(np.flatnonzero(np.isfinite(slope))[-1])
    if found.time[at] > 0.5 * found.time[last]:
        return LowestSlope(*(np.nan,) * 4)
    value, error = found.derived(lambda g: local_slope(found.time, g)[at])
    return LowestSlope(value, float(error), found.time[at], found.value[at])


def diffusion_constant(found: Resampled, dimension: int, after: float) -> tuple[float, float]:
    """D from the slope of g = 2 d D t + c beyond a time.

    Returns
    -------
    value, error : float
        NaN with fewer than four lags there.
    """
    late = found.time >= after
    if late.sum() < 4:
        return np.nan, np.nan
    time = found.time[late]

    def slope(g):
        return np.polyfit(time, g[late], 1)[0] / (2 * dimension)

    value, error = found.derived(slope)
    return float(value), float(error)


def subdiffusion(sweep: xr.Dataset, axis: str) -> xr.Dataset:
    """Displacements, local slopes and exponents of the points of a sweep of chains.

    The subdiffusive window is where a bead has moved more than two bonds and less than the
    chain's size: 4 <l^2> < g_i < R_g^2. Below it beads fly freely or feel only their
    neighbours, above it the whole chain diffuses.

    Parameters
    ----------
    sweep : xarray.Dataset
        Collected, with ``displacement``, ``bonds`` and ``chains`` observed.
    axis : str
        The one axis besides ``replica``.

    Returns
    -------
    xarray.Dataset
        Over the axis and ``lag``: ``time``, ``inner``, ``centre``, ``slope`` (of inner), each but
        the first with ``_error`` (standard error). Over the axis: ``exponent`` of inner in
        the window and its error, ``first`` and ``last`` time and ``low`` and ``high`` square
        displacement of the window, ``diffusion`` of the centre of mass beyond ``last``, and
        ``lowest``, the smallest local slope, at ``lowest_time`` and ``lowest_square``, and
        ``duration`` and ``box_edge`` of the run.
    """
    rows, curves = [], []
    for place in sweep[axis].values:
        at = sweep.sel({axis: place})
        inner, centre = displacements(at, "inner"), displacements(at, "centre")
        low = TWO_BONDS * float(at.bond_mean_square.mean())
        high = float(at.gyration_square.mean())
        window = exponent_between(inner, low, high)
        after = window.last if np.isfinite(window.last) else inner.time[-1]
        constant = diffusion_constant(centre, at.sizes["axis"], after)
        scene = first_scene(at)
        time = scene.steps.sample * scene.data["integrator"]["dt"]
        rows.append((
            *window, low, high, *constant, *lowest_slope(inner), time, min(scene.box),
        ))  # fmt: skip
        slope, slope_error = inner.derived(partial(local_slope, inner.time))
        curves.append(np.array([
            inner.time, *inner.derived(lambda g: g), *centre.derived(lambda g: g), slope,
            slope_error,
        ]))  # fmt: skip
    tables = np.stack(padded(curves), axis=1)
    of_lags = (
        "time", "inner", "inner_error", "centre", "centre_error", "slope", "slope_error",
    )  # fmt: skip
    units_of_lags = ("tau", "r_c^2", "r_c^2", "r_c^2", "r_c^2", "1", "1")
    # Numbered lags: sweeps of other lengths have others, and are filled up where they are joined.
    data = xr.Dataset(coords={axis: sweep[axis], "lag": np.arange(tables.shape[-1])})
    for name, unit, table in zip(of_lags, units_of_lags, tables):
        data[name] = ((axis, "lag"), table, {"units": unit, "long_name": name.replace("_", " ")})
    names = (
        "exponent", "exponent_error", "first", "last", "low", "high", "diffusion",
        "diffusion_error", "lowest", "lowest_error", "lowest_time", "lowest_square", "duration",
        "box_edge",
    )  # fmt: skip
    units = (
        "1", "1", "tau", "tau", "r_c^2", "r_c^2", "r_c^2 / tau", "r_c^2 / tau", "1", "1", "tau",
        "r_c^2", "tau", "r_c",
    )  # fmt: skip
    for name, unit, column in zip(names, units, np.array(rows).T):
        data[name] = (axis, column, {"units": unit, "long_name": name.replace("_", " ")})
    return data
