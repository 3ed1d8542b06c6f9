"""Figure 4: chains of three beads that three equations make for one pressure, over bond length."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured
from dpd.report.style import panels, points, published_line
from paper_figures.crgw_2019.shared import LOOKS, TARGET, mean_of

APART = 1.0  # r_c: longer bonds leave no overlap of bonded beads
FITTED = 0.6  # r_c, the longest bond to which the equation was fitted

TITLE = "Pressure of chains of three beads at the repulsion that an equation gives for 41.89."
PAPER_SHOWS = (
    "Density of chains 1.67. (a) The simulated pressure; dashed: that which was asked for. "
    "(b) The repulsion. The paper finds that crGW alone changes it with bond length, such that "
    "the pressure is near that which was asked for, and that beyond a bond length of 1 nothing "
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
    if not off.size:
        return np.nan, np.nan
    return off.mean(), 100 * np.sqrt((at.pressure_error.values**2).sum()) / TARGET / len(off)


def _beyond(values, errors):
    """The last of some values over the first, and the standard error of that."""
    if len(values) < 2:
        return np.nan, np.nan
    ratio = values[-1] / values[0]
    return float(ratio), float(ratio * np.hypot(errors[-1] / values[-1], errors[0] / values[0]))


def measured(data):
    """How far from the target each equation ends, and what bonds beyond 1 change."""
    ours, error = _off(data, "crGW")
    worst = {name: _off(data, name)[0] for name in ("rGW", "GW")}
    at = data.sel(equation="crGW")
    last = 100 * (float(at.pressure[-1]) / TARGET - 1)
    long = data.where(data.bond >= APART, drop=True)
    ends = long.bond.values
    bonds = f"bonds of {ends[-1]:g} over {ends[0]:g}" if ends.size else ""
    by_rgw, by_crgw = long.sel(equation="rGW"), long.sel(equation="crGW")
    return {
        "target_crgw": Measured(*_off(data.where(data.bond <= FITTED, drop=True), "crGW")),
        "target_long": Measured(
            *_off(data.where(data.bond > FITTED, drop=True), "crGW"),
            f"{last:+.1f} % at a bond of {float(at.bond[-1]):g}",
        ),
        "target_others": Measured(
            min(worst.values()) / ours, error * min(worst.values()) / ours**2,
            f"rGW {worst['rGW']:.1f} %, GW {worst['GW']:.1f} %, crGW {ours:.1f} %",
        ),
        "saturation": Measured(
            *_beyond(by_rgw.pressure.values, by_rgw.pressure_error.values), f"{bonds}, by rGW"
        ),
        "saturation_repulsion": Measured(
            *_beyond(by_crgw.repulsion.values, np.zeros(long.sizes["bond"])), bonds
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "Pressures of crGW lie near the dashed line up to a bond of about 0.6, and fall below it "
        "for longer ones; those of rGW and GW begin far below it, rise, and are level beyond 0.8. "
        "Below, the repulsion of crGW falls with bond length; the others are level."
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
