"""Bonds that cross, counted over time."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene, padded
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, SKY, panels

TITLE = "Bond crossings begun so far, per bond and tau."
PAPER_SHOWS = (
    "Not a figure of the paper, which saw no crossing in set (1) in 1e7 steps although about 0.05"
    " % of its bonds are longer than 4 r_0. Pairs of bonds that cross are looked for every 0.2 "
    "tau; counted is each pair that did not cross at the look before. Solid: count over bonds and"
    " time. Dashed: runs that have seen none, what they exclude at 95 % (3 over bonds times "
    "time). Of the sweep over F_max and C the runs with most crossings are drawn."
)
ERRORS = "Bands: 95 % intervals, from the square root of the count."
COLORS = (RED, ORANGE, PURPLE, SKY, GREEN, BLUE, BLACK)
SYMBOLS = {"force": "F", "stiffness": "C", "length": "N", "set": ""}
DRAWN = 3  # runs of the sweep over F_max and C
AT_LEAST = 3.0  # counts that exclude none at 95 %


def compute(sweeps):
    """Crossings begun over time for each run, and bonds times time."""
    names, curves, bonds, most = [], [], [], []
    for name, sweep in sweeps.items():
        axes = [d for d in sweep.kT.dims if d != "replica"]
        for place in np.ndindex(*(sweep.sizes[d] for d in axes)):
            at = sweep.isel(dict(zip(axes, place)))
            length = len(first_scene(at).molecules[0].beads)
            time = at.crossing_time.isel(replica=0).dropna("crossing_sample").values
            begun = at.crossings_begun.sum("replica").values[: len(time)]
            label = ", ".join(f"{SYMBOLS.get(d, d)} {at[d].item()}" for d in axes)
            names.append(f"{name}: {label}")
            curves.append(np.array([time, begun.cumsum()]))
            bonds.append(float(at.beads.sum()) * (length - 1) / length)
            most.append(float(at.crossings.max()))
    table = np.stack(padded(curves), axis=1)
    return xr.Dataset(
        {
            "time": (("run", "look"), table[0], {"units": "tau"}),
            "begun": (("run", "look"), table[1], {"units": "1", "long_name": "crossings begun"}),
            "bonds": ("run", bonds, {"units": "1", "long_name": "bonds, all replicas"}),
            "most_at_once": ("run", most, {"units": "1"}),
        },
        {"run": names},
    )


def _total(data, name):
    """Crossings, and bonds times time, of the runs of which the name begins so."""
    chosen = data.sel(run=[run for run in data.run.values if run.startswith(name)])
    exposure = (chosen.bonds * chosen.time.max("look")).sum()
    return float(chosen.begun.max("look").sum()), float(exposure)


def measured(data):
    """Crossings of the paper's sets."""
    found = {}
    for number, names in ((1, ("sets:  set_1", "melts: ")), (2, ("sets:  set_2",))):
        count, exposure = (sum(part) for part in zip(*(_total(data, name) for name in names)))
        rate = f"rate {count / exposure:.2g}" if count else f"rate < {AT_LEAST / exposure:.1e}"
        note = f"in {exposure:.3g} bonds times tau; {rate} per bond and tau"
        found[f"crossings_{number}"] = Measured(count, float(np.sqrt(count)), note)
    return found


def draw(data):
    """Rates so far, and limits where nothing has crossed."""
    figure, axes = panels(1, height=3.0)
    total = data.begun.max("look")
    swept = [k for k, run in enumerate(data.run.values) if run.startswith("rigidity")]
    shown = sorted(swept, key=lambda k: -float(total[k]))[:DRAWN]
    shown += [k for k in range(data.sizes["run"]) if k not in swept]
    for k, color in zip(shown, COLORS * 3):
        at = data.isel(run=k).dropna("look")
        exposure = float(at.bonds) * at.time
        name = str(at.run.item()).replace("sets:  ", "").replace("_", " ")
        if total[k] > 0:
            at = at.where(at.begun > 0, drop=True)
            exposure = float(data.bonds[k]) * at.time
            rate, reach = at.begun / exposure, COVERAGE * np.sqrt(at.begun) / exposure
            low = np.maximum(rate - reach, 0.1 * rate)  # an axis of logarithms has no zero
            axes.fill_between(at.time, low, rate + reach, color=color, alpha=0.25, linewidth=0)
            axes.plot(at.time, rate, color=color, label=f"{name}: {float(rate[-1]):.1e}")
        else:
            limit = AT_LEAST / exposure
            axes.plot(at.time, limit, "--", color=color, linewidth=0.8,
                      label=f"{name}: < {float(limit[-1]):.0e}")  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel=r"time / $\tau$",
             ylabel=r"crossings per bond and $\tau$")  # fmt: skip
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * 3e3)
    axes.legend(loc="upper right", ncols=2, fontsize=5.5, columnspacing=1.0)
    return figure
