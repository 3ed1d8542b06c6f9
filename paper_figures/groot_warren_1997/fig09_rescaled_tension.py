"""Figure 9: rescaled surface tension of chains against 1 / (chi N)."""

from itertools import cycle

import numpy as np

from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, panels, points, published_line
from dpd.report.text import with_error
from paper_figures.groot_warren_1997.tension_laws import collapse
from paper_figures.groot_warren_1997.tensions import (
    GROUPS,
    NOT_SETTLED,
    OUTSIDE,
    VAN_DER_WAALS,
    draw_dimers,
    fit_in_words,
    longer_in_words,
    off_the_law,
    put_law,
    tensions_of_chains,
    two_legends,
    without_dimers,
)

PUBLISHED = shown_by(__file__)
SLOPE, CRITICAL = PUBLISHED["chain_slope"], PUBLISHED["tension_critical"]
EXPONENT, FIXED = PUBLISHED["tension_exponent"], PUBLISHED["tension_exponent_fixed"]
REFERENCE = 5.0  # the Delta a that all others are brought to
LEAST = 6  # settled runs for a fit

TITLE = "Rescaled surface tension of chains against 1 / (chi N) (rho = 3, C = 2)."
PAPER_SHOWS = (
    "For each Delta a, and so each chi = "
    f"{SLOPE.value:g} Delta a, the paper changes N, and multiplies all tensions by one factor, so "
    f"that they lie on those of Delta a = {REFERENCE:g}. It fits k (1 - chi_crit / (chi N))^mu: "
    f"chi_crit = {CRITICAL}, mu = {EXPONENT}; with chi_crit = 2, mu = {FIXED}. Dashed: its Eq. 33. "
    "Here all factors, chi_crit and mu are fitted at once, and again without dimers, N = 2, which "
    "have a dot. The factors shown are those of all chains and chi_crit = 2. chi is taken from the "
    "paper's slope of Figure 8; with our own it is smaller, and chi_crit too, in proportion. "
    f"Tensions come from the pressure tensor of the box. {NOT_SETTLED}, {OUTSIDE}."
)
SHAPES = {"free": {}, "fixed": {"critical": VAN_DER_WAALS["critical"]}}


def compute(sweeps):
    """Tensions, brought to one curve, and the shape of that curve."""
    data = tensions_of_chains(sweeps["tension"], SLOPE.value)
    longer = without_dimers(data)
    for name, held in SHAPES.items():
        found = _collapsed(data, **held)
        put_law(data, name, found)
        put_law(data, f"longer_{name}", _collapsed(longer, **held))
    height = np.array([part.value for part in found.prefactors])
    reference = int(np.abs(data.excess.values.astype(float) - REFERENCE).argmin())
    factor = height[reference] / height
    data["factor"] = (
        "excess",
        factor,
        {"units": "1", "long_name": "that tensions are rescaled by"},
    )
    data["height"] = ((), height[reference], {"units": "1", "long_name": "k at the reference"})
    data["reference_chi"] = ((), float(data.chi[reference].max()), {"units": "1"})
    for name in ("scaled", "scaled_error"):
        said = f"{data[name].long_name}, rescaled"
        data[f"re{name}"] = (data.factor * data[name]).assign_attrs(units="1", long_name=said)
    return data


def _collapsed(data, **held):
    """The fit of `paper_figures.groot_warren_1997.tension_laws.collapse` to runs of all Delta a."""
    group, _ = np.indices(data.scaled.shape)
    use = data.fitted.values
    columns = (data[name].values[use] for name in ("segregation", "scaled", "scaled_error"))
    return collapse(group[use], *columns, groups=data.sizes["excess"], **held)


def measured(data):
    """The critical point and the exponents."""
    few = "" if int(data.fitted.sum()) >= LEAST else f"fewer than {LEAST} settled runs"

    def of(name, part):
        value, error = float(data[f"{name}_{part}"]), float(data[f"{name}_{part}_error"])
        note = f"{fit_in_words(data, name)}; {longer_in_words(data, name, part)}"
        if few or error < value / COVERAGE:
            return Measured(value, error, note, few or off_the_law(data, name))
        reason = f"the runs do not fix it: {with_error(value, error)}"
        return Measured(np.nan, np.nan, note, reason)

    return {
        "tension_critical": of("free", "critical"),
        "tension_exponent": of("free", "mu"),
        "tension_exponent_fixed": of("fixed", "mu"),
    }


def describe(data):
    """What is seen."""
    scatter = "more than" if off_the_law(data, "fixed") else "no more than"
    return (
        "Rescaled tensions lie close to one curve, which falls from the left, where chains are "
        f"long, to zero near 1 / (chi N) = 1/2. They scatter about it {scatter} their errors "
        f"allow. The fitted curve, of exponent {float(data.fixed_mu):.2f}, lies near the dashed "
        "one of Eq. 33."
    )


def draw(data):
    """Rescaled tensions over 1 / (chi N), the paper's axes."""
    figure, axes = panels(1)
    for (color, marker), excess in zip(cycle(GROUPS), data.excess.values):
        at = data.sel(excess=excess)
        for fitted in (True, False):
            use = at.fitted.values == fitted
            label = rf"$\Delta a$ = {excess:g}" if fitted else None
            points(axes, 1 / at.segregation[use], at.rescaled[use], at.rescaled_error[use], label,
                   color, marker, fitted)  # fmt: skip
    two = data.beads.values == 2
    draw_dimers(axes, 1 / data.segregation.values[two], data.rescaled.values[two])
    x = np.linspace(1e-3, 0.5, 200)
    mu, error = float(data.fixed_mu), float(data.fixed_mu_error)
    if np.isfinite(mu):
        label = (
            rf"fit, $\chi_\mathrm{{crit}}$ = 2: $\mu$ = {mu:.2f} ± {COVERAGE * error:.2f} (95 %)"
        )
        axes.plot(x, float(data.height) * (1 - 2 * x) ** mu, color=BLACK, lw=0.8, label=label)
    at = float(data.reference_chi)
    eq_33 = PUBLISHED["master_prefactor"].value * at**0.4 * (1 - 2 * x) ** 1.5
    published_line(axes, x, eq_33, "published, Eq. 33")
    axes.axhline(0, color=BLACK, lw=0.5)
    axes.set(xlim=(0, 0.6), ylim=(-0.03, None), xlabel=r"$1 / (\chi N)$",
             ylabel=r"rescaled $\sigma / (\rho k_BT r_c)$")  # fmt: skip
    two_legends(axes, "upper right", "center right")
    return figure
