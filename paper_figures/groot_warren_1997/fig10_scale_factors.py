"""Figure 10: how the tension of chains of equal chi N depends on chi."""

from itertools import cycle

import numpy as np
from matplotlib.ticker import FixedLocator, NullFormatter

from dpd.analysis.statistics import COVERAGE, linear_fit, misfit_share
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, panels, points
from dpd.report.text import with_error
from paper_figures.groot_warren_1997.shared import misfit
from paper_figures.groot_warren_1997.tensions import (
    GROUPS,
    TRIMERS,
    draw_dimers,
    runs_of_chains,
    two_legends,
)

PUBLISHED = shown_by(__file__)
SLOPE, PUBLISHED_SLOPE = PUBLISHED["chain_slope"], PUBLISHED["scale_slope"]
MEAN_FIELD = PUBLISHED_SLOPE.rival
SWEEPS = ("tension", "chains")
EQUAL = 1e-6  # relative difference of chi N that are one

TITLE = "Tension of chains of equal chi N against chi (rho = 3, C = 2)."
PAPER_SHOWS = (
    "The paper shows the factors of its Figure 9 against chi on logarithmic axes, and finds the "
    f"slope {PUBLISHED_SLOPE}; mean field would have {MEAN_FIELD:g}. Those factors bring tensions "
    "of equal chi N together. Here we take them from runs that have the same chi N at different "
    "chi, so that no law of chi N is needed: all such runs of Figure 9, and those of Figure 8, "
    "where chi N is 4. The logarithms of sigma / (rho kT r_c) are fitted by one straight line for "
    "each chi N, all of the same slope. Each tension is shown over what its line has at chi = 1. "
    "Dimers, N = 2, have a dot. Runs that the other figures leave open are left out, and "
    "those with no other run of the same chi N."
)


def compute(sweeps):
    """Tensions of runs that share their chi N with others, and the slope of their logarithms."""
    data = runs_of_chains({name: sweeps[name] for name in SWEEPS}, SLOPE.value)
    return with_slope(data.isel(run=data.fitted.values & (data.scaled.values > 0)))


def with_slope(runs):
    """The runs that share their chi N, each over what its group has at chi = 1, and the slope."""
    group, count = groups_of(runs.segregation.values)
    shared = count[group] > 1
    data = runs.isel(run=shared)
    _, group = np.unique(group[shared], return_inverse=True)
    groups = int(group.max(initial=-1)) + 1
    slope = error = quality = p = np.nan
    level = np.full(groups, np.nan)
    if len(group) > groups + 1:
        x, y = np.log(data.chi.values), np.log(data.scaled.values)
        of_group = (group == np.arange(groups)[:, np.newaxis]).astype(float)
        fit = linear_fit([x, *of_group], y, data.scaled_error.values / data.scaled.values)
        slope, error, quality, p = (
            fit.values[0], fit.errors[0], fit.reduced_chi_square, fit.p_value
        )  # fmt: skip
        level = np.exp(fit.values[1:])
    data["group"] = ("run", group, {"units": "1", "long_name": "runs of one chi N"})
    for name in ("scaled", "scaled_error"):
        said = f"{data[name].long_name}, over that at chi 1 by the fit"
        factor = data[name] / level[group]
        data[name.replace("scaled", "factor")] = factor.assign_attrs(units="1", long_name=said)
    data["slope"] = ((), slope, {"units": "1", "long_name": "d ln sigma / d ln chi"})
    data["slope_error"] = ((), error, {"units": "1", "long_name": "standard error"})
    data["reduced_chi_square"] = ((), quality, {"units": "1"})
    data["p_value"] = ((), p, {"units": "1"})
    return data


def groups_of(segregation):
    """Which runs share a chi N: the group of each, numbered by chi N, and how many each has."""
    order = np.argsort(segregation, kind="stable")
    ascending = segregation[order]
    begins = np.append(False, np.diff(ascending) > EQUAL * ascending[1:])
    group = np.empty(len(segregation), dtype=int)
    group[order] = np.cumsum(begins)
    return group, np.bincount(group)


def measured(data):
    """The exponent of chi."""
    runs, groups = data.sizes["run"], len(np.unique(data.group))
    longer = with_slope(data.isel(run=data.beads.values >= TRIMERS))
    return {
        "scale_slope": Measured(
            float(data.slope), float(data.slope_error),
            f"{runs} runs of {groups} values of chi N, reduced chi-square "
            f"{float(data.reduced_chi_square):.2f}; without N = 2: "
            f"{with_error(float(longer.slope), float(longer.slope_error))}",
            misfit(float(data.p_value), "straight lines of one slope", "the slope depends")
            if np.isfinite(data.slope) else "too few settled runs of equal chi N",
            systematic=float(data.slope_error)
            * misfit_share(float(data.reduced_chi_square), float(data.p_value)),
        )
    }  # fmt: skip


def describe(data):
    """What is seen."""
    if np.isnan(data.slope):
        return "Too few settled runs share their chi N."
    return (
        f"Tensions of equal chi N rise with chi in a straight line of slope {float(data.slope):.2f}"
        " on logarithmic axes, less steeply than the dotted line of mean field."
    )


def draw(data):
    """Tensions over what their chi N has at chi 1, logarithmic axes."""
    figure, axes = panels(1)
    for number, (color, marker) in zip(np.unique(data.group), cycle(GROUPS)):
        at = data.isel(run=data.group.values == number)
        label = rf"$\chi N$ = {float(at.segregation[0]):.1f}"
        points(axes, at.chi, at.factor, at.factor_error, label, color, marker)
    two = data.isel(run=data.beads.values == 2)
    draw_dimers(axes, two.chi, two.factor)
    x = np.array([0.35, 2.75])  # from Delta a 13 / 10 to 8, with a margin
    slope, error = float(data.slope), float(data.slope_error)
    if np.isfinite(slope):
        label = f"fit: slope {slope:.3f} ± {COVERAGE * error:.3f} (95 %)"
        axes.plot(x, x**slope, color=BLACK, lw=0.8, label=label)
    axes.plot(x, x**MEAN_FIELD, color=BLACK, lw=0.9, ls=":",
              label=f"mean field: slope {MEAN_FIELD:g}")  # fmt: skip
    axes.plot(x, x**PUBLISHED_SLOPE.value, color=BLACK, alpha=0.25, lw=4, zorder=0,
              label=f"published: slope {PUBLISHED_SLOPE}")  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel=r"$\chi$", xlim=x,
             ylabel=r"$\sigma$ over that at $\chi$ = 1")  # fmt: skip
    ticks = {"x": [0.5, 1, 1.5, 2, 2.5], "y": [0.6, 0.7, 0.8, 0.9, 1, 1.2, 1.4, 1.6]}
    for name, values in ticks.items():
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(FixedLocator(values))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
    two_legends(axes, "upper left", "lower right")
    return figure
