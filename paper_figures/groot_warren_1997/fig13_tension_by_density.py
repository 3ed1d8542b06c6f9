"""Figure 13: surface tension of single beads at two densities, and its critical point."""

from dataclasses import replace

import numpy as np
import xarray as xr

from dpd.analysis.interfaces import sweep_chi
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import shown_by
from dpd.report.style import BLACK, panels, points, published_line
from paper_figures.groot_warren_1997.shared import SEGREGATION, monomer_slope
from paper_figures.groot_warren_1997.tensions import (
    NOT_SETTLED,
    SCALED,
    curve,
    law_of,
    measured_part,
    put_law,
    scaled_tensions,
    with_slope,
)

PUBLISHED = shown_by(__file__)
ALPHA, CRITICAL = PUBLISHED["monomer_alpha"], PUBLISHED["monomer_critical"]
HEIGHT = PUBLISHED["monomer_height"]
ISING_ALPHA, ISING_CRITICAL = (
    PUBLISHED["monomer_alpha_ising"], PUBLISHED["monomer_critical_ising"],
)  # fmt: skip
ISING = PUBLISHED["tension_exponent"].rival  # the exponent of the Ising model
LAWS = {"classical": {"mu": 1.5}, "ising": {"mu": ISING}}

TITLE = "Surface tension of single beads at both densities against chi."
PAPER_SHOWS = (
    "The paper shows the tension at rho 3 and 5, chi from Delta a by Eq. 24, and fits "
    "sigma / (rho kT r_c) = k chi^alpha (1 - chi_crit / chi)^mu, here to both densities: "
    f"with the classical mu = 1.5, k = {HEIGHT}, alpha = {ALPHA} and chi_crit = {CRITICAL} "
    f"(Eq. 36, dashed); with that of the Ising model, {ISING:g}, alpha = {ISING_ALPHA} and "
    f"chi_crit = {ISING_CRITICAL}. "
    "Tensions come from the runs of Figure 7, whose own slopes would differ a little from those of "
    f"Eq. 24 and bring the points of both densities closer to one curve. {NOT_SETTLED}."
)


def compute(sweeps):
    """Tensions at both densities, and the law with both exponents."""
    parts = [
        scaled_tensions(sweeps[runs.sweep], PUBLISHED[runs.slope].value)
        for runs in SEGREGATION.values()
    ]
    laws = {name: law_of(parts, **held) for name, held in LAWS.items()}
    slopes = [own_slope(sweeps[runs.sweep]) for runs in SEGREGATION.values()]
    own = [with_slope(part, slope) for part, slope in zip(parts, slopes)]
    laws["own"] = law_of(own, **LAWS["classical"])
    alone = {rho: law_of([part], **LAWS["classical"]) for rho, part in zip(SEGREGATION, parts)}
    rows = [part.drop_vars("density").expand_dims(rho=[rho])
            for rho, part in zip(SEGREGATION, parts)]  # fmt: skip
    data = xr.concat(rows, "rho", join="outer", fill_value={"fitted": False})
    for name, law in laws.items():
        put_law(data, name, law)
    for rho, law in alone.items():
        put_law(data, f"classical_{rho}", law)
    return data


def own_slope(runs):
    """chi / Delta a of these runs, as in Figure 7; NaN where none is good enough."""
    _, fit = monomer_slope(sweep_chi(runs, "excess"))
    return np.nan if fit is None else float(fit.values[0])


def measured(data):
    """Both laws."""
    each = ", ".join(
        f"{float(data[f'classical_{rho}_critical']):.2f} +- "
        f"{float(data[f'classical_{rho}_critical_error']):.2f} at rho {rho}"
        for rho in SEGREGATION
    )
    critical = measured_part(data, "classical", "critical")
    own, error, quality = (
        float(data[f"own_{name}"]) for name in ("critical", "critical_error", "reduced_chi_square")
    )
    by_own = f"with our own slopes of Figure 7 {own:.2f} +- {error:.2f}, chi-square {quality:.2f}"
    return {
        "monomer_height": measured_part(data, "classical", "prefactor"),
        "monomer_alpha": measured_part(data, "classical", "alpha"),
        "monomer_critical": replace(critical, note=f"{critical.note}; alone {each}; {by_own}"),
        "monomer_alpha_ising": measured_part(data, "ising", "alpha"),
        "monomer_critical_ising": measured_part(data, "ising", "critical"),
    }


def describe(data):
    """What is seen."""
    return (
        "Tensions of both densities rise with chi nearly on one curve, from zero near "
        f"{float(data.classical_critical):.2f} with the exponent 1.5, or near "
        f"{float(data.ising_critical):.2f} with {ISING:g}; the two fits hardly differ, and the "
        "dashed Eq. 36 lies beside them."
    )


def draw(data):
    """Tension over chi of both densities."""
    figure, axes = panels(1)
    for rho, runs in SEGREGATION.items():
        name, color, marker = runs.look
        at = data.sel(rho=rho).dropna("excess", subset=["scaled"])
        for fitted in (True, False):
            part = at.isel(excess=at.fitted.values == fitted)
            points(axes, part.chi, part.scaled, part.scaled_error, name if fitted else None, color,
                   marker, fitted)  # fmt: skip
    x = np.linspace(2, 1.05 * float(data.chi.max()), 300)
    for name, style in (("classical", "-"), ("ising", ":")):
        critical, error = (float(data[f"{name}_critical{part}"]) for part in ("", "_error"))
        if np.isfinite(error):
            mu = LAWS[name]["mu"]
            text = rf"fit, $\mu$ = {mu:g}: $\chi_\mathrm{{crit}}$ = {critical:.2f} ± "
            text += f"{COVERAGE * error:.2f}"
            axes.plot(x, curve(data, name, x), color=BLACK, lw=0.8, ls=style, label=text)
    eq_36 = HEIGHT.value * x**ALPHA.value * np.maximum(1 - CRITICAL.value / x, 0) ** 1.5
    published_line(axes, x, eq_36, "published, Eq. 36")
    axes.set(xlim=(2, x[-1]), ylim=(0, None), xlabel=r"$\chi$ from $\Delta a$ by Eq. 24",
             ylabel=SCALED)  # fmt: skip
    axes.legend(loc="upper left")
    return figure
