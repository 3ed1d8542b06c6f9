"""Results as labelled datasets: with time as a coordinate, units, and a summary."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.analysis import collect
from dpd.errors import UserError

if TYPE_CHECKING:
    import os

    import xarray as xr

CONVENTIONS = "CF-1.11"
UNITS = (
    "Reduced units: length r_c, the range of the forces; energy kT; mass m of a bead; time tau = "
    "r_c sqrt(m / kT). They are no units of UDUNITS."
)
REMEDY = "if it should be the result of a run or a sweep, make it again"


def load(path: str | os.PathLike) -> xr.Dataset:
    """Read the result of a run or of a sweep.

    Parameters
    ----------
    path : path
        A file that `dpd.run`, `dpd.sweep` or the command ``dpd run`` wrote.

    Returns
    -------
    xarray.Dataset
        Of a run: the variables of its observables. Time series have the dimension and coordinate
        ``time``, in tau since the end of equilibration. Averages over a part of the run have the
        dimension ``block``. Each variable has ``units`` and ``long_name``, and each series of
        numbers, as ``run.kT.attrs``, its ``mean``, its standard ``error`` (1.96 of it make a 95 %
        interval) and its ``correlation_time`` in tau; files of older versions lack those. The
        attributes hold the scene as JSON, the seed and what made the file.

        Of a sweep: see `dpd.sweep`.

    Raises
    ------
    dpd.UserError
        If the file is missing, damaged or something else.

    Examples
    --------
    >>> import dpd
    >>> fluid = {
    ...     "dimension": 2, "box": 8, "molecules": [{"architecture": "A", "density": 2}],
    ...     "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
    ...     "steps": {"equilibrate": 100, "sample": 200},
    ... }
    >>> made = dpd.run(fluid, output="fluid.nc", progress=False)
    >>> run = dpd.load("fluid.nc")
    >>> run.kT.dims, run.time.units, run.pressure.units
    (('time',), 'tau', 'kT / r_c^2')
    >>> run.equals(made)
    True
    """
    path = Path(path)
    if not path.is_file():
        raise UserError(f"{path}: {'is a folder' if path.is_dir() else 'there is no such file'}")
    data = collect.load(path, REMEDY)
    if "sweep" in data.attrs:
        return data
    if "scene_digest" not in data.attrs:
        raise UserError(f"{path}: neither the result of a run nor of a sweep; {REMEDY}")
    written = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    return described(as_series(data), f"{written:%Y-%m-%dT%H:%M:%SZ} written by dpd run")


def as_series(data: xr.Dataset) -> xr.Dataset:
    """A run whose samples are numbered by time, and whose units name its dimension."""
    if "sample" in data.dims:
        data = data.set_coords("time").swap_dims(sample="time")
    dimension = str(data.sizes["axis"]) if "axis" in data.sizes else "dimension"
    for variable in data.variables.values():
        if "units" in variable.attrs:
            variable.attrs["units"] = variable.attrs["units"].replace("dimension", dimension)
    return data


def described(data: xr.Dataset, history: str) -> xr.Dataset:
    """The same with attributes for people and programs before those that the file has.

    Parameters
    ----------
    data : xarray.Dataset
    history : str
        When and by what it was written.

    Returns
    -------
    xarray.Dataset
    """
    made = ", ".join(f"{name} {data.attrs[name]}" for name in ("sources", "numpy", "numba"))
    about = {
        "title": f"Dissipative particle dynamics of {data.attrs['beads']} beads",
        "source": f"dpd-papers ({made})",
        "history": history,
        "comment": UNITS,
        "Conventions": CONVENTIONS,
    }
    warned = {key: data.attrs[key] for key in ("warning",) if key in data.attrs}
    data = data.copy()
    data.attrs = warned | about | data.attrs  # the first ones are shown
    return data
