"""Sec. VII: self-diffusion, and what the periodic box and the time step do to it."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import diffusion_constant, displacements
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, RED, panels, points
from paper_figures.groot_warren_1997.dynamics import AFTER

PUBLISHED = shown_by(__file__)["diffusion"]
LOW, HIGH = PUBLISHED.value - PUBLISHED.error, PUBLISHED.value + PUBLISHED.error

TITLE = "Self-diffusion over the edge of the box (rho = 3, a = 25, gamma = 6.75)."
PAPER_SHOWS = (
    f"Not a figure of the paper: its text gives D = {PUBLISHED} (shaded) and no box. In a "
    "periodic box D falls in proportion to 1 / L, because a bead drags its images along, so the "
    "value for an infinite box is the intercept of a straight line in 1 / L. At the paper's "
    "dt 0.04 kT is too high, and D with it; at the smaller dt it is nearly right. Open: the "
    "intercept. tau_0 is the unit of time of DPD."
)
ERRORS = (
    "Bars: 95 % intervals, the larger of two jackknife errors, leaving out molecules, and leaving"
    " out tenths of the run. Times up to a tenth of the run, so that tenths are independent. In the"
    " legend, ± of this work is a 95 % interval, too; that of the published value is as printed."
)
SWEEPS = {"diffusion": (BLUE, "o"), "diffusion_small_step": (RED, "s")}


def compute(sweeps):
    """D in each box, and for an infinite one, at both time steps."""
    return xr.concat([of_sweep(sweeps[name]) for name in SWEEPS], "sweep", join="outer")


def of_sweep(runs):
    """D over the edge of the box, the straight line in 1 / L, and the mean kT."""
    edges = runs.box.values.astype(float)
    found, ends = [], []
    for edge in runs.box.values:
        at = displacements(runs.sel(box=edge), "centre")
        ends.append(at.time[-1])
        found.append(diffusion_constant(at, 3, min(AFTER, at.time[-1] / 4)))
    value, error = np.array(found).T
    use = np.isfinite(value) & (error > 0)
    values, errors, quality = np.full(2, np.nan), np.full(2, np.nan), np.nan
    if use.sum() >= 2:
        terms = [np.ones_like(edges[use]), 1 / edges[use]]
        values, errors, quality, _ = linear_fit(terms, value[use], error[use])
    kT = np.average(runs.kT.values.mean(axis=1), weights=runs.beads.values[:, 0])
    constant = {"units": "r_c^2 / tau"}
    return xr.Dataset(
        {
            "diffusion": ("box", value, constant | {"long_name": "self-diffusion constant"}),
            "diffusion_error": ("box", error, constant | {"long_name": "standard error"}),
            "infinite": ((), values[0], constant | {"long_name": "in an infinite box"}),
            "infinite_error": ((), errors[0], constant | {"long_name": "standard error"}),
            "slope": ((), values[1], {"units": "r_c^3 / tau", "long_name": "over 1 / L"}),
            "slope_error": ((), errors[1], {"units": "r_c^3 / tau", "long_name": "standard error"}),
            "reduced_chi_square": ((), quality, {"units": "1"}),
            "longest": ((), min(ends), {"units": "tau", "long_name": "longest time apart"}),
            "dt": ((), first_scene(runs).dt, {"units": "tau"}),
            "kT": ((), kT, {"units": "kT", "long_name": "mean over boxes"}),
        },
        {"box": edges},
    )


def measured(data):
    """D for an infinite box at the paper's time step, and how it is where kT is right."""
    paper, small = (data.isel(sweep=n) for n in range(2))
    change, error = heating(data)
    scaled = float(paper.infinite) / (1 + change)
    scaled_error = scaled * float(
        np.hypot(paper.infinite_error / paper.infinite, error / (1 + change))
    )
    longest = float(data.longest.min())
    short = ""
    if longest < 2 * AFTER:
        short = f"displacements end at {longest:g}, before they grow in proportion to time"
    return {
        "diffusion": Measured(
            float(paper.infinite), float(paper.infinite_error), in_words(paper), short
        ),
        "diffusion_small_step": Measured(
            scaled, scaled_error, f"that at dt {float(paper.dt):g}, less what heat adds", short,
        ),
        "diffusion_heat": Measured(
            change, error,
            f"in boxes simulated at both; kT {float(paper.kT):.4f} at dt {float(paper.dt):g}, "
            f"{float(small.kT):.4f} at dt {float(small.dt):g}", short,
        ),
    }  # fmt: skip


