"""What figures of the chain-revised equation of state share."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import block_mean_and_error, over_replicas, taped
from dpd.report.style import BLUE, GREEN, ORANGE, Look

TARGET = 41.89  # the pressure of all fluids at constant pressure, in kT / r_c^3
LOOKS = {
    "crGW": Look("crGW", BLUE, "o"),
    "rGW": Look("rGW", ORANGE, "s"),
    "GW": Look("GW", GREEN, "^"),
}
PERCENT = {"units": "%"}


def mean_of(runs, name):
    """Mean and standard error of a series over the replicas of each point, as two arrays.

    ``runs``: a collected sweep. ``name``: of the series. Returns ``value``, ``error``.
    """
    value, error = runs[name], runs[f"{name}_error"]
    axis = value.dims.index("replica")
    mean, spread = over_replicas(value.values, error.values, axis)
    dims = [dim for dim in value.dims if dim != "replica"]
    coordinates = {dim: runs[dim] for dim in dims}
    return tuple(xr.DataArray(part, coordinates, dims) for part in (mean, spread))


def mean_of_alike(series):
    """Mean of a series over time and replicas, of points whose correlation is taken as one.

    The barostat sets it, and runs at constant pressure are so short that one says little of it.

    ``series``: over ``time``, ``replica`` and axes of a sweep. Returns ``value``, ``error``.
    """
    like, spread, flat = _scaled(series)
    found = (part.reshape(spread.shape) * spread for part in block_mean_and_error(flat, alike=True))
    return tuple(like.copy(data=part) for part in over_replicas(*found, axis=-1))


@taped
def _scaled(series):
    """An array without time and replicas, standard deviations, and (time, points) over these."""
    series = series.transpose("time", ..., "replica")
    spread = np.maximum(series.std("time"), np.finfo(float).tiny)
    flat = (series / spread).values.reshape(series.sizes["time"], -1)
    return spread[..., 0].drop_vars("replica", errors="ignore"), spread.values, flat


def mismatches(sweeps):
    """By how much each equation misses the pressure of each oligomer fluid.

    ``sweeps``: with ``oligomers`` and ``oligomer_pressures``. Returns ``mismatch`` of each equation
    and its ``mismatch_error``, in percent of the simulated ``pressure``, over the axes of the runs;
    ``mismatch_filled``, this error, and in place of one that is not known that by the longest
    correlation of all fluids, for means over many; mean lengths of bonds over those that were asked
    for.
    """
    runs, theory = sweeps["oligomers"], sweeps["oligomer_pressures"]
    pressure, error = mean_of(runs, "pressure")
    # A run that is too short for an error still knows how much its samples scatter.
    spread = runs.pressure_spread.max("replica").transpose(*error.dims)
    filled = error.fillna(spread * (error / spread).max())
    place = {name: runs[name] for name in ("chain", "density", "bond", "repulsion")}
    length = runs.bond_mean.mean(("block", "replica")).transpose(*pressure.dims)
    parts = []
    for equation in LOOKS:
        ratio = theory[equation].sel(place).transpose(*pressure.dims) / pressure
        parts.append(
            xr.Dataset({
                "mismatch": 100 * (ratio - 1),
                "mismatch_error": 100 * ratio * error / pressure,
                "mismatch_filled": 100 * ratio * filled / pressure,
            }).expand_dims(equation=[equation])
        )  # fmt: skip
    data = xr.concat(parts, "equation").transpose("equation", *pressure.dims)
    data["pressure"], data["pressure_error"] = pressure, error
    data["bond_ratio"] = length / runs.bond
    for name, units in (("mismatch", "%"), ("mismatch_error", "%"), ("mismatch_filled", "%"),
                        ("pressure", "kT / r_c^3"), ("pressure_error", "kT / r_c^3"),
                        ("bond_ratio", "1")):  # fmt: skip
        data[name].attrs = {"units": units}
    return data


def mean_unsigned(at):
    """Mean unsigned mismatch in percent, and its standard error at most, of one equation."""
    values, errors = at.mismatch.values.ravel(), at.mismatch_filled.values.ravel()
    return float(np.abs(values).mean()), float(np.sqrt((errors**2).sum()) / len(errors))


def largest(at):
    """Largest unsigned mismatch in percent, its standard error, and where it is, in words."""
    worst = at.stack(fluid=at.mismatch.dims)
    worst = worst.isel(fluid=int(np.abs(worst.mismatch.values).argmax()))
    where = (
        f"m = {int(worst.chain)}, rho = {float(worst.density):g}, l = {float(worst.bond):g}, "
        f"a = {float(worst.repulsion):g}"
    )
    return abs(float(worst.mismatch)), float(worst.mismatch_error), where
