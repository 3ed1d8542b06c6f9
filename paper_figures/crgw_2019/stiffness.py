"""That neither the stiffness of bonds nor the time step shows in the pressure of oligomers."""

from itertools import cycle

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured
from dpd.report.style import BLUE, RED, panels, points
from paper_figures.crgw_2019.shared import mean_of

LOOKS = ((BLUE, "o"), (RED, "s"))
CHOSEN = {"stiffness": 1000, "dt": 0.008}  # of Figures 2 to 4

TITLE = "Pressure of tetramers over the stiffness of their bonds, and their mean bond length."
PAPER_SHOWS = (
    "The paper says that bonds stiffer than 100 do not affect the pressure. Density 5 of beads, "
    "repulsion 25, mean bond length 0.4: the rest length is such that a bond of a tetramer has "
    "this mean, whatever its stiffness."
)


def compute(sweeps):
    """Pressures and mean lengths."""
    runs = sweeps["stiffness"]
    pressure, error = mean_of(runs, "pressure")
    units = {"units": "kT / r_c^3"}
    return xr.Dataset({
        "pressure": pressure.assign_attrs(units),
        "pressure_error": error.assign_attrs(units),
        "length": runs.bond_mean.mean(("block", "replica")).assign_attrs(units="r_c"),
        "kT": runs.kT.mean("replica").assign_attrs(units="kT"),
    })  # fmt: skip


def measured(data):
    """The step of time, the mean length, and what softer bonds change."""
    finest = data.isel(dt=0).sel(stiffness=CHOSEN["stiffness"])
    chosen = data.sel(CHOSEN)
    ratio = float(chosen.pressure / finest.pressure)
    soft = data.sel(stiffness=100, dt=CHOSEN["dt"])
    change = float(soft.pressure / chosen.pressure)
    relative = [float(at.pressure_error / at.pressure) for at in (chosen, finest, soft)]
    alone = data.sizes["dt"] == 1
    return {
        "small_step": Measured(
            ratio, ratio * np.hypot(relative[0], relative[1]),
            f"kT {float(chosen.kT):.4f} at dt {CHOSEN['dt']:g}",
            "a single time step in this study" if alone else "",
        ),
        "mean_length": Measured(float(chosen.length) / 0.4, 0.0),
        "soft_bonds": Measured(
            change, change * np.hypot(relative[0], relative[2]),
            f"mean length {float(soft.length):.4f}",
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "Left, pressures that agree within a percent or two over the stiffness; right, mean "
        "lengths that are near 0.4, the nearer the stiffer the bonds are."
    )


def draw(data):
    """Pressure and length over stiffness."""
    figure, (left, right) = panels(2, height=2.3)
    for (color, marker), dt in zip(cycle(LOOKS), data.dt.values):
        at, label = data.sel(dt=dt), rf"$\Delta t$ = {dt:g}"
        points(left, at.stiffness, at.pressure, at.pressure_error, label, color, marker)
        right.plot(at.stiffness, at.length, marker, color=color, label=label)
    right.axhline(0.4, color="0.5", linewidth=0.6)
    for panel, label in ((left, "$p$ / ($k_BT$ $r_c^{-3}$)"), (right, "mean bond / $r_c$")):
        panel.set(xscale="log", xlabel="stiffness / ($k_BT$ $r_c^{-2}$)", ylabel=label)
    left.legend(loc="best")
    return figure
