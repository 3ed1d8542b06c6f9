"""Figure 3: the three equations of state beside each other, for the same oligomers."""

import numpy as np

from dpd.analysis.verdicts import Measured
from dpd.report.style import panels
from paper_figures.crgw_2019.shared import LOOKS, largest, mean_unsigned, mismatches

TITLE = "By how much three equations of state miss simulated pressures of oligomers."
PAPER_SHOWS = (
    "The fluids of Figure 2. GW and rGW do not know of bonds, and give all chains of one density "
    "and repulsion one pressure; they are wrong by tens of percent where chains are long and bonds "
    "are short. The paper prints no number for them, but concludes that crGW is an improvement of "
    "several orders of magnitude."
)


def compute(sweeps):
    """Mismatch of every fluid and equation."""
    return mismatches(sweeps)


def measured(data):
    """By how many orders of magnitude the error of crGW is less than that of the better other."""
    found = {str(name): mean_unsigned(data.sel(equation=name)) for name in data.equation.values}
    largests = {name: largest(data.sel(equation=name))[0] for name in found}
    better = min(("rGW", "GW"), key=lambda name: found[name][0])
    relative = [found[name][1] / found[name][0] for name in (better, "crGW")]
    said = ", ".join(f"{k} {found[k][0]:.1f} % (largest {largests[k]:.0f} %)" for k in found)
    return {
        "improvement": Measured(
            float(np.log10(found[better][0] / found["crGW"][0])),
            float(np.hypot(*relative) / np.log(10)), said,
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    most = float(data.mismatch.sel(equation="GW").max())
    return (
        "Points of crGW lie in a band about zero; those of rGW and GW spread upwards, to "
        f"{most:.0f} % for GW, most at low pressure."
    )


def draw(data):
    """Mismatch over pressure."""
    figure, axes = panels(1)
    for equation in ("GW", "rGW", "crGW"):
        look, at = LOOKS[equation], data.sel(equation=equation)
        axes.plot(
            at.pressure.values.ravel(), at.mismatch.values.ravel(), look.marker, color=look.color,
            label=look.label, markersize=2.5, markerfacecolor="none", markeredgewidth=0.6,
        )  # fmt: skip
    axes.axhline(0, color="0.5", linewidth=0.6)
    axes.set(
        xlim=(3, 300), xlabel="simulated pressure / ($k_BT$ $r_c^{-3}$)", ylabel="mismatch / %"
    )
    axes.set_xscale("log")
    axes.legend(loc="upper right")
    return figure
