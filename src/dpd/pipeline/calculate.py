"""The file of a sweep of theory: all points on its axes, of which only new ones are calculated."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from dpd.analysis.collect import load
from dpd.errors import UserError
from dpd.own import explained
from dpd.page import Quantity
from dpd.stages import calculation_sources

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.pipeline.theory import TheoryPoint, TheorySweep

DIGEST = "point_digest"


def calculate(
    sweep: TheorySweep, path: str | Path, progress: Callable[[int], None] | None = None
) -> xr.Dataset:
    """Calculate a sweep; points that a former file has are taken from there.

    Parameters
    ----------
    sweep : TheorySweep
    path : path
        Of the former file, if there is one. Only what the sources as they are have made is used.
    progress : callable or None
        Called with the number of points done.

    Returns
    -------
    xarray.Dataset
        Dimensions are the axes of the sweep, and those of arrays that are calculated.

    Raises
    ------
    UserError
        If a point has no solution, with its name and why.
    """
    begun = time.perf_counter()
    former, found = _former(sweep, path), []
    for done, point in enumerate(sweep.points):
        found.append(former.get(point.digest) or calculated(point))
        if progress is not None:
            progress(done + 1)
    names = [axis.name for axis in sweep.axes]
    shape = [len(axis.labels) for axis in sweep.axes]
    data = xr.Dataset()
    for axis in sweep.axes:
        about = {"units": axis.units, "long_name": axis.long_name}
        data[axis.name] = (axis.name, list(axis.labels), about)
    for name, first in found[0].items():
        about = {"units": first.units, "long_name": first.long_name}
        if first.dims == (name,):
            data[name] = (name, first.value, about)
            continue
        values = np.array([point[name].value for point in found])
        data[name] = ((*names, *first.dims), values.reshape((*shape, *values.shape[1:])), about)
    digests = np.reshape([point.digest for point in sweep.points], shape)
    data[DIGEST] = (names, digests, {"units": "1", "long_name": "digest of the arguments"})
    made = sum(point.digest not in former for point in sweep.points)
    data.attrs = {
        "sweep": sweep.name,
        "calculation": sweep.calculation,
        "description": _description(sweep),
        "sources": calculation_sources(sweep.paper),
        "points": sweep.digest,
        "points_calculated": made,
        "seconds": time.perf_counter() - begun,
    }
    return data


def calculated(point: TheoryPoint) -> dict[str, Quantity]:
    """What a calculation finds at one point.

    Raises
    ------
    UserError
        Naming the point, if its arguments have no solution, or the calculation is broken.
    """
    calculation = point.calculation
    try:
        found = calculation.calculate()
        return {name: Quantity(*value) for name, value in found.items()}
    except ValueError as problem:
        raise UserError(f"{point.where}: {calculation.key}: {problem}") from None
    except Exception as problem:  # whatever a paper's own file may raise
        said = explained(problem, type(calculation))
        raise UserError(f"{point.where}: {calculation.key}: calculations.py: {said}") from None


def _former(sweep, path):
    """Points of a file that the same calculation and sources have made, by digest."""
    if not Path(path).is_file():
        return {}
    with suppress(UserError, KeyError):  # a damaged file is made anew
        data = load(path)
        made_by = data.attrs["calculation"], data.attrs["sources"]
        if made_by == (sweep.calculation, calculation_sources(sweep.paper)):
            axes = data[DIGEST].dims
            flat = data.stack(point=axes) if axes else data.expand_dims("point")
            return {
                str(flat[DIGEST].values[k]): _quantities(flat.isel(point=k), axes)
                for k in range(flat.sizes["point"])
            }
    return {}


def _quantities(at, axes):
    """One point of a file as its calculation gave it."""
    names = [name for name in at.variables if name not in (*axes, DIGEST, "point")]
    return {
        str(name): Quantity(
            at[name].values if at[name].dims else float(at[name]),
            at[name].attrs["units"], at[name].attrs["long_name"], tuple(map(str, at[name].dims)),
        )
        for name in names
    }  # fmt: skip


def _description(sweep):
    """What captions say of the sweep."""
    axes = "; ".join(
        f"{axis.long_name} {', '.join(map(str, axis.labels))}"
        if len(axis.labels) <= 6
        else f"{axis.long_name} {axis.labels[0]} to {axis.labels[-1]} ({len(axis.labels)} values)"
        for axis in sweep.axes
    )
    return f"calculated, nothing is simulated: {sweep.calculation.replace('_', ' ')}; {axes}."
