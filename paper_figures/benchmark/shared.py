"""What figures of the benchmark share: run time against error, and ranges of timings."""

import numpy as np
import pandas as pd
from matplotlib.ticker import NullFormatter

from dpd.analysis.statistics import COVERAGE
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, SKY, Look, panels
from dpd.report.text import with_error
from paper_figures.benchmark.accuracy import (
    JUDGED,
    LABELS,
    bound,
    choices,
    deviations,
    front,
    in_percent,
)  # fmt: skip

LOOKS = {
    "euler": Look("Euler", RED, "D"),
    "gw-vv-0.5": Look(r"gw-vv, $\lambda$ 0.5", BLUE, "o"),
    "gw-vv-0.65": Look(r"gw-vv, $\lambda$ 0.65", SKY, "s"),
    "dpd-vv": Look("dpd-vv", BLACK, "v"),
    "shardlow": Look("Shardlow", ORANGE, "^"),
    "lowe-andersen": Look("Lowe-Andersen", PURPLE, "P"),
    "aboba": Look("ABOBA", GREEN, "X"),
}
LEAST = 1e-4  # relative error at which the panels end


def shows(beads):
    """What such a figure shows, for its caption.

    ``beads``: how many beads the run time is for.
    """
    return (
        "Each scheme over its time step, at each friction. Down: less error; left: less run "
        f"time, per tau of {beads} beads on one core. Temperatures are held against kT = 1, other "
        "quantities against their limit for dt to 0 (written in), taken from Shardlow's scheme and "
        "ABOBA. Lowe-Andersen has another dynamics by design, so its diffusion has another limit. "
        "Hollow: noise hides the error, which is below the mark with 97.5 % confidence. Grey: the "
        "front, on which no scheme is both faster and surely more accurate. Crosses: runs too "
        "short for a standard error. Runs that blew up, or with kT above 2, are left out."
    )


def against_time(runs, costs, workload):
    """Relative errors of a sweep's runs, with the run time per tau of the workload.

    ``runs``: collected, see `deviations`. ``costs``: the measurement
    ``schemes``: ``cost`` in s per bead and step. ``workload``: one of its workloads. Result:
    `deviations`, and ``seconds`` per tau over ``scheme`` and ``dt``.
    """
    data = deviations(runs)
    each = costs.cost.sel(workload=workload).median("turn").sel(scheme=data.scheme)
    beads = float(costs.beads.sel(workload=workload))
    data["seconds"] = (each * beads / data.dt).transpose("scheme", "dt")
    text = f"run time per tau of {beads:.0f} beads, one core"
    data.seconds.attrs = {"units": "s / tau", "long_name": text}
    return data.drop_vars("workload", errors="ignore")


def describe(data):
    """What such a figure shows, for those who cannot see it."""
    return (
        "Panels for each quantity and friction: the error falls as runs take more time, for every "
        "scheme; a grey line marks those that no other beats in both."
    )


def draw(data):
    """Panels: quantities downwards, frictions across."""
    names = [name for name in LABELS if name in data]
    figure, axes = panels(data.sizes["gamma"], len(names), height=2.2, squeeze=False)
    for row, name in zip(axes, names):
        for axis, gamma in zip(row, data.gamma.values):
            _panel(axis, data.sel(gamma=gamma), name)
            axis.set_title(rf"{LABELS[name]}, $\gamma$ = {gamma:g}")
    for axis in axes[-1]:
        axis.set_xlabel(r"run time per $\tau$ / s")
    for row in axes:
        row[0].set_ylabel("relative error")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    return figure


def _panel(axis, data, name):
    """|error| where it is clear of noise; else the bound on it, as a hollow mark."""
    error, sigma = np.abs(data[name]), data[f"{name}_error"]
    limit = bound(data, name)
    for scheme in data.scheme.values:
        label, color, marker = LOOKS[str(scheme)]
        at = dict(scheme=scheme)
        x, y, s = (part.sel(at).values for part in (data.seconds, error, sigma))
        clear = y > COVERAGE * s
        axis.plot(x, np.where(clear, y, limit.sel(at)), color=color, linewidth=0.5)
        axis.errorbar(x[clear], y[clear], COVERAGE * s[clear], color=color, marker=marker,
                      linestyle="none", elinewidth=0.6, label=label)  # fmt: skip
        hidden = ~clear & np.isfinite(y)
        axis.plot(x[hidden], limit.sel(at).values[hidden], color=color, marker=marker,
                  markerfacecolor="white", linestyle="none")  # fmt: skip
        unknown = np.isfinite(y) & ~np.isfinite(s)
        axis.plot(x[unknown], y[unknown], "x", color=color)
    x, y = data.seconds.values.ravel(), limit.transpose("scheme", "dt").values.ravel()
    best = front(x, y)
    axis.step(x[best], y[best], where="post", color="0.75", linewidth=3, zorder=0)
    axis.set(xscale="log", yscale="log", ylim=(LEAST, 2))
    axis.xaxis.set_minor_formatter(NullFormatter())
    if not name.startswith("kT") and f"{name}_limit" in data:
        value, sigma = float(data[f"{name}_limit"]), float(data[f"{name}_limit_error"])
        text = f"limit {with_error(value, sigma)}"
        axis.text(0.03, 0.04, text, transform=axis.transAxes, fontsize=7)


def table(data):
    """The cheapest scheme and step for each tolerance: in pressure, and in pressure and kT."""
    rows = []
    for names, text in ((("pressure",), "pressure"), (JUDGED, "pressure and kT")):
        for choice in choices(data, names):
            start = (f"{100 * choice.tolerance:g} % in {text}", f"{choice.gamma:g}")
            if choice.scheme is None:
                rows.append((*start, "none", "–", "–", "–", "–"))
                continue
            scheme = LOOKS[choice.scheme].label.replace("$", "").replace("\\", "")
            cost, errors = f"{1000 * choice.seconds:.3g}", in_percent(choice.deviations)
            rows.append((*start, scheme, f"{choice.dt:g}", cost, errors["pressure"], errors["kT"]))
    head = ["within", "gamma", "scheme", "dt / tau", "ms per tau", "pressure / %", "kT / %"]
    return pd.DataFrame(rows, columns=head)


def with_range(middle, low, high):
    """A number with the range that it was met in."""
    return f"{middle:.3g} ({low:.3g} to {high:.3g})" if np.isfinite(middle) else "–"


def ranged(data, name):
    """Median and range of a timing, as text."""
    return with_range(*(float(data[name + end]) for end in ("", "_low", "_high")))


def middle_and_range(turns):
    """Median, smallest and largest over the last axis: of timings, which have no normal errors."""
    return np.median(turns, axis=-1), np.min(turns, axis=-1), np.max(turns, axis=-1)
