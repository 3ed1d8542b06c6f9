"""Figure 3: the three equations of state beside each other, for the same oligomers."""

from dpd.analysis.verdicts import Measured
from dpd.report.style import panels
from paper_figures.crgw_2019.shared import LOOKS, largest, mean_unsigned, mismatches

TITLE = "By how much three equations of state miss simulated pressures of oligomers."
PAPER_SHOWS = (
    "The fluids of Figure 2. GW and rGW do not know of bonds, and give all chains of one density "
    "and repulsion one pressure; they are wrong by tens of percent where chains are long and bonds "
    "are short. The paper prints no number for them."
)


def compute(sweeps):
    """Mismatch of every fluid and equation."""
    return mismatches(sweeps)


def measured(data):
    """How much larger the errors of the other equations are."""
    ours, ours_error = mean_unsigned(data.sel(equation="crGW"))
    found = {}
    for equation in ("rGW", "GW"):
        at = data.sel(equation=equation)
        mean, error = mean_unsigned(at)
        worst, _, where = largest(at)
        relative = ((error / mean) ** 2 + (ours_error / ours) ** 2) ** 0.5
        found[f"{equation.lower()}_over_crgw"] = Measured(
            mean / ours, mean / ours * relative,
            f"{mean:.1f} % over {ours:.1f} %; largest {worst:.0f} % at {where}",
        )  # fmt: skip
    return found


def describe(data):
    """What is seen."""
    return (
        "Points of crGW lie in a band about zero; those of rGW and GW spread upwards to tens of "
        "percent, most at low pressure."
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
    axes.set(xscale="log", xlabel="simulated pressure / ($k_BT$ $r_c^{-3}$)", ylabel="mismatch / %")
    axes.legend(loc="upper right")
    return figure
