"""Relaxation of chains: end-to-end correlation, relaxation times, diffusion, exponents."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import diffusion_constant, displacements
from dpd.analysis.resampling import part_length, resampled

if TYPE_CHECKING:
    from dpd.analysis.resampling import Resampled

TAIL_LOW, TAIL_HIGH = 0.15, 0.6  # of C(t) / C(0), where its slowest mode alone is left
TEN = 10.0  # relaxation times that a run has to last
SETTLED = 2.0  # and to settle before: of a wrong R^2 at the start exp(-4) is left, 2 %


def end_to_end(runs: xr.Dataset) -> tuple[Resampled, float]:
    """<R(t) . R(0)> of the replicas of one point.

    Parameters
    ----------
    runs : xarray.Dataset
        One point of a collected sweep with ``end_to_end``, with the dimension ``replica``.

    Returns
    -------
    Resampled
        In r_c^2.
    square : float
        <R^2>.
    """
    found = resampled(
        runs, "end_lag", "chain", "end_lag_time", "end_correlation", "end_sums", "end_samples"
    )
    return found, float(runs.end_square.mean())


def in_tail(share: np.ndarray) -> np.ndarray:
    """Whether each lag lies in the tail, given C(t) / C(0) by increasing lag."""
    inside = (share < TAIL_HIGH) & (share > TAIL_LOW)
    # The first lag below the tail ends it, whatever noise does later.
    ended = np.flatnonzero(share <= TAIL_LOW)
    if len(ended):
        inside[ended[0] :] = False
    return inside


def relaxation_time(found: Resampled, square: float) -> tuple[float, float]:
    """tau of exp(-t / tau) from the straight part of ln C(t).

    Lags reach to a tenth of a run, so the tail is cut at C(t) / C(0) = 0.37 where a run lasts for
    ten tau. Of ideal chains, tau comes out 1.5 % too small there, and 0.3 % with the whole tail.

    Parameters
    ----------
    found : Resampled
    square : float

    Returns
    -------
    value, error : float
        In tau; NaN where C(t) has fewer than four lags in the tail.
    """
    inside = in_tail(found.value / square)
    if inside.sum() < 4:
        return np.nan, np.nan
    time = found.time[inside]

    def tau(value):
        return -1.0 / np.polyfit(time, np.log(np.maximum(value[inside], 1e-9)), 1)[0]

    value, error = found.derived(tau)
    return float(value), float(error)


def chain_dynamics(sweep: xr.Dataset) -> xr.Dataset:
    """Relaxation times and diffusion constants over chain length.

    Parameters
    ----------
    sweep : xarray.Dataset
        With the axes ``length`` and ``replica``.

    Returns
    -------
    xarray.Dataset
        Over ``length``: ``tau``, ``diffusion``, each with ``_error``, ``duration`` of a run, and
        ``long_enough``, 1 where that is ten tau or more, after two tau or more to settle.
    """
    rows = []
    for length in sweep.length.values:
        at = sweep.sel(length=length)
        scene = first_scene(at)
        duration = part_length(at) * at.sizes["part"]
        tau, tau_error = relaxation_time(*end_to_end(at))
        before = scene.steps.equilibrate * scene.data["integrator"]["dt"]
        enough = duration >= TEN * tau and before >= SETTLED * tau
        constant = (np.nan, np.nan)
        if enough:
            centre = displacements(at, "centre")
            constant = diffusion_constant(centre, scene.dimension, 0.5 * tau)
        rows.append((tau, tau_error, *constant, duration, float(enough)))
    names = ("tau", "tau_error", "diffusion", "diffusion_error", "duration", "long_enough")
    units = ("tau", "tau", "r_c^2 / tau", "r_c^2 / tau", "tau", "1")
    data = xr.Dataset(coords={"length": sweep.length.astype(float)})
    for name, unit, column in zip(names, units, np.array(rows).T):
        data[name] = ("length", column, {"units": unit, "long_name": name.replace("_", " ")})
    return data
