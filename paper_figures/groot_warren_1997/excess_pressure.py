"""What pressures over density and repulsion say, and the pressure from g(r)."""

from __future__ import annotations

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import jackknife, linear_fit
from dpd.analysis.structure import blocks_of


def dense(data: xr.Dataset, above: float = 2.0) -> tuple[np.ndarray, ...]:
    """Flat arrays (repulsion, density, scaled, scaled_error) of the runs denser than that."""
    flat = data[["scaled", "scaled_error"]].stack(point=("repulsion", "density"))
    flat = flat.dropna("point", subset=["scaled"]).where(flat.density > above, drop=True)
    return tuple(
        np.asarray(flat[name].values, dtype=float)
        for name in ("repulsion", "density", "scaled", "scaled_error")
    )


def compressibility(data: xr.Dataset, density: float, reach: float = 1.0) -> tuple[float, float]:
    """(dp / d rho) / kT at one density, which Groot and Warren 1997, Eq. 14, match to water's.

    ``data``: of `excess_pressure` at one repulsion. ``reach``: densities that far off or nearer are
    used. Returns ``value``, ``error``: slope of a polynomial through p there, at most a cubic; NaN
    with fewer than two densities.
    """
    near = data.where(np.abs(data.density - density) <= reach, drop=True)
    near = near.dropna("density", subset=["excess", "excess_error"])
    if near.sizes["density"] < 2:
        return np.nan, np.nan
    away = near.density.values - density
    terms = [away**power for power in range(min(4, len(away)))]
    fit = linear_fit(terms, near.density + near.excess.values, near.excess_error.values)
    (_, slope, *_), (_, slope_error, *_) = fit.values, fit.errors
    return float(slope), float(slope_error)


def exponent(data: xr.Dataset, above: float = 2.0) -> tuple[float, float]:
    """x of excess pressure ~ a^x at constant density, for densities above a value.

    Returns ``value``, ``error``: the error is from the scatter about the fit; NaN with fewer than
    two repulsions.
    """
    a, density, scaled, _ = dense(data, above)
    excess = scaled * a * density**2
    shared = [rho for rho in np.unique(density) if np.sum(density == rho) > 1]
    use = np.isin(density, shared)
    if not use.any():
        return np.nan, np.nan
    constants = [(density[use] == rho).astype(float) for rho in shared]
    fit = linear_fit([np.log(a[use]), *constants], np.log(excess[use]))
    (power, *_), (power_error, *_) = fit.values, fit.errors
    return float(power), float(power_error)


def from_rdf(runs: xr.Dataset) -> tuple[float, float]:
    """Excess pressure of one species from g(r): Groot and Warren 1997, Eq. 15, third line.

    ``runs``: one point of a collected sweep in three dimensions with ``rdf``, with the dimension
    ``replica``. Returns ``value``, ``error``: by leaving out blocks.
    """
    scene = first_scene(runs)
    repulsion, density = scene.data["repulsion"]["A A"], float(runs.number_density.mean())
    r = runs.r.values
    edge = 0.5 * (r[1] - r[0])
    # g is a mean over a bin, so the weight r^3 (1 - r) is integrated over each exactly.
    low, high = np.minimum(r - edge, 1.0), np.minimum(r + edge, 1.0)
    weight = (high**4 - low**4) / 4 - (high**5 - low**5) / 5
    factor = 2 * np.pi / 3 * density**2 * repulsion
    return jackknife(blocks_of(runs.rdf), lambda g: factor * (weight @ g))
