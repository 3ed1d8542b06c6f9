"""Figure 5: equation of state of monomers with rigid cores, and whether it is a parabola."""

from dataclasses import replace

import numpy as np
from scipy.integrate import quad

from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.structure import excess_pressure
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, ORANGE, panels, points
from paper_figures.liu_2008.shared import CORES, at_radius

TITLE = "Pressure of monomers with rigid cores (a 25, F_max 100)."
PAPER_SHOWS = (
    "The paper shows (a) the pressure over density with parabolas p = rho kT + kappa a rho^2, "
    "fitted for rho > 2, and (b) the pressure over a rho^2, which has a plateau for r_s = 0 and "
    "0.15 and none for 0.20 and 0.25. Its legend gives the spread there for rho > 2, largest less "
    "smallest over the mean. (c) Not in the paper: the excess p - rho kT over a rho^2, as in Groot "
    "and Warren's Fig. 4, of which the parabola's plateau is kappa; the term rho kT falls in (b) "
    "while this rises. Its legend gives the exponent n of p - rho kT ~ rho^n for rho > 2 (a "
    "parabola: 2), with its 95 % interval. Lines: the parabolas of (a). Diamond at rho = 0: B2 / a "
    "without a core, exact. Dotted: mean field, pi / 24, an upper bound without cores."
)
DENSE = 2.0  # the fit's density from which on, Eq. 10
COMMON = 4.0  # the largest density at which the paper has all four cores
REPULSION, FORCE = 25.0, 100.0
UNITS = {
    "kappa": "r_c^3", "kappa_error": "r_c^3", "chi_square": "1", "exponent": "1",
    "exponent_error": "1", "misfit": "1", "misfit_error": "1",
}  # fmt: skip


def compute(sweeps):
    """Excess pressures, parabolas, and exponents."""
    data = excess_pressure(list(sweeps.values()), "r_s")
    rows = [_fits(data.sel(r_s=radius)) for radius in data.r_s.values]
    for name, unit in UNITS.items():
        data[name] = ("r_s", [row.get(name, np.nan) for row in rows], {"units": unit})
    data.misfit.attrs["long_name"] = "largest distance from the parabola over the largest pressure"
    limits = [_core_limits(radius) for radius in data.r_s.values]
    data["virial"] = ("r_s", [low for low, _ in limits], {"units": "r_c^3"})
    data["mean_field"] = ("r_s", [high for _, high in limits], {"units": "r_c^3"})
    return data


def _dense(at):
    """Density, excess pressure and error of dense systems."""
    use = np.isfinite(at.excess.values) & (at.density.values > DENSE)
    return (at[name].values[use] for name in ("density", "excess", "excess_error"))


def _fits(at):
    """kappa, how far points are from the parabola, and the exponent, for dense systems."""
    rho, excess, error = _dense(at)
    if len(rho) < 3:
        return {}
    # Every point counts alike, as for Groot and Warren: the errors are so small that those of
    # the thinnest system would decide where the parabola lies.
    parabola = linear_fit([REPULSION * rho**2], excess)
    (kappa,), (kappa_error,) = parabola.values, parabola.errors
    off = excess - kappa * REPULSION * rho**2
    # Points without an error count in the fit, not in its quality.
    pulls = (off / error)[np.isfinite(error)]
    power = linear_fit([np.ones_like(rho), np.log(rho)], np.log(excess))
    (_, exponent), (_, exponent_error) = power.values, power.errors
    far = np.argmax(np.abs(off))
    largest = (rho + excess).max()
    return {
        "kappa": kappa,
        "kappa_error": kappa_error,
        "chi_square": pulls @ pulls / max(len(pulls) - 1, 1),
        "exponent": exponent,
        "exponent_error": exponent_error,
        "misfit": abs(off[far]) / largest,
        "misfit_error": error[far] / largest,
    }


def spread(at):
    """How far P / (a rho^2) of one core is from level in dense systems, and its error.

    ``at``: ``excess`` and ``excess_error`` over ``density``. Returns ``value``, ``error``: largest
    less smallest, over the mean; NaN without dense systems.
    """
    rho, excess, error = _dense(at)
    if not len(rho):
        return np.nan, np.nan
    scaled, error = (rho + excess) / rho**2, error / rho**2
    low, high, mean = np.argmin(scaled), np.argmax(scaled), scaled.mean()
    return (scaled[high] - scaled[low]) / mean, float(np.hypot(error[high], error[low])) / mean


def measured(data):
    """kappa, and whether the equation of state is a parabola."""
    found = {}
    for radius in CORES:
        at, name = at_radius(data, radius), f"{100 * radius:.0f}"
        found[f"parabola_{name}"] = Measured(
            float(at.misfit), float(at.misfit_error),
            f"p - rho kT ~ rho^n with n = {float(at.exponent):.3f} +- "
            f"{float(at.exponent_error):.3f}; reduced chi-square of the parabola "
            f"{float(at.chi_square):.3g}",
        )  # fmt: skip
        if radius in (0.0, 0.15):
            found[f"kappa_{name}"] = Measured(
                float(at.kappa), float(at.kappa_error),
                "error from the scatter about the parabola; exact limits "
                f"{float(at.virial):.5f} and {float(at.mean_field):.4f}",
                systematic=float(at.kappa_error),
            )  # fmt: skip
    bare, thin, thick, crowded = (at_radius(data, radius) for radius in CORES)
    kappas = ((float(at.kappa), float(at.kappa_error)) for at in (thin, bare))
    ratio = _ratio(*kappas, less=1.0)
    found["kappa_ratio"] = replace(ratio, systematic=ratio.error)
    spreads = [spread(at) for at in (bare, thin, thick, crowded)]
    listed = ", ".join(f"{value:.1%}" for value, _ in spreads)
    ratio = _ratio(min(spreads[2:]), max(spreads[:2]))
    found["plateau_order"] = Measured(ratio.value, ratio.error, f"{listed} for r_s 0 to 0.25")
    found["pressure_25"] = _pressures(crowded, bare)
    return found


