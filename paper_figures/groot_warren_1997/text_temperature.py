"""Numbers of Sec. III without a figure: relaxation of kT, and kT against noise amplitude."""

import numpy as np
import xarray as xr
from scipy.optimize import curve_fit

from dpd.analysis.statistics import independent_mean_and_error, over_replicas
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, RED, panels, points

TITLE = "Temperature relaxation and noise amplitude (rho 3, a 25, dt 0.04)."
PAPER_SHOWS = (
    "The paper states, without a figure, that kT relaxes exponentially from 10 to 1 within some "
    "10 steps at sigma 3 and some 90 at sigma 1, and that kT rises slowly with sigma up to about "
    "8 and rapidly beyond. Left: kT - 1 after a hot start, mean over replicas, with fitted "
    "exponentials. Right: kT - 1 against sigma."
)
HOT = 10.0
RAPID = 0.1  # kT - 1 that counts as the end of the slow rise


def compute(sweeps):
    """Relaxation times in steps, kT against sigma, and where kT - 1 passes 0.1."""
    relaxation, noise = sweeps["relaxation"], sweeps["noise_amplitude"]
    dt = float(relaxation.time[1] - relaxation.time[0])
    steps = relaxation.time.values / dt
    series = relaxation.kT_series.transpose("sigma", "replica", "time")
    times = np.array([[decay(steps, kT) for kT in replicas] for replicas in series.values])
    relaxation_steps, error = independent_mean_and_error(times)
    kT, kT_error = over_replicas(noise.kT.values, noise.kT_error.values, -1)
    return xr.Dataset(
        {
            "relaxation_steps": ("sigma", relaxation_steps, {"units": "steps"}),
            "relaxation_error": ("sigma", error, {"units": "steps"}),
            "kT_series": (("sigma", "step"), series.mean("replica").values, {"units": "kT"}),
            "excess": ("amplitude", kT - 1, {"units": "kT", "long_name": "kT - 1"}),
            "excess_error": ("amplitude", kT_error, {"units": "kT", "long_name": "standard error"}),
        },
        {
            "sigma": relaxation.sigma.values.astype(float),
            "step": steps,
            "amplitude": noise.sigma.values.astype(float),
        },
    )


def decay(steps, kT):
    """Relaxation time in steps of kT = end + (10 - end) exp(-steps / time)."""
    (time, _), _ = curve_fit(
        lambda s, time, end: end + (HOT - end) * np.exp(-s / time), steps, kT, p0=(30.0, 1.0)
    )
    return time


def knee(data):
    """Noise amplitude where kT - 1 passes `RAPID`, between two measured ones; and its error."""
    above = np.flatnonzero(data.excess.values > RAPID)
    if not len(above) or above[0] == 0:
        return np.nan, np.nan
    at = above[0]
    x, y, e = data.amplitude.values, data.excess.values, data.excess_error.values
    slope = (y[at] - y[at - 1]) / (x[at] - x[at - 1])
    return x[at - 1] + (RAPID - y[at - 1]) / slope, float(np.hypot(e[at], e[at - 1])) / slope


def measured(data):
    """Relaxation times and the knee."""
    found = {}
    for sigma in data.sigma.values:
        at = data.sel(sigma=sigma)
        alone = not np.isfinite(float(at.relaxation_error))
        found[f"relaxation_sigma_{sigma:g}"] = Measured(
            float(at.relaxation_steps),
            0.0 if alone else float(at.relaxation_error),
            "exponential from kT 10, end value free" + ("; one replica, no error" if alone else ""),
        )
    where, error = knee(data)
    found["noise_knee"] = Measured(
        where, error, "where kT - 1 passes 0.1, interpolated",
        "" if np.isfinite(where) else "kT - 1 does not pass 0.1 in the amplitudes of this study",
    )  # fmt: skip
    return found


def draw(data):
    """Relaxation on a logarithmic axis; kT - 1 against sigma."""
    figure, (left, right) = panels(2)
    for sigma, color in zip(data.sigma.values, (RED, BLUE)):
        at = data.sel(sigma=sigma)
        label = rf"$\sigma$ = {sigma:g}: {float(at.relaxation_steps):.1f} steps"
        left.plot(data.step, at.kT_series - 1, color=color, linewidth=0.7, label=label)
    for sigma, steps, color in ((1, 90, RED), (3, 10, BLUE)):
        label = rf"published, $\sigma$ = {sigma}: {steps} steps"
        published = (HOT - 1) * np.exp(-data.step / steps)
        left.plot(data.step, published, color=color, linestyle="--", linewidth=0.8, label=label)
    left.set(yscale="log", ylim=(0.01, 12), xlim=(0, 300), xlabel="steps of 0.04 τ",
             ylabel=r"$k_BT - 1$")  # fmt: skip
    left.legend(loc="upper right")
    points(right, data.amplitude, data.excess, data.excess_error, "this work")
    right.axvline(8, color=BLACK, linestyle="--", linewidth=0.9, label="published end of slow rise")
    right.axhline(RAPID, color=BLACK, linestyle=":", linewidth=0.6)
    right.set(xlabel=r"noise amplitude $\sigma$", ylabel=r"$k_BT - 1$")
    right.legend(loc="upper left")
    return figure
