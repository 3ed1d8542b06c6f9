"""The runs of a sweep, or what it calculates, as one labelled dataset."""

import time
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import NetCDF4DataStore

from dpd import files
from dpd.analysis.statistics import block_mean_and_error, correlation_time, spread_of_mean, trend
from dpd.digests import calculations_file, run_sources, stage_digest
from dpd.errors import UserError
from dpd.page import Calculation, Quantity
from dpd.page.own import blaming
from dpd.scene.scene import Scene

LAST = "last_"  # what variables of the last configuration begin with: it stays with its run
RECORDED = {
    "number_density": ("1 / r_c^dimension", "number density"),
    "beads": ("1", "number of beads"),
    "steps": ("1", "steps"),
    "lost_step": ("1", "step at which the run blew up; -1 if it did not"),
    "seed": ("1", "seed of the noise"),
    "seconds": ("s", "wall clock of the run"),
    "bead_steps_per_second": ("1 / s", "bead-steps per second"),
    "peak_memory_MiB": ("MiB", "peak memory of the run"),
}
# Each is asked for in all repeats of `degrees_of` and for the caption, and takes half a ms.
cached_scene = cache(Scene.of_result)


def collect(sweep: Any, paths: Iterable[str | Path], any_version: bool = False) -> xr.Dataset:
    """Put runs of a `dpd.pipeline.sweep.Sweep`, one per point in order, on its axes; replica last.

    A series becomes its mean, ``_error`` (standard error, from all replicas of its point; NaN where
    a run is too short), ``_degrees`` (its share of the degrees of freedom of that),
    ``_correlation_time`` in tau, ``_trend`` per tau with ``_trend_error``, and ``_spread`` (the
    standard deviation about the trend). Blocks and tables are kept whole, filled up with NaN where
    runs have fewer molecules or lags than others; so are the series that the sweep names (kT if it
    names none), where all runs share one time axis.

    ``any_version``: whether other sources than today's may have made them. Raises `UserError` if a
    run was made by other sources or from another scene.
    """
    begun = time.perf_counter()
    runs = [_read(path, point.scene, any_version) for path, point in zip(paths, sweep.points)]
    data, put = _on_axes(sweep)
    for name, (units, long_name) in RECORDED.items():
        put(name, [run.attrs[name] for run in runs], units, long_name)
    put("scene", [run.attrs["scene"] for run in runs], "1", "the scene as JSON")
    warnings = [run.attrs.get("warning", "") for run in runs]
    put("warning", warnings, "1", "what the run warned of; nothing if of nothing")
    per_bead = [float(np.abs(run.momentum).max()) / run.attrs["beads"] for run in runs]
    put("momentum_per_bead", per_bead, "m r_c / tau", "largest component met, over all samples")
    for name, variable in runs[0].data_vars.items():
        parts = [run[name] for run in runs]
        if variable.dims == ("sample",) and name != "time":
            for suffix, *column in _summed(runs, name, data.sizes["replica"]):
                put(name + suffix, *column)
        elif "sample" not in variable.dims and (
            _alike(parts) or len({part.shape for part in parts}) == 1
        ):
            about = variable.attrs["units"], variable.attrs["long_name"]
            put(name, padded([part.values for part in parts]), *about, variable.dims)
            for own in sorted(set(variable.dims) & set(runs[0].coords) - set(data.variables)):
                places = [run[own] for run in runs]
                if _alike(places):
                    data.coords[own] = places[0]
                elif f"{own}_of_run" not in data:  # as the slices of boxes that change
                    about = places[0].attrs["units"], places[0].attrs["long_name"]
                    put(f"{own}_of_run", [place.values for place in places], *about, (own,))
    if len({run.time.values.tobytes() for run in runs}) == 1:
        data.coords["time"] = ("time", runs[0].time.values, runs[0].time.attrs)
        for name in sweep.series:
            if name not in runs[0]:
                raise UserError(
                    f"sweep {sweep.name}: series: its runs have no {name!r}; let them "
                    "observe it, or remove the name"
                )
            units, long_name = (runs[0][name].attrs[key] for key in ("units", "long_name"))
            inner = ("time", *runs[0][name].dims[1:])  # a tensor has two axes more
            put(f"{name}_series", [run[name].values for run in runs], units, long_name, inner)
    data.attrs |= {key: runs[0].attrs[key] for key in ("numpy", "numba")}
    data.attrs["sources"] = " ".join(sorted({run.attrs["sources"] for run in runs}))
    data.attrs["collect_sources"] = stage_digest("collect")
    data.attrs["seconds"] = time.perf_counter() - begun
    return data


def _on_axes(sweep):
    """A dataset with the axes of a sweep, and what puts a variable of its points there."""
    data = xr.Dataset(attrs={"sweep": sweep.name})
    for axis in sweep.axes:
        about = {"units": axis.units, "long_name": axis.long_name}
        data[axis.name] = (axis.name, list(axis.labels), about)
    names, shape = zip(*((axis.name, len(axis.labels)) for axis in sweep.axes))

    def put(name, values, units, long_name, inner=()):
        values = np.array(values)
        stacked = values.reshape(*shape, *values.shape[1:])
        data[name] = ((*names, *inner), stacked, {"units": units, "long_name": long_name})

    return data, put


