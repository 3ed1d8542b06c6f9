"""How beads and chains move: displacements, exponents, D; end-to-end correlation, relaxation."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene, padded
from dpd.analysis.statistics import jackknife_error, linear_fit, taped, widened_by

Value = TypeVar("Value", bound=float | np.ndarray)

SLOPE_OVER = 4.0  # ratio of the times that a local slope is taken over
FEWEST = 4  # lags that a line is fitted to
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
USED = ("scene", "lag_", "msd_", "end_", "bond_mean_s", "gyration_s")  # all cost at each point
HALF = 5.0  # parts of a run, which are tenths
GROUPS = 20  # of molecules, left out in turn
# By which the variance of a mean over parts is larger, as displacements that end in one have begun
# in the one before: of free diffusion 4/3 at the longest lag, 1 at the shortest.
OVERLAP = 1.2
DECADE = 10.0  # factor in time over which shared motion is measured

TAIL_LOW, TAIL_HIGH = 0.15, 0.6  # of C(t) / C(0), where its slowest mode alone is left
TEN = 10.0  # relaxation times that a run has to last
SETTLED = 2.0  # and to settle before: of a wrong R^2 at the start 2 to 14 % are left
# Relaxation times between which D is taken, of chains of any length: a run of ten has these lags.
DIFFUSES, LATER = (0.5, 1.0), (1.0, 2.0)
# What `chain_dynamics` gives, with units.
DYNAMICS = {
    "tau": "tau", "tau_error": "tau", "diffusion": "r_c^2 / tau", "diffusion_error": "r_c^2 / tau",
    "diffusion_later": "r_c^2 / tau", "diffusion_later_error": "r_c^2 / tau", "duration": "tau",
    "long_enough": "1",
}  # fmt: skip


class Resampled(NamedTuple):
    """A mean-square displacement or a correlation at some lags, and without some of the data."""

    time: np.ndarray  # (lags,), in tau, increasing
    value: np.ndarray  # (lags,)
    without_molecules: np.ndarray  # (groups, lags), leaving out a group of molecules in turn
    # (parts, lags), leaving out a part of a run in turn: what all molecules do together shows here
    without_part: np.ndarray

    @taped
    def derived(self, function: Callable[[np.ndarray], Value]) -> tuple[Value, float | np.ndarray]:
        """A function of the (lags,) values, with its standard error.

        The larger of two jackknife errors, over molecules and over parts of the runs, both taken as
        independent but for `OVERLAP`. NaN where either is.
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


@taped
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
    seen = np.flatnonzero(time <= reach * part * (1 + 1e-9))
    seen = seen[np.argsort(time[seen])]
    count, total = runs[counts].values[:, :, seen], runs[sums].values[:, :, seen]
    single = runs[each].transpose("replica", members, lag).values[:, :, seen]
    weight = count.sum(axis=1)
    molecules = np.flatnonzero(np.isfinite(single[0]).all(axis=1))
    without = []
    for replica in range(len(single)):
        for group in np.array_split(molecules, min(GROUPS, len(molecules))):
            means = single[:, molecules].mean(axis=1)
            means[replica] = single[replica, np.setdiff1d(molecules, group)].mean(axis=0)
            without.append((means * weight).sum(axis=0) / weight.sum(axis=0))
    all_sums, all_counts = total.sum(axis=(0, 1)), count.sum(axis=(0, 1))
    parts = ((all_sums - total) / (all_counts - count)).reshape(-1, len(seen))
    found = Resampled(time[seen], all_sums / all_counts, np.array(without), parts)
    return _far(found, part * (1 + 1e-9)) if reach > 1 else found


