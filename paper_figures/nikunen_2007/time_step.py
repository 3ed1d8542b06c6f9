"""How far temperature and bond lengths are off at the paper's time steps."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.statistics import block_mean_and_error, over_replicas
from dpd.analysis.structure import blocks_of
from dpd.report.style import panels, points
from dpd.report.text import with_error
from paper_figures.nikunen_2007.shared import SETS, in_words, repulsion

TITLE = "Kinetic temperature (a) and variance of the bond length (b) over the time step."
PAPER_SHOWS = (
    "Not a figure of the paper. Chains of 8 with each parameter set; filled: at the paper's time "
    "step (0.03 for its control, which has none). The variance is drawn relative to that at the "
    "smallest step. Points far above the paper's are cut off. Runs that blow up or heat by more "
    "than a half are left out. tau_0 = (m r_c^2 / kT)^(1/2) is the unit of time."
)
PAPER_STEP = {"a25": 0.03, "a50": 0.03, "a100": 0.02, "a150": 0.015, "a200": 0.0125}
HIGHEST = {"heat": 8, "change": 20}  # per cent that are drawn
HOT = 1.5  # kT from which on a run counts as blown up


def compute(sweeps):
    """kT - 1, and the variance of bonds over that at the smallest step, minus 1."""
    runs = sweeps["time_step"].sortby("dt")
    heat, heat_error = over_replicas(runs.kT.values, runs.kT_error.values, -1)
    variance, error = np.full(heat.shape, np.nan), np.full(heat.shape, np.nan)
    for place in np.ndindex(heat.shape):
        at = runs.isel(set=place[0], dt=place[1])
        if (at.lost_step < 0).all() and heat[place] < HOT:
            blocks = blocks_of(at.bond_mean_square - at.bond_mean**2)
            variance[place], error[place] = block_mean_and_error(blocks)
    heat = np.where(np.isfinite(variance), heat, np.nan)
    first, first_error = variance[:, :1], error[:, :1]
    ratio = variance / first
    spread = ratio * np.hypot(error / variance, first_error / first)
    spread[:, 0] = 0.0
    along = ("set", "dt")
    return xr.Dataset(
        {
            "heat": (along, heat - 1, {"units": "kT", "long_name": "kinetic temperature less 1"}),
            "heat_error": (along, heat_error, {"units": "kT"}),
            "variance": (along, variance, {"units": "r_c^2", "long_name": "variance of bonds"}),
            "change": (along, ratio - 1, {"units": "1", "long_name": "relative to smallest step"}),
            "change_error": (along, spread, {"units": "1"}),
        },
        {"set": runs.set, "dt": runs.dt},
    )


def measured(data):
    """None: the paper gives no such numbers."""
    return {}


def table(data):
    """Both at the paper's steps."""
    rows = []
    for name in data.set.values:
        dt = PAPER_STEP[str(name)]
        if dt not in data.dt.values:
            continue
        at = data.sel(set=name, dt=dt)
        rows.append((
            in_words(name), f"{dt:g}",
            with_error(100 * float(at.heat), 100 * float(at.heat_error)),
            with_error(100 * float(at.change), 100 * float(at.change_error)),
        ))  # fmt: skip
    return pd.DataFrame(rows, columns=["set", "dt", "kT - 1 / %", "variance of bonds, change / %"])


def describe(data):
    """What is seen."""
    own = [data.sel(set=name, dt=step) for name, step in PAPER_STEP.items()
           if name in data.set.values and step in data.dt.values]  # fmt: skip
    if not own:
        return TITLE
    heat, change = ([abs(100 * float(at[part])) for at in own] for part in ("heat", "change"))
    return (
        "Both rise with the time step and with a; at the paper's steps kT is up to "
        f"{np.nanmax(heat):.1f} % and the variance of bonds up to {np.nanmax(change):.1f} % off."
    )


def draw(data):
    """Two panels over dt."""
    figure, axes = panels(2)
    shown = (("heat", r"$k_BT - 1$ / %"), ("change", "change of bond variance / %"))
    for panel, (name, label) in zip(axes, shown):
        for key in data.set.values:
            at, color = data.sel(set=key), SETS[str(key)]
            value, error = 100 * at[name], 100 * at[f"{name}_error"]
            points(panel, at.dt, value, error, f"a = {repulsion(key)}", color, filled=False,
                   linestyle="-", linewidth=0.6)  # fmt: skip
            own = at.dt == PAPER_STEP[str(key)]
            panel.plot(at.dt[own], value[own], "o", color=color, zorder=3)
        panel.set_ylim(-HIGHEST[name] / 4, HIGHEST[name])
        panel.axhline(0, color="0.6", linewidth=0.6, zorder=0)
        panel.set(xlabel=r"time step dt / $\tau_0$", ylabel=label)
    axes[0].legend(loc="upper left")
    return figure
