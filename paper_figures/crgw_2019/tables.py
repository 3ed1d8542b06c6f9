"""Tables I and II: repulsions by the equations of state, and densities at constant pressure."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLUE, RED, panels, points
from dpd.theory.equation_of_state import C1, C2, second_virial, virial_switch
from paper_figures.crgw_2019.shared import LOOKS, TARGET, mean_of_alike

PUBLISHED = shown_by(__file__)
FLUIDS = ("Vh1", "Vh2", "Vo2")
MIXTURES = ("Vh1Vh2", "Vh1Vo2", "Vh2Vo2")
SOLVENTS = (2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5)  # input densities of Table II

TITLE = "Repulsions and densities of Tables I and II over the printed ones."
PAPER_SHOWS = (
    "(a) Repulsions at the pressure 41.89 by each equation as it is printed, over those of the "
    "tables; those of mixtures follow from the printed ones of pure fluids by Eqs. 25 and 27. Bars "
    "are the rounding of Table I. (b) Simulated "
    "densities of the solvents of Table II at 41.89, with its repulsions, over its densities."
)


def compute(sweeps):
    """Repulsions by theory, densities by simulation, and constants that give Table II."""
    pure, mixed, solvents = (
        sweeps[f"{name}_repulsions"].repulsion for name in ("alkane", "alkane_cross", "solvent")
    )
    volume, error = mean_of_alike(sweeps["solvents"].volume_series)
    beads = float(sweeps["solvents"].beads.values.ravel()[0])
    units = {"units": "1 / r_c^3"}
    constants = _constants()
    return xr.Dataset({
        "pure": pure, "mixed": mixed, "solvent": solvents.rename(density="input"),
        "density_found": (beads / volume).assign_attrs(units),
        "density_error": (beads / volume**2 * error).assign_attrs(units),
        "constants": ("constant", constants, {"units": "1"}),
    })  # fmt: skip


def _constants():
    """c_1 and c_2 of Eq. 4 with which Eq. 2 gives the repulsions of Table II at 41.89.

    1 / F_alpha = 1 / (c_1 rho^2) + c_2 / c_1 is linear in both coefficients.
    """
    rho = np.array(SOLVENTS, dtype=float)
    a = np.array([PUBLISHED[_solvent(value)].value for value in SOLVENTS])
    switch = ((TARGET - rho) / rho**2 - second_virial(a) * virial_switch(rho)) / a
    basis = np.stack([1 / rho**2, np.ones_like(rho)], axis=1) * switch[:, None]
    (first, second), *_ = np.linalg.lstsq(basis, np.ones_like(rho), rcond=None)
    return np.array([1 / first, second / first])


def _rounding(name):
    """Half of the last printed digit over the printed value."""
    return PUBLISHED[name].rounding / PUBLISHED[name].value


def _solvent(density):
    return f"solvent_{density:g}"


def measured(data):
    """Every number of both tables."""
    found = {}
    for fluid in FLUIDS:
        for equation in LOOKS:
            value = float(data.pure.sel(fluid=fluid, equation=equation))
            found[f"{fluid.lower()}_{equation.lower()}"] = Measured(value, 0.0)
    for pair in MIXTURES:
        for equation in LOOKS:
            value = float(data.mixed.sel(model=f"{pair}-{equation}"))
            found[f"{pair.lower()}_{equation.lower()}"] = Measured(value, 0.0)
    for density in SOLVENTS:
        found[_solvent(density)] = Measured(float(data.solvent.sel(input=density)), 0.0)
        name, value, error = f"density_{density:g}", np.nan, np.nan
        if density in data.density:
            at = data.sel(density=density)
            value, error = float(at.density_found), float(at.density_error)
        found[name] = Measured(value, error)
    c1, c2 = data.constants.values
    for name, printed, value in (("c1", C1, c1), ("c2", C2, c2)):
        found[f"switch_{name}"] = Measured(value, 0.0, f"that gives Table II; printed: {printed}")
    return found


def table(data):
    """Ours and the printed repulsions of Table I."""
    rows = []
    for fluid in FLUIDS:
        for equation in LOOKS:
            printed = PUBLISHED[f"{fluid.lower()}_{equation.lower()}"].value
            value = float(data.pure.sel(fluid=fluid, equation=equation))
            rows.append((fluid, equation, f"{value:.2f}", f"{printed:g}"))
    for pair in MIXTURES:
        for equation in LOOKS:
            printed = PUBLISHED[f"{pair.lower()}_{equation.lower()}"].value
            value = float(data.mixed.sel(model=f"{pair}-{equation}"))
            rows.append((pair, equation, f"{value:.2f}", f"{printed:g}"))
    return pd.DataFrame(rows, columns=["fluid or mixture", "equation", "this work", "published"])


def describe(data):
    """What is seen."""
    return (
        "Left, repulsions over the printed ones: those of GW and of mixtures lie at one within "
        "the rounding, those of rGW and crGW about half a percent below. Right, densities over "
        "the printed ones lie at one within half a percent."
    )


def draw(data):
    """Ratios to the printed numbers."""
    figure, (left, right) = panels(2, height=2.6)
    names = [*FLUIDS, *MIXTURES]
    for k, (equation, look) in enumerate(LOOKS.items()):
        ratios = [
            float(
                data.pure.sel(fluid=name, equation=equation) if name in FLUIDS
                else data.mixed.sel(model=f"{name}-{equation}")
            ) / PUBLISHED[f"{name.lower()}_{equation.lower()}"].value
            for name in names
        ]  # fmt: skip
        rounding = [_rounding(f"{name.lower()}_{equation.lower()}") for name in names]
        left.errorbar(
            np.arange(len(names)) + 0.2 * (k - 1), ratios, rounding, fmt=look.marker,
            color=look.color, elinewidth=0.7, capsize=1.5, label=look.label,
        )  # fmt: skip
    solvent = [float(data.solvent.sel(input=d)) / PUBLISHED[_solvent(d)].value for d in SOLVENTS]
    places = len(names) + np.arange(len(SOLVENTS))
    left.plot(places, solvent, "D", color=RED, markerfacecolor="none", label="rGW, Table II")
    left.axhline(1, color="0.5", linewidth=0.6)
    labels = [*names, *(rf"$\rho$ {d:g}" for d in SOLVENTS)]
    left.set_xticks(range(len(labels)), labels, rotation=60, ha="right")
    left.set(ylabel="repulsion over the printed one")
    left.legend(loc="upper right", ncols=2)
    printed = np.array([PUBLISHED[f"density_{d:g}"].value for d in data.density.values])
    ratio, error = data.density_found / printed, data.density_error / printed
    points(right, data.density, ratio, error, None, BLUE)
    right.axhline(1, color="0.5", linewidth=0.6)
    right.set(xlabel="input density / $r_c^{-3}$", ylabel="density over the printed one")
    reach = max(0.007, 1.2 * float(np.abs(ratio - 1).max()))
    right.set_ylim(1 - reach, 1 + reach)
    return figure
