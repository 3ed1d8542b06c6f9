"""Figure 7: chi from the composition of coexisting phases against excess repulsion."""

import numpy as np
import xarray as xr

from dpd.analysis.interfaces import sweep_chi
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, panels, points, published_line
from paper_figures.groot_warren_1997.shared import (
    MEAN_FIELD,
    NOT_FITTED,
    SEGREGATION,
    misfit,
    monomer_slope,
)

PUBLISHED = shown_by(__file__)
SLOPES = {rho: PUBLISHED[runs.slope] for rho, runs in SEGREGATION.items()}

TITLE = "chi against excess repulsion Delta a = a_AB - a for monomers."
PAPER_SHOWS = (
    "The paper shows chi by Eq. 18 from the minority fraction in the bulk of both phases at rho 3 "
    "(a 25) and rho 5 (a 15), and fits chi = s Delta a through the origin where chi > 3: s = "
    f"{SLOPES[3]} and {SLOPES[5]} (dashed). Open points are not fitted: chi is below 3, "
    f"{NOT_FITTED} The bulk of a phase is taken from the positions that the interfaces have in "
    "each block of the run."
)


def compute(sweeps):
    """chi over excess repulsion for both densities, and the fitted slopes."""
    parts = []
    for rho, runs in SEGREGATION.items():
        data = sweep_chi(sweeps[runs.sweep], "excess")
        fitted, fit = monomer_slope(data)
        data["fitted"] = ("excess", fitted)
        slope, error, quality, degrees = np.nan, np.nan, np.nan, 0
        intercept, intercept_error = np.nan, np.nan
        farther, farther_error, p_value = np.nan, np.nan, np.nan
        if fit:
            (slope,), (error,), quality, degrees = fit
            p_value = fit.p_value
        if fitted.sum() >= 3:
            first = data.excess.values[fitted][0]
            _, beyond = monomer_slope(data.isel(excess=data.excess.values > first))
            (farther,), (farther_error,) = beyond.values, beyond.errors
            x = data.excess.values.astype(float)[fitted]
            terms = [x, np.ones_like(x)]
            free = linear_fit(terms, data.chi.values[fitted], data.chi_error.values[fitted])
            (_, intercept), (_, intercept_error) = free.values, free.errors
        data["slope"] = ((), slope, {"units": "r_c / kT", "long_name": "chi / Delta a, chi > 3"})
        data["slope_error"] = ((), error, {"units": "r_c / kT", "long_name": "standard error"})
        data["intercept"] = ((), intercept, {"units": "1", "long_name": "of a line with one"})
        data["intercept_error"] = ((), intercept_error, {"units": "1"})
        data["reduced_chi_square"] = ((), quality, {"units": "1"})
        data["p_value"] = ((), p_value, {"units": "1"})
        data["slope_beyond"] = (
            (),
            farther,
            {"units": "r_c / kT", "long_name": "first point left out"},
        )
        data["slope_beyond_error"] = ((), farther_error, {"units": "r_c / kT"})
        data["degrees"] = ((), degrees, {"units": "1"})
        parts.append(data.expand_dims(density=[rho]))
    data = xr.concat(parts, "density", join="outer", fill_value={"fitted": False})
    return data


def measured(data):
    """Both slopes of Eq. 24."""
    found = {}
    for rho in SEGREGATION:
        at = data.sel(density=rho)
        count = int(at.fitted.sum())
        quality, p = float(at.reduced_chi_square), float(at.p_value)
        why = misfit(p, "a straight line through the origin", "its slope depends")
        if count < 2:
            why = "fewer than two settled points with chi > 3"
        note = f"{count} settled points with chi > 3, reduced chi-square {quality:.2f}"
        if count >= 3:
            note += (
                f"; a line not through the origin has the intercept {float(at.intercept):.2f} +- "
                f"{float(at.intercept_error):.2f}; without the point nearest to chi = 3 the slope "
                f"is {float(at.slope_beyond):.4f} +- {float(at.slope_beyond_error):.4f}"
            )
        found[f"chi_slope_rho_{rho}"] = Measured(
            float(at.slope),
            float(at.slope_error),
            note,
            why,
        )
    return found


def describe(data):
    """What is seen."""
    each = " and ".join(
        f"{float(data.slope.sel(density=rho)):.3f} at density {rho}" for rho in SEGREGATION
    )
    return (
        "chi against excess repulsion: two straight lines through the origin, of slopes "
        f"{each}. The points lie on them and on the dashed published lines, those below chi = 3 "
        "lie lower."
    )


def draw(data):
    """chi against Delta a, the paper's axes."""
    figure, axes = panels(1)
    for rho, runs in SEGREGATION.items():
        color, marker = runs.look.color, runs.look.marker
        at = data.sel(density=rho).dropna("excess", subset=["chi"])
        for fitted in (True, False):
            part = at.where(at.fitted == fitted, drop=True)
            label = rf"$\rho$ = {rho}, $a$ = {75 // rho}" if fitted else None
            points(axes, part.excess, part.chi, part.chi_error, label, color, marker, fitted)
        x = np.array([0, max(at.excess.values, default=0) * 1.05])
        slope, error = float(at.slope), float(at.slope_error)
        label = rf"$\rho$ = {rho}, fit: {slope:.3f} ± {COVERAGE * error:.3f}"
        axes.plot(
            x, slope * x, color=color, linewidth=0.8, label=label, zorder=0.9
        )  # below the published line
        published_line(axes, x, SLOPES[rho].value * x, "published, Eq. 24" if rho == 3 else None)
    axes.axhline(MEAN_FIELD, color=BLACK, linewidth=0.4, linestyle=":")
    axes.set(xlim=(0, None), ylim=(0, 7), xlabel=r"excess repulsion $\Delta a$ $r_c$ / $k_BT$",
             ylabel=r"$\chi$")  # fmt: skip
    axes.legend(loc="lower right")
    return figure
