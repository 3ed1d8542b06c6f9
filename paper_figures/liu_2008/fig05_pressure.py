"""Figure 5: equation of state of monomers with rigid cores, and whether it is a parabola."""

import numpy as np

from dpd.analysis.pressure import excess_pressure
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels, points
from dpd.theory.virial import core_limits

TITLE = "Pressure of monomers with rigid cores (a 25, F_max 100)."
PAPER_SHOWS = (
    "The paper shows (a) the pressure over density with parabolas p = rho kT + kappa a rho^2, "
    "fitted for rho > 2, and (b) the pressure over a rho^2, which has a plateau for r_s = 0 and "
    "0.15 and none for 0.20 and 0.25. Its axis in (b) says P; drawn here is the excess p - rho kT"
    " over a rho^2, as in Groot and Warren's Fig. 4, of which the parabola's plateau is kappa. "
    "The legend gives the exponent n of p - rho kT ~ rho^n for rho > 2 (a parabola: 2). Diamonds "
    "at rho = 0: B2 / a, exact. Dotted: mean field, pi / 24, an upper bound without cores."
)
COLORS = {0.0: BLACK, 0.15: BLUE, 0.2: GREEN, 0.25: RED}
DENSE = 2.0  # the fit's density from which on, Eq. 10
REPULSION, FORCE = 25.0, 100.0


def compute(sweeps):
    """Excess pressures, parabolas, and exponents."""
    data = excess_pressure(list(sweeps.values()), "r_s")
    rows = [_fits(data.sel(r_s=radius)) for radius in data.r_s.values]
    names = (
        "kappa",
        "kappa_error",
        "chi_square",
        "exponent",
        "exponent_error",
        "trend",
        "trend_error",
    )
    for name, column in zip(names, np.array(rows).T):
        data[name] = ("r_s", column)
    limits = [core_limits(REPULSION, radius, FORCE) for radius in data.r_s.values]
    data["virial"] = ("r_s", [low for low, _ in limits])
    data["mean_field"] = ("r_s", [high for _, high in limits])
    for name in ("kappa", "kappa_error", "virial", "mean_field"):
        data[name].attrs = {"units": "r_c^3"}
    for name in ("chi_square", "exponent", "exponent_error", "trend", "trend_error"):
        data[name].attrs = {"units": "1"}
    data.trend.attrs["long_name"] = "slope of the scaled excess for rho > 2 over its mean"
    return data


def _fits(at):
    """kappa, chi-square of the parabola, exponent and relative slope for dense systems."""
    at = at.dropna("density", subset=["excess"]).where(at.density > DENSE, drop=True)
    rho, p, error = at.density.values, at.excess.values, at.excess_error.values
    if len(rho) < 3:
        return (np.nan,) * 7
    # Every point counts alike, as for Groot and Warren: the errors are so small that those of
    # the thinnest system would decide where the parabola lies.
    parabola = linear_fit([REPULSION * rho**2], p)
    off = (p - parabola.values[0] * REPULSION * rho**2) / error
    off = off[np.isfinite(off)]  # points without an error count in the fit, not in its quality
    power = linear_fit([np.ones_like(rho), np.log(rho)], np.log(p))
    flat = p / rho**2
    line = linear_fit([np.ones_like(rho), rho - rho.mean()], flat)
    return (
        parabola.values[0], parabola.errors[0], off @ off / max(len(off) - 1, 1),
        power.values[1], power.errors[1],
        line.values[1] / line.values[0], line.errors[1] / line.values[0],
    )  # fmt: skip


def measured(data):
    """kappa, and whether the equation of state is a parabola."""
    found = {}
    for radius in (0.0, 0.15, 0.2, 0.25):
        here = np.isclose(data.r_s, radius)
        at = data.isel(r_s=int(np.argmax(here))) if here.any() else data.isel(r_s=0) * np.nan
        name = f"{100 * radius:.0f}"
        found[f"exponent_{name}"] = Measured(
            float(at.exponent), float(at.exponent_error),
            f"reduced chi-square of the parabola {float(at.chi_square):.3g}; the scaled excess "
            f"changes by {float(at.trend):.1%} +- {float(at.trend_error):.1%} per unit of density",
        )  # fmt: skip
        if radius in (0.0, 0.15):
            found[f"kappa_{name}"] = Measured(
                float(at.kappa), float(at.kappa_error),
                "error from the scatter about the parabola; exact limits "
                f"{float(at.virial):.5f} and {float(at.mean_field):.4f}",
            )  # fmt: skip
    return found


def draw(data):
    """Pressure, and scaled excess pressure; the paper's axes."""
    figure, (left, right) = panels(2)
    end = float(data.density.max()) * 1.03
    rho = np.linspace(DENSE, end, 100)
    for radius in data.r_s.values:
        at = data.sel(r_s=radius).dropna("density", subset=["excess"])
        color = COLORS.get(float(radius), ORANGE)
        exponent, error = float(at.exponent), COVERAGE * float(at.exponent_error)
        label = rf"$r_s$ = {radius:g}, n = {exponent:.2f} ± {error:.2f}"
        points(
            left, at.density, at.excess + at.density, at.excess_error, f"$r_s$ = {radius:g}", color
        )
        points(right, at.density, at.scaled, at.scaled_error, label, color)
        shown = rho[rho <= float(at.density.max()) * 1.03]
        kappa = float(at.kappa)
        left.plot(shown, shown + kappa * REPULSION * shown**2, color=color, linewidth=0.8)
        right.plot(shown, np.full_like(shown, kappa), color=color, linewidth=0.8)
    right.plot(
        [0], [float(data.virial[0])], "D", color=BLACK, clip_on=False, markerfacecolor="white"
    )
    right.axhline(float(np.pi / 24), color=BLACK, linestyle=":", linewidth=0.8)
    left.set(xlim=(0, end), ylim=(0, None), xlabel=r"density $\rho$ $r_c^2$",
             ylabel=r"pressure p / ($k_BT$ $r_c^{-2}$)", title="(a)")  # fmt: skip
    left.legend(loc="upper left")
    right.set(xlim=(0, end), ylim=(0, None), xlabel=r"density $\rho$ $r_c^2$",
              ylabel=r"$(p - \rho k_BT) / (a \rho^2)$ / $r_c^3$", title="(b)")  # fmt: skip
    right.legend(loc="lower right")
    return figure
