"""What the radius r_s of the core does to bonds, and its force F_max to the pressure."""

import numpy as np
import pandas as pd

from dpd.analysis.statistics import COVERAGE
from dpd.analysis.structure import excess_pressure
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, RED, panels, points
from dpd.report.text import with_error
from paper_figures.liu_2008.shared import bonds_and_crossings, closest_contact

TITLE = (
    "Core radius r_s (melts of N = 20, F_max 100, C 300); core force F_max (monomers, r_s 0.15)."
)
PAPER_SHOWS = (
    "Not a figure of the paper, which has r_s 0.15 and 0.25 with other C, and F_max 100 alone. (a) "
    "The longest bond l_max of the run, and the closest contact 2 r_0 of monomers of that r_s, at "
    "which bonds rest. In two dimensions none can cross while l_max is below 4 r_0 (dashed). All "
    "begin from one melt of set (1). (b) Excess pressure p - rho kT over that at F_max 100. The "
    "legend has kappa of the parabola p = rho kT + kappa a rho^2, fitted as in Fig. 5, to the "
    "densities above 2 that all F_max have."
)
ERRORS = (
    "(a): 95 % intervals of a median, and of the scatter of blocks' longest bonds. (b): 95 % "
    "intervals from blocks of the run; so are those of kappa, as what a parabola misses is alike."
)
FORCE, RADIUS = 100, 0.15  # of set (1)
COLORS = {50: GREEN, 100: BLUE, 200: RED}
REPULSION, DENSE = 25.0, 2.0  # a, and the density from which on parabolas are fitted


def compute(sweeps):
    """Bonds over r_s; excess pressures and parabolas over F_max."""
    used = ["scene", "excess_conservative", "excess_conservative_error"]
    fluid = sweeps["equation_of_state"][used].sel(r_s=RADIUS, drop=True)
    fluids = [fluid.expand_dims(force=[FORCE]), sweeps["core_forces"][used]]
    data = excess_pressure(fluids, "force")
    data = data.where(data.density > DENSE).dropna("density", subset=["excess"])
    weight = REPULSION * data.density**2
    weight /= (weight**2).sum()
    at, kappa = data.sel(force=FORCE, drop=True), (weight * data.excess).sum("density")
    kappa_error = np.sqrt(((weight * data.excess_error) ** 2).sum("density"))
    ratio = data.excess / at.excess
    ratio_error = np.hypot(data.excess_error, ratio * at.excess_error) / at.excess
    found = {"kappa": kappa, "kappa_error": kappa_error}
    data = data.assign({name: each.assign_attrs(units="r_c^3") for name, each in found.items()})
    found = {"ratio": ratio, "ratio_error": ratio_error}
    data = data.assign({name: each.assign_attrs(units="1") for name, each in found.items()})
    runs, monomers = sweeps["radius"], sweeps["monomers"][["rdf", "beads"]]
    units = {"rest": "r_c", "begun": "1", "exposure": "tau", "melt_kT": "kT", "melt_kT_error": "kT"}
    rows = []
    for radius in runs.r_s.values:
        at, core = runs.sel(r_s=radius), closest_contact(monomers.sel(r_s=radius))
        longest = at.bond_longest.values  # of blocks, which scatter as that of the run does
        lengths = (core.value, core.error, longest.max(), longest.std(ddof=1))
        found = bonds_and_crossings(at)
        rows.append((*lengths, *(found[name] for name in units)))
    names = dict.fromkeys(("contact", "contact_error", "l_max", "l_max_error"), "r_c") | units
    for (name, unit), column in zip(names.items(), np.array(rows, float).T):
        data[name] = ("r_s", column, {"units": unit})
    return data.assign_coords(r_s=("r_s", runs.r_s.values.astype(float), {"units": "r_c"}))


def measured(data):
    """Whether bonds cross where the criterion is met."""
    met = data.isel(r_s=(data.l_max < 2 * data.rest).values)
    count = float(met.begun.sum()) if met.sizes["r_s"] else np.nan
    where = ", ".join(f"{r:g}" for r in met.r_s.values) or "none"
    note = f"r_s {where}; {float(met.exposure.sum()):.3g} bonds times DPD time units"
    return {"criterion_holds": Measured(count, 0.0, note)}


def _kappas(data):
    return ", ".join(
        f"{float(k):.4f} at F_max {f:g}" for f, k in zip(data.force.values, data.kappa)
    )


def table(data):
    """What comes out for each r_s."""
    names = ("r_s", "2 r_0", "4 r_0", "l_max", "4 r_0 > l_max", "crossings", "bonds x time", "kT")
    columns = (
        [f"{r:g}" for r in data.r_s.values],
        [with_error(*each) for each in zip(data.contact.values, data.contact_error.values)],
        [f"{2 * rest:.3f}" for rest in data.rest.values],
        [f"{longest:.3f}" for longest in data.l_max.values],
        ["yes" if met else "no" for met in data.l_max.values < 2 * data.rest.values],
        [f"{count:.0f}" for count in data.begun.values],
        [f"{exposure:.3g}" for exposure in data.exposure.values],
        [with_error(*each) for each in zip(data.melt_kT.values, data.melt_kT_error.values)],
    )
    return pd.DataFrame(dict(zip(names, columns)))


def describe(data):
    """What is seen, in words."""
    (low, high), (first, last) = data.l_max.values[[0, -1]], 2 * data.rest.values[[0, -1]]
    crossed = ", ".join(f"{r:g}" for r in data.r_s.values[data.begun.values > 0])
    return (
        f"Over r_s: l_max goes from {low:.2f} to {high:.2f} r_c, 4 r_0 from {first:.2f} to "
        f"{last:.2f}. Bonds cross at r_s {crossed or 'none'}. kappa is {_kappas(data)}."
    )


def draw(data):
    """Lengths over r_s; pressures over density."""
    figure, (lengths, pressure) = panels(2, height=2.6)
    points(lengths, data.r_s, data.l_max, data.l_max_error, r"$l_{max}$", RED, linestyle="-")
    points(lengths, data.r_s, data.contact, data.contact_error, "$2 r_0$", BLUE, "s", linestyle="-")
    lengths.plot(data.r_s, 2 * data.rest, "--", color=BLACK, label="$4 r_0$")
    lengths.set(ylim=(0, None), xlabel="core radius $r_s$ / $r_c$", ylabel="length / $r_c$")
    lengths.legend(loc="upper left")
    for force in data.force.values:
        at, color = data.sel(force=force), COLORS.get(force, BLACK)
        label = f"{force:g}: {with_error(float(at.kappa), COVERAGE * float(at.kappa_error))}"
        if force == FORCE:
            pressure.axhline(1, color=color, label=label)
        else:
            points(pressure, at.density, at.ratio, at.ratio_error, label, color, linestyle="-")
    pressure.set(xlabel=r"density $\rho$ $r_c^2$",
                 ylabel=f"excess pressure / that at $F_{{max}}$ {FORCE}")  # fmt: skip
    figure.legend(*pressure.get_legend_handles_labels(), loc="outside right center",
                  title=r"$F_{max}$: $\kappa$ / $r_c^3$")  # fmt: skip
    return figure
