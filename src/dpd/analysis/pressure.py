"""Equations of state."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import over_replicas


def excess_pressure(sweeps):
    """Excess pressure of several sweeps over repulsion and density, as one dataset.

    Parameters
    ----------
    sweeps : list of xarray.Dataset
        With axes ``repulsion``, ``density``, ``replica``.

    Returns
    -------
    xarray.Dataset
        ``excess`` and ``excess_error`` (standard error) over repulsion and density, NaN
        where no run was made; ``scaled`` and ``scaled_error`` are divided by a rho^2.
    """
    parts = []
    for sweep in sweeps:
        value, error = over_replicas(
            sweep.excess_conservative.values, sweep.excess_conservative_error.values, -1
        )
        parts.append(
            xr.Dataset(
                {"excess": (("repulsion", "density"), value)}
                | {"excess_error": (("repulsion", "density"), error)},
                {
                    "repulsion": sweep.repulsion.astype(float),
                    "density": sweep.density.astype(float),
                },
            )
        )
    data = xr.concat(parts, "repulsion", join="outer")
    scale = data.repulsion * data.density**2
    data["scaled"] = data.excess / scale
    data["scaled_error"] = data.excess_error / scale
    units = {"excess": "kT / r_c^3", "scaled": "r_c^4"}
    for name, unit in units.items():
        data[name].attrs = {"units": unit, "long_name": f"{name} pressure, conservative virial"}
        data[f"{name}_error"].attrs = {"units": unit, "long_name": "standard error"}
    return data


def dense(data, above=2.0):
    """Flat arrays (repulsion, density, scaled, scaled_error) of the runs denser than that."""
    flat = data[["scaled", "scaled_error"]].stack(point=("repulsion", "density"))
    flat = flat.dropna("point").where(flat.density > above, drop=True)
    return tuple(
        np.asarray(flat[name].values, dtype=float)
        for name in ("repulsion", "density", "scaled", "scaled_error")
    )
