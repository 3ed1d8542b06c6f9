"""Figure S3: a_ij of mixtures without heat by the thermal rule over that by the athermal one."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLUE, panels
from paper_figures.crgw_2019.mixing import chain_potential
from paper_figures.crgw_2019.shared import TARGET

PUBLISHED = shown_by(__file__)
WEAKEST, STRONGEST = 5.0, 60.0  # repulsions beyond which the paper leaves a fluid out
CLOSE = 2.0  # percent
HALVINGS = 50  # of the range of a_ij

TITLE = "Repulsion of unlike chains at chi = 0 by the thermal rule, less that by the athermal one."
PAPER_SHOWS = (
    "Every pair of fluids of chains at the pressure 41.89 that differ in density, beads, or bond "
    f"length, with repulsions from {WEAKEST:g} to {STRONGEST:g}. The thermal rule is Eq. 29 with "
    "Eq. 34, the athermal one Eqs. 25 and 27. The paper shows this histogram in its supplement and "
    f"says that most pairs are within {CLOSE:g} % (gray), and the thermal rule a little lower on "
    "average. Nothing is simulated."
)
ERRORS = "No errors: all numbers follow from equations."


def compute(sweeps):
    """The difference of both rules for every pair of fluids, in percent."""
    fluids = [
        sweeps[name].repulsion.stack(fluid=("chain", "density", "bond")).reset_index("fluid")
        for name in ("chain_repulsions", "thin_chain_repulsions")
    ]
    m, rho, length, a = (
        np.concatenate([part[name].values if name else part.values for part in fluids])
        for name in ("chain", "density", "bond", "")
    )
    length = np.where(m == 1, 0.0, length)
    kept = np.unique(np.stack([m, rho, length, a])[:, (a > WEAKEST) & (a < STRONGEST)], axis=1)
    return xr.Dataset({"off": ("pair", 100 * _ratios(*kept), {"units": "%"})})


def _ratios(m, rho, length, a):
    """a_ij by the thermal rule over that by the athermal one, less 1, of every pair of fluids."""
    i, j = np.triu_indices(len(m), 1)
    excess = TARGET - rho  # pressure over that of an ideal gas, the h of Eq. 27
    athermal = (excess[i] + excess[j]) / 2 * np.sqrt(a[i] * a[j] / (excess[i] * excess[j]))
    own = chain_potential(a, m * rho, m.astype(int), length)

    def heat(cross):
        """Free energy of moving both kinds into the fluid of the other; it rises with a_ij."""
        return sum(
            rho[k] * (chain_potential(cross, (m * rho)[into], m[k].astype(int), length[k]) - own[k])
            for k, into in ((i, j), (j, i))
        )

    low, high = np.zeros(len(i)), np.full(len(i), 10 * STRONGEST)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        cold = heat(middle) < 0
        low, high = np.where(cold, middle, low), np.where(cold, high, middle)
    return low / athermal - 1


def measured(data):
    """The share of pairs that are close, and the mean difference."""
    off = data.off.values
    low, high = np.percentile(off, [5, 95])
    pairs = f"{off.size} pairs, nine tenths from {low:.1f} to {high:.1f} %"
    return {
        "athermal_close": Measured(float((np.abs(off) <= CLOSE).mean()), 0.0, pairs),
        "athermal_lower": Measured(float(off.mean()), 0.0, f"median {np.median(off):.1f} %"),
    }


def describe(data):
    """What is seen."""
    return (
        "A histogram with a narrow peak a little below zero, inside the gray band, and a long "
        "tail to negative values."
    )


def draw(data):
    """The histogram."""
    figure, axes = panels(1)
    off = data.off.values
    bins = np.arange(np.floor(off.min()), np.ceil(off.max()) + 0.5, 0.5)
    axes.axvspan(-CLOSE, CLOSE, color="0.9", zorder=0)
    axes.hist(off, bins, weights=np.full(off.size, 100 / off.size), color=BLUE)
    axes.axvline(0, color="0.5", linewidth=0.6)
    axes.set(xlabel="thermal less athermal $a_{ij}$ / %", ylabel="pairs of fluids / %")
    return figure
