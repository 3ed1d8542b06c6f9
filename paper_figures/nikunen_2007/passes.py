"""Bonds that pass through each other, against the criterion that should forbid it."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured
from dpd.report.style import BLUE, ORANGE, panels, points

TITLE = "Bonds passed through per bond and tau, against the margin of the criterion."
PAPER_SHOWS = (
    "Not a figure of the paper, which holds that bonds cannot cross if sqrt(2) r_min > l_max. "
    "Pairs of bonds that go through each other are counted directly, from looks every 2 and every"
    " 4 steps between which beads are taken to move in straight lines. The margin is taken from "
    "the longest chains of Figure 3's runs. Dashed: margin 0; sets to its right meet the "
    "criterion."
)
ERRORS = (
    "Bars: 95 % intervals, from the square root of the count. Triangles: none seen, 95 % limit."
)
AT_LEAST = 3.0  # counts that exclude none at 95 %


def compute(sweeps):
    """Counts for each set and interval, and the margin of each set."""
    from dpd.analysis.structure import radial_distribution, rise

    runs, statics = sweeps["passes"], sweeps["statics"]
    statics = statics.sel(length=statics.length.max())
    shape = (runs.sizes["set"], runs.sizes["interval"])
    count, exposure = np.zeros(shape), np.zeros(shape)
    margin = []
    for k, name in enumerate(runs.set.values):
        at = statics.sel(set=name)
        r_min = rise(statics.r.values, radial_distribution(at)[0])
        density = at.bond_density.mean(("replica", "block")).values
        margin.append(np.sqrt(2) * r_min - statics.bond_length.values[density >= 0.05].max())
        for m in range(shape[1]):
            one = runs.isel(set=k, interval=m)
            count[k, m] = float(one.passes.sum())
            beads = float(one.beads.sum())
            exposure[k, m] = beads * float(one.pass_time.max())
    return xr.Dataset(
        {
            "count": (("set", "interval"), count, {"units": "1"}),
            "exposure": (("set", "interval"), exposure, {"units": "tau"}),
            "margin": ("set", margin, {"units": "r_c"}),
        },
        {"set": runs.set, "interval": runs.interval},
    )


def measured(data):
    """What the criterion says of each set, and what is counted."""
    found = {}
    for name in ("a25", "a50", "a100", "a150", "a200"):
        if name not in data.set.values:
            found[f"passes_{name}"] = Measured(np.nan, np.nan)
            continue
        at = data.sel(set=name).isel(interval=0)
        count, exposure = float(at["count"]), float(at.exposure)
        note = (
            f"{count:.0f} passes in {exposure:.3g} beads times tau; margin {float(at.margin):.3f}"
        )
        found[f"passes_{name}"] = Measured(
            count / exposure, np.sqrt(max(count, 1)) / exposure, note
        )
    return found


def draw(data):
    """Rates over the margin."""
    figure, axes = panels(1)
    for k, color in zip(range(data.sizes["interval"]), (BLUE, ORANGE)):
        at = data.isel(interval=k)
        seen = at["count"] > 0
        rate, error = at["count"] / at.exposure, np.sqrt(at["count"]) / at.exposure
        label = f"looks every {at.interval.item()} steps"
        points(axes, at.margin[seen], rate[seen], error[seen], label, color)
        axes.plot(at.margin[~seen], AT_LEAST / at.exposure[~seen], "v", color=color,
                  markerfacecolor="white")  # fmt: skip
    for name in data.set.values:
        at = data.sel(set=name).isel(interval=0)
        height = float(np.maximum(at["count"], AT_LEAST) / at.exposure)
        axes.annotate(f"a = {str(name)[1:]}", (float(at.margin), height), (3, 4),
                      textcoords="offset points", fontsize=6.5)  # fmt: skip
    axes.axvline(0, color="0.5", linestyle="--", linewidth=0.8)
    axes.set(yscale="log", xlabel=r"margin $\sqrt{2} r_{min} - l_{max}$ / $r_c$",
             ylabel=r"passes per bead and $\tau$")  # fmt: skip
    axes.legend()
    return figure
