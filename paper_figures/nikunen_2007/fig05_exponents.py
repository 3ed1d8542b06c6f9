"""Figure 5: relaxation time and diffusion over chain length, from Rouse to reptation."""

import numpy as np

from dpd.analysis.relaxation import chain_dynamics, power
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, panels, points

TITLE = "Relaxation time (a) and diffusion constant of chains (b) over chain length, a 100, k 200."
PAPER_SHOWS = (
    "The paper shows tau ~ N^2 crossing to N^3 and D ~ 1/N crossing to N^-2, with the crossover "
    "between N = 40 and 60 (shaded). Drawn here as tau / N^2 and D N, which are level for Rouse "
    "chains. Only runs of ten tau or more have a tau and a D; lengths without one are listed in "
    "the table. Fits: N up to 40, and from 60 on."
)
ERRORS = (
    "Bars: 95 % intervals, the larger of two jackknife errors, leaving out molecules, and leaving"
    " out tenths of the run."
)
ROUSE, REPTATION = (8, 40), (60, np.inf)


def compute(sweeps):
    """tau and D over N."""
    data = chain_dynamics(sweeps["dynamics"])
    n = data.length.values
    good = data.long_enough.values > 0
    for name in ("tau", "diffusion"):
        value = np.where(good, data[name].values, np.nan)
        for regime, limits in (("rouse", ROUSE), ("reptation", REPTATION)):
            found = power(n, value, data[f"{name}_error"].values, *limits)
            data[f"{name}_{regime}"] = ((), found[0], {"units": "1"})
            data[f"{name}_{regime}_error"] = ((), found[1], {"units": "1"})
    return data


def measured(data):
    """Exponents in both regimes, and the crossover."""
    good = data.length.values[data.long_enough.values > 0]
    note = f"N {', '.join(f'{n:g}' for n in good)} ran ten tau or more"
    found = {}
    for name in ("tau", "diffusion"):
        for regime in ("rouse", "reptation"):
            value = float(data[f"{name}_{regime}"])
            limits = ROUSE if regime == "rouse" else REPTATION
            missing = f"fewer than two lengths between {limits[0]} and {limits[1]} ran ten tau"
            found[f"{name}_{regime}"] = Measured(
                value, float(data[f"{name}_{regime}_error"]), note,
                "" if np.isfinite(value) else missing,
            )  # fmt: skip
    found["crossover"] = _crossover(data)
    return found


def _crossover(data):
    """Where the lines of both regimes meet in tau."""
    use = (data.long_enough.values > 0) & np.isfinite(data.tau.values)
    n, tau = np.log(data.length.values[use]), np.log(data.tau.values[use])
    error = data.tau_error.values[use] / data.tau.values[use]
    low, high = n < np.log(ROUSE[1]), n > np.log(REPTATION[0])
    if low.sum() < 2 or high.sum() < 2:
        return Measured(np.nan, np.nan, "", "needs two lengths in each regime")
    a, b = (np.polyfit(n[part], tau[part], 1, w=1 / error[part]) for part in (low, high))
    crossing = np.exp((a[1] - b[1]) / (b[0] - a[0]))
    spread = []
    rng = np.random.default_rng(0)
    for _ in range(200):
        noisy = tau + error * rng.normal(size=len(tau))
        c, d = (np.polyfit(n[part], noisy[part], 1, w=1 / error[part]) for part in (low, high))
        spread.append(np.exp((c[1] - d[1]) / (d[0] - c[0])))
    return Measured(float(crossing), float(np.std(spread)), "lines of both regimes in tau")


def draw(data):
    """tau / N^2 and D N."""
    figure, axes = panels(2)
    n, good = data.length, data.long_enough > 0
    shown = (
        ("tau", n**-2.0, r"$\tau / N^2$ / $\tau_0$", "N^2"),
        ("diffusion", n, r"$D N$ / ($r_c^2$ $\tau_0^{-1}$)", "1 / N"),
    )
    for panel, (name, scale, label, law), title in zip(axes, shown, ("(a)", "(b)")):
        value, error = data[name] * scale, data[f"{name}_error"] * scale
        points(panel, n[good], value[good], error[good], "ten relaxation times or more", BLUE)
        if (~good).any() and np.isfinite(value[~good]).any():
            points(panel, n[~good], value[~good], error[~good], "shorter, not fitted", BLUE,
                   filled=False)  # fmt: skip
        seen = value[good & np.isfinite(value)]
        if seen.size:
            panel.axhline(float(seen.mean()), color=BLACK, linewidth=0.6, label=f"${law}$")
        panel.axvspan(40, 60, color=BLACK, alpha=0.1, linewidth=0, label="published crossover")
        panel.set(xscale="log", yscale="log", xlabel="chain length N", ylabel=label, title=title)
        panel.legend()
    return figure
