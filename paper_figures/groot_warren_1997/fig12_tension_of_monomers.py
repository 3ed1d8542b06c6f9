"""Figure 12: surface tension of single beads against chi."""

import numpy as np

from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import shown_by
from dpd.report.style import BLACK, BLUE, RED, panels, points, published_line
from paper_figures.groot_warren_1997.shared import SEGREGATION
from paper_figures.groot_warren_1997.tensions import (
    NOT_SETTLED,
    SCALED,
    VAN_DER_WAALS,
    curve,
    law_of,
    measured_part,
    put_law,
    scaled_tensions,
)

PUBLISHED = shown_by(__file__)
PREFACTOR, OF_CHAINS = PUBLISHED["monomer_prefactor"], PUBLISHED["master_prefactor"]
CRITICAL, ALPHA = PUBLISHED["monomer_critical"], PUBLISHED["monomer_alpha"]
HEIGHT = PUBLISHED["monomer_height"]
LAWS = {
    "chains": {"alpha": 0.4} | VAN_DER_WAALS,
    "classical": {"mu": VAN_DER_WAALS["mu"]},
}

TITLE = "Surface tension of single beads against chi (rho = 3, a = 25)."
PAPER_SHOWS = (
    "The paper shows the tension of single beads, from the runs of its Figure 7 with chi of "
    "Delta a by Eq. 24. The law of chains, Eq. 33, needs another prefactor, "
    f"{PREFACTOR} in place of {OF_CHAINS} (dotted), and vanishes at a smaller chi than the tension "
    "does. The paper does not say which densities that is fitted to; we take this one. "
    f"Eq. 36 (dashed), with the critical point {CRITICAL}, describes it. Lines: our fits. "
    f"{NOT_SETTLED}."
)


def compute(sweeps):
    """Tensions of the runs of Figure 7 at density 3, and two laws."""
    runs = SEGREGATION[3]
    data = scaled_tensions(sweeps[runs.sweep], PUBLISHED[runs.slope].value)
    for name, held in LAWS.items():
        put_law(data, name, law_of([data], **held))
    return data


def measured(data):
    """The prefactor of the law of chains."""
    return {"monomer_prefactor": measured_part(data, "chains", "prefactor")}


def describe(data):
    """What is seen."""
    return (
        "The tension of single beads rises with chi from zero near "
        f"{float(data.classical_critical):.1f}. The law of chains, which begins at 2, is too high "
        "close to the critical point; the law with a critical point of its own follows the points "
        "and the dashed Eq. 36."
    )


def draw(data):
    """Tension over chi."""
    figure, axes = panels(1)
    for fitted in (True, False):
        at = data.isel(excess=data.fitted.values == fitted)
        points(axes, at.chi, at.scaled, at.scaled_error, "this work" if fitted else None, BLUE,
               "o", fitted)  # fmt: skip
    x = np.linspace(2, 1.05 * float(data.chi.max()), 300)
    k, error = (float(data[f"chains_prefactor{part}"]) for part in ("", "_error"))
    critical, error_of = (float(data[f"classical_critical{part}"]) for part in ("", "_error"))
    if np.isfinite(k):
        axes.plot(x, curve(data, "chains", x), color=RED, lw=0.8, ls="-.",
                  label=f"Eq. 33 with prefactor {k:.3f} ± {COVERAGE * error:.3f}")  # fmt: skip
    if np.isfinite(error_of):
        text = rf"fit: $\chi_\mathrm{{crit}}$ = {critical:.2f} ± {COVERAGE * error_of:.2f}"
        axes.plot(x, curve(data, "classical", x), color=BLUE, lw=0.8, label=text)
    eq_36 = HEIGHT.value * x**ALPHA.value * np.maximum(1 - CRITICAL.value / x, 0) ** 1.5
    published_line(axes, x, eq_36, "published, Eq. 36")
    chains = LAWS["chains"]
    of_chains = (
        PREFACTOR.value * x ** chains["alpha"]
        * np.maximum(1 - chains["critical"] / x, 0) ** chains["mu"]
    )  # fmt: skip
    axes.plot(x, of_chains, color=BLACK, lw=0.8, ls=":", label="published, with Eq. 33")
    axes.set(xlim=(2, x[-1]), ylim=(0, None), xlabel=r"$\chi$ from $\Delta a$ by Eq. 24",
             ylabel=SCALED)  # fmt: skip
    axes.legend(loc="upper left")
    return figure
