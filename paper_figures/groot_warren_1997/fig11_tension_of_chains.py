"""Figure 11: the master curve of the tension of chains."""

import numpy as np

from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import shown_by
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels, points, published_line
from paper_figures.groot_warren_1997.interface_theory import (
    BROSETA,
    HELFAND,
    finite_length,
    tension_of_long_chains,
)
from paper_figures.groot_warren_1997.tensions import (
    NOT_SETTLED,
    OUTSIDE,
    VAN_DER_WAALS,
    draw_dimers,
    law_of,
    longer_in_words,
    measured_part,
    off_the_law,
    put_law,
    runs_of_chains,
    without_dimers,
)

PUBLISHED = shown_by(__file__)
SLOPE, PREFACTOR = PUBLISHED["chain_slope"], PUBLISHED["master_prefactor"]
ALPHA = 0.4  # of Eq. 33
SWEEPS = {"tension": ("several $N$ for each $\\Delta a$", BLUE, "o"),
          "chains": ("runs of Fig. 8", RED, "s")}  # fmt: skip

TITLE = "Master curve of the surface tension of chains (rho = 3, C = 2)."
PAPER_SHOWS = (
    "The paper shows sigma / (rho kT chi^0.4) against 1 / (chi N), and Eq. 33, sigma = "
    f"({PREFACTOR}) rho kT r_c chi^0.4 [1 - 2 / (chi N)]^(3/2) (dashed). It adds experiments on "
    "PS/PMMA that are rescaled in both directions; we leave them out. The runs of Figure 8 have "
    "another Delta a for each N, and chi N is 4 in all of them: they lie on one point of the same "
    "curve if there is one. Dimers, N = 2, have a dot. Dotted: mean field for "
    "long chains, rho b (chi / 6)^(1/2) [1 - k / (chi N)], k = pi^2 / 6 (Broseta et al.) and "
    "2 ln 2 (Helfand et al.), with b from the size of our chains and at the middle chi. "
    f"{NOT_SETTLED}, {OUTSIDE}."
)


def compute(sweeps):
    """Scaled tensions of both sweeps, the fit of Eq. 33's prefactor, and mean field."""
    data = runs_of_chains({name: sweeps[name] for name in SWEEPS}, SLOPE.value)
    shape = {"alpha": ALPHA, **VAN_DER_WAALS}
    put_law(data, "master", law_of([data], **shape))
    put_law(data, "longer_master", law_of([without_dimers(data)], **shape))
    data["middle_chi"] = ((), float(np.exp(np.log(data.chi).mean())), {"units": "1"})
    ends = sweeps["tension"].end_to_end_square
    ends = ends.mean([name for name in ends.dims if name not in ("excess", "length")])
    bonds = ends.length.astype(float) - 1
    segment = np.sqrt(ends / bonds).isel(length=-1).mean()
    data["segment"] = ((), float(segment), {"units": "r_c", "long_name": "b, of the largest N"})
    return data


def measured(data):
    """The prefactor of Eq. 33."""
    longer = longer_in_words(data, "master", "prefactor")
    return {"master_prefactor": measured_part(data, "master", "prefactor", longer)}


def describe(data):
    """What is seen."""
    scatter = "more than" if off_the_law(data, "master") else "no more than"
    return (
        "Scaled tensions of chains of all lengths and repulsions lie close to one curve of "
        f"1 / (chi N), {float(data.master_prefactor):.3f} [1 - 2 / (chi N)]^(3/2), beside the "
        f"dashed published one, and scatter about it {scatter} their errors allow. Both mean-field "
        "curves start below it on the left and fall in flatter straight lines."
    )


def draw(data):
    """Tension over rho kT chi^0.4, the paper's axes."""
    figure, axes = panels(1)
    scale = data.chi.values**ALPHA
    for name, (label, color, marker) in SWEEPS.items():
        for fitted in (True, False):
            use = ((data.sweep == name) & (data.fitted == fitted)).values
            points(axes, 1 / data.segregation[use], data.scaled[use] / scale[use],
                   data.scaled_error[use] / scale[use], label if fitted else None, color, marker,
                   fitted)  # fmt: skip
    two = (data.beads == 2).values
    draw_dimers(axes, 1 / data.segregation[two], data.scaled[two] / scale[two])
    x = np.linspace(1e-3, 0.5, 200)
    shape = (1 - VAN_DER_WAALS["critical"] * x) ** VAN_DER_WAALS["mu"]
    k, error = float(data.master_prefactor), float(data.master_prefactor_error)
    if np.isfinite(k):
        axes.plot(
            x, k * shape, color=BLUE, lw=0.8, label=f"fit: {k:.3f} ± {COVERAGE * error:.3f} (95 %)"
        )
    published_line(axes, x, PREFACTOR.value * shape, f"published, Eq. 33: {PREFACTOR}")
    chi, segment = float(data.middle_chi), float(data.segment)
    for k, color, name in ((BROSETA, GREEN, "Broseta et al."), (HELFAND, ORANGE, "Helfand et al.")):
        mean_field = (
            tension_of_long_chains(chi, 1.0, segment) / chi**ALPHA * finite_length(1 / x, k)
        )
        axes.plot(x, mean_field, color=color, ls=":", lw=1.2, label=f"mean field, {name}")
    axes.axhline(0, color=BLACK, lw=0.5)
    axes.set(xlim=(0, 0.6), ylim=(-0.03, 1.0), xlabel=r"$1 / (\chi N)$",
             ylabel=r"$\sigma / (\rho k_BT r_c \chi^{0.4})$")  # fmt: skip
    axes.legend(loc="upper right")
    return figure
