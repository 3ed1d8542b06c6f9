"""Scenes made with chi: chi by the composition of their phases against chi asked for."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.interfaces import sweep_chi
from dpd.analysis.statistics import linear_fit
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLUE, GREEN, RED, panels, points, published_line

PUBLISHED = shown_by(__file__)


class Group(NamedTuple):
    """Scenes for which one relation gives the repulsion: sweep, published slope, and look."""

    sweep: str
    slope: str
    label: str
    color: str
    marker: str


GROUPS = (
    Group("monomers", "chi_slope_3", r"beads, $\rho$ = 3", BLUE, "o"),
    Group("monomers_5", "chi_slope_5", r"beads, $\rho$ = 5", RED, "s"),
    Group("dimers", "chi_slope_chains", r"dimers, $\rho$ = 3", GREEN, "^"),
)
ALPHA, ALPHA_ERROR = 0.101, 0.001  # of the equation of state, Eq. 31
LIKE = PUBLISHED["like_repulsion"].value  # a rho / kT, for a fluid that compresses as water does
WATER = PUBLISHED["compressibility"].value

TITLE = "chi found against chi asked for, in two coexisting phases of A and B."
PAPER_SHOWS = (
    "The manual has no such figure. It gives chi = s Delta a with s = "
    f"{PUBLISHED['chi_slope_3']} at density 3 and {PUBLISHED['chi_slope_5']} at density 5 for "
    f"single beads, and s = {PUBLISHED['chi_slope_chains']} for chains at density 3, and so a_AB = "
    "a_AA + chi / s. Here scenes ask for chi, and the minority fraction in the bulk of both phases "
    "gives it back, by the theory of Flory and Huggins. Dashed: the same chi. Open: not settled."
)


def compute(sweeps):
    """chi asked for and found, and chi over Delta a of each group."""
    parts = []
    for group in GROUPS:
        found = sweep_chi(sweeps[group.sweep], "asked").rename(chi="found", chi_error="error")
        parts.append(_with_slope(found).expand_dims(group=[group.sweep]))
    return xr.concat(parts, "group", join="outer")


def _with_slope(data):
    """The same with the slope of chi over Delta a, through the origin, of what has settled."""
    use = (data.settled == 1) & np.isfinite(data.found) & (data.error > 0)
    slope, error = np.nan, np.nan
    if use.any():
        fit = linear_fit(
            [data.excess_repulsion.values[use]], data.found.values[use], data.error.values[use]
        )
        (slope,), (error,) = fit.values, fit.errors
    units = {"units": "r_c / kT"}
    return data.assign(slope=((), slope, units), slope_error=((), error, units))


def measured(data):
    """The slopes, chi found over chi asked for, and the closed forms of the text."""
    found = {}
    for group in GROUPS:
        at = data.sel(group=group.sweep).dropna("asked", subset=["found"])
        each = ", ".join(
            f"{float(f):.2f} for {float(a):g}{'' if s else ' (not settled)'}"
            for a, f, s in zip(at.asked, at.found, at.settled.values)
        )
        settled = int((at.settled == 1).sum())
        found[group.slope] = Measured(
            float(at.slope), float(at.slope_error), f"chi found: {each}",
            "" if settled else "no run has settled",
        )  # fmt: skip
    at = data.sel(group="monomers").dropna("asked", subset=["found"])
    at = at.where(at.settled == 1, drop=True)
    ratio, error = np.nan, np.nan
    if at.sizes["asked"]:
        fit = linear_fit([at.asked.values], at.found.values, at.error.values)
        (ratio,), (error,) = fit.values, fit.errors
    found["there_and_back"] = Measured(float(ratio), float(error), "single beads at density 3")
    # p = rho kT + alpha a rho^2, so that kappa^-1 = 1 + 2 alpha a rho / kT (Eqs. 31 and 32).
    # Of numbers that are printed, whose errors no sampling lowers.
    error = 2 * ALPHA_ERROR * LIKE
    found["compressibility"] = Measured(1 + 2 * ALPHA * LIKE, error, systematic=error)
    needed, error = (WATER - 1) / (2 * ALPHA), (WATER - 1) / (2 * ALPHA) * ALPHA_ERROR / ALPHA
    found["like_repulsion"] = Measured(needed, error, systematic=error)
    return found


def describe(data):
    """What is seen."""
    return (
        "chi found over chi asked for: points of single beads at two densities and of dimers lie "
        "on or close to the diagonal."
    )


def draw(data):
    """chi found over chi asked for."""
    figure, axes = panels(1)
    top = 1.15 * float(np.nanmax([data.asked.max(), data.found.max()]))
    published_line(axes, [0, top], [0, top], "the same")
    for group in GROUPS:
        at = data.sel(group=group.sweep).dropna("asked", subset=["found"])
        label = group.label
        for settled in (1, 0):
            part = at.where(at.settled == settled, drop=True)
            if part.sizes["asked"]:
                points(axes, part.asked, part.found, part.error, label, group.color, group.marker,
                       bool(settled))  # fmt: skip
                label = None
    axes.set(xlim=(0, top), ylim=(0, top), xlabel=r"$\chi$ asked for", ylabel=r"$\chi$ found")
    axes.legend(loc="upper left")
    return figure
