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
    """Read the result of a run or of a sweep, which `dpd.run`, `dpd.sweep` or ``dpd run`` wrote.

    Parameters
    ----------
    path : path

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
    With ``fluid`` as in `dpd.run`:

    >>> made = dpd.run(fluid, output="fluid.nc", progress=False)
    >>> run = dpd.load("fluid.nc")
    >>> run.kT.dims, run.time.units, run.pressure.units
    (('time',), 'tau', 'kT / r_c^3')
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
    if "sample" in data.dims:
        data = data.set_coords("time").swap_dims(sample="time")
    dimension = str(data.sizes["axis"]) if "axis" in data.sizes else "dimension"
    for variable in data.variables.values():
        if "units" in variable.attrs:
            variable.attrs["units"] = variable.attrs["units"].replace("dimension", dimension)
    written = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    made = ", ".join(f"{name} {data.attrs[name]}" for name in ("sources", "numpy", "numba"))
    warned = {key: data.attrs[key] for key in ("warning",) if key in data.attrs}
    about = {
        "title": f"Dissipative particle dynamics of {data.attrs['beads']} beads",
        "source": f"dpd-papers ({made})",
        "history": f"{written:%Y-%m-%dT%H:%M:%SZ} written by dpd run",
        "comment": UNITS,
        "Conventions": CONVENTIONS,
    }
    data.attrs = warned | about | data.attrs  # the first ones are shown
    return data
