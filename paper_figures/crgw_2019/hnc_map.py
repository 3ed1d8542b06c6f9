"""The HNC closure against simulation: pressure over density and repulsion, and g(r)."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import block_mean_and_error
from dpd.analysis.structure import blocks_of
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, RED, panels
from paper_figures.crgw_2019.shared import mean_of

STANDARD = {"density": 3, "repulsion": 25}  # the fluid of Groot and Warren
STRONGEST = 50  # repulsion of the fluids that are like those of Groot and Warren, who had 15 to 30

TITLE = "Errors of the HNC closure of the Ornstein-Zernike equation for fluids of single beads."
PAPER_SHOWS = (
    "The paper takes the cavity function y from this theory, says that it was confirmed by "
    "simulation, and shows no figure. (a) Virial pressure by HNC less the simulated one. (b) g(r) "
    "at density 3 and repulsion 25, and below, enlarged ten times, theory less simulation. The "
    "same fluids say how good GW and rGW are for single beads, which the paper quotes for fluids "
    "that it does not list."
)


def compute(sweeps):
    """Errors of the pressure, and both g(r) of the standard fluid."""
    theory, runs = sweeps["hnc"], sweeps["monomers"]
    pressure, error = mean_of(runs, "pressure")
    place = {name: runs[name] for name in ("density", "repulsion")}
    by_hnc = theory.pressure.sel(place).transpose("density", "repulsion")
    ratio = by_hnc / pressure
    at = runs.sel(STANDARD)
    g, g_error = block_mean_and_error(blocks_of(at.rdf))
    r = runs.r.values
    exact = np.interp(r, theory.r.values, theory.rdf.sel(STANDARD).values)
    units = {"units": "kT / r_c^3"}
    others = {
        name: (100 * (theory[f"pressure_{name}"].sel(place) / pressure - 1)).assign_attrs(units="%")
        for name in ("gw", "rgw")
    }
    return xr.Dataset(
        others
        | {
            "pressure": pressure.assign_attrs(units),
            "pressure_error": error.assign_attrs(units),
            "by_hnc": by_hnc.assign_attrs(units),
            "off": (100 * (ratio - 1)).assign_attrs(units="%"),
            "off_error": (100 * ratio * error / pressure).assign_attrs(units="%"),
            "potential": theory.chemical_potential.sel(STANDARD).assign_attrs(units="kT"),
            "g": ("r", g, {"units": "1"}),
            "g_error": ("r", g_error, {"units": "1"}),
            "g_hnc": ("r", exact, {"units": "1"}),
        },
        {"r": ("r", r, {"units": "r_c"})},
    )


def measured(data):
    """Pressure and potential of the standard fluid; the largest error; how good GW and rGW are."""
    at = data.sel(STANDARD)
    off = data.off.stack(fluid=("density", "repulsion"))
    worst = off.isel(fluid=int(np.abs(off.values).argmax()))
    error = float(data.off_error.sel(density=worst.density, repulsion=worst.repulsion))
    return {
        "standard_pressure": Measured(float(at.pressure), float(at.pressure_error)),
        "hnc_pressure": Measured(float(at.by_hnc), 0.0),
        "hnc_potential": Measured(float(at.potential), 0.0),
        "hnc_worst": Measured(
            abs(float(worst)), error,
            f"{float(worst):+.2f} % at density {float(worst.density):g} and repulsion "
            f"{float(worst.repulsion):g}",
        ),
        "gw_beads": _of_beads(data, "gw"),
        "rgw_beads": _of_beads(data, "rgw"),
    }  # fmt: skip


def _of_beads(data, name):
    """Mean unsigned error of an equation in percent; its error is that of the choice of fluids."""
    at = data.where(data.repulsion <= STRONGEST, drop=True)
    off = np.abs(at[name].values.ravel())
    if off.size < 2:
        return Measured(np.nan, np.nan)
    error = float(off.std(ddof=1) / np.sqrt(off.size))
    return Measured(
        float(off.mean()), error,
        f"{off.size} fluids, up to repulsions of {STRONGEST}; largest {off.max():.1f} %",
        systematic=error,
    )  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "A map of small errors of the pressure, in percent, written in its cells; beside it g(r) "
        "by theory on that of simulation, with a difference that is hardly seen."
    )


def draw(data):
    """The map, and g(r)."""
    figure, (left, right) = panels(2, height=2.6)
    off = data.off.transpose("repulsion", "density").values
    span = max(0.5, float(np.abs(off).max()))
    image = left.imshow(off, origin="lower", cmap="RdBu_r", vmin=-span, vmax=span, aspect="auto")
    for (row, column), value in np.ndenumerate(off):
        dark = abs(value) > 0.6 * span
        left.text(column, row, f"{value:+.2f}", ha="center", va="center", fontsize=7,
                  color="white" if dark else BLACK)  # fmt: skip
    left.set_xticks(range(data.sizes["density"]), [f"{v:g}" for v in data.density.values])
    left.set_yticks(range(data.sizes["repulsion"]), [f"{v:g}" for v in data.repulsion.values])
    left.set(xlabel=r"density $\rho$ / $r_c^{-3}$", ylabel="$a$ / ($k_BT$ $r_c^{-1}$)")
    figure.colorbar(image, ax=left, label="HNC less simulated pressure / %")
    right.plot(data.r, data.g, "o", color=RED, markersize=1.5, label="simulated")
    right.plot(data.r, data.g_hnc, color=BLUE, label="HNC")
    right.plot(
        data.r, 10 * (data.g_hnc - data.g), color=BLACK, linewidth=0.7, label="10 × difference"
    )
    right.set(xlim=(0, 2.5), xlabel="$r$ / $r_c$", ylabel="$g(r)$")
    right.legend(loc="center right", bbox_to_anchor=(1.0, 0.5))
    return figure