def heating(data):
    """Relative change of D from the smaller time step to the paper's, and its error.

    In the same box, mean over boxes: straight lines to an infinite box would cost most of the
    precision.
    """
    both = data.dropna("box", subset=["diffusion", "diffusion_error"])
    if not both.sizes["box"]:
        return np.nan, np.nan
    value, error = both.diffusion.values, both.diffusion_error.values
    ratio = value[0] / value[1]
    fit = linear_fit([np.ones_like(ratio)], ratio, ratio * np.hypot(*(error / value)))
    return float(fit.values[0]) - 1, float(fit.errors[0])


def in_words(at):
    """How D of an infinite box was found."""
    at = at.dropna("box", subset=["diffusion"])
    each = ", ".join(f"{float(d):.4f} at L {b:g}" for b, d in zip(at.box.values, at.diffusion))
    quality = float(at.reduced_chi_square)
    fit = f", reduced chi-square {quality:.2f}" if np.isfinite(quality) else ""
    return f"dt {float(at.dt):g}; straight line in 1 / L{fit}; {each}"


def describe(data):
    """What is seen."""
    change, _ = heating(data)
    infinite = float(data.infinite[0])
    beside = "below" if infinite < LOW else "above" if infinite > HIGH else "inside"
    return (
        "The diffusion constant falls in a straight line with one over the edge of the box, from "
        f"{infinite:.3f} in an infinite box at dt {float(data.dt[0]):g}, {beside} the published "
        f"band of {LOW:.3f} to {HIGH:.3f}; at dt {float(data.dt[1]):g} it is "
        f"{100 * change / (1 + change):.0f} % lower."
    )


def draw(data):
    """D over one over the edge."""
    figure, axes = panels(1, height=2.9)
    end = 1.1 / float(data.box.min())
    for n, (color, marker) in enumerate(SWEEPS.values()):
        at = data.isel(sweep=n)
        label = rf"$\Delta t$ = {float(at.dt):g}, $k_BT$ = {float(at.kT):.3f}"
        points(axes, 1 / at.box, at.diffusion, at.diffusion_error, label, color, marker)
        x = np.array([0, end])
        line = float(data.infinite[0]) + float(data.slope[0]) * x
        if n == 0:
            value, error = float(at.infinite), float(at.infinite_error)
            label = rf"$L \to \infty$: {value:.3f} ± {COVERAGE * error:.3f}"
            points(axes, [0], [value], [error], label, color, marker, filled=False)
            axes.plot(x, line, color=color, linewidth=0.8)
        else:
            axes.plot(x, line / (1 + heating(data)[0]), color=color, linewidth=0.8, linestyle=":",
                      label="the same line, scaled")  # fmt: skip
    axes.axhspan(LOW, HIGH, color=BLACK, alpha=0.15, linewidth=0, label=f"published {PUBLISHED}")
    lowest = min(LOW, float((data.diffusion - COVERAGE * data.diffusion_error).min()))
    axes.set(
        xlim=(-0.04 * end, end),
        ylim=(lowest - 0.035, None),  # room for the legend
        xlabel="inverse edge of the box $r_c / L$",
        ylabel=r"diffusion constant $D$ / ($r_c^2$ $\tau_0^{-1}$)",
    )
    axes.legend(loc="lower left")
    return figure
