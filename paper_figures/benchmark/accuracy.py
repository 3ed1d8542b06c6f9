"""Errors of integration schemes: how far from the limit of small steps, at what cost."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import diffusion_constant, displacements
from dpd.analysis.statistics import (
    COVERAGE,
    block_mean_and_error,
    jackknife,
    linear_fit,
    over_replicas,
)
from dpd.analysis.structure import blocks_of
from dpd.report.text import with_error

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterable, Mapping, Sequence

# Second order in dt for what depends on positions, and so what the limit dt -> 0 is taken from.
SECOND_ORDER = ("shardlow", "aboba")
HALF = 0.5  # of the steps, those that the limit is taken from
AFTER = 2.0  # tau, beyond which beads diffuse
HOT = 2.0  # kT from which on a run counts as lost
TOLERANCES = (0.03, 0.01, 0.003)
JUDGED = ("pressure", "kT")  # what a scheme is chosen by
LABELS = {
    "kT": "kinetic temperature",
    "kT_configurational": "configurational temperature",
    "pressure": "pressure",
    "energy": "potential energy",
    "rdf": "g(r), largest deviation",
    "bond": "bond length",
    "diffusion": "diffusion",
}


def quantities(runs: xr.Dataset) -> xr.Dataset:
    """What schemes are judged by, at every point of a sweep.

    ``runs``: collected over ``scheme``, ``gamma`` (or another axis), ``dt`` and ``replica``, with
    ``thermo``, and where they are observed ``configurational``, ``bonds``, ``displacement``.
    Result: each quantity and its ``_error`` (standard error) over the axes but ``replica``: ``kT``,
    ``pressure`` (kT / r_c^d), ``energy`` (kT per bead), ``kT_configurational``, ``bond`` (r_c),
    ``diffusion`` (r_c^2 / tau). NaN where a run was lost.
    """
    dims = runs.kT.dims[:-1]
    shape = tuple(runs.sizes[name] for name in dims)
    names = ["kT", "pressure", "energy"]
    for name, variable in (
        ("kT_configurational", "force_square"),
        ("bond", "bond_mean"),
        ("diffusion", "msd_inner"),
    ):
        if variable in runs:
            names.append(name)
    found = {name: np.full((2, *shape), np.nan) for name in names}
    for place in np.ndindex(shape):
        at = runs.isel(dict(zip(dims, place)))
        if (at.lost_step >= 0).any() or not float(at.kT.mean()) < HOT:
            continue
        for name in names:
            found[name][(slice(None), *place)] = _quantity(at, name)
    return xr.Dataset(
        {
            name + suffix: (dims, values[k], {"units": _units(runs, name), "long_name": name})
            for name, values in found.items()
            for k, suffix in enumerate(("", "_error"))
        },
        {name: runs[name] for name in dims},
    )


def _quantity(at, name):
    """Value and standard error of one quantity, from the replicas of one point."""
    if name in ("kT", "pressure"):
        return over_replicas(at[name].values, at[f"{name}_error"].values, -1)
    if name == "energy":
        value = (at.pair_energy + at.bond_energy).values
        error = np.hypot(at.pair_energy_error, at.bond_energy_error).values
        beads = at.beads.values
        return over_replicas(value / beads, error / beads, -1)
    if name == "kT_configurational":
        blocks = np.stack([blocks_of(at.force_square), blocks_of(at.curvature)], axis=-1)
        return jackknife(blocks, lambda means: means[0] / means[1])
    if name == "bond":
        return block_mean_and_error(blocks_of(at.bond_mean))
    return diffusion_constant(displacements(at, "inner"), first_scene(at).dimension, AFTER)


def _units(runs, name):
    if name == "pressure":
        return runs.pressure.attrs["units"]
    return {"bond": "r_c", "diffusion": "r_c^2 / tau"}.get(name, "kT")


def limit(data: xr.Dataset, name: str, along: str = "gamma") -> tuple[float, float]:
    """A quantity for dt -> 0: one value that the `SECOND_ORDER` schemes share.

    q(dt) = q_0 + c dt^2 with a c for each of them, and each value of ``along`` (friction does
    not change what is in equilibrium, but diffusion it does), through the smaller half
    of the steps.

    Returns ``value``, ``error``: NaN with too few runs that have an error.
    """
    small = data.isel(dt=slice(0, max(2, int(np.ceil(HALF * data.sizes["dt"])))))
    small = small.sel(scheme=[name for name in SECOND_ORDER if name in data.scheme.values])
    dts, values, errors, kinds = [], [], [], []
    groups = small[name].stack(group=("scheme", along)).group.size
    flat = small[[name, f"{name}_error"]].stack(group=("scheme", along))
    for group in range(groups):
        at = flat.isel(group=group)
        seen = np.isfinite(at[name].values) & (at[f"{name}_error"].values > 0)
        dts += list(at.dt.values[seen])
        values += list(at[name].values[seen])
        errors += list(at[f"{name}_error"].values[seen])
        kinds += [group] * int(seen.sum())
    dt, kind = np.array(dts), np.array(kinds)
    basis = [np.ones_like(dt), *(dt**2 * (kind == group) for group in np.unique(kind))]
    if len(dt) < len(basis):
        return np.nan, np.nan
    fit = linear_fit(np.array(basis), np.array(values), np.array(errors))
    (shared, *_), (shared_error, *_) = fit.values, fit.errors
    return float(shared), float(shared_error)


def deviations(runs: xr.Dataset) -> xr.Dataset:
    """Relative errors of every quantity at every point.

    Temperatures are held against kT = 1, all else against the `limit`; diffusion against that
    at the same friction. g(r) is held against the mean of the `SECOND_ORDER` schemes at the
    smallest step, and its error is the largest deviation at any distance, in units of g's
    highest value.

    ``runs``: as for `quantities`. Returns ``<quantity>`` and ``<quantity>_error`` over the axes, 1
    for 100 %; ``<quantity>_limit`` and ``<quantity>_limit_error``, with a dimension ``gamma`` for
    diffusion.
    """
    data = quantities(runs)
    found = xr.Dataset(coords=data.coords)
    for name in [name for name in LABELS if name in data]:
        value, error = data[name], data[f"{name}_error"]
        if name.startswith("kT"):
            reference, spread = xr.DataArray(1.0), xr.DataArray(0.0)
        elif name == "diffusion":
            each = [limit(data.sel(gamma=[g]), name) for g in data.gamma.values]
            reference, spread = (xr.DataArray(list(v), dims="gamma") for v in zip(*each))
        else:
            reference, spread = (xr.DataArray(v) for v in limit(data, name))
        found[name] = value / reference - 1
        found[f"{name}_error"] = np.hypot(error, spread * value / reference) / reference
        found[f"{name}_limit"] = reference.assign_attrs(data[name].attrs)
        found[f"{name}_limit_error"] = spread
        found[name].attrs = {"units": "1", "long_name": f"relative error of {LABELS[name]}"}
    if "rdf" in runs:
        found["rdf"], found["rdf_error"] = rdf_deviation(runs, np.isfinite(data.kT))
    return found


def rdf_deviation(
    runs: xr.Dataset, seen: xr.DataArray
) -> tuple[xr.DataArray, tuple[tuple[Hashable, ...], np.ndarray]]:
    """Largest deviation of g(r) from that of the best runs, and its standard error.

    Of many bins the one that noise moves most would be found, so what counts is the largest
    deviation d less what noise s there explains: sqrt(max(0, d^2 - 2 ln(bins) s^2)). NaN where the
    run is too short for an error there.
    """
    dims = runs.kT.dims[:-1]
    mean: dict[tuple[int, ...], np.ndarray] = {}
    error: dict[tuple[int, ...], np.ndarray] = {}
    for place in np.ndindex(tuple(runs.sizes[name] for name in dims)):
        if seen.values[place]:
            blocks = blocks_of(runs.rdf.isel(dict(zip(dims, place))))
            mean[place], error[place] = block_mean_and_error(blocks)  # type: ignore[assignment]  # many bins
    best = [
        place for place in mean if place[-1] == 0 and runs.scheme.values[place[0]] in SECOND_ORDER
    ]
    reference = np.mean([mean[place] for place in best], axis=0)
    spread = np.sqrt(np.sum([error[place] ** 2 for place in best], axis=0)) / len(best)
    value, sigma = np.full(seen.shape, np.nan), np.full(seen.shape, np.nan)
    for place, g in mean.items():
        if place in best:
            continue
        apart, noise = g - reference, np.hypot(error[place], spread)
        at = int(np.argmax(np.abs(apart)))
        excess = apart[at] ** 2 - 2 * np.log(len(g)) * noise[at] ** 2
        value[place] = np.sqrt(np.maximum(0.0, excess)) / reference.max()
        sigma[place] = noise[at] / reference.max()
    attrs = {"units": "1", "long_name": f"relative error of {LABELS['rdf']}"}
    return xr.DataArray(value, seen.coords, dims, attrs=attrs), (dims, sigma)


def bound(data: xr.Dataset, name: str) -> xr.DataArray:
    """The error that a scheme has at most, with 97.5 % confidence."""
    # NumPy's hints know no other arrays than its own.
    return np.abs(data[name]) + COVERAGE * data[f"{name}_error"]  # type: ignore[return-value]


class Cheapest(NamedTuple):
    """A scheme, its time step in tau, and its run time in seconds per tau."""

    scheme: str
    dt: float
    seconds: float


def cheapest(
    data: xr.Dataset, seconds: xr.DataArray, names: Iterable[str], tolerance: float
) -> Cheapest | None:
    """The scheme and step of least run time whose errors are surely within a tolerance.

    ``data``: from `deviations`, at one friction: over ``scheme`` and ``dt``. ``seconds``: run time
    per tau over ``scheme`` and ``dt``. ``names``: quantities that must be. Result: none if no run
    is good enough.
    """
    good = seconds
    for name in names:
        good = good.where(bound(data, name) <= tolerance)
    if not np.isfinite(good).any():
        return None
    at = good.stack(point=("scheme", "dt")).dropna("point")
    best = at.isel(point=int(np.argmin(at.values)))
    # By name: ``best.dt`` is the step only because it is no date, which xarray tries first.
    return Cheapest(str(best.scheme.values), float(best["dt"]), float(best))


class Choice(NamedTuple):
    """The cheapest scheme and step within a tolerance, at one friction.

    - ``scheme``: none where no run is good enough; the rest is empty then.
    - ``dt``, ``seconds``: time step, and run time per tau.
    - ``deviations``: dict of str to (float, float); relative error and its standard error of each
      of `JUDGED`.
    """

    gamma: float
    tolerance: float
    scheme: str | None = None
    dt: float = np.nan
    seconds: float = np.nan
    deviations: dict | None = None


def choices(data: xr.Dataset, names: Sequence[str] = JUDGED) -> list[Choice]:
    """For each friction and tolerance the cheapest scheme.

    ``data``: from `deviations`, with ``seconds`` per tau over ``scheme`` and ``dt``. ``names``:
    quantities whose errors must all be within the tolerance.
    """
    found = []
    for gamma in data.gamma.values:
        at = data.sel(gamma=gamma)
        for tolerance in TOLERANCES:
            best = cheapest(at, data.seconds, names, tolerance)
            if best is None:
                found.append(Choice(float(gamma), tolerance))
                continue
            chosen = at.sel(scheme=best.scheme, dt=best.dt)
            errors = {name: (float(chosen[name]), float(chosen[f"{name}_error"]))
                      for name in JUDGED}  # fmt: skip
            found.append(Choice(float(gamma), tolerance, *best, errors))
    return found


def front(seconds: np.ndarray, error: np.ndarray) -> list[int]:
    """Places of points to which no other is both faster and more accurate, by run time."""
    order = np.argsort(seconds)
    best, places = np.inf, []
    for place in order:
        if np.isfinite(error[place]) and error[place] < best:
            best = error[place]
            places.append(int(place))
    return places


def in_percent(errors: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """Relative errors, each with its standard error, in per cent."""
    return {name: with_error(100 * value, 100 * error) for name, (value, error) in errors.items()}
