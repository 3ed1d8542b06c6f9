"""Equations of state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import over_replicas

if TYPE_CHECKING:
    from collections.abc import Sequence


def excess_pressure(sweeps: Sequence[xr.Dataset], axis: str = "repulsion") -> xr.Dataset:
    """Excess pressure of several sweeps over an axis and density, as one dataset.

    ``axis``: ``repulsion``, or another one where all have the same repulsion. Result: ``excess``
    with ``excess_error``, NaN where no run was made; ``scaled`` and ``scaled_error`` are divided by
    a rho^2.
    """
    parts = []
    for sweep in sweeps:
        value, error = over_replicas(
            sweep.excess_conservative.values, sweep.excess_conservative_error.values, -1
        )
        along = (axis, "density")
        parts.append(
            xr.Dataset(
                {"excess": (along, value), "excess_error": (along, error)},
                {name: sweep[name].astype(float) for name in along},
            )
        )
    data = xr.concat(parts, axis, join="outer").sortby(axis)
    scene = first_scene(sweeps[0])
    repulsion = data.repulsion if axis == "repulsion" else scene.data["repulsion"]["A A"]
    scale = repulsion * data.density**2
    data["scaled"] = data.excess / scale
    data["scaled_error"] = data.excess_error / scale
    d = scene.dimension
    units = {"excess": f"kT / r_c^{d}", "scaled": f"r_c^{d + 1}"}
    for name, unit in units.items():
        data[name].attrs = {"units": unit, "long_name": f"{name} pressure, conservative virial"}
        data[f"{name}_error"].attrs = {"units": unit, "long_name": "standard error"}
    return data
