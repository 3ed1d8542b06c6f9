"""Figures 8 and S4: composition of two phases beside each other over 1 / chi."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import COVERAGE, block_mean_and_error
from dpd.analysis.verdicts import Measured
from dpd.report.style import panels
from paper_figures.crgw_2019.shared import LOOKS

MIXTURES = {
    "Vh1 and Vo2": ("vh1_vo2_slabs", 1),
    "Vh2 and Vo2": ("vh2_vo2_slabs", 2),
    "Vh1 and Vh2": ("vh1_vh2_slabs", 1),
}  # name, and beads of the first component; fmt: skip
BEADS_OF_OTHER = 2
BULK = 0.15  # of the box on either side of the middle of a slab

TITLE = "Mole fractions of coexisting phases over 1 / chi, for three equations of state."
PAPER_SHOWS = (
    "The paper starts from both pure fluids in two boxes that exchange molecules; here they lie "
    "beside each other as slabs in one long box, at the pressure 41.89 across the interfaces. It "
    "finds that crGW mixes at a much larger 1 / chi than the others, and that only with crGW both "
    "mixtures are alike; of Vh1 and Vh2, in its supplement, it says that the equations do not "
    "differ much. No number is printed. Hollow points are of runs that are too short for an error."
)


def compute(sweeps):
    """Mole fractions in both bulks."""
    parts = [
        _compositions(sweeps[name], beads).expand_dims(mixture=[label])
        for label, (name, beads) in MIXTURES.items()
    ]
    return xr.concat(parts, "mixture")


def _compositions(runs, beads):
    """Mole fraction of A in the phase rich in A and in the one poor in A."""
    profile = runs.density_profile.transpose(
        "equation", "inverse_chi", "replica", "block", "species", "z"
    ).values[:, :, 0]
    names = [str(name) for name in runs.species.values.ravel()[: runs.sizes["species"]]]
    a, b = (
        profile[..., names.index("A"), :] / beads,
        profile[..., names.index("B"), :] / BEADS_OF_OTHER,
    )
    shape = profile.shape[:2]
    found = np.empty((2, 2, *shape))  # mean and error, rich and poor
    for place in np.ndindex(shape):
        for k, bulk in enumerate(_bulks((a[place] / (a[place] + b[place])).mean(axis=0))):
            fraction = a[place][:, bulk].sum(axis=1) / (a[place] + b[place])[:, bulk].sum(axis=1)
            found[(slice(None), k, *place)] = block_mean_and_error(fraction)
    along = ("phase", "equation", "inverse_chi")
    return xr.Dataset(
        {"fraction": (along, found[0], {"units": "1"}), "error": (along, found[1], {"units": "1"})},
        {"phase": ["rich", "poor"], "equation": runs.equation, "inverse_chi": runs.inverse_chi},
    )


def _bulks(fraction):
    """Slices about the middles of both slabs, which half a box lies between."""
    count = len(fraction)
    place = np.arange(count)
    wave = (fraction * np.exp(2j * np.pi * place / count)).sum()
    middle = np.angle(wave) / (2 * np.pi) * count
    reach = max(1.0, BULK * count)
    for at in (middle, middle + count / 2):
        away = np.abs((place - at + count / 2) % count - count / 2)
        yield away <= reach


def measured(data):
    """How much further apart the phases of crGW are, whether mixtures and equations are alike."""
    gap = data.fraction.sel(phase="rich") - data.fraction.sel(phase="poor")
    error = np.sqrt((data.error**2).sum("phase", skipna=False))
    most = gap.inverse_chi.values[-1]
    gap, error = gap.sel(inverse_chi=most), error.sel(inverse_chi=most)
    found = {}
    for label, name in (("Vh1 and Vo2", "wider_vh1_vo2"), ("Vh2 and Vo2", "wider_vh2_vo2")):
        at, spread = gap.sel(mixture=label), error.sel(mixture=label)
        other = max(
            ("rGW", "GW"), key=lambda e: float(at.sel(equation=e)) if e in at.equation else -1
        )
        found[name] = Measured(
            float(at.sel(equation="crGW") - at.sel(equation=other)),
            float(np.hypot(spread.sel(equation="crGW"), spread.sel(equation=other))),
            f"at 1 / chi = {float(most):g}: {float(at.sel(equation='crGW')):.2f} against "
            f"{float(at.sel(equation=other)):.2f} of {other}",
        )  # fmt: skip
    ours, spread = (part.sel(equation="crGW").values[:2] for part in (gap, error))
    found["alike"] = Measured(
        float(ours[0] - ours[1]), float(np.hypot(*spread)),
        f"difference of the mole fractions, {float(ours[0]):.2f} and {float(ours[1]):.2f}, at "
        f"1 / chi = {float(most):g}",
    )  # fmt: skip
    same = gap.sel(mixture="Vh1 and Vh2")
    low, high = (same.isel(equation=int(place(same.values))) for place in (np.argmin, np.argmax))
    ends = error.sel(mixture="Vh1 and Vh2", equation=[low.equation.item(), high.equation.item()])
    found["same_volume"] = Measured(
        float(high - low), float(np.hypot(*ends.values)),
        f"{float(high):.2f} by {high.equation.item()} less {float(low):.2f} by "
        f"{low.equation.item()}, at 1 / chi = {float(most):g}",
    )  # fmt: skip
    return found


def describe(data):
    """What is seen."""
    return (
        "Three panels, one a mixture: pairs of branches that approach each other as 1 / chi grows, "
        "for three equations."
    )


def draw(data):
    """A panel for each mixture."""
    figure, axes = panels(3, height=2.6, sharey=True)
    for panel, label in zip(axes, MIXTURES):
        for name in data.equation.values:
            look, at = LOOKS[str(name)], data.sel(mixture=label, equation=name)
            for k, phase in enumerate(("rich", "poor")):
                one = at.sel(phase=phase).dropna("inverse_chi", subset=["fraction"])
                panel.plot(one.fraction, one.inverse_chi, color=look.color, linewidth=0.7)
                known = np.isfinite(one.error.values)
                for seen, face in ((known, look.color), (~known, "white")):
                    entry = look.label if k == 0 and face != "white" else None
                    panel.errorbar(
                        one.fraction[seen], one.inverse_chi[seen], xerr=COVERAGE * one.error[seen],
                        fmt=look.marker, color=look.color, markerfacecolor=face, markersize=3.5,
                        elinewidth=0.7, capsize=1.5, label=entry,
                    )  # fmt: skip
        panel.set(xlim=(-0.03, 1.03), xlabel=f"{label.split()[0]} in {label}, mole fraction")
    axes[0].set(ylabel=r"$1 / \chi$")
    axes[0].legend(loc="best")
    return figure