def calculate(
    paper: str, sweep: Any, progress: Callable[[int], object] = lambda done: None
) -> xr.Dataset:
    """Calculate a paper's sweep of theory: dimensions are its axes, and those of its arrays.

    ``progress`` is called with the number of points done. Raises `UserError` of a point without a
    solution.
    """
    begun, found = time.perf_counter(), []
    for done, point in enumerate(sweep.points, 1):
        calculation: Calculation = point.scene
        place = f"{paper}.yaml: sweeps.{sweep.name} ({point.name}): {calculation.key}"
        with blaming(calculation, place):
            try:
                results = calculation.calculate()
            except ValueError as problem:
                raise UserError(f"{place}: {problem}") from None
            found.append({name: Quantity(*value) for name, value in results.items()})
        progress(done)
    data, put = _on_axes(sweep)
    for name, (value, *about, dims) in found[0].items():
        if dims == (name,):
            data[name] = (name, value, dict(zip(("units", "long_name"), about)))
        else:
            put(name, [point[name].value for point in found], *about, dims)
    data.attrs |= {
        "calculation": sweep.points[0].scene.key,
        "axes": " ".join(axis.name for axis in sweep.axes),
        "sources": stage_digest("calculate", calculations_file(paper)),
        "points": sweep.calculated_digest,
        "seconds": time.perf_counter() - begun,
    }
    return data


def first_scene(runs: xr.Dataset) -> Scene:
    """The scene of the first point of a sweep, or of some of its points."""
    return cached_scene(str(runs.scene.values.ravel()[0]), "sweep")


def _summed(runs, name, replicas):
    """What stays of a series of each run: endings of names, values, units and long names."""
    series, attrs = [run[name].values for run in runs], runs[0][name].attrs
    units, long_name = attrs["units"], attrs["long_name"]
    mean, error, degrees, times = _means(series, replicas)
    times = times * np.array([float(run.time[0]) for run in runs])
    trends = [trend(run.time.values, each) for run, each in zip(runs, series)]
    slope, slope_error, spread = zip(*trends)
    text = f"linear trend of {long_name}"
    yield "", mean, units, long_name
    yield "_error", error, units, f"standard error of {long_name}"
    yield "_degrees", degrees, "1", f"degrees of freedom of {name}_error"
    yield "_correlation_time", times, "tau", f"integrated autocorrelation time of {long_name}"
    yield "_trend", slope, f"{units} / tau", text
    yield "_trend_error", slope_error, f"{units} / tau", f"standard error of {text}"
    yield "_spread", spread, units, f"standard deviation of {long_name} about its trend"


def _means(series, replicas):
    """Mean, error, degrees of freedom of the error, and correlation time of each of some series.

    Errors are from the variance and correlation of all replicas of a point; each has its share of
    their degrees of freedom.
    """
    found = []
    for first in range(0, len(series), replicas):
        point = series[first : first + replicas]
        if len({len(each) for each in point}) == 1 and np.isfinite(point).all():
            groups = [np.transpose(point)]
        else:  # as where a run was lost
            groups = [each[:, None] for each in point]
        for x in groups:
            mean, error = block_mean_and_error(x, alike=True)
            tau = correlation_time(x)
            degrees = spread_of_mean(x, alike=True).degrees if len(x) > 1 else np.zeros(x.shape[1])
            found += zip(mean, error, degrees / x.shape[1], [tau] * x.shape[1])
    return np.transpose(found)


def _alike(parts):
    """Whether arrays of several runs stand on the same coordinates, where they have any."""
    return all(part.coords.equals(parts[0].coords) for part in parts[1:])


def padded(arrays: list[np.ndarray]) -> list[np.ndarray]:
    """Arrays of one shape: shorter ones, as of fewer molecules, are filled up with NaN."""
    shape = np.max([array.shape for array in arrays], axis=0)
    if all((array.shape == shape).all() for array in arrays):
        return arrays
    rooms = [[(0, n) for n in shape - array.shape] for array in arrays]
    return [
        np.pad(array.astype(float), room, constant_values=np.nan)
        for array, room in zip(arrays, rooms)
    ]


def _read(path, scene, any_version):
    """A run as a dataset, refused if it is not what the sweep asks for."""
    # Snakemake keeps no record of a file that was moved or copied, and would leave it as it is.
    remedy = f"make it again: rm '{Path(path).parents[1]}'/*.made, and then snakemake"
    run = load(path, remedy)
    if not any_version:
        files.check_digest(path, run.attrs, "sources", run_sources(scene), remedy)
    files.check_digest(path, run.attrs, "scene_digest", scene.digest, remedy)
    if "kT" not in run:
        raise UserError(f"{scene.where}: observe: a sweep needs 'thermo' among its observables")
    return run.drop_vars([name for name in run.variables if str(name).startswith(LAST)])


def load(path: str | Path, remedy: str = "delete it and let snakemake make it again") -> xr.Dataset:
    """Read a dataset that `save` or a run has written."""
    with files.reading(path, "NetCDF file", remedy), files.opened(path) as file:
        return xr.open_dataset(NetCDF4DataStore(file)).load()


def save(data: xr.Dataset, path: str | Path) -> None:
    """Write a dataset whole or not at all, in the types that it has in memory."""

    def fill(draft):
        with files.opened(draft, "w") as file:
            # A type remembered from a file that was read would be forced on values put in since.
            data.drop_encoding().dump_to_store(NetCDF4DataStore(file))

    files.replace_whole(path, fill)