def _far(found, part):
    """With errors at lags longer than a part from molecules alone, as parts overlap there.

    Shared motion makes them larger by the ratio of both errors in the decade of lags up to a part,
    if it is above 1. Of walkers that share up to 70 % of their steps the rms of z is 0.8 to 1.3.
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
    """Mean-square displacements in r_c^2 of the replicas of one point with ``displacement``.

    ``kind``: ``inner`` or ``centre``. ``reach``: of lags, in tenths of the run, see `resampled`.
    """
    return resampled(
        runs, "lag", "molecule", "lag_time", f"msd_{kind}", f"msd_{kind}_sums", "lag_samples",
        reach,
    )  # fmt: skip


def end_to_end(runs: xr.Dataset) -> tuple[Resampled, float]:
    """<R(t) . R(0)> of the replicas of one point with ``end_to_end``, and <R^2>, in r_c^2."""
    found = resampled(
        runs, "end_lag", "chain", "end_lag_time", "end_correlation", "end_sums", "end_samples"
    )
    return found, float(runs.end_square.mean())


@taped
def local_slope(time: np.ndarray, value: np.ndarray) -> np.ndarray:
    """d ln g / d ln t at each of (n,) increasing times: a line over a factor `SLOPE_OVER` about it.

    NaN where the data do not reach half that factor to both sides.
    """
    x, y = np.log(time), np.log(value)
    reach = 0.5 * np.log(SLOPE_OVER) + 1e-9
    inside = (x - reach >= x[0] - 2e-9) & (x + reach <= x[-1] + 2e-9)
    near = np.abs(x - x[:, None]) <= reach
    slope = np.full(len(x), np.nan)
    for k in np.flatnonzero(inside & (near.sum(axis=1) >= 3)):
        slope[k] = exponent(x[near[k]], y[near[k]])
    return slope


def exponent(x: np.ndarray, y: np.ndarray) -> float:
    """Slope of a straight line, every stretch of x with the weight of its length."""
    weight = np.gradient(x) if len(x) > 1 else np.ones(1)
    x, y = x - np.average(x, weights=weight), y - np.average(y, weights=weight)
    return float((weight * x * y).sum() / (weight * x * x).sum())


def diffusion_constant(
    found: Resampled, dimension: int, after: float, before: float = np.inf
) -> tuple[float, float]:
    """D and its error from the slope of g = 2 d D t + c between two times; NaN of few lags."""
    between = (found.time >= after) & (found.time <= before)
    if between.sum() < FEWEST:
        return np.nan, np.nan
    time, over = found.time[between], 2 * dimension
    value, error = found.derived(lambda g: np.polyfit(time, g[between], 1)[0] / over)
    return float(value), float(error)


def subdiffusion(sweep: xr.Dataset, axis: str) -> xr.Dataset:
    """Displacements, local slopes and exponents of the points of a sweep of chains.

    The subdiffusive window is where a bead has moved more than two bonds and less than the
    chain's size: 4 <l^2> < g_i < R_g^2.

    ``sweep``: collected, with ``displacement``, ``bonds`` and ``chains`` observed, over one axis.
    Over it and ``lag``: `CURVES`, slope being that of inner. Over the axis: `NUMBERS`: ``exponent``
    of inner in the window, which begins and ends at ``first`` and ``last``, ``low`` and ``high``;
    ``lowest``, the smallest local slope; ``beads`` of the longest chain, ``friction`` of the run.
    """
    sweep = sweep[[name for name in sweep.data_vars if str(name).startswith(USED)]]
    points = [_of_chains(sweep.isel({axis: place})) for place in range(sweep.sizes[axis])]
    data: dict[str, Any] = {}
    for name, unit in (CURVES | NUMBERS).items():
        column = padded([np.asarray(point[name]) for point in points])
        about = {"units": unit, "long_name": name.replace("_", " ")}
        data[name] = ((axis, "lag")[: 1 + column[0].ndim], np.stack(column), about)
    # Numbered lags: sweeps of other lengths have others, and are filled up where they are joined.
    return xr.Dataset(data, {axis: sweep[axis], "lag": np.arange(data["time"][1].shape[1])})


def _of_chains(at):
    """What `subdiffusion` finds at one point, by name."""
    inner, centre = (displacements(at, kind, HALF) for kind in ("inner", "centre"))
    scene = first_scene(at)
    low, high = TWO_BONDS * float(at.bond_mean_square.mean()), float(at.gyration_square.mean())
    found = dict.fromkeys(NUMBERS, np.nan) | {
        "time": inner.time, "low": low, "high": high, "duration": scene.steps.sample * scene.dt,
        "box_edge": min(scene.box), "beads": max(scene.lengths),
        "friction": scene.data["thermostat"]["gamma"],
    }  # fmt: skip

    def put(name, of, function):
        found[name], found[f"{name}_error"] = of.derived(function)

    window = (inner.value >= low) & (inner.value <= high)
    if window.sum() >= FEWEST:
        within = inner.time[window]
        found["first"], found["last"] = within[0], within[-1]
        put("exponent", inner, lambda g: exponent(np.log(within), np.log(g[window])))
    slope = partial(local_slope, inner.time)
    here = slope(inner.value)
    seen = np.flatnonzero(np.isfinite(here))
    # None is the smallest where the slope falls to the end of the times that there are.
    if len(seen) and inner.time[k := int(np.nanargmin(here))] <= 0.5 * inner.time[seen[-1]]:
        put("lowest", inner, lambda g: slope(g)[k])
        found["lowest_time"], found["lowest_square"] = inner.time[k], inner.value[k]
    put("inner", inner, lambda g: g)
    put("centre", centre, lambda g: g)
    put("slope", inner, slope)
    return found


def in_tail(share: np.ndarray, low: float = TAIL_LOW, high: float = TAIL_HIGH) -> np.ndarray:
    """Which lags lie in the tail of C(t) / C(0), by increasing lag: the first below it ends it."""
    return (share < high) & (np.minimum.accumulate(share) > low)


def relaxation_time(found: Resampled, square: float) -> tuple[float, float]:
    """tau of exp(-t / tau), and its error, from the straight part of ln C(t).

    Lags reach to a tenth of a run, so the tail is cut at C(t) / C(0) = 0.30 where a run lasts for
    ten tau. Of ideal chains, tau comes out 0.9 % too small there, and 0.4 % with the whole tail.
    NaN where C(t) has fewer than four lags in the tail.
    """
    inside = in_tail(found.value / square)
    if inside.sum() < FEWEST:
        return np.nan, np.nan
    value, error = found.derived(lambda c: decay_time(found.time, c, inside))
    return float(value), float(error)


def decay_time(time: np.ndarray, correlation: np.ndarray, inside: np.ndarray) -> float:
    """tau of a straight line through ln C(t) at some lags."""
    return -1.0 / np.polyfit(time[inside], np.log(np.maximum(correlation[inside], 1e-9)), 1)[0]


def chain_dynamics(sweep: xr.Dataset) -> xr.Dataset:
    """Relaxation times and diffusion constants over chain length, `DYNAMICS`.

    ``diffusion`` is from lags of half a tau to one, ``diffusion_later`` the same at one tau to two
    where the run has them; ``long_enough`` is 1 where ``duration`` of a run is ten tau or more,
    after two or more to settle. ``sweep``: with the axes ``length`` and ``replica``.
    """
    sweep, rows = sweep[[name for name in sweep.data_vars if str(name).startswith(USED)]], []
    for place in range(sweep.sizes["length"]):
        at = sweep.isel(length=place)
        scene = first_scene(at)
        before, duration = (steps * scene.dt for steps in scene.steps)
        tau, tau_error = relaxation_time(*end_to_end(at))
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
    variables = {
        name: ("length", column, {"units": unit, "long_name": name.replace("_", " ")})
        for (name, unit), column in zip(DYNAMICS.items(), np.array(rows).T)
    }
    return xr.Dataset(variables, {"length": sweep.length.astype(float)})


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
    return Power(float(fit.values[1]), float(fit.errors[1]), float(fit.values[0]), fit.p_value)
