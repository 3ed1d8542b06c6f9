"""Viscosity of a fluid under shear, in flows that a body force drives, and at rest.

The profile u(z) of a flow that a force g on each bead drives, at a density rho, is a parabola, as
eta u'' = -rho g: its curvature gives eta. Viscosities are in kT tau / r_c^dimension.
"""

import json
from typing import NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.statistics import independent_mean_and_error, mean_and_error, over_replicas
from dpd.errors import UserError

PARTS = 20  # of a run, each long beside the memory of the stress


class Measured(NamedTuple):
    """A value and its standard error, which knows about correlation between blocks."""

    value: float
    error: float


def measured(blocks: np.ndarray) -> Measured:
    """Mean and error of one value per sample or block of a run."""
    return Measured(*mean_and_error(blocks)[:2])


def viscosity(run: xr.Dataset) -> Measured:
    """Viscosity of a run under shear: the mean shear stress over the rate, eta = -<P_xy> / rate.

    The stress is that of all forces, with velocities about the flow.

    ``run``: as from `dpd.run` or `dpd.load`, with the observable ``thermo`` and pressures. Raises
    `UserError` if the run has no shear, or did not measure the stress.
    """
    stress = measured(_stress(run))
    rate = _rate(str(run.attrs["scene"]))
    return Measured(stress.value / rate, stress.error / abs(rate))


def viscosities(sweep: xr.Dataset) -> xr.Dataset:
    """`viscosity` and its error at each point of a collected sweep, replicas taken together."""
    stress = _stress(sweep)
    rates = np.vectorize(_rate, otypes=[float])(sweep.scene.values)
    errors = sweep.shear_stress_error.values / abs(rates)
    value, error = over_replicas(stress / rates, errors, -1)
    along = sweep.shear_stress.dims[:-1]
    units = sweep.shear_stress.attrs["units"].replace("kT", "kT tau")
    about, of_error = (
        {"units": units, "long_name": text}
        for text in ("viscosity", "standard error of the viscosity")
    )
    found = {"viscosity": (along, value, about), "viscosity_error": (along, error, of_error)}
    return xr.Dataset(found, {name: sweep[name] for name in along})


def _stress(runs):
    if "shear_stress" not in runs:
        raise UserError(
            "no shear stress was measured: a scene needs the key 'shear', and the observable "
            "'thermo' with pressure"
        )
    return np.asarray(runs.shear_stress.values, dtype=float)


def _rate(scene):
    data = json.loads(scene)
    changed = (key for each in data.get("schedule", ()) for key in each["set"])
    if any(key.split(".")[0] == "shear" for key in changed) or not (rate := data["shear"]["rate"]):
        raise UserError("shear.rate: a viscosity needs one rate, which is not 0, all the time")
    return float(rate)


def viscosity_of_two_flows(
    run: xr.Dataset, strength: float, edge: float, axis: int = 0
) -> Measured:
    """Shear viscosity from two opposite flows in a periodic box.

    With h = edge / 2 the flow of the lower half is u(z) = rho g z (h - z) / (2 eta), and the upper
    one the same backwards (Backer, Lowe, Hoefsloot and Iedema, J. Chem. Phys. 122, 154503 (2005)).
    Layers at the same place of both halves are taken together, which removes a drift of the box.

    ``run``: with ``velocity_profile`` and ``bead_profile`` over ``block``, ``axis`` and ``layer``.
    ``strength``: g, the force on a bead in the lower half, in kT / r_c. ``edge``: of the box across
    the flows, in r_c. ``axis``: of the flows. Raises `ValueError` if the number of layers is odd.
    """
    velocity = run.velocity_profile.values[:, axis]
    layers = velocity.shape[1]
    if layers % 2:
        raise ValueError(f"{layers} layers cannot be halved; choose 'bin' for an even number")
    half = 0.5 * edge
    flow = 0.5 * (velocity[:, : layers // 2] - velocity[:, layers // 2 :])
    z = run.layer.values[: layers // 2]
    shape = z * (half - z) - (edge / layers) ** 2 / 12  # the mean of z (h - z) over a layer
    curvature = flow @ shape / (shape @ shape)
    return viscosity_of_curvature(float(run.bead_profile.mean()) * strength, 2 * curvature)


def viscosity_of_curvature(force: float, second_derivatives: np.ndarray) -> Measured:
    """eta = force / -u'', from one second derivative per block; its error to first order."""
    mean = second_derivatives.mean()
    eta = force / mean
    return measured(eta - eta * (second_derivatives - mean) / mean)


def viscosity_of_fluctuations(
    tensor: np.ndarray, dt: float, volume: float, kT: float, memory: float
) -> Measured:
    """Shear viscosity by the Einstein relation (Helfand 1960) of the pressure tensor.

    With S_ab(t), the integral of P_ab over a time t,

        <S_ab(t)^2>  =  2 eta kT t / V + constant

    as soon as t is longer than the memory of the stress. The slope is that from t to 3 t, of the
    five `shear_components`.

    ``tensor``: (n, 3, 3) array; with all forces at each step, in kT / r_c^3: noise has no memory,
    and what it adds up to in one step counts. ``dt``: in tau. ``volume``: in r_c^3. ``memory``: t
    in tau, from which the slope is taken. The error is that of the mean over `PARTS` parts of the
    run, which count as independent. Raises `ValueError` if a part would be shorter than 9 t.
    """
    first = max(1, round(memory / dt))
    size = len(tensor) // PARTS
    if size < 9 * first:
        text = f"a run of {len(tensor)} steps has parts of {size} steps"
        raise ValueError(f"{text}; {9 * first} are needed")
    parts = shear_components(tensor[: size * PARTS]).reshape(PARTS, size, -1)
    slopes = [(_spread(part, 3 * first) - _spread(part, first)) / (2 * first) for part in parts]
    eta = np.array(slopes) * dt * volume / (2 * kT)
    return Measured(*map(float, independent_mean_and_error(eta)))


def shear_components(tensor: np.ndarray) -> np.ndarray:
    """Five independent ones, (n, 5), of (n, 3, 3) tensors, of the variance of an off-diagonal one.

    xy, xz, yz, (xx - yy) / 2 and (2 zz - xx - yy) / sqrt(12).
    """
    xx, yy, zz = (tensor[:, k, k] for k in range(3))
    off = [(tensor[:, a, b] + tensor[:, b, a]) / 2 for a, b in ((0, 1), (0, 2), (1, 2))]
    return np.stack([*off, (xx - yy) / 2, (2 * zz - xx - yy) / np.sqrt(12)], axis=1)


def _spread(stress, steps):
    """Mean square of the sum of the stress over so many steps, all components together."""
    sums = np.concatenate([np.zeros((1, stress.shape[1])), np.cumsum(stress, axis=0)])
    return ((sums[steps:] - sums[:-steps]) ** 2).mean()
