"""Figure 1: kinetic temperature against time step, five schemes and two noises."""

import numpy as np
import xarray as xr
from scipy.special import chdtrc

from dpd.analysis.statistics import COVERAGE, linear_fit, over_replicas, student
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, Look, panels, points
from dpd.report.text import with_error

PUBLISHED = shown_by(__file__)
STATED = {0.04: PUBLISHED["kT_excess_dt_0.04"].value, 0.05: PUBLISHED["kT_excess_dt_0.05"].value}
HEATED = STATED[0.04]  # kT - 1 at which time steps of schemes are compared

TITLE = "Temperature against time step (rho = 4, a = 25, sigma = 3)."
PAPER_SHOWS = (
    "The paper shows the kinetic temperature of 4000 beads, averaged over 200 steps, for the Euler"
    " scheme, Verlet without the acceleration term, and Verlet with lambda 0.5 and 0.65, and "
    f"states kT - 1 = {STATED[0.04]:g} at dt 0.04 and {STATED[0.05]:g} at dt 0.05 for lambda 0.5 "
    "(stars; their bars are the scatter of means over 200 steps from run to run, measured here). "
    "Of Euler with the acceleration term the text alone speaks. "
    "(a) The paper's layout. (b) How far kT is from 1, above or below, on logarithmic axes, where "
    "the order of a scheme is a slope. Where kT - 1 is not clear of zero, an arrow points down from"
    " its upper bound (95 %). Filled: uniform noise; open: Gaussian noise. tau_0 is the unit of "
    "time of DPD."
)
ERRORS = "Bars: 95 % intervals from blocking; in (a) most are shorter than the marks."

STEPS_AVERAGED, BEADS = 200, 4000  # of the paper's points

STYLES = {
    "euler": Look("Euler, Eq. 7", RED, "D"),
    "euler-acceleration": Look(r"Euler with $\Delta t^2 f/2$", PURPLE, "v"),
    "verlet-no-acceleration": Look(r"Verlet without $\Delta t^2 f/2$", ORANGE, "^"),
    "gw-vv-0.5": Look(r"Verlet, $\lambda$ = 0.5", BLUE, "o"),
    "gw-vv-0.65": Look(r"Verlet, $\lambda$ = 0.65", GREEN, "s"),
}


def compute(sweeps):
    """kT - 1 with standard errors, and the uniform against Gaussian test."""
    parts = []
    for sweep in (sweeps["time_step_verlet"], sweeps["time_step_euler"]):
        kT, error = over_replicas(sweep.kT.values, sweep.kT_error.values, -1)
        dims = sweep.kT.dims[:-1]
        coords = {name: sweep[name] for name in dims}
        degrees = sweep.kT_degrees.sum(sweep.kT.dims[-1]).values
        found = {"excess": kT - 1, "error": error, "degrees": degrees}
        parts.append(xr.Dataset({name: (dims, each) for name, each in found.items()}, coords))
    data = xr.concat(parts, "scheme", join="outer")
    data.excess.attrs = {"units": "kT", "long_name": "kinetic temperature minus 1"}
    data.error.attrs = {"units": "kT", "long_name": "standard error"}
    data.degrees.attrs = {"units": "1", "long_name": "degrees of freedom of that"}
    value, error, pieces = scatter(sweeps["short_averages"])
    data["scatter"] = ((), value, {"units": "kT", "long_name": "of means over 200 steps"})
    data["scatter_error"] = ((), error, {"units": "kT", "long_name": "standard error"})
    data["scatter_pieces"] = ((), pieces, {"units": "1", "long_name": "means that it is from"})
    return data


def scatter(runs):
    """Standard deviation of kT averaged over 200 steps of 4000 beads, as the paper's points are.

    Runs are cut into pieces of 200 steps, which are 13 correlation times or more. In a smaller
    box the scatter is larger, as one over the root of the number of beads.

    Returns ``value``, ``error``: both time steps together. ``pieces``.
    """
    interval = float(runs.time[1] - runs.time[0])
    squares = []
    for dt in runs.dt.values:
        at = runs.sel(dt=dt)
        length = round(STEPS_AVERAGED * float(dt) / interval)
        for series in at.kT_series.values:
            count = len(series) // length
            means = series[: count * length].reshape(count, length).mean(axis=1)
            beads = float(at.beads.values.ravel()[0])
            squares.append((count - 1, means.var(ddof=1) * beads / BEADS))
    degrees = sum(free for free, _ in squares)
    value = np.sqrt(sum(free * square for free, square in squares) / degrees)
    return value, value / np.sqrt(2 * degrees), degrees + len(squares)


