"""Our own check: how often 95 % intervals hold the truth, over the length of runs."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.archive import ARCHIVE, compared, summary, table_of
from dpd.report.style import BLACK, BLUE, GREEN, RED, Look, panels, points
from paper_figures.groot_warren_1997.coverage import Coverage, coverage_of_pieces, slow_time

WANTED = shown_by(__file__)["coverage_kT_20"]  # the same for all quantities and lengths
LEAST, MOST = WANTED.value - WANTED.rounding, WANTED.value + WANTED.rounding

SEEDS = (3, 4)  # of the two studies that the table compares

TITLE = "Calibration of error bars: how often 95 % intervals hold the truth."
PAPER_SHOWS = (
    "Not a figure of the paper: a check of our own errors. One long run of a small melt (chains "
    "of 4) is cut into many short ones. (a) The share of them whose 95 % interval holds the mean "
    "of the long run, over their length in correlation times tau. tau is the integrated "
    "autocorrelation time of the slowest part of the long run's series: we average samples over "
    "one autocorrelation time first, so that faster parts do not hide it. Shaded: the limits that "
    f"we set, {LEAST:.2f} to {MOST:.2f}, from 20 tau on. Crosses: samples taken for independent. "
    "tau_0: the DPD time unit. (b) Median width of the intervals over that of a perfect one "
    "(solid), and the share of runs that are found too short for an error (dashed)."
)
ERRORS = (
    "Bars: 95 % intervals of binomial counts. Short runs are part of the long one, which is taken "
    "into account. The table: two archived quick studies that share no random number, of the seeds "
    f"{SEEDS[0]} and {SEEDS[1]}, beside each other. z: a value's difference over its error, with "
    "the rms that degrees of freedom let expect; flips: verdicts that differ; missing: values that "
    "one study lacks, which have no verdict."
)
LENGTHS = (5, 10, 20, 50, 100, 200)  # correlation times
JUDGED = (20, 100)
SHOWN = {
    "kT": Look(r"$k_BT$", BLUE, "o"),
    "pressure": Look("pressure", GREEN, "s"),
    "bond_energy": Look("bond energy", RED, "^"),
}


def compute(sweeps):
    """Coverage over run length for each quantity; also if samples are taken for independent."""
    run = sweeps["coverage"].isel(replica=0)
    step = float(run.time[1] - run.time[0])
    names, table, naive, times = list(SHOWN), [], [], []
    for name in names:
        series = run[f"{name}_series"].values
        tau = slow_time(series)
        sizes = [max(2, round(length * tau)) for length in LENGTHS]
        table.append([coverage_of_pieces(series, size) for size in sizes])
        naive.append([coverage_of_pieces(series, size, independent).share for size in sizes])
        times.append(tau * step)
    along = ("quantity", "length")
    data = xr.Dataset(coords={"quantity": names, "length": np.array(LENGTHS, dtype=float)})
    data.length.attrs = {"units": "1", "long_name": "length of the run in correlation times"}
    for part, values in zip(Coverage._fields, np.moveaxis(np.array(table), 2, 0)):
        data[part] = (along, values, {"units": "1", "long_name": part.replace("_", " ")})
    data["independent"] = (along, naive, {"units": "1", "long_name": "share, as if independent"})
    data["correlation_time"] = ("quantity", times, {"units": "tau"})
    return data


def independent(pieces):
    """Mean and standard error of runs whose samples were independent."""
    return pieces.mean(axis=0), pieces.std(axis=0, ddof=1) / np.sqrt(len(pieces))


def measured(data):
    """Shares that cover, of the shortest runs that have errors and of longer ones."""
    found = {}
    for name in SHOWN:
        for length in JUDGED:
            at = data.sel(quantity=name, length=length)
            found[f"coverage_{name}_{length}"] = Measured(
                float(at.share), float(at.error),
                f"{int(at['count'])} runs of {length * float(at.correlation_time):.3g} time units; "
                f"{float(at.too_short):.1%} too short for an error; "
                f"{float(at.independent):.2f} if samples were taken for independent",
            )  # fmt: skip
    return found


def table(data):
    """Archived studies of two seeds beside each other, for each paper: what `dpd compare` says."""
    places = [ARCHIVE / f"quick-seed{seed}" for seed in SEEDS]
    if not all(place.is_dir() for place in places):  # in a copy without the archive
        return pd.DataFrame()
    return summary(compared(*map(table_of, places))).rename_axis("paper").reset_index().astype(str)


def describe(data):
    """What is seen, in words."""
    at = data.sel(length=data.length >= min(JUDGED))
    low, high = float(at.share.min()), float(at.share.max())
    return (
        "(a) Coverage over the length of runs: from 20 correlation times on it lies between "
        f"{low:.3f} and {high:.3f}; taken for independent, samples give far less. (b) Intervals "
        "are somewhat wider than perfect ones in short runs."
    )


def draw(data):
    """Shares that cover; widths and runs without an error."""
    figure, (left, right) = panels(2, height=3.0)
    left.axhline(WANTED.value, color=BLACK, linewidth=0.6)
    ends = np.array([min(JUDGED), 1.2 * LENGTHS[-1]])
    left.fill_between(ends, LEAST, MOST, color=BLACK, alpha=0.12, linewidth=0)
    for shift, (name, (label, color, marker)) in zip((0.94, 1, 1.06), SHOWN.items()):
        at = data.sel(quantity=name)
        x = at.length * shift  # beside each other
        tau = rf"{label}, $\tau$ = {float(at.correlation_time):.2g} $\tau_0$"
        points(left, x, at.share, at.error, tau, color, marker)
        left.plot(x, at.independent, "x", color=color)
        points(right, x, at.width, 0 * at.width, label, color, marker, linestyle="-")
        right.plot(x, at.too_short, "--", color=color, marker=marker, markerfacecolor="white")
    left.plot([], [], "x", color=BLACK, label="samples taken for independent")
    right.plot([], [], "--", color=BLACK, label="share too short")
    ticks = [f"{length:g}" for length in LENGTHS]
    for axes in (left, right):
        axes.set(xscale="log", xlim=(0.8 * LENGTHS[0], 1.2 * LENGTHS[-1]),
                 xlabel=r"length of the run / correlation time $\tau$")  # fmt: skip
        axes.set_xticks(LENGTHS, ticks)
        axes.set_xticks([], minor=True)
    left.set(ylim=(0, 1.04), ylabel="share of 95 % intervals that cover")
    right.set(ylim=(0, 2), ylabel="width of intervals; share too short")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    right.legend(loc="upper right")
    return figure
