"""Figure 5: relaxation time and diffusion over chain length, from Rouse to reptation."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.diffusion import chain_dynamics, power
from dpd.analysis.statistics import linear_fit
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, Look, panels, points
from dpd.report.text import with_error
from paper_figures.nikunen_2007.chain_lengths import Crossover, crossover
from paper_figures.nikunen_2007.shared import CONTROL, MAIN, SETS, law

PUBLISHED = shown_by(__file__)
CROSSOVER = PUBLISHED["crossover_diffusion"]  # chain lengths
SHORTEST = 8  # chain length from which on Rouse's laws are fitted
LIKELY = 0.05  # p value of a law that fits
FIELDS = Crossover._fields

TITLE = "Relaxation time (a) and diffusion constant of chains (b) over chain length."
PAPER_SHOWS = (
    "The paper shows tau ~ N^2 crossing to N^3 and D ~ 1/N crossing to N^-2 for a 100, k 200, with "
    f"the crossover between N = {CROSSOVER.low:g} and {CROSSOVER.high:g} (shaded). (c), (d): "
    "tau / N^2 and D N, which are level for long Rouse chains. D is from lags of half a tau to "
    "one. Only runs of ten relaxation times or more, after two to settle, count; others are drawn "
    "hollow and left out of the fits. Exponents are fitted "
    f"over N from {SHORTEST} to {CROSSOVER.low:g} and from {CROSSOVER.high:g} on. Dashed and "
    "dotted: laws with the published exponents, fitted to the points of a 100 in each range. The "
    "crossover is where they meet. The control a 25, k 50, whose bonds pass through each other, "
    "should be Rouse-like at any length. tau is the relaxation time, tau_0 = (m r_c^2 / kT)^(1/2) "
    "the unit of time."
)
ERRORS = (
    "Bars: 95 % intervals, the larger of two jackknife errors, leaving out molecules, and leaving"
    " out tenths of the run."
)
STYLES = {
    MAIN: Look("a = 100", SETS[MAIN], "o"),
    CONTROL: Look("a = 25, control", SETS[CONTROL], "s"),
}
REGIMES = {"rouse": (SHORTEST, CROSSOVER.low), "reptation": (CROSSOVER.high, np.inf)}
LAWS = {
    quantity: {regime: law(PUBLISHED[f"{quantity}_{regime}"]) for regime in REGIMES}
    for quantity in ("tau", "diffusion")
}


def compute(sweeps):
    """tau and D over N, of both sets; exponents in both regimes, and where the laws meet."""
    runs = {MAIN: sweeps["dynamics"], CONTROL: sweeps["dynamics_control"]}
    data = xr.concat([chain_dynamics(run) for run in runs.values()], "set", join="outer")
    data = data.assign_coords(set=list(runs))
    for quantity in LAWS:
        for regime, limits in REGIMES.items():
            found = [power(*_counted(data, name, quantity), *limits) for name in runs]
            data[f"{quantity}_{regime}"] = ("set", [fit.exponent for fit in found], {"units": "1"})
            errors = [fit.error for fit in found]
            data[f"{quantity}_{regime}_error"] = ("set", errors, {"units": "1"})
            likely = [fit.p_value for fit in found]
            data[f"{quantity}_{regime}_p_value"] = ("set", likely, {"units": "1"})
        counted = _counted(data, MAIN, quantity)
        found = [crossover(*counted), crossover(*counted, tuple(LAWS[quantity].values()))]
        for name in FIELDS:
            data[f"{quantity}_crossover_{name}"] = (
                "exponents", [getattr(each, name) for each in found], {"units": "1"}
            )  # fmt: skip
    return data.assign_coords(exponents=["fitted", "published"])


def _counted(data, name, quantity):
    """N, value and error of the runs that are long enough."""
    at = data.sel(set=name)
    use = at.long_enough.values > 0
    return (
        at.length.values[use], at[quantity].values[use], at[f"{quantity}_error"].values[use]
    )  # fmt: skip


def measured(data):
    """Exponents in both regimes, of the control, and the crossover."""
    found = {}
    for quantity in LAWS:
        for regime in REGIMES:
            found[f"{quantity}_{regime}"] = _exponent(data, MAIN, quantity, regime)
        found[f"{quantity}_control"] = _exponent(data, CONTROL, quantity, "reptation")
        found[f"crossover_{quantity}"] = _crossover(data, quantity)
    return found


def _exponent(data, name, quantity, regime):
    """Of one set in one range of lengths."""
    at = data.sel(set=name)
    low, high = REGIMES[regime]
    n, _, _ = _counted(data, name, quantity)
    inside = ", ".join(f"{length:g}" for length in n if low <= length <= high)
    value, error = float(at[f"{quantity}_{regime}"]), float(at[f"{quantity}_{regime}_error"])
    if np.isfinite(value):
        likely = float(at[f"{quantity}_{regime}_p_value"])
        return Measured(value, error, f"N {inside}; one power law fits them with p {likely:.2g}")
    between = f"from {low:g} on" if np.isinf(high) else f"from {low:g} to {high:g}"
    return Measured(np.nan, np.nan, "", f"fewer than three lengths {between} ran ten tau")


def meeting(data, quantity):
    """Chain length at which the laws with the published exponents meet, and its standard error.

    Each is fitted to the points of its own range, with errors widened where the points scatter
    more about it than they should.

    Returns ``length``, ``error``: NaN where a range has no point.
    """
    n, value, error = _counted(data, MAIN, quantity)
    heights, spreads = [], []
    for regime, (low, high) in REGIMES.items():
        use = (n >= low) & (n <= high) & (error > 0)
        if not use.any():
            return np.nan, np.nan
        rest = np.log(value[use]) - LAWS[quantity][regime] * np.log(n[use])
        fit = linear_fit([np.ones_like(rest)], rest, error[use] / value[use])
        heights.append(fit.values[0])
        spreads.append(fit.errors[0])
    short, long = LAWS[quantity].values()
    length = np.exp((heights[0] - heights[1]) / (long - short))
    return float(length), float(length * np.hypot(*spreads) / abs(long - short))


def _crossover(data, quantity):
    """Where the published laws meet, and whether the data ask for two."""
    length, error = meeting(data, quantity)
    if not np.isfinite(length):
        return Measured(np.nan, np.nan, "", f"no length from {CROSSOVER.high:g} on ran ten tau")
    free, fixed = (
        {name: float(data[f"{quantity}_crossover_{name}"].sel(exponents=which)) for name in FIELDS}
        for which in ("fitted", "published")
    )
    note = (
        f"laws with the published exponents fit all lengths with p {fixed['p_value']:.2g}; with "
        f"exponents of their own, p {free['p_value']:.2g}, they meet at {_place(free)}; one power "
        f"law alone: p {free['straight']:.2g}"
    )
    blind = "one power law fits all lengths" if free["straight"] > LIKELY else ""
    return Measured(length, error, note, blind)


def _place(found):
    """Where the laws meet, with its error if the lengths bound it."""
    if np.isfinite(found["error"]):
        return with_error(found["length"], found["error"])
    return f"{found['length']:.3g} (not bounded)"


def warnings(data):
    """Runs that are too short, or began too early."""
    short = [
        f"{STYLES[name].label}, N = {n:g}"
        for name in data.set.values
        for n in data.length.values
        if data.long_enough.sel(set=name, length=n) == 0
    ]
    if not short:
        return []
    return [f"Without a D, as ten relaxation times or two to settle lack: {'; '.join(short)}."]


def table(data):
    """tau and D of each chain length, with how long its run was."""
    rows = []
    for name in data.set.values:
        for n in data.length.values:
            at = data.sel(set=name, length=n)
            if not np.isfinite(at.duration):
                continue
            rows.append((
                STYLES[name].label, f"{n:g}", with_error(float(at.tau), float(at.tau_error)),
                with_error(float(at.tau) / n**2, float(at.tau_error) / n**2),
                with_error(float(at.diffusion), float(at.diffusion_error)),
                with_error(float(at.diffusion) * n, float(at.diffusion_error) * n),
                with_error(float(at.diffusion_later) * n, float(at.diffusion_later_error) * n),
                f"{float(at.duration):.4g}",
                "yes" if at.long_enough else "no: run too short",
            ))  # fmt: skip
    return pd.DataFrame(rows, columns=[
        "set", "N", "tau / tau_0", "tau / N^2", "D", "D N", "D N from tau to 2 tau", "run / tau_0",
        "counts",
    ])  # fmt: skip


def describe(data):
    """What is seen."""
    n, tau, _ = _counted(data, MAIN, "tau")
    if not len(n):
        return "No run lasts for ten relaxation times."
    _, constant, _ = _counted(data, MAIN, "diffusion")
    return (
        f"From N = {n[0]:g} to {n[-1]:g}, tau / N^2 of a 100 goes from {tau[0] / n[0] ** 2:.2f} to "
        f"{tau[-1] / n[-1] ** 2:.2f} and D N from {constant[0] * n[0]:.2f} to "
        f"{constant[-1] * n[-1]:.2f}."
    )


def draw(data):
    """tau and D, and below both with Rouse's law taken out."""
    figure, axes = panels(2, rows=2, height=2.4)
    labels = {
        "tau": (r"$\tau$ / $\tau_0$", r"$\tau / N^2$ / $\tau_0$"),
        "diffusion": (r"$D$ / ($r_c^2 / \tau_0$)", r"$D N$ / ($r_c^2 / \tau_0$)"),
    }
    for column, (quantity, texts) in zip(axes.T, labels.items()):
        for panel, taken, text in zip(column, (0, LAWS[quantity]["rouse"]), texts):
            panel.set(xscale="log", yscale="linear" if taken else "log", xlabel="chain length N",
                      ylabel=text)  # fmt: skip
            for name in data.set.values:
                _draw_set(panel, data.sel(set=name), quantity, taken, *STYLES[name])
            for regime, line in (("rouse", "--"), ("reptation", ":")):
                _draw_law(panel, data, quantity, regime, taken, line)
            panel.axvspan(CROSSOVER.low, CROSSOVER.high, color=BLACK, alpha=0.1, linewidth=0,
                          label="published crossover")  # fmt: skip
            panel.set_xticks(data.length.values, [f"{n:g}" for n in data.length.values])
            panel.set_xticks([], minor=True)
    axes[0, 0].legend(loc="upper left")
    axes[0, 1].legend(loc="lower left")
    return figure