def both_noises(data, scheme, dt):
    """Mean of the two noises' kT - 1, and its standard error; NaN where no run was made."""
    if scheme not in data.scheme or dt not in data.dt:
        return np.nan, np.nan
    at = data.sel(scheme=scheme, dt=dt)
    return float(at.excess.mean()), float(np.sqrt((at.error**2).sum()) / 2)


def between_noises(data):
    """Mean square of the relative difference of kT with uniform and with Gaussian noise.

    Over all schemes and steps of which both runs have an error, less what our errors add to it,
    which is their variance without Student's t. The text compares points that scatter as means over
    200 steps do, so it says nothing of differences far below that.
    """
    kT, error = 1 + data.excess, data.error / (1 + data.excess)
    gap = (kT.sel(noise="uniform") / kT.sel(noise="gaussian") - 1).values
    spread, sigma = (
        np.hypot(*(each.sel(noise=n).values for n in ("uniform", "gaussian")))
        for each in (error, error / student(data.degrees))
    )
    known = np.isfinite(gap / spread)
    gap, spread, sigma = gap[known], spread[known], sigma[known]
    if not len(gap):
        return Measured(np.nan, np.nan)
    value = float(np.mean(gap**2 - sigma**2))
    real = np.maximum(gap**2 - sigma**2, 0)
    error = float(np.sqrt(np.sum(4 * real * sigma**2 + 2 * sigma**4))) / len(gap)
    chance = float(chdtrc(len(gap), np.sum((gap / spread) ** 2)))
    largest = np.argmax(np.abs(gap))
    return Measured(
        value, error,
        f"{len(gap)} points; the largest is {100 * gap[largest]:+.2f} %, in our own errors "
        f"{gap[largest] / spread[largest]:+.1f}; p = {chance:.2g} that our errors make them all",
    )  # fmt: skip


def step_at(data, scheme, target, largest):
    """Time step at which kT - 1 is ``target``: c dt + d dt^2 through the dt up to ``largest``.

    Returns ``step``, ``error``: NaN if no run there is long enough for an error, or there is none.
    """
    if scheme not in data.scheme:
        return np.nan, np.nan
    small = data.sel(scheme=scheme).isel(dt=data.dt.values <= largest).dropna("dt")
    dt = small.dt.values
    if not len(dt):
        return np.nan, np.nan
    excess, error = small.excess.mean("noise").values, np.sqrt((small.error**2).sum("noise")) / 2
    fit = linear_fit(np.stack([dt, dt**2])[: min(2, len(dt))], excess, error.values)
    c, d = np.pad(fit.values, (0, 2 - len(fit.values)))
    step = target / c if d == 0 else (-c + np.sqrt(c * c + 4 * d * target)) / (2 * d)
    near = np.argmin(np.abs(dt - step))  # the fit is as good there as the nearest point, or better
    return float(step), float(error.values[near] / (c + 2 * d * step))


