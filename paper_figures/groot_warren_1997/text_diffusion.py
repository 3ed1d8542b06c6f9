"""Sec. VII: self-diffusion, and what the periodic box takes from it."""

import numpy as np
import xarray as xr

from dpd.analysis.diffusion import diffusion_constant, displacements
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, panels, points

TITLE = "Self-diffusion at rho 3, a 25, gamma 6.75, over the edge of the box."
PAPER_SHOWS = (
    "Not a figure of the paper: its text gives D = 0.306 +- 0.006 (shaded) and no box. In a "
    "periodic box D falls by kT xi / (6 pi eta L), xi = 2.837, because a bead drags its images "
    "along, so the value for an infinite box is the intercept of a straight line in 1 / L."
)
ERRORS = (
    "Bars: 95 % intervals, the larger of two jackknife errors, leaving out molecules, and leaving"
    " out tenths of the run. Times up to a tenth of the run, so that tenths are independent."
)
AFTER = 5.0  # tau, beyond which displacements grow in proportion to time
PUBLISHED, PUBLISHED_ERROR = 0.306, 0.006


def compute(sweeps):
    """D in each box, and for an infinite one."""
    runs = sweeps["diffusion"]
    edges = runs.box.values.astype(float)
    found = []
    for edge in runs.box.values:
        at = displacements(runs.sel(box=edge), "centre")
        found.append(diffusion_constant(at, 3, min(AFTER, at.time[-1] / 4)))
    value, error = np.array(found).T
    use = np.isfinite(value) & (error > 0)
    line = np.array([np.nan, np.nan]), np.array([np.nan, np.nan])
    if use.sum() >= 2:
        line = linear_fit([np.ones_like(edges[use]), 1 / edges[use]], value[use], error[use])[:2]
    values, errors = line
    constant = {"units": "r_c^2 / tau"}
    return xr.Dataset(
        {
            "diffusion": ("box", value, constant | {"long_name": "self-diffusion constant"}),
            "diffusion_error": ("box", error, constant),
            "infinite": ((), values[0], constant | {"long_name": "in an infinite box"}),
            "infinite_error": ((), errors[0], constant),
            "slope": ((), values[1], {"units": "r_c^3 / tau"}),
        },
        {"box": runs.box},
    )


def measured(data):
    """D for an infinite box."""
    each = ", ".join(f"{float(d):.4f} at L {b:g}" for b, d in zip(data.box.values, data.diffusion))
    note = f"extrapolated in 1 / L; {each}"
    return {"diffusion": Measured(float(data.infinite), float(data.infinite_error), note)}


def draw(data):
    """D over one over the edge."""
    figure, axes = panels(1)
    points(axes, 1 / data.box, data.diffusion, data.diffusion_error, "this work", BLUE)
    value, error = float(data.infinite), float(data.infinite_error)
    label = f"infinite box: {value:.3f} ± {COVERAGE * error:.3f}"
    points(axes, [0], [value], [error], label, BLACK, "s", clip_on=False)
    x = np.array([0, 1.1 / float(data.box.min())])
    axes.plot(x, float(data.infinite) + float(data.slope) * x, color=BLUE, linewidth=0.8)
    low, high = PUBLISHED - PUBLISHED_ERROR, PUBLISHED + PUBLISHED_ERROR
    axes.axhspan(low, high, color=BLACK, alpha=0.15, linewidth=0, label="published 0.306 ± 0.006")
    axes.set(
        xlim=(0, x[1]),
        xlabel="1 / L / $r_c^{-1}$",
        ylabel=r"diffusion constant D / ($r_c^2$ $\tau^{-1}$)",
    )
    axes.legend(loc="lower left")
    return figure