def _draw_set(panel, at, quantity, taken, label, color, marker):
    """Points of one set over N^taken, hollow where the run was too short."""
    n, counts = at.length.values, at.long_enough.values > 0
    value, error = at[quantity].values / n ** float(taken), at[f"{quantity}_error"].values
    error = error / n ** float(taken)
    points(panel, n[counts], value[counts], error[counts], label, color, marker)
    rest = ~counts & np.isfinite(value)
    if rest.any():
        points(panel, n[rest], value[rest], error[rest], f"{label}, run too short", color, marker,
               filled=False)  # fmt: skip


def _draw_law(panel, data, quantity, regime, taken, line):
    """The published law, with the height that fits the points of its regime, and to the meeting."""
    exponent, (low, high) = LAWS[quantity][regime], REGIMES[regime]
    fit = power(*_counted(data, MAIN, quantity), low, high, exponent=exponent)
    if not np.isfinite(fit.height):
        return
    met, _ = meeting(data, quantity)
    ends = low, min(high, data.length.values.max())
    x = np.geomspace(np.nanmin([ends[0], met]), np.nanmax([ends[1], met]), 50)
    panel.plot(x, np.exp(fit.height) * x ** (exponent - taken), color=BLACK,
               linestyle=line, linewidth=0.9, label=f"$N^{{{exponent:g}}}$")  # fmt: skip