def _ratio(upper, lower, less=0.0):
    """Ratio of two numbers with errors of their own."""
    (high, high_error), (low, low_error) = upper, lower
    error = np.hypot(high_error / low, high * low_error / low**2)
    return Measured(high / low - less, float(error), f"{high:.3f} and {low:.3f}")


def _pressures(upper, lower):
    """Ratio of the pressures of two cores at the density that all have."""
    if COMMON not in upper.density.values:
        return Measured(np.nan, np.nan)
    upper, lower = (at.sel(density=COMMON) for at in (upper, lower))
    high, low = (COMMON + float(at.excess) for at in (upper, lower))
    error = np.hypot(float(upper.excess_error) / low, high * float(lower.excess_error) / low**2)
    return Measured(high / low, float(error), f"{high:.2f} and {low:.2f} kT / r_c^2")


def describe(data):
    """What is seen, in words."""
    parts = [
        f"r_s {float(r):g}: n = {float(n):.2f}"
        for r, n in zip(data.r_s, data.exponent)
        if np.isfinite(n)
    ]
    return (
        "(a) Pressures rise with density, the more the larger the core, beside fitted parabolas. "
        "(b) P over a rho^2 is level at high density for the small cores and rises for the large "
        f"ones. (c) So does the excess, which rises for all; exponents {', '.join(parts)}."
    )


def draw(data):
    """Pressure, the same over a rho^2, the paper's axes; and its excess."""
    figure, (left, middle, right) = panels(3, height=2.7)
    end = float(data.density.max()) * 1.03
    for radius in data.r_s.values:
        at = data.sel(r_s=radius).dropna("density", subset=["excess"])
        if not at.sizes["density"]:
            continue
        color = CORES.get(float(radius), ORANGE)
        scale = REPULSION * at.density**2
        n, error = float(at.exponent), COVERAGE * float(at.exponent_error)
        name = f"$r_s$ = {radius:g}"
        shown = np.linspace(DENSE, min(end, 1.03 * float(at.density.max())), 100)
        excess = float(at.kappa) * REPULSION * shown**2
        for panel, value, bar, line, label in (
            (left, at.excess + at.density, at.excess_error, shown + excess, name),
            (middle, (at.excess + at.density) / scale, at.excess_error / scale,
             (shown + excess) / (REPULSION * shown**2), f"{name}: {100 * spread(at)[0]:.1f} %"),
            (right, at.scaled, at.scaled_error, excess / (REPULSION * shown**2),
             rf"{name}, n = {n:.2f} ± {error:.2f}"),
        ):  # fmt: skip
            points(panel, at.density, value, bar, label, color)
            panel.plot(shown, line, color=color, linewidth=0.8)
    right.plot(
        [0], [float(data.virial[0])], "D", color=BLACK, clip_on=False, markerfacecolor="white"
    )
    right.axhline(float(np.pi / 24), color=BLACK, linestyle=":", linewidth=0.8)
    labels = (
        r"pressure $P$ / ($k_BT$ $r_c^{-2}$)", r"$P / (a \rho^2)$ / $r_c^3$",
        r"$(P - \rho k_BT) / (a \rho^2)$ / $r_c^3$",
    )  # fmt: skip
    for panel, label in zip((left, middle, right), labels):
        panel.set(xlim=(0, end), ylim=(0, None), xlabel=r"density $\rho$ $r_c^2$", ylabel=label)
    # In thin systems P / (a rho^2) grows as 1 / rho; shown is what the paper speaks of.
    middle.set(ylim=(0, 0.25))
    left.legend(loc="upper left")
    middle.legend(loc="lower right", title=rf"spread for $\rho$ > {DENSE:g}", title_fontsize=7)
    right.legend(loc="lower right")
    return figure


def _core_limits(radius):
    """B2 / a, and the pressure coefficient for g(r) = 1, of discs with rigid cores, in r_c^3.

    The force is `FORCE` below 2 ``radius`` and a (1 - r) from there on (Eq. 5), kT = 1.
    """
    a, force, d = REPULSION, FORCE, 2.0 * radius

    def potential(r):
        if r < d:
            return force * (d - r) + 0.5 * a * (1.0 - d) ** 2
        return 0.5 * a * (1.0 - r) ** 2

    virial = sum(
        quad(lambda r: np.pi * r * -np.expm1(-potential(r)), low, high)[0]
        for low, high in ((0.0, d), (d, 1.0))
    )
    inside = force * d**3 / 3.0
    outside = a * ((1.0 - d**3) / 3.0 - (1.0 - d**4) / 4.0)
    return virial / a, 0.5 * np.pi * (inside + outside) / a
