"""Bonds that cross, counted over time."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import NONE_SEEN, interval
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLUE, RED, SINGLE, panels
from paper_figures.liu_2008.shared import (
    PAPER_BEADS,
    PAPER_LENGTH,
    PAPER_STEP,
    SETS,
    printed_share,
)

SHARE = printed_share(shown_by(__file__)["share"].value)

TITLE = "Rate of bond crossings per bond, in DPD units."
PAPER_SHOWS = (
    "Not a figure of the paper, which saw no crossing in set (1) in 1e7 steps although about "
    f"{100 * SHARE:g} % of its bonds are longer than 4 r_0. Every 0.2 tau_0 we look for pairs of "
    "bonds that cross, and count those that did not cross at the look before. Filled: runs in "
    "which bonds crossed. Hollow: runs in which none did, and the rate that they exclude at 95 % "
    "(3 over bonds times time). The growth refuses crossings, so that those of melts as grown are "
    "a check of ours. F is the core force F_max, C the spring constant, N the chain length."
)
ERRORS = "Bars: 95 % intervals of the mean of a Poisson distribution, given the count."
SYMBOLS = {"force": "F", "stiffness": "C", "r_s": "r_s"}
SYSTEMS = {"sets": "", "rigidity": "N 20, ", "radius": "N 20, "}
NAMES = SETS | {"standard": "standard DPD"}
USED = ["scene", "kT", "crossing_time", "crossings_begun", "beads", "crossings"]
PAPER_BONDS = PAPER_BEADS * (PAPER_LENGTH - 1) / PAPER_LENGTH
PAPER_EXPOSURE = PAPER_BONDS * 1e7 * PAPER_STEP  # bonds times the time of its longest runs
ENOUGH = 0.1  # of the paper's exposure, below which none seen decides nothing; ours


def compute(sweeps):
    """Crossings counted in each run, and bonds times time."""
    rows = []
    for name, sweep in sweeps.items():
        sweep = sweep[USED]  # choosing a point costs for each variable there is
        axes = [d for d in sweep.kT.dims if d != "replica"]
        for place in np.ndindex(*(sweep.sizes[d] for d in axes)):
            at = sweep.isel(dict(zip(axes, place)))
            length = len(first_scene(at).molecules[0].beads)
            time = float(at.crossing_time.isel(replica=0).max())
            label = ", ".join(_label(axis, at[axis].item(), length) for axis in axes)
            rows.append({
                "run": SYSTEMS[name] + label,
                "begun": float(at.crossings_begun.sum()),
                "exposure": float(at.beads.sum()) * (length - 1) / length * time,
                "first": float(at.crossings.isel(crossing_sample=0).sum()),
                "most_at_once": float(at.crossings.max()),
            })  # fmt: skip
    data = xr.Dataset(coords={"run": [row["run"] for row in rows]})
    units = {"begun": "1", "exposure": "tau", "first": "1", "most_at_once": "1"}
    for name, unit in units.items():
        data[name] = ("run", [row[name] for row in rows], {"units": unit})
    data.exposure.attrs["long_name"] = "bonds times time"
    return data


def _label(axis, value, length):
    """One value of an axis, as the name of a run has it."""
    return f"{NAMES[value]}, N {length}" if axis == "set" else f"{SYMBOLS[axis]} {value}"


def measured(data):
    """Crossings of the paper's sets, and in melts as they were grown."""
    found = {}
    of_sets = data.isel(run=["set (" in run for run in data.run.values])
    for number in (1, 2):
        at = of_sets.isel(run=[f"set ({number})" in run for run in of_sets.run.values])
        count, exposure = float(at.begun.sum()), float(at.exposure.sum())
        rate = f"rate {count / exposure:.2g}" if count else f"rate < {NONE_SEEN / exposure:.1e}"
        share = exposure / PAPER_EXPOSURE
        note = (
            f"in {exposure:.3g} bonds times DPD time units, {share:.1%} of the paper's; {rate}; a "
            "single one would deviate"
        )
        few = (
            ""
            if count or share >= ENOUGH
            else f"less than {ENOUGH:.0%} of the paper's bonds times time"
        )
        found[f"crossings_{number}"] = Measured(count, 0.0, note, few)
    note = f"{of_sets.sizes['run']} melts, at the first look after equilibration"
    found["grown"] = Measured(float(of_sets["first"].sum()), 0.0, note)
    return found


def table(data):
    """Counts and bonds times time of every run."""
    rows = []
    for k in range(data.sizes["run"]):
        at = data.isel(run=k)
        count, exposure = float(at.begun), float(at.exposure)
        rate = f"{count / exposure:.2g}" if count else f"< {NONE_SEEN / exposure:.1e}"
        rows.append((at.run.item(), f"{count:.0f}", f"{exposure:.3g}", rate))
    names = ("run", "crossings begun", "bonds times time / tau_0", "rate x tau_0")
    return pd.DataFrame(rows, columns=names)


def describe(data):
    """What is seen, in words."""
    crossed = data.run.values[data.begun.values > 0]
    return (
        f"Rates of crossing of {data.sizes['run']} runs on a logarithmic axis. Bonds cross in "
        f"{'; '.join(crossed) or 'none'}; the others have upper bounds."
    )


def draw(data):
    """A row for each run: a rate, or the bound on it."""
    count = data.sizes["run"]
    figure, axes = panels(1, height=0.7 + 0.145 * count, width=SINGLE)
    for k in range(count):
        at = data.isel(run=k)
        begun, exposure = float(at.begun), float(at.exposure)
        if begun:
            low, high = interval(begun)
            bar = [[(begun - low) / exposure], [(high - begun) / exposure]]
            axes.errorbar(begun / exposure, k, xerr=bar, fmt="o", color=RED, capsize=1.5)
        else:
            axes.plot(NONE_SEEN / exposure, k, "<", color=BLUE, markerfacecolor="white")
    axes.plot([], [], "o", color=RED, label="counted")
    axes.plot([], [], "<", color=BLUE, markerfacecolor="white", label="less than (95 %)")
    axes.set_yticks(range(count), data.run.values)
    axes.set(xscale="log", ylim=(count - 0.5, -2.2))
    axes.set_xlabel(r"rate of crossings per bond / $\tau_0^{-1}$")
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", linewidth=0.3, alpha=0.5)
    axes.legend(loc="upper center", ncols=2)
    return figure
