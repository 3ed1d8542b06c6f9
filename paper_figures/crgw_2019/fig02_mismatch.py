"""Figure 2: by how much the chain-revised equation misses simulated pressures of oligomers."""

import numpy as np

from dpd.analysis.published import shown_by
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLUE, GREEN, ORANGE, PURPLE, RED, panels
from paper_figures.crgw_2019.shared import largest, mean_unsigned, mismatches

PUBLISHED = shown_by(__file__)
FLUIDS = 240  # of the paper
COLORS = (BLUE, ORANGE, GREEN, RED, PURPLE)
MARKERS = ("o", "s", "^", "D", "v")
CODES = (("bond", "l"), ("density", "rho"), ("repulsion", "a"), ("chain", "m"))
LETTERS = {"l": "$l$", "rho": r"$\rho$", "a": "$a$", "m": "$m$"}

TITLE = "Pressure by the chain-revised equation less the simulated one, in percent of that."
PAPER_SHOWS = (
    "Each point is a fluid of 3072 beads in chains of m; the four panels show the same points, "
    "marked by bond length l, density rho of beads, repulsion a, and m. The paper finds a mean "
    f"unsigned error of {PUBLISHED['crgw_mean_error'].value:g} % and none above "
    f"{PUBLISHED['crgw_largest_error'].value:g} % (gray), with larger errors at low pressure, and "
    "from slight under-prediction at m = 2 to over-prediction at m = 8. The paper speaks of the "
    "average bond length in places and does not say which one is in the equation here; we take "
    "the mean that was simulated, up to a tenth more than l where m is 8 and l 0.3. The "
    "notes of the verdicts say what l itself gives."
)


def compute(sweeps):
    """Mismatch of every fluid."""
    return mismatches(sweeps)


def measured(data):
    """Mean unsigned and largest error of the equation, and the trend with m."""
    at = data.sel(equation="crGW")
    fluids = at.mismatch.size
    missing = "" if fluids == FLUIDS else f"{fluids} of the paper's {FLUIDS} fluids"
    mean, mean_error = mean_unsigned(at)
    worst, worst_error, where = largest(at)
    by_chain = at.mismatch.mean(("density", "bond", "repulsion"))
    said = ", ".join(
        f"{float(v):+.1f} % for m = {int(m)}" for m, v in zip(by_chain.chain, by_chain)
    )
    rise = float(by_chain[-1] - by_chain[0])
    ends = at.mismatch_bound.isel(chain=[0, -1]).values
    noise = float(np.sqrt((ends**2).sum()) / (ends.size / 2))
    bonds = (
        f"bonds are {float(at.bond_ratio.min()):.3f} to {float(at.bond_ratio.max()):.3f} times l"
    )
    asked = data.as_asked
    asked_rise = float((asked.sel(chain=asked.chain[-1]) - asked.sel(chain=asked.chain[0])).mean())
    at_l = "with the length asked for"
    return {
        "crgw_mean_error": Measured(
            mean, mean_error, f"{bonds}; {at_l} {float(np.abs(asked).mean()):.1f} %", missing
        ),
        "crgw_largest_error": Measured(
            worst, worst_error, f"{where}; {at_l} {float(np.abs(asked).max()):.1f} %", missing
        ),
        "crgw_rise": Measured(
            rise, noise, f"mean mismatch {said}; {at_l} a rise of {asked_rise:.1f} %"
        ),
    }


def describe(data):
    """What is seen."""
    return (
        "Four panels of the same points about zero over pressure; they scatter most at low "
        "pressure, and those of the longest chains lie highest."
    )


def draw(data):
    """The same points four times."""
    figure, axes = panels(2, rows=2, height=2.4, sharex=True, sharey=True)
    at, bound = data.sel(equation="crGW"), PUBLISHED["crgw_largest_error"].value
    for panel, (name, letter) in zip(axes.flat, CODES):
        for k, value in enumerate(at[name].values):
            one = at.sel({name: value})
            panel.plot(
                one.pressure.values.ravel(), one.mismatch.values.ravel(), MARKERS[k % 5],
                color=COLORS[k % 5], label=f"{LETTERS[letter]} = {value:g}", markersize=2.5,
                markerfacecolor="none", markeredgewidth=0.7,
            )  # fmt: skip
        panel.axhspan(-bound, bound, color="0.93", zorder=0)
        panel.axhline(0, color="0.5", linewidth=0.6)
        panel.legend(loc="upper right", ncols=2, handletextpad=0.2, columnspacing=0.8)
    reach = 1.15 * max(bound, float(np.abs(at.mismatch).max()))
    axes[0, 0].set(xscale="log", ylim=(-reach, 1.5 * reach))  # legends above the points
    for panel in axes[1]:
        panel.set(xlabel="simulated pressure / ($k_BT$ $r_c^{-3}$)")
    for panel in axes[:, 0]:
        panel.set(ylabel="mismatch of crGW / %")
    return figure
