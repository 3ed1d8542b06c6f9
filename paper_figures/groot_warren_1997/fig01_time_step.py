"""Figure 1: kinetic temperature against time step, four schemes and two noises."""

import numpy as np
import xarray as xr
from scipy.special import chdtrc, ndtri

from dpd.analysis.statistics import COVERAGE, linear_fit, over_replicas
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels, points

TITLE = "Temperature against time step (rho 4, a 25, sigma 3)."
PAPER_SHOWS = (
    "The paper shows the kinetic temperature of 4000 beads over 200 steps for the Euler scheme, "
    "Verlet without the acceleration term, and Verlet with lambda 0.5 and 0.65, and states 2 % "
    "at dt 0.04 and 3 % at 0.05 for lambda 0.5. Left: the paper's layout. Right: the same on "
    "logarithmic axes, where the order of each scheme shows as a slope. Filled: uniform noise; "
    "open: Gaussian noise."
)

STYLES = {
    "euler": ("Euler, Eq. 7", RED, "D"),
    "verlet-no-acceleration": (r"Verlet without $\Delta t^2 f/2$", ORANGE, "^"),
    "gw-vv-0.5": (r"Verlet, $\lambda$ = 0.5", BLUE, "o"),
    "gw-vv-0.65": (r"Verlet, $\lambda$ = 0.65", GREEN, "s"),
}


def compute(sweeps):
    """kT - 1 with standard errors, and the uniform against Gaussian test."""
    parts = []
    for sweep in sweeps.values():
        kT, error = over_replicas(sweep.kT.values, sweep.kT_error.values, -1)
        dims = sweep.kT.dims[:-1]
        coords = {name: sweep[name] for name in dims}
        parts.append(xr.Dataset({"excess": (dims, kT - 1), "error": (dims, error)}, coords))
    data = xr.concat(parts, "scheme", join="outer")
    data.excess.attrs = {"units": "kT", "long_name": "kinetic temperature minus 1"}
    data.error.attrs = {"units": "kT", "long_name": "standard error"}
    gap = (data.excess.sel(noise="uniform") - data.excess.sel(noise="gaussian")).values
    spread = np.hypot(*(data.error.sel(noise=n).values for n in ("uniform", "gaussian")))
    pulls = (gap / spread)[np.isfinite(gap / spread)]  # of pairs of which both have an error
    data["noise_chi_square"] = ((), float(np.sum(pulls**2)), {"units": "1"})
    data["noise_points"] = ((), len(pulls), {"units": "1"})
    data["noise_p_value"] = ((), float(chdtrc(len(pulls), np.sum(pulls**2))), {"units": "1"})
    return data


def both_noises(data, scheme, dt):
    """Mean of the two noises' kT - 1, and its standard error; NaN where no run was made."""
    if scheme not in data.scheme or dt not in data.dt:
        return np.nan, np.nan
    at = data.sel(scheme=scheme, dt=dt)
    return float(at.excess.mean()), float(np.sqrt((at.error**2).sum()) / 2)


def euler_step(data, target):
    """Time step at which Euler's kT - 1 is ``target``: c dt + d dt^2 through dt <= 0.01.

    NaN if no run there is long enough for an error.
    """
    small = data.sel(scheme="euler").where(data.dt <= 0.01, drop=True).dropna("dt")
    excess = small.excess.mean("noise").values
    error = np.sqrt((small.error**2).sum("noise").values) / 2
    dt = small.dt.values
    if not len(dt):
        return np.nan, np.nan
    terms = np.stack([dt, dt**2])[: min(2, len(dt))]
    fit = linear_fit(terms, excess, error)
    c, d = np.pad(fit.values, (0, 2 - len(fit.values)))
    step = target / c if d == 0 else (-c + np.sqrt(c * c + 4 * d * target)) / (2 * d)
    return float(step), float(step * fit.errors[0] / c)


def measured(data):
    """Numbers of Sec. III."""
    at_004, error_004 = both_noises(data, "gw-vv-0.5", 0.04)
    at_005, error_005 = both_noises(data, "gw-vv-0.5", 0.05)
    at_006, error_006 = both_noises(data, "gw-vv-0.65", 0.06)
    step, step_error = euler_step(data, 0.02)
    p = float(data.noise_p_value)
    z = -float(ndtri(max(p, 1e-300)))
    return {
        "kT_excess_dt_0.04": Measured(at_004, error_004, "mean of both noises"),
        "kT_excess_dt_0.05": Measured(at_005, error_005, "mean of both noises"),
        "kT_excess_lambda_0.65": Measured(at_006, error_006, "measured at rho 4, both noises"),
        "euler_time_step": Measured(step, step_error, "where kT - 1 = 0.02, fitted for dt <= 0.01"),
        "noise_difference": Measured(
            z, 1.0,
            f"chi-square {float(data.noise_chi_square):.1f} over {int(data.noise_points)} points, "
            f"p = {p:.2g}; value is p as a normal deviate",
        ),
    }  # fmt: skip


def draw(data):
    """kT on a linear axis as published, and |kT - 1| on logarithmic axes."""
    figure, (left, right) = panels(2, height=3)
    for scheme, (label, color, marker) in STYLES.items():
        for noise in ("uniform", "gaussian"):
            at = data.sel(scheme=scheme, noise=noise).dropna("dt", subset=["excess"])
            style = dict(color=color, marker=marker, filled=noise == "uniform")
            if noise == "uniform":
                style |= dict(label=label, linestyle="-")
            points(left, at.dt, 1 + at.excess, at.error, **style)
            # A logarithm has no place for zero: points within their error are left out.
            clear = np.abs(at.excess) > COVERAGE * at.error
            clear_at = at.where(clear, drop=True)
            points(right, clear_at.dt, abs(clear_at.excess), clear_at.error, **style)
    for dt, percent in ((0.04, 2), (0.05, 3)):
        left.plot(dt, 1 + percent / 100, "*", color=BLACK, markersize=8, zorder=5,
                  label="published, $\\lambda$ = 0.5" if dt == 0.04 else None)  # fmt: skip
        right.plot(dt, percent / 100, "*", color=BLACK, markersize=8, zorder=5)
    left.axhline(1, color=BLACK, linewidth=0.5)
    left.set(xscale="log", ylim=(0.98, 1.3), xlabel=r"time step $\Delta t$ / $\tau$",
             ylabel=r"kinetic temperature $k_BT$")  # fmt: skip
    right.set(xscale="log", yscale="log", xlabel=r"time step $\Delta t$ / $\tau$",
              ylabel=r"$|k_BT - 1|$, points clear of zero")  # fmt: skip
    for axes in (left, right):
        axes.set_xticks([0.001, 0.01, 0.1], ["0.001", "0.01", "0.1"])
        axes.set_xticks([], minor=True)
        axes.set_xlim(0.0008, 0.13)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure
