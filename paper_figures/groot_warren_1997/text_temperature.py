"""Numbers of Sec. III without a figure: relaxation of kT, and kT against noise amplitude."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import curve_fit

from dpd.analysis.statistics import (
    COVERAGE,
    independent_mean_and_error,
    linear_fit,
    over_replicas,
)
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, RED, panels, points

PUBLISHED = shown_by(__file__)
STEPS = {sigma: PUBLISHED[f"relaxation_sigma_{sigma:g}"].value for sigma in (1.0, 3.0)}
BEST = PUBLISHED["best_lambda"].value

SHOWS_TEMPERATURE = True
TITLE = "Temperature: relaxation, noise amplitude, and lambda (rho = 3, a = 25)."
PAPER_SHOWS = (
    "Not a figure of the paper: its Sec. III states these. (a) kT - 1 at dt 0.04 after a start at "
    f"kT = 10, mean over replicas: it relaxes exponentially within some {STEPS[3.0]:g} steps at "
    f"sigma 3 and some {STEPS[1.0]:g} at sigma 1 (dashed); solid thin lines: fitted exponentials "
    "from 10 to kT in equilibrium; the last tenth relaxes more slowly than they do. "
    "(b) kT - 1 at dt 0.04 against sigma: it rises slowly up to about 8 (dashed) and rapidly "
    "beyond. Cross: the run blew up. (c) kT - 1 at dt 0.06 against lambda; the text finds "
    f"{BEST:g} (dashed) to be the best. Line: parabola, whose zero is where kT is right."
)
HOT = 10.0
END_OF_SLOW = 8.0  # sigma, as the text has it
BEGIN_OF_SLOW = 3.0  # below, kT - 1 is hardly larger than its error
MIDDLE = 0.6  # lambda about which the parabola is written


def compute(sweeps):
    """Relaxation times in steps, kT against sigma and against lambda."""
    relaxation, noise = sweeps["relaxation"], sweeps["noise_amplitude"]
    factor = sweeps["prediction_factor"]
    dt = float(relaxation.time[1] - relaxation.time[0])
    steps = relaxation.time.values / dt
    series = relaxation.kT_series.transpose("sigma", "replica", "time")
    kT, kT_error = over_replicas(noise.kT.values, noise.kT_error.values, -1)
    sigma, amplitude = (runs.sigma.values.astype(float) for runs in (relaxation, noise))
    ends = np.interp(sigma, amplitude[np.isfinite(kT)], kT[np.isfinite(kT)])
    times = np.array([
        [decay(steps, kT, end) for kT in replicas] for replicas, end in zip(series.values, ends)
    ])  # fmt: skip
    relaxation_steps, error = independent_mean_and_error(times)
    at_lambda, lambda_error = over_replicas(factor.kT.values, factor.kT_error.values, -1)
    above_one = {"units": "kT", "long_name": "kT - 1"}
    standard_error = {"units": "kT", "long_name": "standard error"}
    return xr.Dataset(
        {
            "relaxation_steps": ("sigma", relaxation_steps, {"units": "steps"}),
            "relaxation_error": ("sigma", error, {"units": "steps"}),
            "relaxation_end": ("sigma", ends, {"units": "kT", "long_name": "kT in equilibrium"}),
            "kT_series": (("sigma", "step"), series.mean("replica").values, {"units": "kT"}),
            "excess": ("amplitude", kT - 1, above_one),
            "excess_error": ("amplitude", kT_error, standard_error),
            "at_lambda": ("lambda", at_lambda - 1, above_one),
            "at_lambda_error": ("lambda", lambda_error, standard_error),
        },
        {
            "sigma": sigma,
            "step": steps,
            "amplitude": amplitude,
            "lambda": factor["lambda"].values.astype(float),
        },
    )


def decay(steps, kT, end):
    """Relaxation time in steps of kT = end + (10 - end) exp(-steps / time)."""
    (time,), _ = curve_fit(
        lambda s, time: end + (HOT - end) * np.exp(-s / time), steps, kT, p0=(30.0,)
    )
    return time


def steepening(data, at):
    """How much steeper kT rises in the unit of sigma after ``at`` than from 3 to there.

    Returns ``ratio``, ``error``: NaN where a run is missing.
    """
    wanted = np.array([BEGIN_OF_SLOW, at, at + 1])
    if not np.isin(wanted, data.amplitude).all():
        return np.nan, np.nan
    first, middle, last = data.excess.sel(amplitude=wanted).values
    errors = data.excess_error.sel(amplitude=wanted).values
    before, after = (middle - first) / (at - BEGIN_OF_SLOW), last - middle
    # Derivatives of after / before by the three temperatures.
    by = np.array([1 / (at - BEGIN_OF_SLOW), 0, 0]) * after / before**2
    by += np.array([0, -1 - after / before / (at - BEGIN_OF_SLOW), 1]) / before
    return after / before, float(np.sqrt(np.sum((by * errors) ** 2)))


class Best(NamedTuple):
    """Where a parabola through kT - 1 is zero.

    ``coefficients`` are those of 1, x and x^2, x = lambda - `MIDDLE`.
    """

    value: float
    error: float
    coefficients: np.ndarray


def best_lambda(data):
    """lambda at which kT = 1.

    Result: all NaN with fewer than three runs that have an error.
    """
    known = data.dropna("lambda", subset=["at_lambda_error"])
    if known.sizes["lambda"] < 3:
        return Best(np.nan, np.nan, np.full(3, np.nan))
    x, y = known["lambda"].values - MIDDLE, known.at_lambda.values
    fit = linear_fit([x**power for power in range(3)], y, known.at_lambda_error.values)
    a, b, c = fit.values
    root = (-b - np.sqrt(max(0.0, b * b - 4 * a * c))) / (2 * c) if c else -a / b
    # The same parabola seen from where it is zero: there the error is that of its offset alone.
    there = linear_fit([(x - root) ** k for k in range(3)], y, known.at_lambda_error.values)
    error = abs(there.errors[0] / there.values[1])
    return Best(MIDDLE + root, error, fit.values)


def measured(data):
    """Relaxation times and the knee."""
    found = {}
    for sigma in data.sigma.values:
        at = data.sel(sigma=sigma)
        found[f"relaxation_sigma_{sigma:g}"] = Measured(
            float(at.relaxation_steps), float(at.relaxation_error),
            "exponential from kT 10 to kT in equilibrium, error from replicas",
        )  # fmt: skip
    found["relaxation_ratio"] = relaxation_ratio(data)
    ratio, error = steepening(data, END_OF_SLOW)
    sooner, _ = steepening(data, END_OF_SLOW - 1)
    found["noise_knee"] = Measured(
        ratio, error, f"{sooner:.1f} at sigma {END_OF_SLOW - 1:g}",
        "" if np.isfinite(ratio) else "no runs at sigma 3, 8 and 9 in this study",
    )  # fmt: skip
    best = best_lambda(data)
    each = ", ".join(
        f"{float(kT):+.4f} at {factor:g}"
        for factor, kT in zip(data["lambda"].values, data.at_lambda)
    )
    found["best_lambda"] = Measured(best.value, best.error, f"kT = 1 on a parabola; kT - 1: {each}")
    found["kT_excess_lambda_0.65_rho_3"] = Measured(
        *(float(data[name].sel({"lambda": BEST})) for name in ("at_lambda", "at_lambda_error"))
    )
    return found


def relaxation_ratio(data):
    """Relaxation time at sigma 1 over that at sigma 3."""
    slow, fast = (data.sel(sigma=sigma) for sigma in (1.0, 3.0))
    ratio = float(slow.relaxation_steps / fast.relaxation_steps)
    parts = [float(at.relaxation_error / at.relaxation_steps) for at in (slow, fast)]
    return Measured(ratio, ratio * float(np.hypot(*parts)), "of the fitted times")


def describe(data):
    """What is seen."""
    slow, fast = (float(data.relaxation_steps.sel(sigma=sigma)) for sigma in (1.0, 3.0))
    return (
        f"(a) kT - 1 falls in straight lines on a logarithmic axis, within {fast:.0f} steps at "
        f"sigma 3 and {slow:.0f} at sigma 1, until noise is left. (b) kT - 1 rises evenly with "
        "sigma, then steeply from 8 on. (c) kT - 1 falls nearly in a straight line with lambda "
        f"and crosses zero at {best_lambda(data).value:.3f}, right of the dashed line at {BEST:g}."
    )


def draw(data):
    """Relaxation on a logarithmic axis; kT - 1 against sigma and against lambda."""
    figure, (left, middle, right) = panels(3)
    for sigma, color in ((1.0, RED), (3.0, BLUE)):
        at, published = data.sel(sigma=sigma), STEPS[sigma]
        label = rf"$\sigma$ = {sigma:g}: {float(at.relaxation_steps):.1f} steps"
        left.plot(data.step, at.kT_series - 1, ".", color=color, markersize=1.5)
        end = float(at.relaxation_end)
        fitted = end + (HOT - end) * np.exp(-data.step / float(at.relaxation_steps))
        left.plot(data.step, fitted - 1, color=color, linewidth=0.7, label=label)
        decayed = (HOT - 1) * np.exp(-data.step / published)
        left.plot(data.step, decayed, color=color, linestyle="--", linewidth=0.9,
                  label=f"published: {published:g} steps")  # fmt: skip
    left.set(yscale="log", ylim=(0.01, 300), xlim=(0, 300), xlabel=r"steps of 0.04 $\tau_0$",
             ylabel=r"$k_BT - 1$")  # fmt: skip
    left.legend(loc="upper right")
    points(middle, data.amplitude, data.excess, data.excess_error, "this work")
    top = 1.25 * float(data.excess.max().fillna(1))
    lost = data.amplitude.values[~np.isfinite(data.excess.values)]
    if len(lost):
        middle.plot(lost, [0.95 * top] * len(lost), "X", color=RED, label="blew up")
    middle.axvline(END_OF_SLOW, color=BLACK, linestyle="--", linewidth=0.9,
                   label="published end of\nslow rise")  # fmt: skip
    middle.set(xlim=(0, 11), ylim=(0, top), xlabel=r"noise amplitude $\sigma$",
               ylabel=r"$k_BT - 1$")  # fmt: skip
    middle.legend(loc="upper left")
    points(right, data["lambda"], data.at_lambda, data.at_lambda_error)
    best = best_lambda(data)
    x = np.linspace(float(data["lambda"].min()), float(data["lambda"].max()), 50)
    label = rf"$k_BT = 1$ at {best.value:.3f} ± {COVERAGE * best.error:.3f}"
    parabola = np.polyval(best.coefficients[::-1], x - MIDDLE)
    right.plot(x, parabola, color=BLUE, linewidth=0.8, label=label)
    low, high = right.get_ylim()
    right.plot([BEST, BEST], [low, high], color=BLACK, linestyle="--", linewidth=0.9,
               label=f"published best, {BEST:g}")  # fmt: skip
    right.set_ylim(low, high + 0.35 * (high - low))  # room for the legend
    right.axhline(0, color=BLACK, linewidth=0.5)
    right.set(xlabel=r"$\lambda$", ylabel=r"$k_BT - 1$")
    right.legend(loc="upper right")
    return figure
