"""Figure 1: B2 of single beads, in closed form and by an older fit."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured
from dpd.report.style import BLUE, RED, panels

ALIKE = 50.0  # kT / r_c: below it, the text says, both give similar values
HARD = 2 * np.pi / 3  # of hard spheres, where the closed form ends

TITLE = "B2 of two beads over their repulsion, in closed form and by an older fit."
PAPER_SHOWS = (
    "The paper compares its closed form (line) with the polynomial that was fitted for the revised "
    "equation of state (dots). Both give similar values below a = 50 and diverge above; the closed "
    "form goes to 2 pi / 3, that of hard spheres. Both are calculated, and nothing is simulated."
)
ERRORS = "Nothing here has a statistical error."


def compute(sweeps):
    """Both coefficients, and their ratio."""
    virials = sweeps["bead_virials"]
    return xr.Dataset({
        "closed": virials.bead,
        "fitted": virials.bead_older,
        "ratio": (virials.bead_older / virials.bead).assign_attrs(units="1"),
    })  # fmt: skip


def measured(data):
    """How far apart both are below 50, on the scale of the figure's inset, and above."""
    small = data.repulsion < ALIKE
    below = (np.abs(data.fitted - data.closed) / data.closed.sel(repulsion=ALIKE)).where(small)
    relative = np.abs(data.ratio - 1)
    most = relative.where(small)
    return {
        "virials_alike": Measured(
            float(below.max()), 0.0,
            f"largest at a = {float(below.idxmax()):g}; relative to B2 there at most "
            f"{float(most.max()):.3f}, at a = {float(most.idxmax()):g}",
        ),
        "virials_diverge": Measured(
            float(relative[-1]), 0.0, f"at a = {float(data.repulsion[-1]):g}"
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "B2 over a: the closed form rises and bends towards that of hard spheres; the older fit "
        "follows it up to about 50 and then shoots up."
    )


def draw(data):
    """B2 over a; an inset of small repulsions."""
    figure, axes = panels(1)
    inset = axes.inset_axes((0.68, 0.5, 0.29, 0.42))
    for panel in (axes, inset):
        panel.plot(data.repulsion, data.closed, color=BLUE, label="closed form, Eq. 20")
        panel.plot(data.repulsion, data.fitted, "o", color=RED, label="older fit", markersize=3)
    axes.axhline(HARD, color="0.5", linestyle=":", linewidth=0.8)
    axes.annotate("hard spheres", (128, HARD), (0, -8), textcoords="offset points", ha="right",
                  fontsize=7, color="0.4")  # fmt: skip
    inset.set(xlim=(0, 52), ylim=(0, 1.4))
    axes.set(
        xlim=(0, 133), ylim=(0, 6), xlabel="$a$ / ($k_BT$ $r_c^{-1}$)", ylabel="$B_2$ / $r_c^3$"
    )
    axes.legend(loc="upper left")
    return figure
