"""How speed goes with the number of beads, the density and the threads."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.report.style import BLUE, ORANGE, panels
from paper_figures.benchmark.shared import middle_and_range, ranged

TITLE = "Bead-steps per second over the number of beads (a) and over the density (b)."
PAPER_SHOWS = (
    "Standard fluid, with one thread and with two threads that share the run. The work of a bead "
    "grows with its partners, whose number grows with the density."
)
ERRORS = "Points: medians. Bars: from the slowest turn to the fastest."
LARGE = 30_000  # beads from which on two threads are judged
COLORS = {1: BLUE, 2: ORANGE}


def compute(data):
    """Medians and ranges of rates and of their ratio; memory per bead; time to start."""
    source = data["scaling"]
    numbers = xr.Dataset(coords={name: source[name] for name in ("beads", "density", "threads")})
    for name in ("rate", "density_rate"):
        dims = source[name].dims[:-1]
        for end, part in zip(("", "_low", "_high"), middle_and_range(source[name].values)):
            numbers[name + end] = (dims, part, source[name].attrs)
    gain = (source.rate.sel(threads=2) / source.rate.sel(threads=1)).values
    for end, part in zip(("", "_low", "_high"), middle_and_range(gain)):
        attributes = {"units": "1", "long_name": "rate of two threads over that of one"}
        numbers[f"gain{end}"] = ("beads", part, attributes)
    middle = numbers.rate.fillna(0.0)
    numbers["best"], numbers["worst"] = middle.idxmax("beads"), middle.idxmin("beads")
    # Turn by turn, as what disturbs a machine disturbs both.
    fall = source.rate.sel(beads=numbers.worst) / source.rate.sel(beads=numbers.best)
    for end, part in zip(("", "_low", "_high"), middle_and_range(fall.values)):
        attributes = {"units": "1", "long_name": "rate of the worst size over that of the best"}
        numbers[f"fall{end}"] = ("threads", part, attributes)
    (less, more), (small, large) = source.memory.values[-2:], source.beads.values[-2:]
    numbers["memory_per_bead"] = ((), (more - less) / (large - small), {"units": "B"})
    for end, part in zip(("", "_low", "_high"), middle_and_range(source.start_up.values)):
        numbers[f"start_up{end}"] = ((), part, {"units": "s", "long_name": "time to start"})
    return numbers


def measured(data):
    """None: nobody has published these numbers."""
    return {}


def table(data):
    """What does not show in the picture."""
    rows = [
        ("peak memory per bead / B", f"{float(data.memory_per_bead):.0f}"),
        ("`python -m dpd run` of one step, caches warm / s", ranged(data, "start_up")),
    ]
    for n in data.beads.values[data.beads.values >= LARGE]:
        rows.append((f"two threads over one, {n} beads", ranged(data.sel(beads=n), "gain")))
    for threads in data.threads.values:
        at = data.sel(threads=threads)
        if np.isfinite(at.rate).all():
            what = f"rate of {int(at.worst)} beads (worst) over that of {int(at.best)} (best)"
            rows.append((f"{what}, {_threads(threads)}", ranged(at, "fall")))
    return pd.DataFrame(rows, columns=["quantity", "median (range)"])


def _threads(n):
    return f"{n} thread{'s' if n > 1 else ''}"


def describe(data):
    """What is seen, in words."""
    low, high = float(data.rate.min()) / 1e6, float(data.rate.max()) / 1e6
    return (
        f"(a) The rate is {low:.1f} to {high:.1f} million bead-steps per second over the number of "
        "beads, with one and with two threads. (b) It falls as the density grows."
    )


def draw(data):
    """Two panels of rates."""
    figure, axes = panels(2)
    for panel, name, along in zip(axes, ("rate", "density_rate"), ("beads", "density")):
        for threads in data.threads.values:
            at = data.sel(threads=threads)
            middle, low, high = (at[name + end].values / 1e6 for end in ("", "_low", "_high"))
            if np.isfinite(middle).any():
                panel.errorbar(
                    data[along], middle, (middle - low, high - middle), marker="o", linewidth=0.8,
                    capsize=1.5, color=COLORS[int(threads)], label=_threads(threads),
                )  # fmt: skip
        panel.set_ylim(0, 1.2 * float(np.nanmax(data[f"{name}_high"])) / 1e6)
        panel.set_ylabel(r"$10^6$ bead-steps / s")
    axes[0].set(xscale="log", xlabel="number of beads")
    axes[1].set(xlabel=r"density / $r_c^{-3}$")
    axes[0].legend(loc="lower right")
    return figure
