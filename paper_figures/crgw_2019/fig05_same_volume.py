"""Figure 5: a fluid of beads and one of dimers of the same volume, Vh1 and Vh2."""

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import panels
from paper_figures.crgw_2019.mixtures import EXCESSES, draw_mixture, mixture, most

PUBLISHED = shown_by(__file__)

TITLE = "Mixtures of Vh1 and Vh2, single beads and dimers that stand for the same molecule."
PAPER_SHOWS = (
    "Repulsions are those of Table I. (a) Pressure at constant volume, less the 41.89 that was "
    f"asked for: the paper finds up to {PUBLISHED['nvt_crgw'].high:g} % for crGW (gray), and up "
    f"to {PUBLISHED['nvt_others'].value:g} % for the others. (b) to (d) Excess enthalpy, energy "
    "and volume at constant pressure, relative to ideal mixing; the paper finds them small for "
    "all equations. Energies are those of pairs and bonds."
)


def compute(sweeps):
    """Everything over the mole fraction."""
    return mixture(sweeps, "vh1", "vh2")


def measured(data):
    """Largest errors of the pressure, and largest excess volume."""
    ours, error = most(data, "pressure_off", "crGW")
    others = [most(data, "pressure_off", name) for name in ("rGW", "GW")]
    worst, worst_error = max(others)
    volume, volume_error = most(data, "volume", "crGW")
    return {
        "nvt_crgw": Measured(ours, error, "over all mole fractions of Vh1 and Vh2"),
        "nvt_others": Measured(
            worst, worst_error, f"rGW {others[0][0]:.1f} %, GW {others[1][0]:.1f} %"
        ),
        "excess_volume": Measured(volume, volume_error, "largest of crGW, Vh1 and Vh2"),
    }


def describe(data):
    """What is seen."""
    return (
        "Pressures of crGW lie near zero at all mole fractions; those of the other equations fall "
        "to minus several percent where dimers prevail. Excess properties are small."
    )


def draw(data):
    """Pressure and three excess properties."""
    figure, axes = panels(2, rows=2, height=2.2, sharex=True)
    draw_mixture(axes[0, 0], data, "pressure_off", "pressure off / %")
    for panel, (name, label) in zip((axes[0, 1], axes[1, 0], axes[1, 1]), EXCESSES.items()):
        draw_mixture(panel, data, name, label)
    bound = PUBLISHED["nvt_crgw"].high
    axes[0, 0].axhspan(-bound, bound, color="0.93", zorder=0)
    axes[0, 0].legend(loc="lower right")
    for panel in axes[1]:
        panel.set(xlabel="mole fraction of Vh1")
    return figure
