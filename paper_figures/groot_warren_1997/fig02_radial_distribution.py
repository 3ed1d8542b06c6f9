"""Figure 2: radial distribution function at rho 3, a 25, and where the mean bond lies."""

from itertools import cycle

import numpy as np
import xarray as xr

from dpd.analysis.statistics import COVERAGE, jackknife, mean_and_error
from dpd.analysis.structure import peak, radial_distribution
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, ORANGE, RED, panels

TITLE = "Radial distribution function (rho = 3, a = 25)."
PAPER_SHOWS = (
    "The paper shows g(r) of the monomer fluid and chooses the spring constant C = 2 so that the "
    "mean bond lies at the maximum of g(r). Vertical lines: mean bond length in melts of N = 10 "
    "for two spring constants, with bonded beads repelling each other like any others."
)
ERRORS = "Band (narrower than the line where not visible): 95 % interval from blocks of the run."


def compute(sweeps):
    """g(r) with its error, its maximum, and mean bond lengths."""
    fluid, springs = sweeps["fluid"], sweeps["springs"]
    g, error, blocks = radial_distribution(fluid)
    r = fluid.r.values
    highest, highest_error = jackknife(blocks, lambda mean: peak(r, mean))
    bonds = [
        mean_and_error(springs.bond_mean.sel(stiffness=c).values.ravel())[:2]
        for c in springs.stiffness.values
    ]
    return xr.Dataset(
        {
            "g": ("r", g, {"units": "1", "long_name": "g(r)"}),
            "g_error": ("r", error, {"units": "1", "long_name": "standard error"}),
            "peak": ((), highest, {"units": "r_c", "long_name": "maximum of g(r)"}),
            "peak_error": ((), highest_error, {"units": "r_c"}),
            "bond": ("stiffness", [b for b, _ in bonds], {"units": "r_c"}),
            "bond_error": ("stiffness", [e for _, e in bonds], {"units": "r_c"}),
        },
        {"r": fluid.r, "stiffness": springs.stiffness},
    )


def measured(data):
    """The claim about the spring constant."""
    found = {}
    for c in data.stiffness.values:
        bond, peak = float(data.bond.sel(stiffness=c)), float(data.peak)
        error = float(data.bond_error.sel(stiffness=c))
        ratio = bond / peak
        found[f"bond_over_peak_C{c:g}"] = Measured(
            ratio, ratio * float(np.hypot(error / bond, data.peak_error / peak)),
            f"mean bond {bond:.4f} r_c, maximum of g(r) at {peak:.3f} r_c",
        )  # fmt: skip
    missing = Measured(np.nan, np.nan)
    return {
        "bond_over_peak": found.get("bond_over_peak_C2", missing),
        "bond_over_peak_C4": found.get("bond_over_peak_C4", missing),
    }


def describe(data):
    """What is seen."""
    bonds = ", ".join(
        f"{float(data.bond.sel(stiffness=c)):.2f} for C = {c:g}" for c in data.stiffness.values
    )
    return (
        f"g(r) rises from a small value at zero distance to {float(data.g.max()):.2f} at "
        f"{float(data.peak):.2f} r_c, dips slightly below 1 and is flat from 2 r_c on. Vertical "
        f"lines mark mean bond lengths: {bonds}."
    )


def draw(data):
    """g(r), the paper's axes."""
    figure, axes = panels(1)
    reach = COVERAGE * data.g_error
    axes.fill_between(data.r, data.g - reach, data.g + reach, color=BLUE, alpha=0.3)
    axes.plot(data.r, data.g, color=BLUE, label="$g(r)$, this work")
    axes.axhline(1, color=BLACK, linewidth=0.5)
    axes.axvline(
        data.peak, color=BLACK, linestyle=":", label=f"maximum, {float(data.peak):.2f} $r_c$"
    )
    for c, color in zip(data.stiffness.values, cycle((RED, ORANGE))):
        bond = float(data.bond.sel(stiffness=c))
        axes.axvline(
            bond, color=color, linestyle="--", label=f"mean bond, $C$ = {c:g}: {bond:.2f} $r_c$"
        )
    axes.set(xlim=(0, 3), ylim=(0, 1.4), xlabel="distance $r$ / $r_c$", ylabel="$g(r)$")
    axes.legend(loc="lower right")
    return figure
