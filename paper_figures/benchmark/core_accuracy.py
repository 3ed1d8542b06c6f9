"""What the jump of a rigid core's force costs, and what smoothing it would buy."""

import numpy as np
import pandas as pd

from dpd.analysis.statistics import linear_fit
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, panels, points
from dpd.report.text import with_error
from paper_figures.benchmark.accuracy import quantities

SHOWS_TEMPERATURE = True

TITLE = "Time step and the edge of a rigid core (Liu's set (1), rho 2, chains of 20)."
PAPER_SHOWS = (
    "The published force jumps at the core's diameter of 0.3, so no scheme is of its order there. "
    "With an edge of some width the force goes over in a straight line. Left: heat over time step; "
    "filled gw-vv, open ABOBA, whose pairs are thermalised exactly. Middle: pressure less its own "
    "limit for dt to 0. Right: what the edge does to the system itself, the limits against those "
    "of the jump. Limits are of straight lines and parabolas in dt through the smallest four steps."
)
COLORS = {0.0: BLACK, 0.02: BLUE, 0.05: GREEN, 0.1: ORANGE}
SMALLEST = 4  # steps that the limit is taken from


def compute(data):
    """Quantities over scheme, width of the edge and dt, and their limits for dt to 0."""
    found = quantities(data["core"])
    for name in ("pressure", "bond"):
        shape = (found.sizes["scheme"], found.sizes["smooth"])
        value, error = np.full(shape, np.nan), np.full(shape, np.nan)
        for place in np.ndindex(shape):
            at = found.isel(scheme=place[0], smooth=place[1], dt=slice(0, SMALLEST))
            seen = np.isfinite(at[name].values) & (at[f"{name}_error"].values > 0)
            if seen.sum() < 3:
                continue
            dt = at.dt.values[seen]
            fit = linear_fit(
                np.array([np.ones_like(dt), dt, dt**2]), at[name].values[seen],
                at[f"{name}_error"].values[seen],
            )  # fmt: skip
            value[place], error[place] = fit.values[0], fit.errors[0]
        along = ("scheme", "smooth")
        found[f"{name}_limit"] = (along, value, found[name].attrs)
        found[f"{name}_limit_error"] = (along, error, found[name].attrs)
    return found


def measured(data):
    """None: the paper gives no such numbers."""
    return {}


def largest_step(data, scheme, smooth, allowed):
    """Largest dt up to which |kT - 1| stays within what is allowed, and its kT; NaN if none."""
    at = data.sel(scheme=scheme, smooth=smooth)
    good = np.abs(at.kT.values - 1) <= allowed
    last = int(np.argmin(good)) if not good.all() else len(good)
    if last == 0:
        return np.nan, np.nan, np.nan
    return float(at.dt[last - 1]), float(at.kT[last - 1]), float(at.kT_error[last - 1])


def table(data):
    """Steps that keep kT within 1 %, and what the edge does to pressure and bonds."""
    rows = []
    for smooth in data.smooth.values:
        for scheme in data.scheme.values:
            at = data.sel(scheme=scheme, smooth=smooth)
            dt, kT, error = largest_step(data, scheme, smooth, 0.01)
            rows.append((
                f"{smooth:g}", str(scheme), f"{dt:g}" if np.isfinite(dt) else "none",
                with_error(100 * (kT - 1), 100 * error),
                with_error(float(at.pressure_limit), float(at.pressure_limit_error)),
                with_error(float(at.bond_limit), float(at.bond_limit_error)),
            ))  # fmt: skip
    names = ["edge / r_c", "scheme", "largest dt with kT within 1 %", "kT - 1 there / %",
             "pressure, dt to 0", "bond length, dt to 0"]  # fmt: skip
    return pd.DataFrame(rows, columns=names)


def describe(data):
    """What is seen, in words."""
    return (
        "kT less 1, and pressure less its limit, over the time step for a core with a jump and for "
        "smoothed ones; and how pressure and bond length change with the width of the edge."
    )


def draw(data):
    """Heat, pressure, and limits."""
    figure, (left, middle, right) = panels(3)
    for smooth in data.smooth.values:
        for scheme in data.scheme.values:
            at, color = data.sel(scheme=scheme, smooth=smooth), COLORS[float(smooth)]
            first = scheme == data.scheme.values[0]
            label = f"edge {smooth:g}" if first else None
            style = dict(filled=first, linestyle="-", linewidth=0.6)
            points(left, at.dt, 100 * (at.kT - 1), 100 * at.kT_error, label, color, **style)
            points(middle, at.dt, at.pressure - at.pressure_limit, at.pressure_error, label, color,
                   **style)  # fmt: skip
    for name, marker, color in (("pressure", "o", BLUE), ("bond", "s", ORANGE)):
        limit = data[f"{name}_limit"].isel(scheme=-1)
        error = data[f"{name}_limit_error"].isel(scheme=-1)
        change = 100 * (limit / limit.isel(smooth=0) - 1)
        spread = 100 * np.hypot(error, error.isel(smooth=0)) / limit.isel(smooth=0)
        points(right, data.smooth[1:], change[1:], spread[1:], name, color, marker)
    for axis in (left, middle):
        axis.set(xscale="log", xlabel=r"time step dt / $\tau$")
        axis.axhline(0, color="0.6", linewidth=0.6, zorder=0)
    left.set_yscale("symlog", linthresh=1)
    left.set_ylabel(r"$k_BT - 1$ / %")
    middle.set_ylabel(r"pressure less its limit / $k_BT\,r_c^{-2}$")
    right.axhline(0, color="0.6", linewidth=0.6, zorder=0)
    right.set(xlabel=r"width of the edge / $r_c$", ylabel="change of the limit / %")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    right.legend()
    return figure
