"""Viscosity from steady shear."""

from __future__ import annotations

import json
from typing import NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.statistics import mean_and_error, over_replicas
from dpd.errors import UserError


class Viscosity(NamedTuple):
    """A viscosity in kT tau / r_c^dimension and its standard error."""

    value: float
    error: float


def viscosity(run: xr.Dataset, settled: float = 0.0) -> Viscosity:
    """Viscosity of a run under shear: the mean shear stress over the rate, eta = -<P_xy> / rate.

    The stress is that of all forces, with velocities about the flow: conservative, friction and
    noise, kinetic. It belongs to the kT and the rate of the run, see `heating`.

    ``run``: as from `dpd.run` or `dpd.load`, with the observable ``thermo`` and pressures.
    ``settled``: time in tau that is left out at the beginning. Result: with an error that knows the
    correlation of samples. Raises `UserError` if the run has no shear, or did not measure the
    stress.
    """
    stress, time = _stress(run), run.time.values
    mean, error, _ = mean_and_error(stress[time > settled])
    rate = _rate(str(run.attrs["scene"]))
    return Viscosity(mean / rate, error / abs(rate))


def viscosities(sweep: xr.Dataset) -> xr.Dataset:
    """The same at each point of a collected sweep, replicas taken together.

    ``sweep``: of runs under shear, with the dimension ``replica``. Returns ``viscosity`` and
    ``viscosity_error`` over the other axes. Raises `UserError` as `viscosity`.
    """
    stress = _stress(sweep)
    rates = np.vectorize(_rate, otypes=[float])(sweep.scene.values)
    errors = sweep.shear_stress_error.values / abs(rates)
    value, error = over_replicas(stress / rates, errors, -1)
    along = sweep.shear_stress.dims[:-1]
    found = xr.Dataset(
        {"viscosity": (along, value), "viscosity_error": (along, error)},
        {name: sweep[name] for name in along},
    )
    units = sweep.shear_stress.attrs["units"].replace("kT", "kT tau")
    found.viscosity.attrs = {"units": units, "long_name": "viscosity"}
    found.viscosity_error.attrs = {"units": units, "long_name": "standard error of the viscosity"}
    return found


def heating(run: xr.Dataset) -> float:
    """Heat that the flow of a run makes in kT / (tau r_c^dimension): stress times rate.

    The thermostat takes it up; kT rises until it does.

    ``run``: as of `viscosity`.
    """
    return float(_stress(run).mean() * _rate(str(run.attrs["scene"])))


def _stress(runs: xr.Dataset) -> np.ndarray:
    if "shear_stress" not in runs:
        raise UserError(
            "no shear stress was measured: a scene needs the key 'shear', and the observable "
            "'thermo' with pressure"
        )
    return np.asarray(runs.shear_stress.values, dtype=float)


def _rate(scene: str) -> float:
    return float(json.loads(scene)["shear"]["rate"])
