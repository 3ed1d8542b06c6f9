"""Figure 6: mixtures with a larger molecule, Vo2, of Vh1 and of Vh2."""

import xarray as xr

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import panels
from paper_figures.crgw_2019.mixtures import EXCESSES, draw_mixture, mixture, most

PAIRS = {"Vh1": ("vh1", "vo2"), "Vh2": ("vh2", "vo2")}
BOUND = shown_by(__file__)["nvt_crgw"].high  # percent; the text gives it for Figure 5

TITLE = "Mixtures of Vo2, dimers of a larger molecule, with Vh1 (left) and with Vh2 (right)."
PAPER_SHOWS = (
    "(a) and (b) Pressure at constant volume, less the 41.89 that was asked for, with the band of "
    "Figure 5 (gray). (c) to (h) Excess enthalpy, energy and volume at constant pressure, "
    "relative to ideal mixing. The paper finds small deviations that are alike for both mixtures "
    "with crGW, and the wrong pressure with the others."
)


def compute(sweeps):
    """Both mixtures over the mole fraction of the first component."""
    parts = [mixture(sweeps, *pair).expand_dims(with_vo2=[name]) for name, pair in PAIRS.items()]
    return xr.concat(parts, "with_vo2")


def measured(data):
    """Largest errors of the pressure."""
    found = {}
    for name in PAIRS:
        at = data.sel(with_vo2=name)
        others = max(most(at, "pressure_off", equation) for equation in ("rGW", "GW"))
        value, error = most(at, "pressure_off", "crGW")
        found[f"nvt_crgw_{name.lower()}_vo2"] = Measured(
            value, error, f"{others[0]:.1f} % for the worse of rGW and GW"
        )
    return found


def describe(data):
    """What is seen."""
    return (
        "Two columns of four panels over the mole fraction. On top the pressure of crGW lies near "
        "zero, the others below; excess properties are curves that are small and alike."
    )


def draw(data):
    """A column a mixture."""
    figure, axes = panels(2, rows=4, height=1.6, sharex=True)
    rows = {"pressure_off": "pressure off / %"} | EXCESSES
    for column, name in enumerate(PAIRS):
        at = data.sel(with_vo2=name)
        for row, (quantity, label) in enumerate(rows.items()):
            draw_mixture(axes[row, column], at, quantity, label if column == 0 else "")
        axes[0, column].axhspan(-BOUND, BOUND, color="0.93", zorder=0)
        axes[-1, column].set(xlabel=f"mole fraction of {name}")
    axes[0, 1].legend(loc="center", ncols=3, bbox_to_anchor=(0.5, 0.5))
    return figure