def measured(data):
    """Numbers of Sec. III."""
    at_004, error_004 = both_noises(data, "gw-vv-0.5", 0.04)
    at_005, error_005 = both_noises(data, "gw-vv-0.5", 0.05)
    at_006, error_006 = both_noises(data, "gw-vv-0.65", 0.06)
    euler, euler_error = step_at(data, "euler", HEATED, 0.01)
    verlet, verlet_error = step_at(data, "gw-vv-0.5", HEATED, 0.05)
    ratio = verlet / euler
    ratio_error = ratio * float(np.hypot(euler_error / euler, verlet_error / verlet))
    without, without_error = step_at(data, "verlet-no-acceleration", HEATED, 0.01)
    nearly = without / euler
    nearly_error = nearly * float(np.hypot(without_error / without, euler_error / euler))
    scattered = (
        f"{int(data.scatter_pieces)} means over {STEPS_AVERAGED} steps scatter by "
        f"{with_error(float(data.scatter), float(data.scatter_error))}"
    )
    with_it, with_it_error = step_at(data, "euler-acceleration", HEATED, 0.01)
    alike = with_it / without
    alike_error = alike * float(np.hypot(with_it_error / with_it, without_error / without))
    return {
        "kT_excess_dt_0.04": Measured(at_004, error_004, f"mean of both noises; {scattered}"),
        "kT_excess_dt_0.05": Measured(at_005, error_005, "mean of both noises"),
        "kT_excess_lambda_0.65": Measured(at_006, error_006, "measured at rho 4, both noises"),
        "euler_time_step": Measured(euler, euler_error, "kT - 1 = c dt + d dt^2 for dt <= 0.01"),
        "step_ratio": Measured(
            ratio, ratio_error, f"dt {verlet:.4f} of Verlet, lambda 0.5, and {euler:.5f} of Euler",
        ),
        "without_acceleration": Measured(
            nearly, nearly_error,
            f"dt {without:.5f}; with the term it is {ratio:.0f} times that of Euler",
        ),
        "euler_with_acceleration": Measured(
            alike, alike_error, f"dt {with_it:.5f} of Euler with it, {without:.5f} of Verlet",
        ),
        "noise_difference": between_noises(data),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    verlet, _ = both_noises(data, "gw-vv-0.5", 0.04)
    euler, _ = both_noises(data, "euler", 0.01)
    return (
        "Kinetic temperature against time step on a logarithmic axis. Euler rises first, to "
        f"{1 + euler:.2f} at dt 0.01, Verlet without the acceleration term soon after it; Verlet "
        f"with lambda 0.5 stays flat and is at {1 + verlet:.3f} at dt 0.04, with lambda 0.65 flat "
        "for longer. Open and filled symbols, Gaussian and uniform noise, cover each other."
    )


def draw(data):
    """kT on a linear axis as published, and |kT - 1| on logarithmic axes."""
    figure, (left, right) = panels(2, height=3)
    looks = {scheme: look for scheme, look in STYLES.items() if scheme in data.scheme}
    for scheme, (label, color, marker) in looks.items():
        for noise in ("uniform", "gaussian"):
            at = data.sel(scheme=scheme, noise=noise).dropna("dt", subset=["excess"])
            style = dict(color=color, marker=marker, filled=noise == "uniform")
            if noise == "uniform":
                style |= dict(label=label, linestyle="-")
            points(left, at.dt, 1 + at.excess, at.error, **style)
            bound = abs(at.excess) + COVERAGE * at.error
            clear = ~(abs(at.excess) <= COVERAGE * at.error)  # also without an error
            clear_at = at.where(clear, drop=True)
            points(right, clear_at.dt, abs(clear_at.excess), clear_at.error, **style)
            high = bound.where(~clear, drop=True)
            right.errorbar(high.dt, high, 0.35 * high, uplims=True, color=color, linestyle="none",
                           elinewidth=0.7, capsize=1.5)  # fmt: skip
    steps, stated = list(STATED), np.array(list(STATED.values()))
    scattered = np.full(len(steps), float(data.scatter))
    style = dict(color=BLACK, marker="*", markersize=7, zorder=5)
    points(left, steps, 1 + stated, scattered, r"published, $\lambda$ = 0.5", **style)
    points(right, steps, stated, scattered, **style)
    left.axhline(1, color=BLACK, linewidth=0.5)
    left.set(xscale="log", ylim=(0.98, 1.3), xlabel=r"time step $\Delta t$ / $\tau_0$",
             ylabel=r"kinetic temperature $k_BT$")  # fmt: skip
    right.set(xscale="log", yscale="log", xlabel=r"time step $\Delta t$ / $\tau_0$",
              ylabel=r"$|k_BT - 1|$")  # fmt: skip
    for axes in (left, right):
        axes.set_xticks([0.001, 0.01, 0.1], ["0.001", "0.01", "0.1"])
        axes.set_xticks([], minor=True)
        axes.set_xlim(0.0008, 0.13)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure
