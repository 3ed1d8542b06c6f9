"""B2 of two chains: the paper's fit against direct sampling."""

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from dpd.analysis.verdicts import Measured
from dpd.report.style import BLUE, GREEN, RED, panels, points
from dpd.theory.equation_of_state import DELTA, GAMMA, A, second_virial

COLORS = {2: BLUE, 4: GREEN, 8: RED}
MARKERS = {10: "o", 20: "s", 30: "^", 40: "D"}

TITLE = "B2 of two chains by Eqs. 18 to 24 of the paper, less the sampled one."
PAPER_SHOWS = (
    "The paper fits its own samples within 1.6 % on average, and shows the errors in its "
    "supplement. Ours are samples of two chains with rigid bonds; for single beads they give the "
    "closed form, and for dimers what a quadrature gives. (a) As printed. (b) The same form with "
    "constants from a least-squares fit to our samples."
)
ERRORS = "Error bars: 95 % intervals of the samples."


def compute(sweeps):
    """Sampled, by the fit as printed, and by the same form fitted to our samples."""
    data = sweeps["chain_virials"][["sampled", "sampled_error", "fitted"]].stack(
        fluid=("chain", "bond", "repulsion")
    )
    m, l, a = (data[name].values.astype(float) for name in ("chain", "bond", "repulsion"))  # noqa: E741

    def form(constants):
        prefactor, gamma, delta = constants
        factor = prefactor * ((1 - gamma) * m**2 + gamma * m - 1) * l**delta + 1
        return factor * second_virial(m ** (2 / (l + 1) ** 3) * a)

    best = least_squares(lambda c: form(c) / data.sampled.values - 1, (A, GAMMA, DELTA)).x
    data = data.reset_index("fluid")
    ratio = data.fitted / data.sampled
    return xr.Dataset({
        "off": (100 * (ratio - 1)).assign_attrs(units="%"),
        "off_error": (100 * ratio * data.sampled_error / data.sampled).assign_attrs(units="%"),
        "refitted_off": ("fluid", 100 * (form(best) / data.sampled.values - 1), {"units": "%"}),
        "constants": ("constant", best, {"units": "1"}),
    })  # fmt: skip


def measured(data):
    """Mean unsigned error of the fit as printed, and of the same form with our constants."""
    off, error = data.off.values, data.off_error.values
    prefactor, gamma, delta = data.constants.values
    spread = float(np.sqrt((error**2).sum()) / len(error))
    return {
        "virial_fit": Measured(
            float(np.abs(off).mean()), spread, f"{off.min():+.1f} to {off.max():+.1f} %"
        ),
        "virial_form": Measured(
            float(np.abs(data.refitted_off).mean()), spread,
            f"with A = {prefactor:.3f}, gamma = {gamma:.3f}, delta = {delta:.3f}; printed: {A}, "
            f"{GAMMA}, {DELTA}",
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "Left, all points lie 5 to 20 % below zero; right, with constants of our own, they "
        "scatter about it within a few percent."
    )


def draw(data):
    """Errors over bond length, as printed and refitted."""
    figure, axes = panels(2, height=2.5, sharey=True)
    for panel, name in zip(axes, ("off", "refitted_off")):
        for k, m in enumerate(np.unique(data.chain)):
            for j, a in enumerate(np.unique(data.repulsion)):
                at = data.where((data.chain == m) & (data.repulsion == a), drop=True)
                aside = 0.008 * (k - 1) + 0.0015 * (j - 1.5)
                points(panel, at.bond + aside, at[name], at.off_error,
                       f"$m$ = {m}, $a$ = {a}", COLORS[int(m)], MARKERS[int(a)],
                       markersize=2.5)  # fmt: skip
        panel.axhline(0, color="0.5", linewidth=0.6)
        panel.set(xlabel="bond length $l$ / $r_c$")
    axes[0].set(ylabel="fit less sampled $B_2$ / %")
    axes[1].legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, 0.45), handletextpad=0.1,
                   columnspacing=0.6)  # fmt: skip
    return figure
