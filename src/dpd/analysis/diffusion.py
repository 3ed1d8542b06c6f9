"""Functions of the time between two samples, with what they are without some of the data.

Of mean-square displacements: local slopes, exponents, diffusion constants.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene, padded
from dpd.analysis.statistics import jackknife_error, taped, widened_by

if TYPE_CHECKING:
    from collections.abc import Callable

    Value = TypeVar("Value", bound=float | np.ndarray)

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
GROUPS = 20  # of molecules, left out in turn
# By which the variance of a mean over parts is larger, as displacements that end in one have begun
# in the one before: of free diffusion 4/3 at the longest lag, 1 at the shortest.
OVERLAP = 1.2
DECADE = 10.0  # factor in time over which shared motion is measured


class Resampled(NamedTuple):
    """A mean-square displacement or a correlation at some lags."""

    time: np.ndarray  # (lags,), in tau, increasing
    value: np.ndarray  # (lags,)
    without_molecules: np.ndarray  # (groups, lags), leaving out a group of molecules in turn
    # (parts, lags), leaving out a part of a run in turn: what all molecules do together shows here
    without_part: np.ndarray

    @taped
    def derived(self, function: Callable[[np.ndarray], Value]) -> tuple[Value, float | np.ndarray]:
        """A quantity, by a function of a (lags,) array of values, with its standard error.

        The larger of two jackknife errors: over molecules, and over parts of the runs, in which
        what all molecules do together shows. Both count as independent, but for `OVERLAP`. NaN
        where either is.
        """
        molecules = jackknife_error([function(row) for row in self.without_molecules])
        parts = np.sqrt(OVERLAP) * jackknife_error([function(row) for row in self.without_part])
        sides = len(self.without_molecules), len(self.without_part)
        widened_by(np.where(parts > molecules, sides[1], sides[0]) - 1.0, 1.0)  # it is the larger's
        return function(self.value), np.maximum(molecules, parts)


def part_length(runs: xr.Dataset) -> float:
    """Length in tau of one of the parts that a run's sums are kept for."""
    scene = first_scene(runs)
    return scene.steps.sample * scene.dt / runs.sizes["part"]


def resampled(
    runs: xr.Dataset, lag: str, members: str, times: str, each: str, sums: str, counts: str,
    reach: float = 1.0,
) -> Resampled:  # fmt: skip
    """What an observable kept of the replicas of one point of a collected sweep, taken together.

    ``lag``, ``members``: the dimensions of lags and of molecules. ``times``, ``each``, ``sums``,
    ``counts``: variables: lags in tau, means of each molecule, sums of means over molecules in
    parts of the run, and how many were summed. ``reach``: length in parts that lags may have;
    beyond 1 parts are not independent, see `_far`.
    """
    runs = runs.transpose("replica", "part", lag, members, ...)
    time, part = runs[times].isel(replica=0).values, part_length(runs)
    seen = time <= reach * part * (1 + 1e-9)
    time = time[seen]
    count, total = runs[counts].values[:, :, seen], runs[sums].values[:, :, seen]
    order = np.argsort(time)
    single = runs[each].transpose("replica", members, lag).values[:, :, seen]
    weight = count.sum(axis=1)
    molecules = np.flatnonzero(np.isfinite(single[0]).all(axis=1))
    groups = np.array_split(molecules, min(GROUPS, len(molecules)))
    without = []
    for replica in range(len(single)):
        for group in groups:
            means = single[:, molecules].mean(axis=1)
            means[replica] = single[replica, np.setdiff1d(molecules, group)].mean(axis=0)
            without.append((means * weight).sum(axis=0) / weight.sum(axis=0))
    all_sums, all_counts = total.sum(axis=(0, 1)), count.sum(axis=(0, 1))
    parts = [
        (all_sums - total[r, p]) / (all_counts - count[r, p])
        for r in range(len(total))
        for p in range(total.shape[1])
    ]
    found = Resampled(
        time[order], (all_sums / all_counts)[order],
        np.array(without)[:, order], np.array(parts)[:, order],
    )  # fmt: skip
    return _far(found, part * (1 + 1e-9)) if reach > 1 else found


def _far(found, part):
    """With errors at lags longer than a part from molecules alone, as parts overlap there.

    How much larger errors are because molecules share motion is taken from the decade of lags up
    to a part: the ratio of both errors there, if it is above 1. In four groups of walkers that
    share up to 70 % of their steps the rms of z is 0.8 to 1.3, up to half the run.
    """
    value, molecules, parts = found.value, found.without_molecules, found.without_part
    far, near = found.time > part, (found.time > part / DECADE) & (found.time <= part)
    if not far.any() or not near.any():
        return found
    over_parts = np.sqrt(OVERLAP) * jackknife_error(parts[:, near] / value[near])
    over_molecules = jackknife_error(molecules[:, near] / value[near])
    shared = max(1.0, float(np.sqrt((over_parts**2).mean() / (over_molecules**2).mean())))
    return found._replace(
        without_molecules=np.where(far, value + shared * (molecules - value), molecules),
        without_part=np.where(far, value, parts),
    )


def displacements(runs: xr.Dataset, kind: str, reach: float = 1.0) -> Resampled:
    """Displacements in r_c^2 of the replicas of one point with ``displacement``, taken together.

    ``kind``: ``inner`` or ``centre``. ``reach``: length that lags may have, in tenths of the run,
    see `resampled`.
    """
    return resampled(
        runs, "lag", "molecule", "lag_time", f"msd_{kind}", f"msd_{kind}_sums", "lag_samples",
        reach,
    )  # fmt: skip


def local_slope(time: np.ndarray, value: np.ndarray) -> np.ndarray:
    """d ln g / d ln t at each of (n,) increasing times: a line over a factor `SLOPE_OVER` about it.

    NaN where the data do not reach half that factor to both sides.
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
    """An exponent with its error, and the times between which the line was laid; or all NaN."""

    value: float
    error: float
    first: float
    last: float


def exponent_between(found: Resampled, low: float, high: float) -> Exponent:
    """Exponent of g ~ t^x where g lies between two values, in r_c^2; NaN below four lags."""
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
    """Smallest local slope; all NaN if the slope falls to the end of the times that there are."""
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
    """D and its error from the slope of g = 2 d D t + c between two times.

    NaN with fewer than four lags there.
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

    ``sweep``: collected, with ``displacement``, ``bonds`` and ``chains`` observed, over one axis.
    Over it and ``lag``: `CURVES`, slope being that of inner. Over the axis: `NUMBERS`: ``exponent``
    of inner in the window, ``first`` and ``last`` time and ``low`` and ``high`` square displacement
    of that; ``lowest``, the smallest local slope, at ``lowest_time`` and ``lowest_square``;
    ``beads`` of the longest chain and ``friction`` of the run.
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
