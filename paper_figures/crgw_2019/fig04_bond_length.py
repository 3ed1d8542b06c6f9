"""Figure 4: chains of three beads that three equations make for one pressure, over bond length."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured
from dpd.report.style import panels, points, published_line
from paper_figures.crgw_2019.shared import LOOKS, TARGET, mean_of

APART = 1.0  # r_c: longer bonds leave no overlap of bonded beads

TITLE = "Pressure of chains of three beads at the repulsion that an equation gives for 41.89."
PAPER_SHOWS = (
    "Density of chains 1.67. Top: the simulated pressure; dashed: that which was asked for. "
    "Bottom: the repulsion. Only crGW changes it with bond length, and only its fluids have nearly "
    "the pressure that was asked for; beyond a bond length of 1 the paper finds that nothing "
    "changes any more."
)


def compute(sweeps):
    """Simulated pressures and repulsions."""
    runs, theory = sweeps["trimers"], sweeps["trimer_repulsions"]
    pressure, error = mean_of(runs, "pressure")
    bonds = runs.bond_mean.mean(("block", "replica")) / runs.bond
    return xr.Dataset({
        "pressure": pressure.assign_attrs(units="kT / r_c^3"),
        "pressure_error": error.assign_attrs(units="kT / r_c^3"),
        "repulsion": theory.repulsion.sel(equation=runs.equation, bond=runs.bond),
        "bond_ratio": bonds.assign_attrs(units="1"),
    })  # fmt: skip


def _off(data, equation):
    """Mean unsigned error of the pressure in percent, and its standard error."""
    at = data.sel(equation=equation)
    off = 100 * np.abs(at.pressure.values / TARGET - 1)
    return off.mean(), 100 * np.sqrt((at.pressure_error.values**2).sum()) / TARGET / len(off)


def measured(data):
    """How far from the target each equation ends, and what bonds beyond 1 change."""
    ours, error = _off(data, "crGW")
    worst = {name: _off(data, name)[0] for name in ("rGW", "GW")}
    found = {
        "target_crgw": Measured(
            ours, error, f"rGW misses it by {worst['rGW']:.1f} %, GW by {worst['GW']:.1f} %"
        ),
        "target_others": Measured(
            min(worst.values()) / ours, error * min(worst.values()) / ours**2
        ),
    }
    long = data.sel(equation="rGW").where(data.bond >= APART, drop=True)
    value, spread, note = np.nan, np.nan, ""
    if long.sizes["bond"] > 1:
        first, last = long.pressure.values[[0, -1]]
        value = last / first
        spread = value * np.hypot(*(long.pressure_error.values / long.pressure.values)[[0, -1]])
        note = f"bonds of {float(long.bond[-1]):g} over {float(long.bond[0]):g}, by rGW"
    found["saturation"] = Measured(float(value), float(spread), note)
    return found


def describe(data):
    """What is seen."""
    return (
        "Pressures of crGW lie near the dashed line at all bond lengths; those of rGW and GW begin "
        "far below it and rise. Below, the repulsion of crGW falls with bond length; the others "
        "are level."
    )


def draw(data):
    """Pressure above, repulsion below."""
    figure, (top, bottom) = panels(1, rows=2, height=2.1, sharex=True)
    published_line(top, [data.bond.min(), data.bond.max()], [TARGET] * 2, "asked for")
    for equation, look in LOOKS.items():
        at = data.sel(equation=equation)
        points(top, at.bond, at.pressure, at.pressure_error, look.label, look.color, look.marker,
               linestyle="-")  # fmt: skip
        bottom.plot(at.bond, at.repulsion, look.marker, linestyle="-", color=look.color)
    top.legend(loc="lower right", ncols=2)
    top.set(ylabel="$p$ / ($k_BT$ $r_c^{-3}$)")
    bottom.set(xlabel="bond length $l$ / $r_c$", ylabel="$a$ / ($k_BT$ $r_c^{-1}$)")
    return figure
