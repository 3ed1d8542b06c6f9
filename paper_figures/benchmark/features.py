"""What features cost that a scene names."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.report.style import BLACK, BLUE, panels
from paper_figures.benchmark.shared import middle_and_range, ranged

TITLE = "What each feature adds to the cost of a bead and step."
PAPER_SHOWS = (
    "Each feature against the bare fluid in the same turn. Some features change the fluid itself, "
    "as bonds do, which draw beads together: their whole change counts. The Langevin bath takes "
    "the place of friction and noise between pairs. Table: the same with the ratio."
)
ERRORS = "Points: medians, beside them the ratio. Bars: from the cheapest turn to the dearest."
NANO = 1e9
ROOM = 0.3  # for the ratios, of the width


def compute(data):
    """Medians and ranges of cost, of cost added, and of the ratio."""
    source = data["features"]
    cost, bare = source.cost.values, source.bare_cost.values
    parts = {
        "cost": ("feature", NANO * cost, "ns", "cost of a bead and step with the feature"),
        "added": ("feature", NANO * (cost - bare), "ns", "what the feature adds"),
        "ratio": ("feature", cost / bare, "1", "cost with the feature over that without"),
        "bare": ((), NANO * bare.ravel(), "ns", "cost of a bead and step of the bare fluid"),
    }
    numbers = xr.Dataset(coords={"feature": source.feature})
    for name, (dims, turns, units, long_name) in parts.items():
        for end, part in zip(("", "_low", "_high"), middle_and_range(turns)):
            numbers[name + end] = (dims, part, {"units": units, "long_name": long_name})
    return numbers


def measured(data):
    """None: nobody has published these numbers."""
    return {}


def table(data):
    """Costs with ranges."""
    rows = [("bare fluid", ranged(data, "bare"), "–", "–")]
    for name in data.feature.values:
        at = data.sel(feature=name)
        rows.append((str(name), *(ranged(at, part) for part in ("cost", "added", "ratio"))))
    return pd.DataFrame(rows, columns=["feature", "ns per bead and step", "added / ns", "ratio"])


def describe(data):
    """What is seen, in words."""
    dearest = data.ratio.idxmax("feature").item()
    return (
        "Bars for each feature of a scene: what it adds to the cost of a bead and step; "
        f"{dearest} multiplies it most, by {float(data.ratio.max()):.2f}."
    )


def draw(data):
    """What is added, one line a feature."""
    figure, axes = panels(1)
    place = np.arange(data.sizes["feature"])[::-1]
    middle, low, high = (data["added" + end].values for end in ("", "_low", "_high"))
    axes.errorbar(
        middle, place, xerr=(middle - low, high - middle), fmt="o", color=BLUE, capsize=1.5,
        elinewidth=0.8,
    )  # fmt: skip
    for x, y, ratio in zip(high, place, data.ratio.values):
        axes.annotate(f"x {ratio:.2f}", (x, y), (4, 0), textcoords="offset points", fontsize=7,
                      va="center")  # fmt: skip
    left, right = axes.get_xlim()
    axes.set_xlim(left, right + ROOM * (right - left))
    axes.axvline(0, color=BLACK, linewidth=0.7)
    axes.set_yticks(place, [str(name) for name in data.feature.values])
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(f"added / ns per bead and step\n(bare fluid: {float(data.bare):.0f} ns)")
    axes.grid(axis="x", color="0.9", linewidth=0.5)
    return figure
